"""The report's figures, for print: one run's curves, or several runs with their mean and interval.

They share the style, colours and dashes of the experiment's own figures, but are drawn from an
`Analysis`, so that gaps stay gaps and every curve carries its estimator.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.comparison import spread_of
from posflock_robotarium.figures.experiment import snapshots
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

_STYLES: tuple[tuple[str, Any], ...] = (
    (BLUE, "-"),
    (ORANGE, (0, (4, 1.5))),
    (GREY, (0, (1, 1))),
    (GREEN, (0, (5, 1, 1, 1))),
)


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
    figures: dict[str, Callable[[], Figure]]
    if len(analyses) == 1:
        run = analyses[0]
        figures = {
            "snapshots": lambda: snapshots(run.recording),
            "alignment": lambda: alignment(run),
            "distances": lambda: distances(run),
            "motion": lambda: motion(run),
        }
    else:
        figures = {"runs": lambda: runs(analyses)}
    return [path for name, draw_one in figures.items() for path in save(draw_one(), folder, name)]


_SHORT = {
    "gamma_motion": "motion",
    "gamma_headings": "headings",
    "gamma_differences": "raw differences",
    "left_out_motion": "motion",
    "left_out_headings": "headings",
    "nearest_neighbour": "nearest neighbour",
    "smallest_distance": "closest pair",
    "cohesive_radius": "cohesive radius",
    "wall_distance": "nearest wall",
    "speed": "mean",
    "drift": "centroid",
}
"""Legends for a column of print; what they mean is in the caption and in `catalogue`."""


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
    curves = ("gamma_differences", "gamma_headings", "gamma_motion")
    for key, style in zip(curves, (_STYLES[2], _STYLES[1], _STYLES[0]), strict=True):
        _curve(top, analysis, key, style, width=0.8 if key == "gamma_differences" else 1.2)
    top.set(ylabel="alignment γ (–)", ylim=(None, 1.05))
    top.axhline(1.0, color=GREY, linewidth=0.5, zorder=0)
    _legend_above(top, 3, backwards=True)
    for key, style in (("left_out_headings", _STYLES[1]), ("left_out_motion", _STYLES[0])):
        _curve(bottom, analysis, key, style)
    bottom.set(xlabel="time (s)", ylabel="left out (–)", ylim=(-0.05, 1.05))
    _time_axis(bottom, [analysis])
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
    for key, style in zip(
        ("nearest_neighbour", "smallest_distance", "cohesive_radius", "wall_distance"),
        (_STYLES[0], _STYLES[1], (BLACK, (0, (1, 1))), _STYLES[3]),
        strict=True,
    ):
        _curve(axes, analysis, key, style)
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
    _time_axis(axes, [analysis])
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
    t, curves = analysis.recording.t, analysis.curves
    axes.fill_between(
        t,
        curves["speed_slowest"],
        curves["speed_fastest"],
        color=BLUE,
        alpha=0.2,
        linewidth=0,
        label="slowest to fastest",
    )
    _curve(axes, analysis, "speed", _STYLES[0])
    _curve(axes, analysis, "drift", (BLACK, (0, (4, 1.5))))
    axes.set(xlabel="time (s)", ylabel="speed (m/s)", ylim=(0, None))
    _legend_above(axes, 3)
    _time_axis(axes, [analysis])
    return figure


@in_style
def runs(analyses: Sequence[Analysis]) -> Figure:
    """Draw γ from motion and the closest pair of every run, their mean and 95 % interval.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    """
    figure = new_figure(7.2, 2.6)
    left, right = figure.subplots(1, 2)
    for axes, key, label in (
        (left, "gamma_motion", "γ from motion (–)"),
        (right, "smallest_distance", "closest pair (m)"),
    ):
        for k, analysis in enumerate(analyses):
            if key in analysis.curves:
                colour, dash = _STYLES[k % len(_STYLES)]
                crowded = len(analyses) > len(_STYLES)
                axes.plot(
                    analysis.recording.t - analysis.recording.t[0],
                    analysis.curves[key],
                    color=GREY if crowded else colour,
                    linestyle="-" if crowded else dash,
                    linewidth=0.6 if crowded else 1.0,
                    alpha=0.6 if crowded else 1.0,
                    label=None if crowded else _plain(analysis.name),
                )
        if len(analyses) >= 3:
            _mean_band(axes, analyses, key)
        axes.set(xlabel="time (s)", ylabel=label)
        _time_axis(axes, analyses)
    _legend_above(left, 4)
    return figure


def _mean_band(axes: Axes, analyses: Sequence[Analysis], key: str) -> None:
    """Draw the mean over runs and its bootstrap interval on a grid of 120 times."""
    shortest = min(float(a.recording.t[-1] - a.recording.t[0]) for a in analyses)
    grid = np.linspace(0.0, shortest, 120)
    sampled = np.array(
        [
            a.curves[key][
                np.searchsorted(a.recording.t - a.recording.t[0], grid).clip(
                    max=len(a.recording.t) - 1
                )
            ]
            for a in analyses
            if key in a.curves
        ]
    )
    if len(sampled) < 3:
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


def _curve(
    axes: Axes, analysis: Analysis, key: str, style: tuple[str, Any], width: float = 1.1
) -> None:
    """Plot one curve, broken at gaps."""
    if key not in analysis.curves:
        return
    gaps = analysis.recording.gaps
    t = np.insert(analysis.recording.t, gaps, np.nan)
    values = np.insert(analysis.curves[key].astype(float), gaps, np.nan)
    colour, dash = style
    axes.plot(t, values, color=colour, linestyle=dash, linewidth=width, label=_SHORT[key])


def _plain(name: str) -> str:
    """Return a run's name as matplotlib draws it letter by letter: no mathematics, never hidden."""
    return f" {name}".replace("$", r"\$")


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


def _time_axis(axes: Axes, analyses: Sequence[Analysis]) -> None:
    if len(analyses) == 1:
        axes.set_xlim(analyses[0].recording.t[0], analyses[0].recording.t[-1])
    else:
        axes.set_xlim(0.0, max(float(a.recording.t[-1] - a.recording.t[0]) for a in analyses))
