"""The paper's figures, recomputed in its layout, beside the same over seeds.

Where the paper shows one run, two figures are drawn: ``…_single``, the first seed, and
``…_seeds``, the median over seeds with the band between the quartiles.  Models differ in
colour and in dash.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from posflock_robotarium.figures.experiment import snapshots
from posflock_robotarium.figures.look import OF_ESTIMATOR, Look
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
from posflock_robotarium.flocking.law import PAPER_SIMULATION, phi
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.simulation import PointRun
from posflock_robotarium.paper.evidence import Evidence, Floats, Robots, Varied

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOK = {
    Model.VELOCITY: Look(BLUE, (0, (4, 1.5))),
    Model.POSITION: Look(ORANGE),
    Model.POSITION_NO_THRESHOLD: Look(GREEN, (0, (1, 1))),
}

#: Panels of the history figure: measure, axis label.
_HISTORY = (
    ("gamma", "alignment γ (–)"),
    ("nearest_neighbour", "nearest neighbour (m)"),
    ("speed", "mean speed (m/s)"),
    ("cohesive_radius", "cohesive radius (m)"),
)


def draw_all(evidence: Evidence, folder: Path) -> list[Path]:
    """Draw every figure, each as PNG and PDF, and return the paths.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    folder : Path
        Where the files are put.
    """
    drawn: dict[str, Figure] = {
        "gain": gain(),
        "trajectories_single": trajectories(evidence.singles),
        "rigidity_single": rigidity(evidence, single=True),
        "rigidity_seeds": rigidity(evidence, single=False),
        "history_single": history(evidence, single=True),
        "history_seeds": history(evidence, single=False),
        "robots_snapshots_single": snapshots(evidence.robots.single),
        "robots_alignment_single": robots_alignment(evidence.robots, single=True),
        "robots_alignment_seeds": robots_alignment(evidence.robots, single=False),
        "beyond_parameters": parameters(evidence),
        "beyond_sensing": sensing(evidence),
        "beyond_three_dimensions": three_dimensions(evidence),
    }
    return [path for name, figure in drawn.items() for path in save(figure, folder, name)]


@in_style
def gain() -> Figure:
    """Draw the gain φ over time, with and without threshold (paper, Fig. 3)."""
    figure = new_figure(3.5, 2.3)
    axes = figure.subplots()
    k = PAPER_SIMULATION.persistence
    times = np.linspace(0.5, 40.0, 400)
    for model, persistence, label in (
        (Model.POSITION, k, "with threshold"),
        (Model.POSITION_NO_THRESHOLD, None, "without"),
    ):
        values = [float(phi(time, 1, persistence)) for time in times]
        look = _LOOK[model]
        axes.plot(times, values, linewidth=1.3, label=label, color=look.colour, linestyle=look.dash)
    axes.axvline(1.0 / k, color=GREY, linewidth=0.7, zorder=0)
    axes.text(1.0 / k + 0.7, 0.93, "t = 1/k", fontsize=7, transform=axes.get_xaxis_transform())
    axes.set(xlabel="time (s)", ylabel="φ / |N| (1/s)", xlim=(0, 40), ylim=(0, 1.0))
    axes.legend(loc="center right")
    return figure


@in_style
def trajectories(singles: dict[Model, PointRun]) -> Figure:
    """Draw the paths of the three models from identical starts (paper, Fig. 4).

    Parameters
    ----------
    singles : dict of Model to PointRun
        One run of each model.
    """
    figure = new_figure(7.2, 2.75)
    for axes, (model, run), letter in zip(
        figure.subplots(1, 3), singles.items(), "abc", strict=True
    ):
        p, v = run.positions, run.velocities
        axes.plot(p[:, 0], p[:, 1], color=_LOOK[model].colour, linewidth=0.35, alpha=0.55)
        axes.plot(*p[0, :2], linestyle="", marker=".", markersize=2.5, color=GREY, label="t = 0 s")
        axes.quiver(
            *p[-1, :2],
            *(v[-1, :2] / np.sqrt(np.square(v[-1]).sum(axis=0))),
            color=BLACK,
            angles="xy",
            scale=24,
            width=0.006,
            zorder=3,
        )
        # What the legend shows for the arrows.
        axes.plot(
            [], [], linestyle="", marker="$→$", color=BLACK, label=f"t = {run.times[-1]:.0f} s"
        )
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_title(f"({letter})  {model.label}", fontsize=8)
        axes.set(xlabel="x (m)", ylabel="y (m)" if letter == "a" else "")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


@in_style
def history(evidence: Evidence, *, single: bool) -> Figure:
    """Draw γ, nearest-neighbour distance, speed and cohesive radius (paper, Fig. 5).

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    single : bool
        Draw the first seed alone, or median and quartiles over seeds.
    """
    figure = new_figure(7.2, 4.2)
    panels = figure.subplots(2, 2, sharex=True)
    for axes, (name, label), letter in zip(panels.flat, _HISTORY, "abcd", strict=True):
        for model, measures in evidence.measures.items():
            _curve(axes, measures.times, getattr(measures, name), model, single)
        axes.set(ylabel=label, xlim=(0, measures.times[-1]))
        axes.set_title(f"({letter})", fontsize=8, loc="left")
    for axes in panels[1]:
        axes.set_xlabel("time (s)")
        axes.set_ylim(bottom=0)
    panels[0, 1].set_ylim(bottom=0)
    _near_one(panels[0, 0], evidence, single)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _near_one(axes: Axes, evidence: Evidence, single: bool) -> None:
    """Show in an inset what happens just below γ = 1, where two models lie on each other."""
    inset = axes.inset_axes((0.15, 0.20, 0.33, 0.30))
    for model in (Model.VELOCITY, Model.POSITION):
        measures = evidence.measures[model]
        _curve(inset, measures.times, measures.gamma, model, single)
    inset.set(xlim=(10, measures.times[-1]), ylim=(0.975, 1.001), yticks=(0.98, 1.0))
    inset.tick_params(labelsize=6)


@in_style
def rigidity(evidence: Evidence, *, single: bool) -> Figure:
    """Draw the variance of pairwise distances, and of their change (paper, Fig. 6).

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    single : bool
        Draw the first seed alone, or median and quartiles over seeds.
    """
    figure = new_figure(7.2, 2.5)
    panels = figure.subplots(1, 2, sharex=True)
    titles = ("Var ‖p$_{ij}$(t)‖ (m²)", "Var (‖p$_{ij}$(t)‖ − ‖p$_{ij}$(0)‖) (m²)")
    names = ("distance_variance", "change_variance")
    for axes, name, title, letter in zip(panels, names, titles, "ab", strict=True):
        for model, measures in evidence.measures.items():
            _curve(axes, measures.times, getattr(measures, name), model, single)
        axes.set(xlabel="time (s)", ylabel=title, xlim=(0, measures.times[-1]))
        axes.set_ylim(bottom=0)
        axes.set_title(f"({letter})", fontsize=8, loc="left")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


@in_style
def robots_alignment(robots: Robots, *, single: bool) -> Figure:
    """Draw γ of the nine robots from headings and from motion (paper, Fig. 8).

    Parameters
    ----------
    robots : Robots
        The nine robots over seeds.
    single : bool
        Draw the first seed alone, or median and quartiles over seeds.
    """
    figure = new_figure(3.5, 2.4)
    axes = figure.subplots()
    for values, label in (
        (robots.gamma_headings, "headings"),
        (robots.gamma_motion, "motion"),
    ):
        _line(axes, robots.times, values, single, label, OF_ESTIMATOR[label])
    axes.axhline(1.0, color=GREY, linewidth=0.5, zorder=0)
    axes.set(xlabel="time (s)", ylabel="alignment γ (–)", xlim=(0, robots.times[-1]))
    axes.set_ylim(top=1.05)
    axes.legend(loc="lower right", title="γ from", title_fontsize=7)
    return figure


@dataclass(frozen=True)
class _Curve:
    """The medians of one study and model over its values, with a name and a look."""

    study: Varied
    model: Model
    label: str
    look: Look


def _of_models(study: Varied, models: Iterable[Model]) -> tuple[_Curve, ...]:
    """Return the curves of several models in one study."""
    return tuple(_Curve(study, model, model.label, _LOOK[model]) for model in models)


_BOTH = (Model.VELOCITY, Model.POSITION)
#: What a V-based agent without a velocity sensor makes of noisy positions.
_DIFFERENTIATING = _Curve(
    Varied.DIFFERENTIATED_NOISE,
    Model.VELOCITY,
    "V-based, velocities from noisy positions",
    Look(BLACK, (0, (5, 1, 1, 1))),
)


@in_style
def parameters(evidence: Evidence) -> Figure:
    """Draw what the time step, δ and k change: γ, and the nearest-neighbour distance.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    columns = (
        ("time step dt (s)", _of_models(Varied.TIME_STEP, Model)),
        ("distance scale δ (m)", _of_models(Varied.DISTANCE_SCALE, _BOTH)),
        ("persistence k (1/s)", _of_models(Varied.PERSISTENCE, (Model.POSITION,))),
    )
    figure = new_figure(7.2, 3.9)
    panels = figure.subplots(2, 3, sharex="col", sharey="row")
    for (upper, lower), (label, curves) in zip(panels.T, columns, strict=True):
        for curve in curves:
            _spread(upper, evidence, curve, "gamma_settled")
            values = _spread(lower, evidence, curve, "nearest_neighbour_settled")
        lower.set_xlabel(label)
        if curve.study is not Varied.DISTANCE_SCALE:
            lower.set_xscale("log")
            lower.set_xticks(values, [f"{value:g}" for value in values], minor=False)
            lower.minorticks_off()
    panels[0, 0].set_ylabel("mean γ, t > 20 s (–)")
    panels[1, 0].set_ylabel("nearest neighbour (m)")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


@in_style
def sensing(evidence: Evidence) -> Figure:
    """Draw γ under noise, dropout, delay and failing agents, V-based and P-based.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    studies = (
        ("position noise σ (m)", (*_of_models(Varied.POSITION_NOISE, _BOTH), _DIFFERENTIATING)),
        ("chance to miss a neighbour (–)", _of_models(Varied.DROPOUT, _BOTH)),
        ("delay of sensing (s)", _of_models(Varied.DELAY, _BOTH)),
        ("share of agents that vanish (–)", _of_models(Varied.VANISHING, _BOTH)),
        ("share of agents that stop (–)", _of_models(Varied.STOPPING, _BOTH)),
    )
    figure = new_figure(7.2, 4.2)
    panels = figure.subplots(2, 3, sharey=True)
    for axes, (label, curves) in zip(panels.flat, studies, strict=False):
        for curve in curves:
            _spread(axes, evidence, curve, "gamma_settled")
        axes.set_xlabel(label)
    noise = panels[0, 0]
    noise.set_xscale("symlog", linthresh=0.01)
    noise.set_xticks([0, 0.01, 0.1, 0.5], ["0", "0.01", "0.1", "0.5"], minor=False)
    noise.minorticks_off()
    for axes in panels[:, 0]:
        axes.set_ylabel("mean γ, t > 20 s (–)")
    panels[1, 2].axis("off")
    panels[1, 2].legend(*noise.get_legend_handles_labels(), loc="center")
    return figure


@in_style
def three_dimensions(evidence: Evidence) -> Figure:
    """Draw γ over time in three dimensions, the three models.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    figure = new_figure(3.5, 2.4)
    axes = figure.subplots()
    drawn = [each for each in evidence.variations if each[0].study is Varied.THREE_DIMENSIONS]
    gammas = _over_common_seeds([measures.gamma for _, measures in drawn])
    for (variation, measures), gamma in zip(drawn, gammas, strict=True):
        _curve(axes, measures.times, gamma, variation.scenario.model, single=False)
        axes.set_xlim(0, measures.times[-1])
    axes.set(xlabel="time (s)", ylabel="alignment γ (–)")
    axes.legend(loc="lower right")
    return figure


def _curve(axes: Axes, times: Floats, values: Floats, model: Model, single: bool) -> None:
    _line(axes, times, values, single, model.label, _LOOK[model])


def _line(axes: Axes, times: Floats, values: Floats, single: bool, label: str, look: Look) -> None:
    """Draw the first row of (B, T) values, or their median with a band between quartiles."""
    if not single:
        low, middle, high = _quartiles(values)
        axes.fill_between(times, low, high, color=look.colour, alpha=0.18, linewidth=0)
    axes.plot(
        times,
        values[0] if single else middle,
        color=look.colour,
        linestyle=look.dash,
        linewidth=look.width,
        label=label,
    )


def _spread(axes: Axes, evidence: Evidence, curve: _Curve, name: str) -> Floats:
    """Draw the medians of a number with bars from quartile to quartile; return the values."""
    values, numbers = evidence.study(curve.study, curve.model)
    low, middle, high = _quartiles(np.transpose(_over_common_seeds([n[name] for n in numbers])))
    axes.errorbar(
        values,
        middle,
        yerr=[middle - low, high - middle],
        marker="o",
        markersize=2.5,
        linewidth=1.1,
        elinewidth=0.7,
        capsize=2,
        label=curve.label,
        color=curve.look.colour,
        linestyle=curve.look.dash,
    )
    return values


def _over_common_seeds(runs: Sequence[Floats]) -> list[Floats]:
    """Cut runs (B, ...) to the seeds that all have.

    What a claim is judged by is run over more; with other seeds at one value than at the next, a
    curve would bend where nothing but the seeds changes.
    """
    fewest = min(len(each) for each in runs)
    return [each[:fewest] for each in runs]


def _quartiles(runs: Floats) -> Sequence[Floats]:
    """Return the quartiles over the first axis, leaving out instants at which γ is unknown."""
    return list(np.nanpercentile(runs, [25, 50, 75], axis=0))
