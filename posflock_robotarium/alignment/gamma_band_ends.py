"""From moments of γ to the ends of its band: which γ make such a reading none of the rarest 5 %.

How the moments come about, and why the band is made like this, says `gamma_band`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CONFIDENCE = 0.95
"""Share of the samples in which the band holds the γ without noise."""

#: Halvings of the interval in which an end of the band is sought: 1e-7 of a broad band.
_HALVINGS = 24
#: Least of the linear variance on a saddle, in units of the square: noise may have hidden as much.
SADDLE = 0.25
_MOST_SKEWED = 2.0 * np.sqrt(2.0)


@dataclass(frozen=True, eq=False)
class BandMoments:
    """What is known of γ at each sample: moments of the expansion, and doubts.

    Attributes
    ----------
    centre : (T,) array
        γ less its bias.
    linear, square : (T,) array
        g'Σg, and tr (HΣ)².
    bending : (T,) array
        How fast the variance g'Σg changes with γ: 2 g'ΣHΣg / g'Σg.
    one_sided : (T,) array
        1 on a summit or in a trough, where all curvatures have one sign; falls to 0 on a saddle.
    doubt_below, doubt_above : (T,) array
        How far γ may fall and rise where it is in doubt who moves, or is a neighbour.
    """

    centre: Floats
    linear: Floats
    square: Floats
    bending: Floats
    one_sided: Floats
    doubt_below: Floats
    doubt_above: Floats


def ends_of(spread: BandMoments) -> tuple[Floats, Floats]:
    """Return the least and the greatest γ under which the reading is not too rare.

    Parameters
    ----------
    spread : BandMoments
        What is known of γ at each sample.

    Returns
    -------
    least, greatest : (T,) array
        γ; may lie beyond 1 or -1.
    """
    broad = 8 * np.sqrt(0.5 * spread.square + spread.linear) + 16 * np.abs(spread.bending)
    centre = spread.centre
    least, inside = centre - broad, centre.copy()
    for _ in range(_HALVINGS):
        middle = (least + inside) / 2
        held = _accepted(middle, spread, _End.HIGH) >= centre
        least, inside = np.where(held, least, middle), np.where(held, middle, inside)
    low = inside
    # On a summit the whole reading may lie above what is accepted there: so from below it.
    inside, most = centre - broad, centre + broad
    for _ in range(_HALVINGS):
        middle = (inside + most) / 2
        held = _accepted(middle, spread, _End.LOW) <= centre
        inside, most = np.where(held, middle, inside), np.where(held, most, middle)
    return low, inside


class _End(Enum):
    """An end of an interval."""

    LOW = "low"
    HIGH = "high"


def _accepted(gamma: Floats, spread: BandMoments, end: _End) -> Floats:
    """Return an end of the 95 % of the readings where the truth is `gamma`: Pearson's type III."""
    from scipy.special import ndtri

    linear = spread.linear - spread.square
    shifted = np.maximum(linear + spread.bending * (gamma - spread.centre), 0.0)
    one = spread.one_sided
    # On a saddle the linear part says nothing of γ, and where it seems none, noise hides it.
    linear = one * shifted + (1 - one) * np.maximum(linear, SADDLE * spread.square)
    half = np.maximum(0.5 * spread.square, 1e-120)
    variance = half + linear
    third = one * spread.bending * (half + 1.5 * linear)
    skewness = np.clip(third / variance**1.5, -_MOST_SKEWED, _MOST_SKEWED)
    rare = 1 - CONFIDENCE
    beyond_summit = np.maximum(rare / 2 * (1 - one * np.exp(-linear / half)), 1e-9)
    summit = spread.bending < 0
    if end is _End.LOW:
        normal = ndtri(np.where(summit, rare - beyond_summit, beyond_summit))
    else:
        normal = -ndtri(np.where(summit, beyond_summit, rare - beyond_summit))
    return np.asarray(gamma + np.sqrt(variance) * _quantile(normal, skewness))


def _quantile(normal: Floats, skewness: Floats) -> Floats:
    """Return the standardised gamma's quantile by the normal's (Wilson and Hilferty 1931)."""
    k = np.where(np.abs(skewness) < 1e-6, 1e-6, skewness)
    return np.asarray(2 / k * ((1 + k * normal / 6 - k**2 / 36) ** 3 - 1))
