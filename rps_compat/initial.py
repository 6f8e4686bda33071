"""Initial conditions: what may be asked for, and where robots stand before they come to them.

Robots begin at their targets, near them as the testbed's drive leaves them, or at places of their
own from which they are driven (:mod:`rps_compat.initial_drive`).

Who starts where is free, so the starts are assigned to the robots such that the sum of squared
ways is smallest. Straight ways then do not cross, and if all robots keep to the same timetable they
do not meet (concurrent assignment and planning of trajectories, Turpin et al. 2014).
"""

import math
import warnings
from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from barrier_certificates.ties import beyond, first_smallest, short_of, within
from barrier_certificates.wall_distance import wall_distances
from rps_compat.arena import Array
from rps_compat.errors import InitialConditionsError
from rps_compat.kinematics import wrap
from rps_compat.placement import CrowdedError
from rps_compat.testbed import RobotModel

#: How near the testbed brings them.
ARRIVAL_POSITION, ARRIVAL_HEADING = 0.05, 0.2

_SHRINKING = 0.8  # of the spacing between drawn poses, where a team is too large for it
_GRID_SPACING = 0.26  # m that the grid's places are apart at least


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
    distance, first, second = nearest_pair(poses, robot.collision_offset)
    if within(distance, robot.collision_diameter):
        message = (
            f"robots {first} and {second} would start too close: their collision points are "
            f"{100 * distance:.1f} cm apart, less than {100 * robot.collision_diameter:.1f} cm"
        )
        if apart:
            raise InitialConditionsError(message + "; the robots cannot be driven there")
        warnings.warn(message, stacklevel=5)


def nearest_pair(poses: Array, ahead: float) -> tuple[float, int, int]:
    """Return how near the two robots are whose collision points are nearest, and which they are.

    Parameters
    ----------
    poses : (3, N) array
        Poses of two robots or more, m and rad.
    ahead : float
        How far ahead of the centres the collision points lie, m.

    Returns
    -------
    distance : float
        Between the two points, m.
    first, second : int
        The robots, counted from 0.
    """
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
    x_min, x_max, y_min, y_max = room_for(targets, robot)
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
        if beyond(nearest_pair(poses, robot.collision_offset)[0], robot.collision_diameter):
            return poses
    return np.array(targets)


def room_for(targets: Array, robot: RobotModel) -> tuple[float, float, float, float]:
    """Return the arena, made wide enough for robots whose targets lie outside.

    Parameters
    ----------
    targets : (3, N) array
        Where each robot is to stand, m and rad.
    robot : RobotModel
        Its boundaries are the arena's.

    Returns
    -------
    x_min, x_max, y_min, y_max : float
        Boundaries, m.
    """
    x_min, x_max, y_min, y_max = robot.boundaries
    x, y, _ = targets
    return (
        float(x.min(initial=x_min)),
        float(x.max(initial=x_max)),
        float(y.min(initial=y_min)),
        float(y.max(initial=y_max)),
    )


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
