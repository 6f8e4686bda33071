"""Initial conditions: what may be asked for, and how robots come to them."""

import math
from typing import Any

import numpy as np

from rps_compat.arena import Array
from rps_compat.errors import InitialConditionsError


def checked_poses(poses: Any, number_of_robots: int) -> Array:
    """Copy of `poses` (3, N) as floats, whatever kind of number they are.

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
    if not math.isfinite(copy.sum()):
        row, robot = (int(k) for k in np.argwhere(~np.isfinite(copy))[0])
        raise InitialConditionsError(
            f"initial_conditions[{row}, {robot}] ({('x', 'y', 'theta')[row]} of robot {robot}) is "
            f"{copy[row, robot]}, expected a finite number"
        )
    return copy
