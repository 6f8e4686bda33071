"""Certificates for robots that go where they are told: ẋ = v."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from barrier_certificates import checks
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.limits import VelocityPolygon
from barrier_certificates.projection import Policy, ProjectionInfo, Projector
from barrier_certificates.rows import (
    Family,
    FloatArray,
    PairRows,
    RowBook,
    Scene,
    WallRows,
    rectangle,
)


@dataclass(frozen=True)
class SafetyParameters:
    """What is kept apart from what, and how firmly; common to all certificates.

    Parameters
    ----------
    safety_radius : float
        Smallest distance between two positions, m.
    barrier_gain : float
        γ of the pair and wall rows.
    unsafe_gain : float, optional
        γ of pairs that are already too close; ``barrier_gain`` if None.
    boundary : (x_min, x_max, y_min, y_max), optional
        Rectangular arena, m.
    wall_margin : float, optional
        How far inside the walls positions stay, m; half the safety radius if None.
    """

    safety_radius: float = 0.15
    barrier_gain: float = 100.0
    unsafe_gain: float | None = None
    boundary: tuple[float, float, float, float] | None = None
    wall_margin: float | None = None

    def __post_init__(self) -> None:
        checks.positive("safety_radius", self.safety_radius, "of metres")
        checks.positive("barrier_gain", self.barrier_gain)
        checks.positive_or_none("unsafe_gain", self.unsafe_gain)
        if self.wall_margin is not None:
            checks.not_negative("wall_margin", self.wall_margin, "of metres")
        if self.boundary is not None:
            bounds = tuple(float(b) for b in np.asarray(self.boundary, dtype=float).reshape(-1))
            if len(bounds) != 4 or not (bounds[0] < bounds[1] and bounds[2] < bounds[3]):
                raise ParameterError(
                    f"boundary is {self.boundary}; expected (x_min, x_max, y_min, y_max) in metres"
                )
            object.__setattr__(self, "boundary", bounds)

    def pair_rows(self) -> PairRows:
        """Return the rows that keep robots apart."""
        return PairRows(self.safety_radius, self.barrier_gain, self.unsafe_gain)

    def wall_rows(self) -> list[Family]:
        """Return the rows that keep robots inside, if there is a boundary."""
        if self.boundary is None:
            return []
        margin = 0.5 * self.safety_radius if self.wall_margin is None else self.wall_margin
        return [WallRows(*rectangle(self.boundary), margin, self.barrier_gain)]


@dataclass(frozen=True)
class SingleIntegratorParameters(SafetyParameters):
    """`SafetyParameters`, and how fast the robots are.

    Parameters
    ----------
    speed_limit : float or None
        Largest speed, m/s; None means no limit.
    speed_shape : {"octagon", "box"}
        The octagon inscribed in the circle of the limit, or |v_x|, |v_y| ≤ limit.
    """

    speed_limit: float | None = 0.2
    speed_shape: str = "octagon"

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive_or_none("speed_limit", self.speed_limit, "of m/s, or None")
        if self.speed_shape not in ("octagon", "box"):
            raise ParameterError(
                f"speed_shape is {self.speed_shape!r}; expected 'octagon' or 'box'"
            )

    def limits(self) -> VelocityPolygon | None:
        """Return the polygon of allowed velocities, or None."""
        if self.speed_limit is None:
            return None
        shape = VelocityPolygon.octagon if self.speed_shape == "octagon" else VelocityPolygon.box
        return shape(self.speed_limit)


class SingleIntegratorCertificate:
    """The safe velocities nearest to the desired ones, for a team of single integrators.

    Parameters
    ----------
    safety_radius, barrier_gain, unsafe_gain, boundary, wall_margin
        See `SafetyParameters`.
    speed_limit, speed_shape
        See `SingleIntegratorParameters`.
    on_infeasible, solver, options
        See `barrier_certificates.projection.Projector`.

    Examples
    --------
    >>> certificate = SingleIntegratorCertificate(boundary=(-1.6, 1.6, -1.0, 1.0))
    >>> velocity, info = certificate([[0.2, -0.2], [0.0, 0.0]], [[-0.1, 0.1], [0.0, 0.0]])
    >>> info.status, info.active
    ('optimal', ('robots 0 and 1',))
    """

    def __init__(
        self,
        safety_radius: float = 0.15,
        barrier_gain: float = 100.0,
        *,
        unsafe_gain: float | None = None,
        boundary: tuple[float, float, float, float] | None = None,
        wall_margin: float | None = None,
        speed_limit: float | None = 0.2,
        speed_shape: str = "octagon",
        on_infeasible: Policy = "relax",
        solver: str = "auto",
        options: Mapping[str, float] | None = None,
    ) -> None:
        self._projector = Projector(solver, on_infeasible, options)
        self.parameters = SingleIntegratorParameters(
            safety_radius=safety_radius,
            barrier_gain=barrier_gain,
            unsafe_gain=unsafe_gain,
            boundary=boundary,
            wall_margin=wall_margin,
            speed_limit=speed_limit,
            speed_shape=speed_shape,
        )

    @property
    def parameters(self) -> SingleIntegratorParameters:
        """What the certificate keeps; set it (``dataclasses.replace``) to change it."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: SingleIntegratorParameters) -> None:
        self._parameters = parameters
        families: list[Family] = []
        limits = parameters.limits()
        self._top_speed = np.inf
        if limits is not None:
            self._top_speed = limits.top_speed()
            families.append(limits.rows())
        families += parameters.wall_rows()
        self._book = RowBook(families, parameters.pair_rows(), self._top_speed)
        self.reset()

    def reset(self) -> None:
        """Forget the previous step."""
        self._projector.reset()

    def __call__(self, desired: Any, positions: Any) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe velocities nearest to the desired ones.

        Parameters
        ----------
        desired : (2, N) array
            Commands, m/s.
        positions : (2, N) array
            Positions, m.

        Returns
        -------
        velocity : (2, N) array
            Safe velocities, m/s.
        info : ProjectionInfo
            What was done.

        Raises
        ------
        ShapeError
            If the shapes do not fit.
        InfeasibleError, NotFiniteError
            Under the policy ``"raise"``.
        """
        desired = checks.columns("commands", desired, 2)
        positions = checks.columns("positions", positions, 2)
        checks.same_number(desired, positions)
        rows, barrier = self._book.write(Scene(positions))
        velocity, info = self._projector.project(desired, rows, self._top_speed)
        info.smallest_h, info.clearance = barrier
        return velocity, info
