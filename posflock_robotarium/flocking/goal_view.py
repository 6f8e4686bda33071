"""What a robot on the way to its goal sees: the goal, and who is near, both from where it stands.

Numbers of the same meaning for every robot let one small network drive them all, whatever their
number. All are turned into the robot's own frame (ahead, left) and seen from its look-ahead point,
which is what a certificate keeps apart and what a policy moves. Of the others there are sums with
weights that fade with the distance: nothing jumps where the second nearest becomes the nearest.

=========  =========================================================================================
column     what it is
=========  =========================================================================================
0, 1       towards the goal, ahead and left; of length 1 from 0.3 m on, shorter where it is nearer
2          how far the goal is, m; 1 from 1 m on
3 to 7     the sum over the others within 0.6 m of w·(1, cos β, sin β, cos 2β, sin 2β), where β is
           the bearing and w falls from 1 to 0 over the range
8 to 12    the same within 0.35 m
=========  =========================================================================================
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError

__all__ = [
    "LOOK_AHEAD",
    "VIEW_SIZE",
    "crowd",
    "goal_view",
    "in_own_frame",
    "look_ahead_points",
    "swapped_places",
]

Floats = NDArray[np.float64]

#: From a robot's centre to the look-ahead point, m.
LOOK_AHEAD = 0.05
#: How many numbers a robot sees.
VIEW_SIZE = 13
_NEAR_GOAL, _FAR_GOAL = 0.3, 1.0  # m
_RANGES = (0.6, 0.35)  # m
_RADII = (0.65, 0.8)  # m, of the places on the circle
_START_SPACING = 0.32  # m
_ATTEMPTS = 1000


def look_ahead_points(poses: Floats) -> Floats:
    """Return the points ahead of the robots that can move in any direction at once.

    Parameters
    ----------
    poses : (..., 3, N) array
        Poses, m and rad.

    Returns
    -------
    (..., 2, N) array
        Points, m.
    """
    heading = poses[..., 2, :]
    ahead: Floats = np.stack([np.cos(heading), np.sin(heading)], axis=-2)
    return poses[..., :2, :] + LOOK_AHEAD * ahead


def in_own_frame(vectors: Floats, headings: Floats) -> Floats:
    """Return vectors as robots see them: how far ahead, and how far to the left.

    Parameters
    ----------
    vectors : (..., 2, N) array
        A vector for each robot, in the arena's frame.
    headings : (..., N) array
        Where robots look, rad.

    Returns
    -------
    (..., N, 2) array
        The same, in each robot's own frame.
    """
    cosine, sine = np.cos(headings), np.sin(headings)
    x, y = vectors[..., 0, :], vectors[..., 1, :]
    return np.stack([cosine * x + sine * y, cosine * y - sine * x], axis=-1)


def crowd(points: Floats, headings: Floats, reach: float) -> Floats:
    """Return who is near, as sums over the others whose weights fade with the distance.

    Parameters
    ----------
    points : (..., 2, N) array
        Look-ahead points, m.
    headings : (..., N) array
        Where robots look, rad.
    reach : float
        Others that are farther do not count, m.

    Returns
    -------
    (..., N, 5) array
        Sums of w·(1, cos β, sin β, cos 2β, sin 2β), see above.
    """
    # What robot i (axis -2) sees of robot j (axis -1).
    x = points[..., 0, None, :] - points[..., 0, :, None]
    y = points[..., 1, None, :] - points[..., 1, :, None]
    apart = np.hypot(x, y)
    near = 1.0 / np.maximum(apart, 1e-6)
    cosine, sine = np.cos(headings)[..., None], np.sin(headings)[..., None]
    ahead, left = near * (cosine * x + sine * y), near * (cosine * y - sine * x)
    others = 1.0 - np.eye(points.shape[-1])
    weight = others * np.maximum(0.0, 1.0 - apart / reach)
    kinds = (1.0, ahead, left, ahead * ahead - left * left, 2.0 * ahead * left)
    return np.stack([(weight * kind).sum(axis=-1) for kind in kinds], axis=-1)


def goal_view(poses: Floats, goals: Floats) -> Floats:
    """Return what each robot sees on the way to its goal.

    Parameters
    ----------
    poses : (..., 3, N) array
        Poses, m and rad; leading axes are teams that do not see each other.
    goals : (..., 2, N) array
        Where the look-ahead points are to go, m.

    Returns
    -------
    (..., N, 13) array
        See above.
    """
    points, headings = look_ahead_points(poses), poses[..., 2, :]
    way = goals - points
    distance = np.hypot(way[..., 0, :], way[..., 1, :])[..., None]
    towards = in_own_frame(way, headings) / np.maximum(distance, _NEAR_GOAL)
    far = np.minimum(distance / _FAR_GOAL, 1.0)
    others = [crowd(points, headings, reach) for reach in _RANGES]
    return np.concatenate([towards, far, *others], axis=-1)


def swapped_places(robots: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return starts around a circle, and goals at which opposite robots have changed places.

    All ways lead through the middle. Radii, angles and headings are drawn anew until all
    look-ahead points are 0.32 m apart, which leaves a certificate's 0.20 m where the testbed
    brings robots not quite to where they are asked.

    Parameters
    ----------
    robots : int
        N, an even number.
    rng : numpy.random.Generator
        Where starts are drawn from.

    Returns
    -------
    start : (3, N) array
        Poses, m and rad; robots 0 and 1 are opposite, 2 and 3, and so on.
    goals : (2, N) array
        Where the look-ahead points are to go, m: to where those opposite were.

    Raises
    ------
    ParameterError
        Where somebody has nobody to change places with, or so many do not fit.
    """
    if robots < 2 or robots % 2:
        raise ParameterError(f"robots: expected an even number, to swap in pairs, got {robots!r}")
    pair = np.arange(robots) // 2
    angles = 2.0 * np.pi * pair / robots + np.pi * (np.arange(robots) % 2)
    for _ in range(_ATTEMPTS):
        around = angles + rng.uniform(-0.08, 0.08, robots)
        radius = rng.uniform(*_RADII, robots)
        heading = rng.uniform(-np.pi, np.pi, robots)
        start = np.stack([radius * np.cos(around), radius * np.sin(around), heading])
        points = look_ahead_points(start)
        apart = np.hypot(*(points[:, :, None] - points[:, None, :])) + 9.0 * np.eye(robots)
        if apart.min() > _START_SPACING:
            return start, points[:, np.arange(robots) ^ 1]
    raise ParameterError(
        f"robots: {robots} do not fit on a circle {_START_SPACING} m apart; ask for fewer"
    )
