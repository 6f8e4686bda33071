"""How a search for a policy went, as a figure: score over generations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from posflock_robotarium.figures.style import BLUE, GREY, in_style, new_figure
from posflock_robotarium.learning.evolution import Evolution

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_learning_curve"]


@in_style
def draw_learning_curve(evolution: Evolution, baseline: float | None = None) -> Figure:
    """Draw the score of each generation, and within which it tried.

    Parameters
    ----------
    evolution : Evolution
        How the search went.
    baseline : float, optional
        The score of what the policy is compared with: a dashed line.
    """
    figure = new_figure(3.5, 2.4)
    axes = figure.add_subplot(xlabel="generation", ylabel="return of an episode (m)")
    generations = np.arange(1, len(evolution.scores) + 1)
    low, high = evolution.spread.T
    tried = "lowest to highest of those tried"
    axes.fill_between(generations, low, high, color=GREY, alpha=0.25, linewidth=0, label=tried)
    axes.plot(generations, evolution.scores, color=BLUE, linewidth=1.2, label="policy")
    if baseline is not None:
        axes.axhline(
            baseline, color="black", linestyle="--", linewidth=0.8, label="straight at the goal"
        )
    axes.legend(loc="lower right")
    return figure
