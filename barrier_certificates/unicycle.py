"""Certificates for differential-drive robots, by a point ahead of the axle.

A unicycle cannot move sideways, but the *projection point* q = p + d·e(θ), a distance d ahead of
the axle, can move in any direction: q̇ = v·e + d·ω·e⊥. The certificate is that of single
integrators at the projection points, with what the motors can do as rows of the same program, in
the body frame (see `barrier_certificates.limits`). Because centre and projection point are d apart,
a radius of r + 2d between projection points keeps centres at least r apart.

While a robot turns, its projection point moves on an arc: after a step of dt it is d (1 − cos ω dt)
behind where a straight move would have ended. At 0.55 rad/s and 0.033 s that is 8 micrometres, at
3.6 rad/s a third of a millimetre, and it adds up. Given the *time step*, the certificate takes
velocities of projection points as means over the step, and turns them into the commands that end
the step exactly there: ω = arcsin(dt q̇·e⊥/d)/dt and v = q̇·e + d (1 − cos ω dt)/dt.

Wheels that do not turn quite as they are told are a bounded *disturbance*: given its bound, the
rows hold for the worst of it (see `barrier_certificates.disturbance`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from barrier_certificates import checks
from barrier_certificates.certificate import Certificate, SafetyParameters
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.deadlock import DeadlockParameters
from barrier_certificates.disturbance import WheelDisturbance
from barrier_certificates.limits import LimitRows, unicycle_polygon
from barrier_certificates.obstacles import Obstacle
from barrier_certificates.projection import Policy, ProjectionInfo
from barrier_certificates.rowbook import Margin
from barrier_certificates.rows import FloatArray, Scene


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
    wheel_disturbance : float
        Largest unwanted speed of a wheel, rad/s, that the rows have to survive.
    time_step : float
        How long a command is held, s; zero leaves the arc of turning robots out of account.
    """

    projection_distance: float = 0.05
    speed_limit: float | None = 0.2
    turn_rate_limit: float | None = None
    wheel_limit: float | None = 12.5
    wheel_radius: float = 0.016
    base_length: float = 0.105
    wheel_disturbance: float = 0.0
    time_step: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive("projection_distance", self.projection_distance, "of metres")
        checks.positive_or_none("speed_limit", self.speed_limit, "of m/s, or None")
        checks.positive_or_none("turn_rate_limit", self.turn_rate_limit, "of rad/s, or None")
        checks.positive_or_none("wheel_limit", self.wheel_limit, "of rad/s, or None")
        checks.positive("wheel_radius", self.wheel_radius, "of metres")
        checks.positive("base_length", self.base_length, "of metres")
        checks.not_negative("wheel_disturbance", self.wheel_disturbance, "of rad/s")
        checks.not_negative("time_step", self.time_step, "of seconds")
        if self.time_step and self.turn_rate_limit is None and self.wheel_limit is None:
            raise ParameterError(
                "a time step is of no use without a limit on turning; expected turn_rate_limit or "
                "wheel_limit"
            )


class UnicycleCertificate(Certificate[UnicycleParameters]):
    """The safe commands nearest to the desired ones, for a team of differential-drive robots.

    Call it with unicycle commands, or `project` velocities of the projection points. It remembers
    which rows bound last time, which makes the next call faster but never changes its result.

    Parameters
    ----------
    safety_radius : float
        Smallest distance between projection points, m: the centres' plus 2 d.
    barrier_gain, unsafe_gain, boundary, wall_margin, obstacle_margin
        See `barrier_certificates.certificate.SafetyParameters`; all act on the projection points.
    projection_distance, speed_limit, turn_rate_limit, wheel_limit, wheel_radius, base_length, \
wheel_disturbance, time_step
        See `UnicycleParameters`.
    obstacles, solver, on_infeasible, options, deadlock, tilt
        See `barrier_certificates.certificate.Certificate`.

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
        boundary: Any = None,
        wall_margin: float | None = None,
        obstacle_margin: float | None = None,
        projection_distance: float = 0.05,
        speed_limit: float | None = 0.2,
        turn_rate_limit: float | None = None,
        wheel_limit: float | None = 12.5,
        wheel_radius: float = 0.016,
        base_length: float = 0.105,
        wheel_disturbance: float = 0.0,
        time_step: float = 0.0,
        obstacles: Sequence[Obstacle] = (),
        solver: str = "auto",
        on_infeasible: Policy = "relax",
        options: Mapping[str, float] | None = None,
        deadlock: DeadlockParameters | None = None,
        tilt: float = 0.0,
    ) -> None:
        parameters = UnicycleParameters(
            safety_radius=safety_radius,
            barrier_gain=barrier_gain,
            unsafe_gain=unsafe_gain,
            boundary=boundary,
            wall_margin=wall_margin,
            obstacle_margin=obstacle_margin,
            projection_distance=projection_distance,
            speed_limit=speed_limit,
            turn_rate_limit=turn_rate_limit,
            wheel_limit=wheel_limit,
            wheel_radius=wheel_radius,
            base_length=base_length,
            wheel_disturbance=wheel_disturbance,
            time_step=time_step,
        )
        super().__init__(parameters, obstacles, solver, on_infeasible, options, deadlock, tilt)

    def _limits(self) -> LimitRows | None:
        p = self._parameters
        limits = unicycle_polygon(
            p.projection_distance,
            p.speed_limit,
            p.turn_rate_limit,
            p.wheel_limit,
            p.wheel_radius,
            p.base_length,
            p.time_step,
        )
        return None if limits is None else limits.rows(turning=True)

    def _disturbance(self) -> WheelDisturbance | None:
        p = self._parameters
        if p.wheel_disturbance == 0.0:
            return None
        return WheelDisturbance(
            p.wheel_disturbance, p.wheel_radius, p.base_length, p.projection_distance
        )

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
        desired, poses = checks.team(desired, poses, "poses", 3)
        if not checks.finite(desired, poses):
            return self._projector.refuse(desired)
        return self._certify(desired, self._scene(poses))

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
        desired, poses = checks.team(desired, poses, "poses", 3)
        if not checks.finite(desired, poses):
            return self._projector.refuse(desired)
        scene = self._scene(poses)
        assert scene.headings is not None
        cos, sin = scene.headings
        ahead, aside = self._means(desired)
        points = np.empty_like(desired)
        points[0] = ahead * cos - aside * sin
        points[1] = ahead * sin + aside * cos
        velocity, info = self._certify(points, scene)
        if info.status == "trivial":
            return desired.copy(), info
        return self._commands(velocity, scene.headings), info

    def commands(self, velocity: Any, poses: Any) -> FloatArray:
        """Return the unicycle commands (2, N) that move projection points with these velocities.

        Parameters
        ----------
        velocity : (2, N) array
            Velocities of the projection points, m/s, as `project` returns them.
        poses : (3, N) array
            Poses of the robots, m and rad.

        Raises
        ------
        ShapeError, NotFiniteError
            If the shapes do not fit, or anything is NaN or infinite.
        """
        velocity, poses = checks.team(velocity, poses, "poses", 3)
        checks.require_finite("velocities", velocity)
        checks.require_finite("poses", poses)
        return self._commands(velocity, np.stack([np.cos(poses[2]), np.sin(poses[2])]))

    def _commands(self, velocity: FloatArray, headings: FloatArray) -> FloatArray:
        (cos, sin), (x, y) = headings, velocity
        distance, step = self._parameters.projection_distance, self._parameters.time_step
        commands = np.empty_like(velocity)
        commands[0] = x * cos + y * sin
        commands[1] = (y * cos - x * sin) / distance
        if step:
            angle = np.arcsin(np.clip(step * commands[1], -1.0, 1.0))
            commands[0] += distance * (1.0 - np.cos(angle)) / step
            commands[1] = angle / step
        return commands

    def _means(self, commands: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how fast commands move the projection points, ahead and aside, m/s."""
        distance, step = self._parameters.projection_distance, self._parameters.time_step
        if not step:
            return commands[0], distance * commands[1]
        # Beyond a quarter turn a step cannot be told from a shorter one.
        angle = np.clip(step * commands[1], -0.5 * np.pi, 0.5 * np.pi)
        ahead = commands[0] - distance * (1.0 - np.cos(angle)) / step
        return ahead, distance * np.sin(angle) / step

    def margins(self, poses: Any, within: float = 0.1) -> list[Margin]:
        """Return every pair, wall and obstacle that is near to being unsafe, the nearest first.

        Parameters
        ----------
        poses : (3, N) array
            Poses of the robots, m and rad; margins are those of their projection points.
        within : float
            Leave out what is clear by more than this, m.
        """
        return self._margins(self._scene(checks.columns("poses", poses, 3)), within)

    def _scene(self, poses: FloatArray) -> Scene:
        """Return where the projection points are, and the headings."""
        headings = np.empty((2, poses.shape[1]))
        np.cos(poses[2], out=headings[0])
        np.sin(poses[2], out=headings[1])
        return Scene(poses[:2] + self._parameters.projection_distance * headings, headings)
