"""Means and extremes over the robots that are seen: one definition, wherever some are not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def mean_of_seen(values: Floats, axis: int = -1) -> Floats:
    """Return the mean of the values that are known.

    Parameters
    ----------
    values : (...) array
        In any unit, which is the mean's too; NaN where unknown.
    axis : int
        Along which the mean is taken.

    Returns
    -------
    (...) array
        NaN where nothing is known.
    """
    known = np.isfinite(values)
    if known.all():
        return np.asarray(values.mean(axis=axis))
    count = known.sum(axis=axis)
    total = np.where(known, values, 0.0).sum(axis=axis)
    mean: Floats = np.divide(total, count, out=np.full(np.shape(total), np.nan), where=count > 0)
    return mean


def centroid_of_seen(positions: Floats) -> Floats:
    """Return the mean position of the robots that are seen.

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m; NaN where a robot is not seen.

    Returns
    -------
    (..., d) array
        m; NaN where nobody is seen.
    """
    return mean_of_seen(positions, axis=-1)
