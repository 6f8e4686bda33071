"""Do the wheels roll where the heading points? What tells readings of a log apart.

A robot with two driven wheels cannot slide sideways. So where poses are read rightly, next to none
of the motion points across the headings, and where columns are mistaken or degrees taken for
radians, about half of it does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FAR = 0.005
"""Metres in five samples that are motion and no noise."""
ROLLING = 0.05
"""Share of the motion across the headings that wheels may do."""
_JUMP = 10.0
"""How many times farther than usual no robot drives."""


def sideways_share(poses: Floats) -> float:
    """Share of the motion that points across the heading: 0 for wheels, about ½ for nonsense.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses, m and rad; at most about 4000 samples are looked at.

    Returns
    -------
    float
        Sum of squared sideways displacements over the sum of all, NaN when nothing moves.
    """
    stride = max(1, len(poses) // 4000)
    # Three zeros are no place but a robot that nobody sees: the way from there is no motion.
    poses = np.where((poses[:, :3] == 0.0).all(axis=1, keepdims=True), np.nan, poses)
    # Displacements over five samples, so that tracking noise does not drown the motion.
    ahead, behind = poses[5:], poses[:-5]
    if len(poses) <= 5:
        ahead, behind = poses[1:], poses[:-1]
    ahead, behind = ahead[::stride], behind[::stride]
    dx, dy = ahead[:, 0] - behind[:, 0], ahead[:, 1] - behind[:, 1]
    middle = behind[:, 2] + 0.5 * (
        np.remainder(ahead[:, 2] - behind[:, 2] + np.pi, 2 * np.pi) - np.pi
    )
    across = -np.sin(middle) * dx + np.cos(middle) * dy
    way = dx * dx + dy * dy
    # A robot that is lost for a while, or jumps, says nothing of how wheels roll.
    moved = way[np.isfinite(across) & (way > 0)]
    usual = np.isfinite(across) & (way <= _JUMP**2 * (np.median(moved) if moved.size else 0.0))
    total = float(np.sum(way[usual]))
    return float(np.sum(np.square(across[usual]))) / total if total > 0 else float("nan")


def moved_far(poses: Floats) -> float:
    """Return how far robots go in five samples, m, as a root of the mean square.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses, m and rad.
    """
    moved = (poses[5:, :2] - poses[:-5, :2]) ** 2
    moved = moved[np.isfinite(moved)]
    return float(np.sqrt(np.mean(moved))) if moved.size else 0.0
