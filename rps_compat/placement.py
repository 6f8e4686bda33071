"""Places for robots to start from: random with a distance to keep, or drawn from two rows.

Random numbers come from numpy's (or Python's) global generator, in the published order, so that a
seeded script starts from the same places here and there.
"""

import random

import numpy as np

from rps_compat.errors import RobotariumError
from rps_compat.kinematics import HALF_TURN, Array

#: Columns of each of the two rows of :func:`two_rows`.
COLUMNS = 11


class CrowdedError(RobotariumError, RuntimeError, AssertionError, ValueError):
    """So many robots do not fit so far apart."""


def spaced_positions(
    robots: int, spacing: float, width: float, height: float, candidates: int
) -> Array:
    """Draw positions in a centred rectangle, any two of them some distance apart.

    Candidates are drawn one by one and kept if they are far enough from those kept before.

    Parameters
    ----------
    robots : int
        Number of robots, N.
    spacing : float
        Least distance of two, m.
    width : float
        Of the rectangle, along x, m.
    height : float
        Of the rectangle, along y, m.
    candidates : int
        How many are drawn at most.

    Returns
    -------
    (2, N) array
        Positions, m.

    Raises
    ------
    CrowdedError
        There is less than a square of side `spacing` for each, or `candidates` draws did not do.
    """
    room = int(width / spacing * (height / spacing))
    if robots > room:
        raise CrowdedError(
            f"{robots} robots, {spacing:g} m apart, do not fit in {width:g} m x {height:g} m: "
            f"there is room for {room}; take fewer robots, a smaller spacing or a larger area"
        )
    positions = np.empty((2, robots))
    placed = 0
    for _ in range(candidates):
        x, y = np.random.rand() - 0.5, np.random.rand() - 0.5  # noqa: NPY002
        candidate = np.array([x * width, y * height])
        others = positions[:, :placed] - candidate[:, np.newaxis]
        if np.all(np.hypot(others[0], others[1]) >= spacing):
            positions[:, placed] = candidate
            placed += 1
            if placed == robots:
                return positions
    raise CrowdedError(
        f"only {placed} of {robots} robots found a place {spacing:g} m from the others in "
        f"{candidates} draws; draw again, or take fewer robots, a smaller spacing or a larger area"
    )


def two_rows(robots: int, width: float, height: float) -> Array:
    """Draw poses from two rows of eleven, which look at each other.

    Parameters
    ----------
    robots : int
        Number of robots, N.
    width : float
        From the first place of a row to its last, along x, m.
    height : float
        From row to row, along y, m.

    Returns
    -------
    (3, N) array
        Poses, m and rad.

    Raises
    ------
    ValueError
        More robots than the 22 places, or fewer than none.
    """
    slots = random.sample(range(2 * COLUMNS), robots)
    x = np.linspace(-width / 2, width / 2, COLUMNS)
    poses = np.empty((3, len(slots)))
    for robot, slot in enumerate(slots):
        column, upper = divmod(slot, 2)
        side = 1 if upper else -1
        poses[:, robot] = x[column], side * height / 2, -side * HALF_TURN / 2
    return poses
