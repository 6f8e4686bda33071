r"""Stalls that a log with nominal times hides, and that its motion tells.

A step that took ten times as long moved every robot ten times as far as it was told, all in the
same row.  For each row the factor s that explains its increments e best is

.. math:: s = \frac{\sum e p / \sigma^2}{\sum p^2 / \sigma^2},

with p what the fit predicts and the sum over robots and over both kinds of increment.  Rows whose
factor stands out of the noise are stalls.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.calibration.fit import Fit

#: A stall takes so many times the usual step at least, and stands out by so many deviations.
_LONGER, _DEVIATIONS = 1.5, 8.0
#: From the median of absolute deviations to the standard deviation of a normal distribution.
_NORMAL = 1.4826


def hidden_stalls(fit: Fit, suspected: NDArray[np.bool_]) -> dict[int, float]:
    """Return rows that took much longer than the log says, and how many times as long.

    Parameters
    ----------
    fit : Fit
        Solved for a log with nominal times.
    suspected : (K,) boolean array
        Rows that are stalls whatever the factor.
    """
    top, bottom = np.zeros(len(fit.data.steps)), np.zeros(len(fit.data.steps))
    for did, predicted in fit.predictions():
        sigma = max(_NORMAL * float(np.median(np.abs(did - predicted))), 1e-12)
        top += np.bincount(fit.row, did * predicted / sigma**2, len(top))
        bottom += np.bincount(fit.row, (predicted / sigma) ** 2, len(top))
    safe = np.maximum(bottom, 1e-300)
    factor: NDArray[np.float64] = top / safe
    out = (factor > _LONGER) & ((factor - 1) * np.sqrt(safe) > _DEVIATIONS)
    return {int(row): max(float(factor[row]), 1.0) for row in np.flatnonzero(out | suspected)}
