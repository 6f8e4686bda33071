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


MOST_TILTED = 0.35
"""Radians (20°) between a body's z axis and the vertical that no robot on a floor has."""


def headings_of(quaternions: Floats) -> tuple[Floats, str]:
    """Return headings where a body stays upright; unknown ones, and why, where it does not.

    A camera in a hand, a drone, a frame whose z axis looks ahead, and a quaternion whose parts are
    in another order turn about other axes, too: then the angle about the vertical is no heading.

    Parameters
    ----------
    quaternions : (4, ...) array
        x, y, z, w.

    Returns
    -------
    heading : (...) array
        Rad; all NaN where bodies tilt.
    told : str
        What is to be added to the note of how they were read.
    """
    x, y, z, w = quaternions
    length = x * x + y * y + z * z + w * w
    with np.errstate(invalid="ignore", divide="ignore"):
        tilt = np.arccos(np.clip(1 - 2 * (x * x + y * y) / length, -1, 1))
    tilted = float(np.nanquantile(tilt, 0.9)) if np.isfinite(tilt).any() else 0.0
    if tilted <= MOST_TILTED:
        return yaw(x, y, z, w), ""
    said = (
        f", which tilt by {np.degrees(tilted):.0f}° as no robot on a floor does: headings are left "
        "out (a camera's frame, or parts in another order than x, y, z, w?)"
    )
    return np.full(x.shape, np.nan), said


def are_unit(quaternions: Floats) -> bool:
    """Tell whether four columns are rotations.

    Parameters
    ----------
    quaternions : (T, 4) array
        What may be quaternions, the real part first or last.
    """
    length = np.linalg.norm(quaternions, axis=1)
    return bool(np.isfinite(length).all() and (np.abs(length - 1) < 0.01).all())
