"""The figure of commanded and achieved speed and turn rate, with the gain of every robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from posflock_robotarium.alignment.following import Following, Response
from posflock_robotarium.figures.style import BLACK, BLUE, GREY, ORANGE, in_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_AXES = (("speed", "m/s", BLUE, "o"), ("turn rate", "rad/s", ORANGE, "D"))


@in_style
def following_figure(found: Following) -> Figure:
    """Draw achieved over commanded speed and turn rate, a line a robot, and all gains.

    Parameters
    ----------
    found : Following
        Of a run whose log determines something; one that was refused has no figure.
    """
    robots = len(found.speed)
    figure = new_figure(7.2, max(2.5, 0.9 + 0.13 * robots))
    left, middle, right = figure.subplots(1, 3, width_ratios=[1, 1, 1.1])
    for axes, responses, (words, unit, colour, _) in zip(
        (left, middle), (found.speed, found.turn), _AXES, strict=True
    ):
        _scatter(axes, responses, words, unit, colour)
    _gains(right, found)
    return figure


def _scatter(axes: Axes, responses: Sequence[Response], words: str, unit: str, colour: str) -> None:
    for response in responses:
        axes.plot(
            response.commanded,
            response.achieved,
            color=colour,
            marker=".",
            markersize=2.5,
            linewidth=0.5,
            alpha=0.65,
        )
    values = [v for r in responses for v in (*r.commanded, *r.achieved)]
    low, high = (min(values, default=0.0), max(values, default=1.0)) if values else (0.0, 1.0)
    ends = np.array([min(low, 0.0), max(high, 0.0)])
    axes.plot(ends, ends, color=GREY, linewidth=0.8, linestyle=(0, (4, 1.5)), zorder=0)
    axes.set_title(f"{words}: {gain_words(responses)}", fontsize=8, loc="left")
    axes.set(xlabel=f"commanded {words} ({unit})", ylabel=f"achieved ({unit})")
    gains = [r.gain.value for r in responses if r.gain is not None]
    if gains:
        axes.plot(ends, float(np.median(gains)) * ends, color=BLACK, linewidth=1.0)
    axes.annotate(
        "as told",
        (ends[1], ends[1]),
        xytext=(-2, -1),
        textcoords="offset points",
        fontsize=6,
        color="#555555",
        ha="right",
        va="top",
    )


def _gains(axes: Axes, found: Following) -> None:
    """Draw the gains with their 99 % intervals, a row a robot."""
    for k, (responses, (words, _, colour, marker)) in enumerate(
        zip((found.speed, found.turn), _AXES, strict=True)
    ):
        known = [(n, r.gain) for n, r in enumerate(responses) if r.gain is not None]
        if known:
            values = np.array([gain.value for _, gain in known])
            ends = np.array([[gain.low, gain.high] for _, gain in known])
            axes.errorbar(
                values,
                [n + 0.15 * (2 * k - 1) for n, _ in known],
                xerr=[values - ends[:, 0], ends[:, 1] - values],
                fmt=marker,
                markersize=3,
                color=colour,
                linewidth=0.9,
                label=words,
            )
    axes.axvline(1.0, color=GREY, linewidth=0.8, linestyle=(0, (4, 1.5)), zorder=0)
    low, high = axes.get_xlim()
    axes.set(
        xlim=(min(low, 0.6), max(high, 1.2)),
        ylim=(len(found.speed) - 0.4, -0.6),
        xlabel="gain, with 99 % interval (–)",
        ylabel="robot",
        yticks=range(0, len(found.speed), 1 + len(found.speed) // 25),
    )
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, handletextpad=0.2)


def gain_words(responses: Sequence[Response]) -> str:
    """Return the median gain of a team in words, and how many robots have none.

    Parameters
    ----------
    responses : sequence of Response
        One a robot.

    Examples
    --------
    >>> gain_words([])
    'no gain'
    """
    gains = [response.gain.value for response in responses if response.gain is not None]
    if not gains:
        return "no gain"
    without = len(responses) - len(gains)
    robots = f", {without} robot{'s' if without > 1 else ''} without" if without else ""
    return f"gain {np.median(gains):.2f}{robots}"
