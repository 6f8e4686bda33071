"""The report's figures, for print: one run's curves, or several runs with their mean and interval.

They share the style of the experiment's own figures, but are drawn from an `Analysis`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import Metric, figures, metrics
from posflock_robotarium.alignment.comparison import spread_of
from posflock_robotarium.alignment.fewest_runs import FEWEST_RUNS
from posflock_robotarium.alignment.panels import LEFT_OUT, Line
from posflock_robotarium.figures.experiment import snapshots
from posflock_robotarium.figures.look import OF_ESTIMATOR, Look, estimator_of, shade
from posflock_robotarium.figures.sightings import sightings
from posflock_robotarium.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    in_style,
    new_figure,
    save,
)
from posflock_robotarium.report.asked_figures import asked_metrics, target_lines, unmathematical
from posflock_robotarium.report.following_figure import following_figure
from posflock_robotarium.report.time_axes import since_start, time_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]


_LOOKS = (
    Look(BLUE),
    Look(ORANGE, (0, (4, 1.5))),
    Look(GREY, (0, (1, 1))),
    Look(GREEN, (0, (5, 1, 1, 1))),
)
_DOTTED = Look(BLACK, (0, (1, 1)))
_DASHED = Look(BLACK, (0, (4, 1.5)))


def draw(analyses: Sequence[Analysis], folder: Path) -> list[Path]:
    """Draw every figure into a folder, each as PNG and PDF.

    Parameters
    ----------
    analyses : sequence of Analysis
        One run, or several that are drawn over each other.
    folder : Path
        Made when it is not there.

    Returns
    -------
    list of Path
        What was written.
    """
    drawn: dict[str, Callable[[], Figure]]
    if len(analyses) == 1:
        run = analyses[0]
        drawn = {
            "snapshots": lambda: snapshots(run.believed),
            "alignment": lambda: alignment(run),
            "distances": lambda: distances(run),
            "motion": lambda: motion(run),
        }
        if "gamma_motion" not in run.curves:  # nobody knows who is whose neighbour
            del drawn["alignment"]
        if run.sightings.unbelieved:
            drawn["sightings"] = lambda: sightings(run)
        for name, shown in figures().items():
            if any(metric.key in run.curves for metric in shown):
                drawn.setdefault(name, partial(curves, run, name))
        if run.following is not None and not run.following.refused:
            drawn["following"] = partial(following_figure, run.following)
    else:
        known = {key for analysis in analyses for key in analysis.curves}
        drawn = {"runs": lambda: runs(analyses)} if known & set(_OF_ALL_RUNS) else {}
        for key, name in asked_metrics(analyses).items():
            drawn.setdefault(name, partial(overlaid, analyses, key))
    return [path for name, draw_one in drawn.items() for path in save(draw_one(), folder, name)]


@in_style
def alignment(analysis: Analysis) -> Figure:
    """Draw γ by its three estimators, and below it the share of robots that each leaves out.

    Parameters
    ----------
    analysis : Analysis
        What was computed of the run.
    """
    figure = new_figure(3.5, 3.1)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    drawn = figures()["alignment"]
    of_gamma = [metric for metric in drawn if metric.panel is not LEFT_OUT]
    for metric, look in reversed(_styled(of_gamma)):
        _curve(top, analysis, metric, look)
    target_lines(top, [analysis], [metric.key for metric in of_gamma])
    top.set(ylabel="alignment γ (–)", ylim=(None, 1.05))
    top.axhline(1.0, color=GREY, linewidth=0.5, zorder=0)
    _legend_above(top, 3, backwards=True)
    for metric, look in reversed(_styled([m for m in drawn if m.panel is LEFT_OUT])):
        _curve(bottom, analysis, metric, look)
    bottom.set(xlabel="time (s)", ylabel="left out (–)", ylim=(-0.05, 1.05))
    time_axis(bottom, [analysis])
    return figure


@in_style
def distances(analysis: Analysis) -> Figure:
    """Draw distances between robots and to the walls with the testbed's collision line.

    Parameters
    ----------
    analysis : Analysis
        What was computed of the run.
    """
    figure = new_figure(3.5, 2.6)
    axes = figure.subplots()
    looks = (_LOOKS[0], _LOOKS[1], _DOTTED, _LOOKS[3])
    for metric, look in _styled(drawn := figures()["distances"], looks):
        _curve(axes, analysis, metric, look)
    target_lines(axes, [analysis], [metric.key for metric in drawn])
    limit = analysis.robot.collision_diameter
    axes.axhline(limit, color=GREY, linewidth=0.8)
    axes.text(
        0.995,
        limit,
        f"collision, {limit:g} m",
        transform=axes.get_yaxis_transform(),
        fontsize=6,
        color="#555555",
        ha="right",
        va="top",
    )
    axes.set(xlabel="time (s)", ylabel="distance (m)", ylim=(min(0.0, axes.get_ylim()[0]), None))
    _legend_above(axes, 2)
    time_axis(axes, [analysis])
    return figure


@in_style
def motion(analysis: Analysis) -> Figure:
    """Draw speeds, slowest to fastest robot, and the speed of the centroid.

    Parameters
    ----------
    analysis : Analysis
        What was computed of the run.
    """
    figure = new_figure(3.5, 2.4)
    axes = figure.subplots()
    t, known = analysis.recording.t, analysis.curves
    axes.fill_between(
        t,
        known["speed_slowest"],
        known["speed_fastest"],
        color=BLUE,
        alpha=0.2,
        linewidth=0,
        label="slowest to fastest",
    )
    for metric, look in _styled(drawn := figures()["motion"], (_LOOKS[0], _DASHED)):
        _curve(axes, analysis, metric, look)
    # What is shaded is of metrics, too: a target may be of the slowest or of the fastest robot.
    shown = [*(metric.key for metric in drawn), "speed_slowest", "speed_fastest"]
    target_lines(axes, [analysis], shown)
    axes.set(xlabel="time (s)", ylabel="speed (m/s)", ylim=(0, None))
    _legend_above(axes, 3)
    time_axis(axes, [analysis])
    return figure


@in_style
def curves(analysis: Analysis, name: str) -> Figure:
    """Draw the metrics of a figure that has nothing of its own beside its curves.

    Parameters
    ----------
    analysis : Analysis
        One run.
    name : str
        What metrics call the figure (`metric_registry.Metric.figure`).
    """
    figure = new_figure(3.5, 2.4)
    axes = figure.subplots()
    drawn = figures()[name]
    for metric, look in _styled(drawn):
        _curve(axes, analysis, metric, look)
    first = drawn[0]
    target_lines(axes, [analysis], [metric.key for metric in drawn])
    axes.set(
        xlabel="time (s)",
        ylabel=_axis_label(first.label if len(drawn) == 1 else "", first),
        ylim=(None, None) if first.panel is None else first.panel.limits,
    )
    if len(axes.get_lines()) > 1:
        _legend_above(axes, 2)
    for line in () if first.panel is None else first.panel.lines:
        _level(axes, line, analysis)
    time_axis(axes, [analysis])
    return figure


@in_style
def runs(analyses: Sequence[Analysis]) -> Figure:
    """Draw γ from motion and the closest pair of every run, their mean and 95 % interval.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    """
    shown = [key for key in _OF_ALL_RUNS if any(key in run.curves for run in analyses)]
    figure = new_figure(7.2 if len(shown) > 1 else 3.5, 2.6)
    axes: list[Axes] = list(np.ravel(figure.subplots(1, len(shown))))
    for one, key in zip(axes, shown, strict=True):
        _runs_over_each_other(one, analyses, key)
        target_lines(one, analyses, [key])
    _legend_above(axes[0], 4 if len(shown) > 1 else 2)
    return figure


def _level(axes: Axes, line: Line, analysis: Analysis) -> None:
    """Draw a level of a panel across its figure, where the axis reaches it."""
    level, (low, high) = line.level(analysis.robot), axes.get_ylim()
    if not (line.always or low <= level <= high):
        return
    axes.axhline(level, color=GREY, linewidth=0.8)
    axes.text(
        0.995,
        level,
        line.label,
        transform=axes.get_yaxis_transform(),
        fontsize=6,
        color="#555555",
        ha="right",
        va="bottom",
    )


_OF_ALL_RUNS = ("gamma_motion", "smallest_distance")
"""Curves that every figure of several runs shows, where they are known."""


@in_style
def overlaid(analyses: Sequence[Analysis], key: str) -> Figure:
    """Draw one metric of every run, and their mean and 95 % interval.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    key : str
        Of the metric.
    """
    figure = new_figure(3.5, 2.6)
    axes = figure.subplots()
    _runs_over_each_other(axes, analyses, key)
    target_lines(axes, analyses, [key])
    _legend_above(axes, 2)
    return figure


def _runs_over_each_other(axes: Axes, analyses: Sequence[Analysis], key: str) -> None:
    for k, analysis in enumerate(analyses):
        if key in analysis.curves:
            look = _LOOKS[k % len(_LOOKS)]
            crowded = len(analyses) > len(_LOOKS)
            axes.plot(
                *since_start(analysis, analysis.curves[key]),
                color=GREY if crowded else look.colour,
                linestyle="-" if crowded else look.dash,
                linewidth=0.6 if crowded else 1.0,
                alpha=0.6 if crowded else 1.0,
                label=None if crowded else _plain(analysis.name),
            )
    if len(analyses) >= FEWEST_RUNS:
        _mean_band(axes, analyses, key)
    axes.set(xlabel="time (s)", ylabel=_axis_label(metrics()[key].label, metrics()[key]))
    time_axis(axes, analyses)


def _mean_band(axes: Axes, analyses: Sequence[Analysis], key: str) -> None:
    """Draw the mean over runs and its bootstrap interval on a grid of 120 times."""
    shortest = min(float(a.recording.t[-1] - a.start) for a in analyses)
    grid = np.linspace(0.0, shortest, 120)
    known = [since_start(a, a.curves[key]) for a in analyses if key in a.curves]
    sampled = np.array([curve[np.searchsorted(t, grid).clip(max=len(t) - 1)] for t, curve in known])
    if len(sampled) < FEWEST_RUNS:
        return
    spreads = [spread_of(column) for column in sampled.T]
    axes.fill_between(
        grid,
        [s.low for s in spreads],
        [s.high for s in spreads],
        color=BLACK,
        alpha=0.18,
        linewidth=0,
        label="95 % of the mean",
    )
    axes.plot(grid, [s.mean for s in spreads], color=BLACK, linewidth=1.4, label="mean over runs")


def _styled(drawn: Sequence[Metric], looks: Sequence[Look] = _LOOKS) -> list[tuple[Metric, Look]]:
    """Give each curve of an axes a look of its own, those of the figure first."""
    known = {metric.key: OF_ESTIMATOR.get(estimator_of(metric.key) or "") for metric in drawn}
    taken = {(look.colour, look.dash) for look in known.values() if look is not None}
    free = dict.fromkeys([*looks, *_LOOKS, _DOTTED, _DASHED])
    others = cycle([look for look in free if (look.colour, look.dash) not in taken])
    return [(metric, known[metric.key] or next(others)) for metric in drawn]


def _curve(axes: Axes, analysis: Analysis, metric: Metric, look: Look) -> None:
    """Plot one curve, broken at gaps."""
    if metric.key not in analysis.curves:
        return
    gaps, curve = analysis.recording.gaps, analysis.curves[metric.key].astype(float)
    t = np.insert(analysis.recording.t, gaps, np.nan)
    if metric.band is not None and set(metric.band) <= set(analysis.curves):
        low, high = (np.insert(analysis.curves[end], gaps, np.nan) for end in metric.band)
        shade(axes, t, low, high, look)
    axes.plot(
        t,
        np.insert(metric.unjoined(curve), gaps, np.nan),
        color=look.colour,
        linestyle=look.dash,
        linewidth=look.width,
        label=unmathematical(metric.legend or metric.label),
        zorder={"headings": 2.5, "differences": 0.5}.get(estimator_of(metric.key) or "", 2),
    )


def _axis_label(words: str, metric: Metric) -> str:
    return unmathematical(f"{words} ({metric.unit or '–'})".strip())


def _plain(name: str) -> str:
    """Return a run's name as matplotlib draws it letter by letter: no mathematics, never hidden."""
    return unmathematical(f" {name}")


def _legend_above(axes: Axes, columns: int, backwards: bool = False) -> None:
    """Put the legend above the axes: no curve of any run can lie under it."""
    handles, names = axes.get_legend_handles_labels()
    order = -1 if backwards else 1
    axes.figure.legend(
        handles[::order],
        names[::order],
        loc="outside upper left",
        ncols=columns,
        handlelength=1.8,
        columnspacing=1.0,
    )
