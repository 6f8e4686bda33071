"""Headings from the quaternions of trackers and robot middleware."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def yaw(x: Floats, y: Floats, z: Floats, w: Floats) -> Floats:
    """Return the angle about the z axis, rad.

    Parameters
    ----------
    x, y, z, w : (...) array
        Quaternions of any length but 0.

    Returns
    -------
    (...) array
        Where the robot's x axis points, seen from above; NaN where there is no rotation.
    """
    length = x * x + y * y + z * z + w * w
    angle: Floats = np.arctan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return np.where(length > 0, angle, np.nan)


def are_unit(quaternions: Floats) -> bool:
    """Tell whether four columns are rotations.

    Parameters
    ----------
    quaternions : (T, 4) array
        What may be quaternions, the real part first or last.
    """
    length = np.linalg.norm(quaternions, axis=1)
    return bool(np.isfinite(length).all() and (np.abs(length - 1) < 0.01).all())
