"""Poses as they were read, refused where they mean nothing to a flock."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]


def checked_poses(poses: ArrayLike, robots: int | None) -> Floats:
    """Return poses as finite floats.

    Parameters
    ----------
    poses : (3, N) array
        x, y in metres and θ in radians; N from 2.
    robots : int or None
        How many there were at the first step; None at the first.

    Returns
    -------
    (3, N) array
        The same, copied only where they were no float array.

    Raises
    ------
    ParameterError
        Where the poses have another shape or a value that is not finite.
    """
    try:
        x = np.asarray(poses, dtype=float)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"poses: expected a (3, N) array, got {poses!r}") from error
    if x.ndim != 2 or x.shape[0] != 3 or x.shape[1] < 2:
        raise ParameterError(
            "poses: expected shape (3, N), x, y and θ of at least two robots (one robot"
            f" is no flock); got {x.shape}"
        )
    if robots is not None and x.shape[1] != robots:
        raise ParameterError(
            f"poses: expected {robots} robots as at the first step,"
            f" got {x.shape[1]}; call reset() to begin another run"
        )
    if not np.isfinite(x).all():
        row, robot = np.argwhere(~np.isfinite(x))[0]
        raise ParameterError(
            f"poses: expected finite numbers, got {'xyθ'[row]} = {x[row, robot]} of robot {robot}"
        )
    return x
