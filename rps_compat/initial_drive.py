"""The drive to the initial conditions, before an experiment begins.

On the testbed every experiment begins with a drive: the robots leave their chargers, go to the
poses that the script asks for, and the experiment starts when all are within tolerance. Generation
2 simulates that drive. Here it is done with the exact certificate of :mod:`barrier_certificates`,
which keeps the very points apart that the collision test looks at.

The robots start where :func:`~rps_compat.initial.starting_places` puts them: straight ways then do
not cross, and if all robots keep to the same timetable they do not meet. What is left to the
certificate is turning and the last centimetres; a team that still gets stuck is shaken by a little
noise until it comes loose.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import beyond
from rps_compat.arena import Arena, Array
from rps_compat.errors import UnreachableError
from rps_compat.initial import check_distances, nearest_pair, room_for
from rps_compat.kinematics import wrap
from rps_compat.testbed import RobotModel

#: How near the drive brings every robot, as the published simulator: metres and radians.
POSITION_TOLERANCE, HEADING_TOLERANCE = 0.02, 0.18
#: A drive that takes longer than this has failed, seconds.
LONGEST_DRIVE = 600.0
#: So has one in which nobody has come nearer for this long, seconds. In 100 drives of 2 to 40
#: robots that arrived it was 2 s at most.
HOPELESS = 60.0

_CRUISE = 0.15  # m/s of the robot with the longest way
_SAFETY = 0.01  # m that the certificate keeps beyond the collision diameter
_PATIENCE = 90  # steps without progress before the robots are shaken


class InitialDrive:
    """Commands that bring a team to its initial conditions.

    Parameters
    ----------
    targets : (3, N) array
        Where each robot is to stand, m and rad.
    robot : RobotModel
        Dimensions and limits of the robots, and the arena.
    rng : Generator
        Draws the shaking that frees robots which block each other.

    Raises
    ------
    InitialConditionsError
        Two robots are too close at `targets`.
    """

    def __init__(self, targets: Array, robot: RobotModel, rng: np.random.Generator) -> None:
        from barrier_certificates.unicycle import UnicycleCertificate

        check_distances(targets, robot, apart=True)
        self._targets, self._robot, self._rng = targets, robot, rng
        ahead = robot.collision_offset
        radius = robot.collision_diameter + _SAFETY
        if targets.shape[1] > 1:
            radius = min(radius, nearest_pair(targets, ahead)[0] - 1e-3)
        x_min, x_max, y_min, y_max = room_for(targets, robot)
        self._certificate = UnicycleCertificate(
            safety_radius=max(radius, robot.collision_diameter + 1e-4),
            barrier_gain=2000.0,
            boundary=(x_min - ahead, x_max + ahead, y_min - ahead, y_max + ahead),
            wall_margin=0.0,
            projection_distance=ahead,
            speed_limit=0.2,
            turn_rate_limit=2.5,
            wheel_limit=0.999 * robot.max_wheel_velocity,
            wheel_radius=robot.wheel_radius,
            base_length=robot.base_length,
        )
        self._settled = np.zeros(targets.shape[1], dtype=bool)
        self._best = math.inf
        self._idle = self._shaking = 0
        self._nearest, self._driven, self._stalled = math.inf, 0, 0

    def arrived(self, poses: Array) -> bool:
        """Return whether all robots are within tolerance of their targets.

        Parameters
        ----------
        poses : (3, N) array
            Poses, m and rad.
        """
        return not self._late(poses).any()

    def _late(self, poses: Array) -> NDArray[np.bool_]:
        """Which robots at `poses` (3, N) are not yet within tolerance."""
        far = beyond(self._position_errors(poses), POSITION_TOLERANCE)
        late: NDArray[np.bool_] = far | beyond(np.abs(self._turns(poses)), HEADING_TOLERANCE)
        return late

    def _position_errors(self, poses: Array) -> Array:
        errors: Array = np.hypot(*(self._targets[:2] - poses[:2]))
        return errors

    def _turns(self, poses: Array) -> Array:
        return wrap(self._targets[2] - poses[2])

    def commands(self, poses: Array) -> Array:
        """Return certified velocities towards the targets.

        Parameters
        ----------
        poses : (3, N) array
            Poses, m and rad.

        Returns
        -------
        (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """
        ahead = self._robot.collision_offset
        ways = self._targets[:2] - poses[:2]
        left = np.hypot(*ways)
        # One timetable for all: who has the longest way drives at cruising speed.
        longest = max(float(left.max()), 1e-9)
        speed = np.maximum(_CRUISE * left / longest, np.minimum(1.5 * left, 0.08))
        velocity = ways * (np.minimum(speed, 2.0 * left) / np.maximum(left, 1e-9))
        # Near enough: stand and turn, unless pushed away again.
        self._settled = left < np.where(self._settled, 0.9 * POSITION_TOLERANCE, 0.012)
        turning = np.clip(2.0 * self._turns(poses), -2.0, 2.0)
        aside = np.array([-np.sin(poses[2]), np.cos(poses[2])])
        velocity = np.where(self._settled, ahead * turning * aside, velocity)
        velocity = velocity + self._shake(float(left.sum() + 0.02 * np.abs(turning).sum()), poses)
        safe, _ = self._certificate.project(velocity, poses)
        along = np.array([np.cos(poses[2]), np.sin(poses[2])])
        return np.stack([(safe * along).sum(axis=0), (safe * aside).sum(axis=0) / ahead])

    def _shake(self, distance: float, poses: Array) -> Array:
        """Noise for a team that makes no progress; nothing for one that does."""
        self._stalled += 1
        if distance < self._nearest - 1e-3:
            self._nearest, self._stalled = distance, 0
        if distance < self._best - 1e-3:
            self._best, self._idle = distance, 0
        self._idle += 1
        if self._idle > _PATIENCE:
            self._idle, self._shaking, self._best = 0, 45, math.inf
            self._noise = self._rng.normal(0.0, 0.1, (2, poses.shape[1]))
        if not self._shaking:
            return np.zeros((2, poses.shape[1]))
        self._shaking -= 1
        return self._noise

    def steps(self) -> Iterator[int]:
        """Count the steps that a drive may take: until its time is up, or nobody comes nearer."""
        time_step = self._robot.time_step
        for self._driven in range(int(LONGEST_DRIVE / time_step)):
            if beyond(self._stalled * time_step, HOPELESS):
                return
            yield self._driven

    def failure(self, poses: Array) -> UnreachableError:
        """Return the error that says which robots did not arrive at all, and how far they were.

        Parameters
        ----------
        poses : (3, N) array
            Poses, m and rad.
        """
        errors = self._position_errors(poses)
        late = np.flatnonzero(self._late(poses))
        which = ", ".join(f"{robot} ({100 * errors[robot]:.1f} cm away)" for robot in late[:8])
        driven = (self._driven + 1) * self._robot.time_step
        return UnreachableError(
            f"after {driven:.3g} s of driving, {late.size} of {errors.size} robots were not "
            f"at their initial conditions: robots {which}. Put the poses farther apart, or start "
            "there with skip_initialization=True or --initial exact"
        )


def drive_to(
    arena: Arena, targets: Array, rng: np.random.Generator, after_step: Callable[[], None]
) -> None:
    """Drive the robots of an arena to their targets, and stop them there.

    `after_step` is called after each step, for sensors and windows.

    Parameters
    ----------
    arena : Arena
        Where they are.
    targets : (3, N) array
        Where each robot is to stand, m and rad.
    rng : Generator
        As for `InitialDrive`.
    after_step : callable
        Is called after each step, for sensors and windows.

    Raises
    ------
    InitialConditionsError
        Two robots are too close at `targets`.
    UnreachableError
        They did not arrive; the message says which, and how far they were.
    """
    drive = InitialDrive(targets, arena.robot, rng)
    arena.driving_to_start = True
    try:
        for _ in drive.steps():
            poses = arena.observe()
            if drive.arrived(poses):
                break
            arena.commands = drive.commands(poses)
            arena.step()
            arena.steps_to_start += 1
            after_step()
        else:
            raise drive.failure(arena.observe())
    finally:
        arena.driving_to_start = False
    arena.commands = np.zeros((2, arena.number_of_robots))
