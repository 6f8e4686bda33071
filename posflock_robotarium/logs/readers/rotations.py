"""Rotations in arrays without names: where they stand, so that nobody takes them for poses.

A robot's four numbers may be x, y and its heading's cosine and sine, its seven a place and a
quaternion, its twelve the upper rows of a matrix. Such an array often fits a layout of poses by its
shape alone, with robots that there are not; but no poses have a length of 1 all the time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]

_ROUNDED = 0.01
"""How far from 1 a length of written numbers is."""

_KINDS = {
    4: (slice(2, 4), "x, y, cosine and sine", "x1,y1,cos1,sin1"),
    7: (slice(3, 7), "a place and a quaternion", "x1,y1,-,qx1,qy1,qz1,qw1"),
}
"""By how many numbers a robot has: which are of length 1, what they are, columns to name."""


def ask_where_rotations(array: Floats, where: str) -> None:
    """Refuse an array whose robots have four or seven numbers, of which some are a rotation.

    Parameters
    ----------
    array : two or three axes, (...) array
        What may be poses.
    where : str
        File (and variable) name for messages.

    Raises
    ------
    LayoutError
        With what the numbers are, and what to do.
    """
    for each, (part, what, names) in _KINDS.items():
        if array.ndim == 3 and any(
            _are_unit(np.moveaxis(array, axis, -1)[..., part])
            for axis in range(3)
            if array.shape[axis] == each
        ):
            raise LayoutError(
                f"{where}: of shape {array.shape}, with {each} numbers a robot: {what}; save x, y "
                "and the heading of each instead (numpy.arctan2 of sine and cosine)"
            )
        for before in (0, 1):  # a column of times
            rest = array.shape[-1] - before
            if array.ndim != 2 or rest < each or rest % each:
                continue
            if _are_unit(array[:, before:].reshape(len(array), -1, each)[..., part]):
                first = "t," if before else ""
                raise LayoutError(
                    f"{where}: {rest // each} robot(s) with {each} numbers each: {what}; name all "
                    f"columns with --columns {first}{names},… or in a header"
                )


def _are_unit(parts: Floats) -> bool:
    """Whether all parts have length 1, and not just one number that is ±1 and others that are 0."""
    each = parts.reshape(-1, parts.shape[-1])
    known = each[np.isfinite(each).all(axis=1)]
    if len(known) < 2:
        return False
    with np.errstate(over="ignore"):
        unit = np.abs(np.linalg.norm(known, axis=1) - 1) < _ROUNDED
    return bool(unit.all() and np.ptp(known, axis=0).max() > 0)


def are_matrices(rows: Floats) -> bool:
    """Tell whether rows are the upper three rows of rigid motions, as KITTI writes them.

    Parameters
    ----------
    rows : (T, 12) array
        What may be rotations, with a place behind each of their rows.
    """
    if not np.isfinite(rows).all():
        return False
    turned = rows.reshape(-1, 3, 4)[:, :, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        product = turned @ turned.transpose(0, 2, 1)
        return bool((np.abs(product - np.eye(3)) < _ROUNDED).all())
