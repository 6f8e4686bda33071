"""Initial conditions: what may be asked for, and how robots come to them.

On the testbed every experiment begins with a drive: the robots leave their chargers, go to the
poses that the script asks for, and the experiment starts when all are within tolerance. Generation
2 simulates that drive. Here it is done with the exact certificate of :mod:`barrier_certificates`,
which keeps the very points apart that the collision test looks at.

Who starts where is free, so the starts are assigned to the robots such that the sum of squared
ways is smallest. Straight ways then do not cross, and if all robots keep to the same timetable they
do not meet (concurrent assignment and planning of trajectories, Turpin et al. 2014). What is left
to the certificate is turning and the last centimetres; a team that still gets stuck is shaken by a
little noise until it comes loose.
"""

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import beyond, first_smallest, short_of, within
from barrier_certificates.wall_distance import wall_distances
from rps_compat.arena import Arena, Array
from rps_compat.errors import InitialConditionsError, UnreachableError
from rps_compat.kinematics import wrap
from rps_compat.placement import CrowdedError
from rps_compat.testbed import RobotModel

#: How near the drive brings every robot, as the published simulator: metres and radians.
POSITION_TOLERANCE, HEADING_TOLERANCE = 0.02, 0.18
#: How near the testbed brings them.
ARRIVAL_POSITION, ARRIVAL_HEADING = 0.05, 0.2
#: A drive that takes longer than this has failed, seconds.
LONGEST_DRIVE = 600.0
#: So has one in which nobody has come nearer for this long, seconds. In 100 drives of 2 to 40
#: robots that arrived it was 2 s at most.
HOPELESS = 60.0

_CRUISE = 0.15  # m/s of the robot with the longest way
_SAFETY = 0.01  # m that the certificate keeps beyond the collision diameter
_SHRINKING = 0.8  # of the spacing between drawn poses, where a team is too large for it
_GRID_SPACING = 0.26  # m that the grid's places are apart at least
_PATIENCE = 90  # steps without progress before the robots are shaken


def checked_poses(poses: Any, number_of_robots: int) -> Array:
    """Copy initial conditions as floats, whatever kind of number they are.

    Parameters
    ----------
    poses : (3, N) array
        What the script gave, m and rad.
    number_of_robots : int
        Number of robots, N.

    Returns
    -------
    (3, N) array
        Poses, m and rad.

    Raises
    ------
    InitialConditionsError
        Not an array, not of shape (3, `number_of_robots`), not numbers, or not finite.
    """
    if not isinstance(poses, np.ndarray):
        raise InitialConditionsError(
            f"initial_conditions is a {type(poses).__name__}, expected a numpy array (3, N), "
            "e.g. np.array([[x], [y], [theta]])"
        )
    if poses.shape != (3, number_of_robots):
        raise InitialConditionsError(
            f"initial_conditions have shape {poses.shape}, expected (3, {number_of_robots}): "
            f"a column (x, y, theta) for each of the {number_of_robots} robots"
        )
    if poses.dtype.kind not in "fiu":
        raise InitialConditionsError(
            f"initial_conditions are of type {poses.dtype}, expected metres and radians as numbers"
        )
    copy = np.array(poses, dtype=float)
    if not math.isfinite(np.abs(copy).max(initial=0.0)):
        row, robot = (int(k) for k in np.argwhere(~np.isfinite(copy))[0])
        raise InitialConditionsError(
            f"initial_conditions[{row}, {robot}] ({('x', 'y', 'theta')[row]} of robot {robot}) is "
            f"{copy[row, robot]}, expected a finite number"
        )
    return copy


def warn_of_outside(poses: Array, robot: RobotModel) -> None:
    """Warn of robots that stand outside the arena.

    Published scripts start some there, so nobody is refused; the run's report counts them.

    Parameters
    ----------
    poses : (3, N) array
        Where they stand, m and rad.
    robot : RobotModel
        Dimensions and limits of the robots, and the arena.
    """
    x, y, _ = poses
    x_min, x_max, y_min, y_max = robot.boundaries
    outside = np.flatnonzero(short_of(wall_distances(poses, robot.boundaries), 0.0))
    if outside.size:
        where = ", ".join(f"robot {k} at ({x[k]:g}, {y[k]:g})" for k in outside)
        warnings.warn(
            f"outside the arena would start {where}: it is {x_min:g} <= x <= {x_max:g}, "
            f"{y_min:g} <= y <= {y_max:g} (metres)",
            stacklevel=5,
        )


def check_distances(poses: Array, robot: RobotModel, *, apart: bool) -> None:
    """Check that no two robots are too close.

    Where robots start so, as in published scripts, a warning names them, and the run's report
    counts them.

    Parameters
    ----------
    poses : (3, N) array
        Where they stand, m and rad.
    robot : RobotModel
        Dimensions and limits of the robots, and the arena.
    apart : bool
        Whether two that are too close are refused, or warned of.

    Raises
    ------
    InitialConditionsError
        Two are too close although they have to be `apart`: a drive cannot bring them there.
    """
    if poses.shape[1] < 2:
        return
    distance, first, second = _nearest_pair(poses, robot.collision_offset)
    if within(distance, robot.collision_diameter):
        message = (
            f"robots {first} and {second} would start too close: their collision points are "
            f"{100 * distance:.1f} cm apart, less than {100 * robot.collision_diameter:.1f} cm"
        )
        if apart:
            raise InitialConditionsError(message + "; the robots cannot be driven there")
        warnings.warn(message, stacklevel=5)


def _nearest_pair(poses: Array, ahead: float) -> tuple[float, int, int]:
    i, j = np.triu_indices(poses.shape[1], 1)
    bodies = poses[:2] + ahead * np.array([np.cos(poses[2]), np.sin(poses[2])])
    distances = np.hypot(*(bodies[:, i] - bodies[:, j]))
    nearest = first_smallest(distances)
    return float(distances[nearest]), int(i[nearest]), int(j[nearest])


def starting_places(targets: Array, robot: RobotModel, rng: np.random.Generator) -> Array:
    """Draw poses from which robots can drive to their targets, well apart.

    The places are drawn from a grid that holds up to 50 robots, jittered, and assigned to the
    robots with the smallest sum of squared ways; headings are random.

    Parameters
    ----------
    targets : (3, N) array
        Where each robot is to stand, m and rad.
    robot : RobotModel
        Dimensions and limits of the robots, and the arena.
    rng : Generator
        Where places and headings are drawn from.

    Returns
    -------
    (3, N) array
        Poses, m and rad.
    """
    from scipy.optimize import linear_sum_assignment

    robots = targets.shape[1]
    places = _grid_places(robots, robot, rng)
    ways = ((targets[:2, :, None] - places[:, None, :]) ** 2).sum(axis=0)
    _, chosen = linear_sum_assignment(ways)
    return np.vstack([places[:, chosen], rng.uniform(-np.pi, np.pi, robots)])


def _grid_places(robots: int, robot: RobotModel, rng: np.random.Generator) -> Array:
    """Draw positions (2, `robots`) from a jittered grid that holds 50, at least 26 cm apart."""
    x_min, x_max, y_min, y_max = robot.boundaries
    across, down = np.meshgrid(
        np.linspace(x_min + 0.15, x_max - 0.15, 10), np.linspace(y_min + 0.15, y_max - 0.15, 5)
    )
    grid = np.stack([across.ravel(), down.ravel()])
    places: Array = grid[:, rng.choice(grid.shape[1], robots, replace=False)]
    return places + rng.uniform(-0.03, 0.03, places.shape)


def drawn_poses(
    draw: Callable[[float], Array],
    spacing: float,
    robots: int,
    robot: RobotModel,
    rng: Callable[[], np.random.Generator],
) -> Array:
    """Draw poses for a script that gives none, as the API does where that works.

    Parameters
    ----------
    draw : callable
        The API's own draw, from the distance that robots are to keep (m).
    spacing : float
        The distance that the API asks for, m. Large teams do not fit so far apart, and nobody asked
        for it: it shrinks, until a jittered grid keeps the robots farther apart.
    robots : int
        Number of robots, N.
    robot : RobotModel
        Dimensions and limits of the robots, and the arena.
    rng : callable
        Makes the random stream of the grid; not called where `draw` finds places.

    Returns
    -------
    (3, N) array
        Poses, m and rad.
    """
    while True:
        try:
            return draw(spacing)
        except CrowdedError:
            spacing *= _SHRINKING
        if spacing < _GRID_SPACING:
            break
    stream = rng()
    places = _grid_places(robots, robot, stream)
    return np.vstack([places, stream.uniform(-np.pi, np.pi, robots)])


def near(targets: Array, robot: RobotModel, rng: np.random.Generator) -> Array:
    """Draw poses as the testbed's drive leaves them: within 5 cm and 0.2 rad of the targets.

    Errors that would bring two robots too close are drawn again, with less and less error; none
    brings a robot outside whose target is inside.

    Parameters
    ----------
    targets : (3, N) array
        Where each robot is to stand, m and rad.
    robot : RobotModel
        Dimensions and limits of the robots, and the arena.
    rng : Generator
        Where the errors are drawn from.

    Returns
    -------
    (3, N) array
        Poses, m and rad.
    """
    robots = targets.shape[1]
    x_min, x_max, y_min, y_max = _room_for(targets, robot)
    poses: Array
    for attempt in range(200):
        reach = ARRIVAL_POSITION * np.sqrt(rng.uniform(0, 1, robots)) * float(0.98**attempt)
        course = rng.uniform(-np.pi, np.pi, robots)
        turn = rng.uniform(-ARRIVAL_HEADING, ARRIVAL_HEADING, robots)
        poses = targets + np.stack([reach * np.cos(course), reach * np.sin(course), turn])
        poses[0] = np.clip(poses[0], x_min, x_max)
        poses[1] = np.clip(poses[1], y_min, y_max)
        poses[2] = wrap(poses[2])
        if robots < 2:
            return poses
        if beyond(_nearest_pair(poses, robot.collision_offset)[0], robot.collision_diameter):
            return poses
    return np.array(targets)


def _room_for(targets: Array, robot: RobotModel) -> tuple[float, float, float, float]:
    """Return the arena's (x_min, x_max, y_min, y_max), wide enough for all `targets` (3, N)."""
    x_min, x_max, y_min, y_max = robot.boundaries
    x, y, _ = targets
    return (
        float(x.min(initial=x_min)),
        float(x.max(initial=x_max)),
        float(y.min(initial=y_min)),
        float(y.max(initial=y_max)),
    )


class Drive:
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
            radius = min(radius, _nearest_pair(targets, ahead)[0] - 1e-3)
        x_min, x_max, y_min, y_max = _room_for(targets, robot)
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
        As for `Drive`.
    after_step : callable
        Is called after each step, for sensors and windows.

    Raises
    ------
    InitialConditionsError
        Two robots are too close at `targets`.
    UnreachableError
        They did not arrive; the message says which, and how far they were.
    """
    drive = Drive(targets, arena.robot, rng)
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
    arena.commands = np.zeros((2, arena.number_of_robots))


def first_poses(
    targets: Array,
    mode: Literal["exact", "arrive", "drive"],
    robot: RobotModel,
    rng: Callable[[], np.random.Generator],
) -> Array:
    """Return where the robots of a new instance stand: at their targets, near, or yet to be driven.

    Parameters
    ----------
    targets : (3, N) array
        Where each robot is to stand, m and rad.
    mode : {"exact", "arrive", "drive"}
        How they come to their targets, see `Session`.
    robot : RobotModel
        Dimensions and limits of the robots, and the arena.
    rng : callable
        Makes the random stream of what is drawn; not called for "exact".

    Returns
    -------
    (3, N) array
        Poses, m and rad.

    Raises
    ------
    InitialConditionsError
        Two robots are too close at `targets` to be driven there.
    """
    warn_of_outside(targets, robot)
    check_distances(targets, robot, apart=mode == "drive")
    if mode == "exact":
        return targets
    return (near if mode == "arrive" else starting_places)(targets, robot, rng())
