r"""What a first fit shows of a log: stalls that nominal times hide, and increments that are damage.

A step that took ten times as long moved every robot ten times as far as it was told, all in the
same row.  For each row the factor s that explains its increments e best is

.. math:: s = \frac{\sum e p / \sigma^2}{\sum p^2 / \sigma^2},

with p what robots were told and the sum over robots and over both kinds of increment.  A row is a
stall where s stands out of the noise and explains nearly all that was seen in it.

An increment of one robot alone that no noise explains is damage: a marker that was lost for a
frame, a wheel that slipped.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.calibration.fit import Fit

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
#: A stall takes so many times the usual step at least, stands out by so many deviations, and
#: explains this share of the row.
_LONGER, _DEVIATIONS, _EXPLAINED = 1.5, 8.0, 0.8
#: Damage is off by so many deviations, of at least these, m and rad; more of it is not damage.
_DAMAGED, _LEAST, _AT_MOST = 10.0, (2e-4, 5e-4), 0.05
#: From the median of absolute deviations to the standard deviation of a normal distribution.
_NORMAL = 1.4826


def hidden_stalls(fit: Fit, suspected: Flags) -> dict[int, float]:
    """Return rows that took much longer than the log says, and how many times as long.

    Parameters
    ----------
    fit : Fit
        Solved for a log with nominal times.
    suspected : (K,) boolean array
        Rows that are stalls whatever the factor.
    """
    rows = len(fit.data.steps)
    seen, both, told = np.zeros(rows), np.zeros(rows), np.zeros(rows)
    for did, predicted in fit.predictions(bias=False):
        sigma = _deviation(did - predicted, 1e-12)
        seen += np.bincount(fit.row, (did / sigma) ** 2, rows)
        both += np.bincount(fit.row, did * predicted / sigma**2, rows)
        told += np.bincount(fit.row, (predicted / sigma) ** 2, rows)
    told += 1e-300  # where nothing was predicted
    factor = both / told
    explained = both * factor >= _EXPLAINED * seen
    out = (factor > _LONGER) & ((factor - 1) * np.sqrt(told) > _DEVIATIONS) & explained
    return {int(row): max(float(factor[row]), 1.0) for row in np.flatnonzero(out | suspected)}


def damaged(fit: Fit) -> Flags:
    """Return increments (K, N) that no noise explains; none where they are too many for damage.

    Parameters
    ----------
    fit : Fit
        Solved.

    Returns
    -------
    (K, N) boolean array
        True for damage.
    """
    off = np.zeros(len(fit.row), dtype=bool)
    for (did, predicted), least in zip(fit.predictions(), _LEAST, strict=True):
        residual = did - predicted
        off |= np.abs(residual) > _DAMAGED * _deviation(residual, least)
    out = np.zeros_like(fit.data.known)
    if off.mean() <= _AT_MOST:
        out[fit.row[off], fit.owner[off]] = True
    return out


def _deviation(residual: Floats, least: float) -> float:
    return max(_NORMAL * float(np.median(np.abs(residual))), least)
