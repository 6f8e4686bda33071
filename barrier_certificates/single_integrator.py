"""Certificates for robots that go where they are told: ẋ = v."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from barrier_certificates import checks
from barrier_certificates.certificate import Certificate, SafetyParameters
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.deadlock import DeadlockParameters
from barrier_certificates.limits import LimitRows, VelocityPolygon
from barrier_certificates.obstacles import Obstacle
from barrier_certificates.projection import Policy, ProjectionInfo
from barrier_certificates.rowbook import Margin
from barrier_certificates.rows import FloatArray, Scene


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


class SingleIntegratorCertificate(Certificate[SingleIntegratorParameters]):
    """The safe velocities nearest to the desired ones, for a team of single integrators.

    It remembers which rows bound last time, which makes the next call faster but never changes its
    result.

    Parameters
    ----------
    safety_radius, barrier_gain, unsafe_gain, boundary, wall_margin, obstacle_margin
        See `barrier_certificates.certificate.SafetyParameters`.
    speed_limit, speed_shape
        See `SingleIntegratorParameters`.
    obstacles, solver, on_infeasible, options, deadlock, tilt
        See `barrier_certificates.certificate.Certificate`.

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
        boundary: Any = None,
        wall_margin: float | None = None,
        obstacle_margin: float | None = None,
        speed_limit: float | None = 0.2,
        speed_shape: str = "octagon",
        obstacles: Sequence[Obstacle] = (),
        solver: str = "auto",
        on_infeasible: Policy = "relax",
        options: Mapping[str, float] | None = None,
        deadlock: DeadlockParameters | None = None,
        tilt: float = 0.0,
    ) -> None:
        parameters = SingleIntegratorParameters(
            safety_radius=safety_radius,
            barrier_gain=barrier_gain,
            unsafe_gain=unsafe_gain,
            boundary=boundary,
            wall_margin=wall_margin,
            obstacle_margin=obstacle_margin,
            speed_limit=speed_limit,
            speed_shape=speed_shape,
        )
        super().__init__(parameters, obstacles, solver, on_infeasible, options, deadlock, tilt)

    def _limits(self) -> LimitRows | None:
        limit = self._parameters.speed_limit
        if limit is None:
            return None
        octagon = self._parameters.speed_shape == "octagon"
        return (VelocityPolygon.octagon if octagon else VelocityPolygon.box)(limit).rows()

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
        desired, positions = checks.team(desired, positions, "positions", 2)
        if not checks.finite(desired, positions):
            return self._projector.refuse(desired)
        return self._certify(desired, Scene(positions))

    def margins(self, positions: Any, within: float = 0.1) -> list[Margin]:
        """Return every pair, wall and obstacle that is near to being unsafe, the nearest first.

        Parameters
        ----------
        positions : (2, N) array
            Positions, m.
        within : float
            Leave out what is clear by more than this, m.
        """
        return self._margins(Scene(checks.columns("positions", positions, 2)), within)
