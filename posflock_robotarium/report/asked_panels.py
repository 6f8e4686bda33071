"""Which plots a page shows: those of flocks where nothing else is asked."""

from __future__ import annotations

from collections.abc import Sequence

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import Metric, Panel, panels
from posflock_robotarium.alignment.panels import OF_FLOCKS
from posflock_robotarium.alignment.questions import Questions


def of_flocks(analyses: Sequence[Analysis]) -> bool:
    """Return whether the page tells of alignment: unless every run was asked something else.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    """
    asked = {analysis.asked.questions for analysis in analyses}
    if Questions.FLOCKING in asked:
        return True
    own = any(panel.leads and shown[0].key in analyses[0].curves for panel, shown in panels())
    return asked == {Questions.NONE} and not own


def asked_panels(analyses: Sequence[Analysis]) -> list[tuple[Panel, list[Metric]]]:
    """Return the plots of the page in reading order, each with its metrics.

    Those of flocks are left out where nobody asks for them, and no target is of their metrics.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    """
    if of_flocks(analyses):
        return panels()
    wanted = {target.metric for analysis in analyses for target in analysis.targets}
    return [
        (panel, shown)
        for panel, shown in panels()
        if panel not in OF_FLOCKS or wanted & {metric.key for metric in shown}
    ]
