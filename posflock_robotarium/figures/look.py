"""What tells one curve from another: colour, dash and marker, so that print needs no colour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.figures.palette import BLUE, GREY, ORANGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Dash = str | tuple[int, tuple[float, ...]]
"""A line style as matplotlib takes it; "" draws no line."""


@dataclass(frozen=True)
class Look:
    """How a curve is drawn.

    Attributes
    ----------
    colour : str
        One of `figures.style`.
    dash : str or (offset, on and off lengths)
        Line style as matplotlib takes it; "" draws markers alone.
    marker : str
        At its points, as matplotlib names it.
    width : float
        Of the line, points.
    """

    colour: str
    dash: Dash = "-"
    marker: str = ""
    width: float = 1.1


OF_ESTIMATOR = {
    "motion": Look(BLUE, "-", width=1.2),
    "headings": Look(ORANGE, (0, (4, 1.5)), width=1.2),
    "differences": Look(GREY, (0, (1, 1)), width=0.8),
}
"""What a curve from one estimator of motion looks like, in every figure and on the page."""


def estimator_of(key: str) -> str | None:
    """Return whose estimate a metric is, a key of `OF_ESTIMATOR`; None of any other metric.

    Parameters
    ----------
    key : str
        Of the metric: ``gamma_motion``, ``polarisation_headings``.
    """
    last = key.rpartition("_")[2]
    return last if last in OF_ESTIMATOR else None


def shade(
    axes: Axes,
    t: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    look: Look,
) -> None:
    """Shade a band behind a curve, in its colour.

    Parameters
    ----------
    axes : Axes
        Where.
    t, low, high : (T,) array
        Times, s, and the ends of the band, NaN where there is none.
    look : Look
        Of the curve.
    """
    axes.fill_between(t, low, high, color=look.colour, alpha=0.35, linewidth=0, zorder=1)
