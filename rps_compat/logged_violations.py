"""The arena's tests of poses that somebody logged: many rows at once, by the same arithmetic."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from barrier_certificates.wall_distance import wall_distances
from rps_compat.testbed import RobotModel
from rps_compat.violations import Violations

#: Pairs at a time: a few MB of temporaries.
_PAIRS_AT_A_TIME = 200_000
#: Robots from which on a k-d tree beats looking at all pairs.
_MANY = 200


def violations_of(poses: NDArray[np.float64], robot: RobotModel, rows: Iterable[int]) -> Violations:
    """Return what the arena holds against logged poses, by its own test of each row.

    Parameters
    ----------
    poses : (T, 3, N) array
        Logged poses over time, m and rad; NaN where a robot was not seen, which then has no faults.
    robot : RobotModel
        Whose collision test and arena are meant.
    rows : iterable of int
        Which rows to test, in order of time; the rows that are left out count as sound.
    """
    found = Violations()
    tested = np.fromiter(rows, dtype=np.intp)
    if poses.shape[2] >= _MANY:
        for step in tested.tolist():
            _of_many(found, step, poses[step], robot)
        return found
    first, second = np.triu_indices(poses.shape[2], 1)
    at_a_time = max(1, _PAIRS_AT_A_TIME // max(1, len(first)))
    for start in range(0, len(tested), at_a_time):
        some = tested[start : start + at_a_time]
        seen = poses[some]
        outside = -wall_distances(seen, robot.boundaries)
        distances = _between_bodies(seen, robot.collision_offset, first, second)
        near = ties.within(distances, robot.collision_diameter)
        crossed = ties.beyond(outside, 0.0).any(axis=1)
        for k in np.flatnonzero(crossed | near.any(axis=1)).tolist():
            step = int(some[k])
            if crossed[k]:
                found.outside(step, outside[k])
            close = np.flatnonzero(near[k])
            if close.size:
                found.close(step, first[close], second[close], distances[k, close])
    return found


def _of_many(found: Violations, step: int, poses: NDArray[np.float64], robot: RobotModel) -> None:
    """Enter what one row holds of many robots, most of whose pairs are far apart."""
    from scipy.spatial import cKDTree

    outside = -wall_distances(poses, robot.boundaries)
    if ties.beyond(outside, 0.0).any():
        found.outside(step, outside)
    bodies = _bodies(poses, robot.collision_offset)
    seen = np.flatnonzero(np.isfinite(bodies))
    tree = cKDTree(np.stack([bodies[seen].real, bodies[seen].imag], axis=1))
    # Farther than asked: the tree rounds otherwise, and the arena's test decides.
    met = tree.query_pairs(1.01 * robot.collision_diameter, output_type="ndarray")
    first, second = seen[met[np.lexsort(met.T[::-1])].T]
    distances = np.abs(bodies[first] - bodies[second])
    close = np.flatnonzero(ties.within(distances, robot.collision_diameter))
    if close.size:
        found.close(step, first[close], second[close], distances[close])


def _between_bodies(
    poses: NDArray[np.float64], ahead: float, first: NDArray[np.intp], second: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Return how far apart the points are that the testbed's test looks at, (T, P), m."""
    bodies = _bodies(poses, ahead)
    return np.asarray(np.abs(bodies[:, first] - bodies[:, second]))


def _bodies(poses: NDArray[np.float64], ahead: float) -> NDArray[np.complex128]:
    """Return those points of (..., 3, N) poses."""
    x, y, heading = np.moveaxis(poses, -2, 0)
    bodies = np.empty(x.shape, dtype=complex)  # the plane as complex numbers, as in the arena
    bodies.real = x + ahead * np.cos(heading)
    bodies.imag = y + ahead * np.sin(heading)
    return bodies
