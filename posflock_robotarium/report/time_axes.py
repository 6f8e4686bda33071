"""Times in the report's figures: as logged of one run, since the experiment's start of several.

Each run takes a time of its own to drive its robots to their places. Of one run that is shaded;
where runs lie over each other, it would move their experiments apart, and is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.figures.style import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]


def since_start(analysis: Analysis, curve: Floats) -> tuple[Floats, Floats]:
    """Return times and values from the start of the experiment on.

    Parameters
    ----------
    analysis : Analysis
        One of several runs.
    curve : (T,) array
        Of its samples, in any unit.

    Returns
    -------
    t, values : (K,) array
        Seconds since the start, and what the curve is then.
    """
    began = analysis.recording.t >= analysis.start
    return analysis.recording.t[began] - analysis.start, curve[began]


def _mark_drive(axes: Axes, analysis: Analysis) -> None:
    """Shade the drive to the start, where one is in the log."""
    first = float(analysis.recording.t[0])
    if analysis.start <= first:
        return
    for shaded in axes.figure.axes:
        shaded.axvspan(first, analysis.start, color=GREY, alpha=0.18, linewidth=0, zorder=0)
    tallest = axes.figure.axes[0]
    tallest.text(
        analysis.start,
        0.98,
        "drive to the start",
        transform=tallest.get_xaxis_transform(),
        fontsize=6,
        color="#555555",
        ha="right",
        va="top",
        rotation=90,
    )


def time_axis(axes: Axes, analyses: Sequence[Analysis]) -> None:
    """Let the axis of time be as long as the run, or the longest experiment of several.

    Parameters
    ----------
    axes : Axes
        Where curves are drawn.
    analyses : sequence of Analysis
        Whose.
    """
    if len(analyses) == 1:
        axes.set_xlim(analyses[0].recording.t[0], analyses[0].recording.t[-1])
        _mark_drive(axes, analyses[0])
    else:
        axes.set_xlim(0.0, max(float(a.recording.t[-1] - a.start) for a in analyses))
        if any(a.start > a.recording.t[0] for a in analyses):
            axes.set_xlabel("time since the drive to the start (s)")
