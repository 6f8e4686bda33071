"""Who was seen when, and what was taken for a robot: a line a robot, over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, in_style, new_figure
from posflock_robotarium.logs.plausibility import Why

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOOKS = {
    Why.MISSING: ("white", "//////", GREY),
    Why.UNHEADED: ("white", "......", GREY),
    Why.HELD: ("white", "|||||", BLACK),
    Why.UNSEEN: (ORANGE, "", ORANGE),
    Why.ELSEWHERE: (BLACK, "", BLACK),
    Why.EXCHANGED: (GREEN, "", GREEN),
}
"""Face, hatch and edge of each: told apart without colours, too."""


@in_style
def sightings(analysis: Analysis) -> Figure:
    """Draw for each robot when it was seen, why it was not otherwise, and its jumps.

    Parameters
    ----------
    analysis : Analysis
        One run.
    """
    recording, found = analysis.recording, analysis.sightings
    t, robots, step = recording.t, recording.robots, recording.step
    figure = new_figure(7.2, min(6.0, 0.9 + 0.22 * robots))
    axes = figure.subplots()
    for n in range(robots):
        axes.barh(n, t[-1] - t[0], left=t[0], height=0.5, color=BLUE, alpha=0.35, linewidth=0)
    for why, (face, hatch, edge) in _LOOKS.items():
        of_why = [entry for entry in found.unbelieved if entry.why is why]
        axes.barh(
            [entry.robot for entry in of_why],
            [entry.end - entry.start + step for entry in of_why],
            left=[entry.start - step / 2 for entry in of_why],
            height=0.5,
            facecolor=face,
            hatch=hatch,
            edgecolor=edge,
            linewidth=0.4,
            label=why.value if of_why else None,
        )
    rows, who = np.nonzero(found.jumps)
    if rows.size:
        axes.plot(t[rows + 1], who - 0.4, "v", color=BLACK, markersize=3, label="jump")
    axes.set(xlabel="time (s)", ylabel="robot", xlim=(t[0], t[-1]), ylim=(robots - 0.4, -0.8))
    axes.set_yticks(range(0, robots, max(1, robots // 20)))
    figure.legend(loc="outside upper left", ncols=4)
    return figure
