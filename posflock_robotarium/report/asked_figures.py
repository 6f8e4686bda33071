"""What figures draw of one's own question: which metrics were asked for, and their targets."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import TYPE_CHECKING

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import metrics
from posflock_robotarium.alignment.panels import COVERAGE, FORMATION
from posflock_robotarium.figures.style import BLACK
from posflock_robotarium.report.words import target_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def asked_metrics(analyses: Sequence[Analysis]) -> dict[str, str]:
    """Return the metrics of what was asked for that some run has, each with its figure's name.

    Parameters
    ----------
    analyses : sequence of Analysis
        Several runs.
    """
    return {
        metric.key: f"runs_{metric.key}"
        for metric in metrics().values()
        if metric.figure and metric.panel is not None
        if metric.panel.leads or metric.panel in (FORMATION, COVERAGE)
        if any(metric.key in analysis.curves for analysis in analyses)
    }


def target_lines(axes: Axes, analyses: Sequence[Analysis], keys: Sequence[str]) -> None:
    """Draw the limits that metrics have to keep to, each in a dash that no curve has.

    Parameters
    ----------
    axes : Axes
        Where the metrics are drawn.
    analyses : sequence of Analysis
        Whose targets.
    keys : sequence of str
        Of the metrics.
    """
    limits = {(t.limit, t.unit): None for run in analyses for t in run.targets if t.metric in keys}
    for (limit, unit), dash in zip(
        limits, cycle([(0, (8, 1.5, 1, 1.5)), (0, (8, 1.5, 1, 1.5, 1, 1.5))])
    ):
        label = unmathematical(target_text(limit, unit))
        axes.axhline(limit, color=BLACK, linewidth=0.8, linestyle=dash, label=label)


def unmathematical(text: str) -> str:
    """Return words that anybody may have written as matplotlib draws them letter by letter.

    Parameters
    ----------
    text : str
        Words in which a dollar is no mathematics.
    """
    return text.replace("$", r"\$")
