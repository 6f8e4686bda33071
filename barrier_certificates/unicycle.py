"""Certificates for differential-drive robots, by a point ahead of the axle.

A unicycle cannot move sideways, but the *projection point* q = p + d·e(θ), a distance d ahead of
the axle, can move in any direction: q̇ = v·e + d·ω·e⊥. The certificate is that of single
integrators at the projection points, with what the motors can do as rows of the same program, in
the body frame (see `barrier_certificates.limits`). Because centre and projection point are d apart,
a radius of r + 2d between projection points keeps centres at least r apart.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from barrier_certificates import checks
from barrier_certificates.limits import unicycle_polygon
from barrier_certificates.projection import Policy, ProjectionInfo, Projector
from barrier_certificates.rows import Family, FloatArray, RowBook, Scene
from barrier_certificates.single_integrator import SafetyParameters


@dataclass(frozen=True)
class UnicycleParameters(SafetyParameters):
    """`SafetyParameters` at the projection points, and what the robots' motors can do.

    Parameters
    ----------
    projection_distance : float
        d, how far ahead of the axle the projection point lies, m.
    speed_limit, turn_rate_limit, wheel_limit : float or None
        Largest |v| in m/s, |ω| in rad/s and wheel speed in rad/s; None means no such limit.
    wheel_radius, base_length : float
        Radius of the wheels and distance between them, m.
    """

    projection_distance: float = 0.05
    speed_limit: float | None = 0.2
    turn_rate_limit: float | None = None
    wheel_limit: float | None = 12.5
    wheel_radius: float = 0.016
    base_length: float = 0.105

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive("projection_distance", self.projection_distance, "of metres")
        checks.positive_or_none("speed_limit", self.speed_limit, "of m/s, or None")
        checks.positive_or_none("turn_rate_limit", self.turn_rate_limit, "of rad/s, or None")
        checks.positive_or_none("wheel_limit", self.wheel_limit, "of rad/s, or None")
        checks.positive("wheel_radius", self.wheel_radius, "of metres")
        checks.positive("base_length", self.base_length, "of metres")


class UnicycleCertificate:
    """The safe commands nearest to the desired ones, for a team of differential-drive robots.

    Call it with unicycle commands, or `project` velocities of the projection points. It remembers
    which rows bound last time, which makes the next call faster but never changes its result.

    Parameters
    ----------
    safety_radius : float
        Smallest distance between projection points, m: the centres' plus 2 d.
    barrier_gain, unsafe_gain, boundary, wall_margin
        See `SafetyParameters`; walls act on the projection points.
    projection_distance, speed_limit, turn_rate_limit, wheel_limit, wheel_radius, base_length
        See `UnicycleParameters`.
    on_infeasible, solver, options
        See `barrier_certificates.projection.Projector`.

    Examples
    --------
    >>> import numpy as np
    >>> certificate = UnicycleCertificate(safety_radius=0.27, speed_limit=0.15)
    >>> poses = np.array([[-0.2, 0.2], [0.0, 0.0], [0.0, np.pi]])   # face to face
    >>> commands, info = certificate([[0.15, 0.15], [0.0, 0.0]], poses)
    >>> info.status, info.active
    ('optimal', ('robots 0 and 1',))
    >>> bool(commands[0, 0] < 0.01)
    True
    """

    def __init__(
        self,
        safety_radius: float = 0.15,
        barrier_gain: float = 100.0,
        *,
        unsafe_gain: float | None = None,
        boundary: tuple[float, float, float, float] | None = None,
        wall_margin: float | None = None,
        projection_distance: float = 0.05,
        speed_limit: float | None = 0.2,
        turn_rate_limit: float | None = None,
        wheel_limit: float | None = 12.5,
        wheel_radius: float = 0.016,
        base_length: float = 0.105,
        on_infeasible: Policy = "relax",
        solver: str = "auto",
        options: Mapping[str, float] | None = None,
    ) -> None:
        self._projector = Projector(solver, on_infeasible, options)
        self.parameters = UnicycleParameters(
            safety_radius=safety_radius,
            barrier_gain=barrier_gain,
            unsafe_gain=unsafe_gain,
            boundary=boundary,
            wall_margin=wall_margin,
            projection_distance=projection_distance,
            speed_limit=speed_limit,
            turn_rate_limit=turn_rate_limit,
            wheel_limit=wheel_limit,
            wheel_radius=wheel_radius,
            base_length=base_length,
        )

    @property
    def parameters(self) -> UnicycleParameters:
        """What the certificate keeps; set it (``dataclasses.replace``) to change it."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: UnicycleParameters) -> None:
        self._parameters = parameters
        families: list[Family] = []
        limits = unicycle_polygon(
            parameters.projection_distance,
            parameters.speed_limit,
            parameters.turn_rate_limit,
            parameters.wheel_limit,
            parameters.wheel_radius,
            parameters.base_length,
        )
        self._top_speed = math.inf
        if limits is not None:
            self._top_speed = limits.top_speed()
            families.append(limits.rows(turning=True))
        families += parameters.wall_rows()
        self._book = RowBook(families, parameters.pair_rows(), self._top_speed)
        self.reset()

    def reset(self) -> None:
        """Forget the previous step."""
        self._projector.reset()

    def project(self, desired: Any, poses: Any) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe velocities of the projection points nearest to the desired ones.

        Parameters
        ----------
        desired : (2, N) array
            Velocities of the projection points, m/s.
        poses : (3, N) array
            Poses of the robots (not of the projection points), m and rad.

        Returns
        -------
        velocity : (2, N) array
            Safe velocities of the projection points, m/s.
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
        poses = checks.columns("poses", poses, 3)
        checks.same_number(desired, poses)
        return self._project(desired, poses, self._headings(poses))

    def __call__(self, desired: Any, poses: Any) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe unicycle commands nearest to the desired ones.

        Nearest is meant at the projection points, where 1 rad/s counts as d m/s.

        Parameters
        ----------
        desired : (2, N) array
            Unicycle commands: v in m/s and ω in rad/s.
        poses : (3, N) array
            Poses of the robots, m and rad.

        Returns
        -------
        commands : (2, N) array
            Safe unicycle commands, m/s and rad/s.
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
        poses = checks.columns("poses", poses, 3)
        checks.same_number(desired, poses)
        headings = self._headings(poses)
        cos, sin = headings
        distance = self._parameters.projection_distance
        ahead, aside = desired[0], distance * desired[1]
        points = np.stack([ahead * cos - aside * sin, ahead * sin + aside * cos])
        velocity, info = self._project(points, poses, headings)
        if info.status == "trivial":
            return desired.copy(), info
        x, y = velocity
        return np.stack([x * cos + y * sin, (y * cos - x * sin) / distance]), info

    @staticmethod
    def _headings(poses: FloatArray) -> FloatArray:
        headings = np.empty((2, poses.shape[1]))
        np.cos(poses[2], out=headings[0])
        np.sin(poses[2], out=headings[1])
        return headings

    def _project(
        self, desired: FloatArray, poses: FloatArray, headings: FloatArray
    ) -> tuple[FloatArray, ProjectionInfo]:
        points = poses[:2] + self._parameters.projection_distance * headings
        rows, barrier = self._book.write(Scene(points, headings))
        velocity, info = self._projector.project(desired, rows, self._top_speed)
        info.smallest_h, info.clearance = barrier
        return velocity, info
