"""Certificates for differential-drive robots, by a point ahead of the axle.

A unicycle cannot move sideways, but a *look-ahead point* q = p + d·e(θ), a distance d ahead of the
axle, can move in any direction: q̇ = v·e + d·ω·e⊥. (The Robotarium calls it the *projection point*,
and so do we from here on.) The certificate is that of single integrators at the projection points,
with what the motors can do as rows of the same program, in the body frame (see
`barrier_certificates.differential_drive`). Because centre and projection point are d apart, a
radius of r + 2d between projection points keeps centres at least r apart.

While a robot turns, its projection point moves on an arc: after a step of dt it is d (1 − cos ω dt)
behind where a straight move would have ended. At 0.55 rad/s and 0.033 s that is 8 micrometres, at
3.6 rad/s a third of a millimetre, and it adds up. Given the *time step*, the certificate takes
velocities of projection points as means over the step, and turns them into the commands that end
the step exactly there: ω = arcsin(dt q̇·e⊥/d)/dt and v = q̇·e + d (1 − cos ω dt)/dt.

Wheels that do not turn quite as they are told are a bounded *disturbance*: given its bound, the
rows hold for the worst of it (see `barrier_certificates.rows.disturbance`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from barrier_certificates import checks
from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate import Certificate
from barrier_certificates.differential_drive import DifferentialDrive
from barrier_certificates.per_robot import as_numbers
from barrier_certificates.projection import ProjectionInfo, Status
from barrier_certificates.rows import (
    LimitRows,
    Margin,
    Obstacle,
    Scene,
    WallRows,
    WheelDisturbance,
)

__all__ = ["UnicycleCertificate"]


@dataclass(frozen=True)
class UnicycleCertificate(Certificate, DifferentialDrive):
    """The safe commands nearest to the desired ones, for a team of differential-drive robots.

    Call it with unicycle commands, or `project` velocities of the projection points. All other
    parameters are those of `barrier_certificates.certificate.Certificate`, which act on the
    projection points, and of `barrier_certificates.differential_drive.DifferentialDrive`.

    Parameters
    ----------
    safety_radius : float or (N,) array-like
        Smallest distance between projection points, m: the centres' plus 2 d. Of each robot with a
        radius rᵢ of its own: 2 (rᵢ + dᵢ).
    robust_walls : bool
        Whether walls allow for the wheels' disturbance, as pairs and obstacles do.

    Examples
    --------
    >>> import numpy as np
    >>> certificate = UnicycleCertificate(safety_radius=0.27, speed_limit=0.15)
    >>> poses = np.array([[-0.2, 0.2], [0.0, 0.0], [0.0, np.pi]])   # face to face
    >>> commands, info = certificate([[0.15, 0.15], [0.0, 0.0]], poses)
    >>> print(info.status, info.active)
    optimal ('robots 0 and 1',)
    >>> bool(commands[0, 0] < 0.01)
    True
    """

    answers_late: ClassVar[bool] = False
    """Whether poses have to be brought to where robots come to rest, by `stops`, beforehand."""

    may_differ: ClassVar[tuple[str, ...]] = (*Certificate.may_differ, *DifferentialDrive.may_differ)

    _: KW_ONLY
    robust_walls: bool = True

    def check(self) -> None:
        """Refuse parameters that make no sense."""
        Certificate.check(self)
        DifferentialDrive.check(self)

    @cached_property
    def look_ahead(self) -> float | FloatArray:
        """How far ahead of their axles the projection points lie, float or (N,) array, m."""
        return as_numbers(self.projection_distance)

    def _motor_limits(self) -> LimitRows | None:
        return self.limit_rows()

    def _disturbance(self) -> WheelDisturbance | None:
        return self.disturbance()

    def _wall_rows(self, disturbance: WheelDisturbance | None) -> WallRows | None:
        return super()._wall_rows(disturbance if self.robust_walls else None)

    def project(
        self, desired: Any, poses: Any, obstacles: Sequence[Obstacle] | None = None
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe velocities of the projection points nearest to the desired ones.

        Parameters
        ----------
        desired : (2, N) array
            Velocities of the projection points, m/s.
        poses : (3, N) array
            Poses of the robots (not of the projection points), m and rad.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, instead of those of the certificate.

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
        desired, poses = checks.team(desired, poses, "poses", 3, self.team_size)
        if not checks.finite(desired, poses):
            return self._refuse(desired)
        return self._certify(desired, self._scene(poses), obstacles)

    def __call__(
        self, desired: Any, poses: Any, obstacles: Sequence[Obstacle] | None = None
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe unicycle commands nearest to the desired ones.

        Nearest is meant at the projection points, where 1 rad/s counts as d m/s.

        Parameters
        ----------
        desired : (2, N) array
            Unicycle commands: v in m/s and ω in rad/s.
        poses : (3, N) array
            Poses of the robots, m and rad.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, instead of those of the certificate.

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
        desired, poses = checks.team(desired, poses, "poses", 3, self.team_size)
        if not checks.finite(desired, poses):
            return self._refuse(desired)
        scene = self._scene(poses)
        assert scene.headings is not None
        cos, sin = scene.headings
        ahead, aside = self._means(desired)
        points = np.empty_like(desired)
        points[0] = ahead * cos - aside * sin
        points[1] = ahead * sin + aside * cos
        velocity, info = self._certify(points, scene, obstacles)
        if info.status is Status.TRIVIAL:
            return desired.copy(), info
        return self._commands(velocity, scene.headings), info

    def commands(self, velocity: Any, poses: Any) -> FloatArray:
        """Return the unicycle commands that move projection points with these velocities.

        Parameters
        ----------
        velocity : (2, N) array
            Velocities of the projection points, m/s, as `project` returns them.
        poses : (3, N) array
            Poses of the robots, m and rad.

        Returns
        -------
        (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.

        Raises
        ------
        ShapeError, NotFiniteError
            If the shapes do not fit, or anything is NaN or infinite.
        """
        velocity, poses = checks.team(velocity, poses, "poses", 3, self.team_size)
        checks.require_finite("velocities", velocity)
        checks.require_finite("poses", poses)
        return self._commands(velocity, np.stack([np.cos(poses[2]), np.sin(poses[2])]))

    def stops(self, poses: FloatArray) -> FloatArray:
        """Return the poses that a certificate is about: those of robots that obey at once.

        Parameters
        ----------
        poses : (3, N) array
            Poses as tracked, m and rad.

        Returns
        -------
        (3, N) array
            The same poses.
        """
        return poses

    def sent(self, commands: FloatArray) -> None:
        """Take note of the commands that robots are sent: nothing, where these act at once.

        Parameters
        ----------
        commands : (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """

    def _commands(self, velocity: FloatArray, headings: FloatArray) -> FloatArray:
        (cos, sin), (x, y) = headings, velocity
        distance, step = self.look_ahead, self.time_step
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
        distance, step = self.look_ahead, self.time_step
        if not step:
            return commands[0], distance * commands[1]
        # Beyond a quarter turn a step cannot be told from a shorter one.
        angle = np.clip(step * commands[1], -0.5 * np.pi, 0.5 * np.pi)
        ahead = commands[0] - distance * (1.0 - np.cos(angle)) / step
        return ahead, distance * np.sin(angle) / step

    def margins(
        self, poses: Any, within: float = 0.1, obstacles: Sequence[Obstacle] | None = None
    ) -> list[Margin]:
        """Return every pair, wall, obstacle and link that is near to its limit, the nearest first.

        Parameters
        ----------
        poses : (3, N) array
            Poses of the robots, m and rad; margins are those of their projection points.
        within : float
            Leave out what is clear by more than this, m.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, instead of those of the certificate.
        """
        poses = checks.columns("poses", poses, 3, self.team_size)
        return self._margins(self._scene(poses), within, obstacles)

    def _scene(self, poses: FloatArray) -> Scene:
        """Return where the projection points are, and the headings."""
        headings = np.empty((2, poses.shape[1]))
        np.cos(poses[2], out=headings[0])
        np.sin(poses[2], out=headings[1])
        return Scene(poses[:2] + self.look_ahead * headings, headings)
