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


def _between_bodies(
    poses: NDArray[np.float64], ahead: float, first: NDArray[np.intp], second: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Return how far apart the points are that the testbed's test looks at, (T, P), m."""
    x, y, heading = np.moveaxis(poses, 1, 0)
    bodies = np.empty(x.shape, dtype=complex)  # the plane as complex numbers, as in the arena
    bodies.real = x + ahead * np.cos(heading)
    bodies.imag = y + ahead * np.sin(heading)
    return np.asarray(np.abs(bodies[:, first] - bodies[:, second]))
