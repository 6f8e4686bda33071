"""Pictures of a study: an outcome over a parameter, with confidence intervals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from posflock_robotarium.alignment.fewest_runs import FEWEST_RUNS
from posflock_robotarium.alignment.intervals import median_interval
from posflock_robotarium.figures.look import Look
from posflock_robotarium.figures.style import BLACK, BLUE, GREEN, ORANGE, in_style, new_figure, save
from posflock_robotarium.sweep.parameter_distribution import StudyError
from posflock_robotarium.sweep.results import outcomes, succeeded
from posflock_robotarium.sweep.store import Row
from posflock_robotarium.sweep.study import Figure as Asked
from posflock_robotarium.sweep.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOKS = (
    Look(BLUE, (0, (4, 1.5)), "s"),
    Look(ORANGE, "-", "o"),
    Look(GREEN, (0, (1, 1)), "^"),
    Look(BLACK, (0, (5, 1, 1, 1)), "D"),
)

#: Units of parameters and outcomes, for the axes; what is missing has none.
UNITS = {
    "alignment_time": "s",
    "change_variance_settled": "m²",
    "closest_pair": "m",
    "cohesive_radius_end": "m",
    "delay": "s",
    "distance_scale": "m",
    "distance_variance_end": "m²",
    "distance_variance_start": "m²",
    "duration": "s",
    "failure_time": "s",
    "fastest_start": "m/s",
    "fastest_wheel": "rad/s",
    "heading_spread": "°",
    "input_limit": "m/s²",
    "largest_intervention": "m/s",
    "mean_speed": "m/s",
    "nearest_neighbour_end": "m",
    "nearest_neighbour_settled": "m",
    "persistence": "1/s",
    "position_noise": "m",
    "radius": "m",
    "side": "m",
    "smallest_clearance": "m",
    "smallest_distance": "m",
    "smallest_wall_distance": "m",
    "spacing": "m",
    "speed_end": "m/s",
    "speed_limit": "m/s",
    "time_step": "s",
    "tracking_noise": "m",
    "velocity_noise": "m/s",
}


def draw_study(study: Study, rows: Sequence[Row], folder: Path) -> list[Path]:
    """Draw the figures a study asks for, or the experiment's headline; return the paths.

    Parameters
    ----------
    study : Study
        Which runs of which experiment.
    rows : sequence of Row
        Its runs, as the store has them.
    folder : Path
        Where the files are put.

    Raises
    ------
    StudyError
        Where a figure asks for an outcome that the experiment does not have.
    OutputError
        Where the folder cannot be written.
    """
    known, rows = outcomes(study, rows), succeeded(rows)
    paths: list[Path] = []
    if not rows:  # nothing is finished yet
        return paths
    for asked in study.figures or _default_figures(study):
        if asked.y not in known:
            raise StudyError(f"figures: expected an outcome, one of {', '.join(known)};"
                             f" got {asked.y!r}")  # fmt: skip
        name = f"{asked.y}_over_{asked.x}" + (f"_by_{asked.by}" if asked.by else "")
        paths += save(outcome_over(study, rows, asked), folder, name)
    return paths


@in_style
def outcome_over(study: Study, rows: Sequence[Row], asked: Asked) -> Figure:
    """Draw medians and their 95 % intervals over a grid, or every run over a distribution.

    Parameters
    ----------
    study : Study
        Which runs of which experiment.
    rows : sequence of Row
        Its runs, as the store has them.
    asked : Asked
        Which outcome over which parameter.
    """
    figure = new_figure(3.6, 2.7)
    axes = figure.subplots()
    groups = _values(study, rows, asked.by) if asked.by else [None]
    axes.set(xlabel=_title(study, asked.x), ylabel=_title(study, asked.y))
    for group, look in zip(groups, cycle(_LOOKS), strict=False):
        chosen = [row for row in rows if group is None or row[asked.by] == group]
        label = _tick(group) if group is not None else None
        if asked.x in study.distributions:
            _every_run(axes, chosen, asked, label, look)
        else:
            values = _values(study, chosen, asked.x)
            _medians(axes, values, chosen, asked, label, look)
    if asked.by:
        title = _title(study, asked.by).removesuffix(" (–)")
        figure.legend(loc="outside lower center", ncols=3, title=title)
    few = study.replications < FEWEST_RUNS
    each = f"median{'' if few else ' and 95 % interval'} of {study.replications} runs"
    axes.set_title("every run" if asked.x in study.distributions else each, fontsize=7, loc="right")
    return figure


def _values(study: Study, rows: Sequence[Row], name: str) -> list[Any]:
    """Return the values that a parameter takes: numbers in order, words as the study lists them."""
    there = {row[name] for row in rows}
    listed = [value for value in study.grid.get(name, []) if value in there]
    return listed if any(isinstance(value, str) for value in listed) else sorted(there)


def _medians(
    axes: Axes,
    values: list[Any],
    rows: Sequence[Row],
    asked: Asked,
    label: str | None,
    look: Look,
) -> None:
    runs = [
        np.array([r[asked.y] for r in rows if r[asked.x] == x and asked.y in r], dtype=float)
        for x in values
    ]
    middle = np.array([np.median(run) if run.size else np.nan for run in runs])
    ends = np.transpose([median_interval(run) for run in runs])
    low, high = np.where(np.isnan(ends), middle, ends)  # of few runs there is no bar
    # Words have no places on an axis: they are put one after another.
    numeric = all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in values)
    places = np.array(values, dtype=float) if numeric else np.arange(len(values))
    drawn = np.isfinite(middle) & np.isfinite(low) & np.isfinite(high)
    axes.errorbar(
        places[drawn],
        middle[drawn],
        yerr=[(middle - low)[drawn], (high - middle)[drawn]],
        markersize=3,
        linewidth=1.0,
        elinewidth=0.8,
        capsize=2,
        label=label,
        color=look.colour,
        linestyle=look.dash if numeric else "",
        marker=look.marker,
    )
    if not numeric:
        axes.set_xticks(places, [_tick(x) for x in values])
        axes.set_xlabel(axes.get_xlabel().removesuffix(" (–)"))
        axes.margins(x=0.15)


def _every_run(
    axes: Axes, rows: Sequence[Row], asked: Asked, label: str | None, look: Look
) -> None:
    points = np.array([(row[asked.x], row[asked.y]) for row in rows], dtype=float).reshape(-1, 2)
    x, y = points[np.isfinite(points).all(axis=1)].T
    axes.plot(
        x,
        y,
        alpha=0.7,
        markersize=3,
        label=label,
        color=look.colour,
        linestyle="",
        marker=look.marker,
    )


def _default_figures(study: Study) -> list[Asked]:
    """Return the headline outcomes over the longest numeric axis, by the next parameter."""
    varied = [*study.grid, *study.distributions]
    if not varied:
        return []
    steps = {name: len(values) for name, values in study.grid.items()}
    numeric = [n for n in varied if not isinstance(study.experiment.defaults[n], (str, bool))]
    x = max(numeric or varied, key=lambda name: steps.get(name, 0))
    others = [name for name in study.grid if name != x and steps[name] > 1]
    by = others[0] if others else ""
    return [Asked(x, y, by) for y in study.experiment.headline]


def _title(study: Study, name: str) -> str:
    """Return a name with its unit, a dash where it has none, and nothing where that is unknown."""
    own = study.experiment.units
    unit = own.get(name, "") if own else UNITS.get(name, "–")
    return name.replace("_", " ") + (f" ({unit})" if unit else "")


def _tick(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
