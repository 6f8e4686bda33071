"""What the arena would have held against a run, of which there is only a log."""

from collections.abc import Iterable

import numpy as np

from rps_compat.arena import Arena, Array
from rps_compat.testbed import RobotModel
from rps_compat.violations import Violations


def violations_of(poses: Array, robot: RobotModel, rows: Iterable[int]) -> Violations:
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
    arena = Arena(np.nan_to_num(poses[0]), robot)
    for row in rows:
        arena.place(poses[row])
        arena.steps = row
        if np.isnan(poses[row]).any():
            arena.check_seen()
        else:
            arena.check()
    return arena.violations
