"""How well a team covers the arena, every place counting alike.

After J. Cortés, S. Martínez, T. Karatas and F. Bullo, *Coverage control for mobile sensing
networks* (2004): each place belongs to the nearest robot, and a team that covers well has each
robot at the centroid of its cell. Computed only where a run is asked about coverage.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from posflock_robotarium.alignment.catalogue.formation import ending
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, NumberFunction, Scalar, register
from posflock_robotarium.alignment.panels import COVERAGE
from posflock_robotarium.alignment.questions import Questions

SPACING = 0.08
"""Metres between the places that the arena is sampled at."""


class Coverage(NamedTuple):
    """How the arena is covered over time.

    Parameters
    ----------
    distance : (T,) array
        Mean distance of a place from the nearest robot, m.
    offset : (T,) array
        Largest distance of a robot from the centroid of its cell, m; NaN where a cell is empty.
    """

    distance: Floats
    offset: Floats


def _coverage(run: MeasuredRun) -> Coverage | None:
    if run.options.questions is not Questions.COVERAGE:
        return None
    left, right, bottom, top = run.robot.boundaries
    columns = max(2, round((right - left) / SPACING))
    rows = max(2, round((top - bottom) / SPACING))
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    places = np.stack([axis.ravel() for axis in np.meshgrid(x, y)])  # (2, P)
    found = np.array([_of_team(team, places) for team in run.positions])
    return Coverage(found[:, 0], found[:, 1])


def _of_team(team: Floats, places: Floats) -> tuple[float, float]:
    """Return mean distance and largest offset of one team, (2, N), by the places of the arena.

    Both are unknown while somebody is not seen, who covers places all the same.
    """
    if np.isnan(team).any():
        return float("nan"), float("nan")
    apart = np.square(places[0] - team[0, :, None]) + np.square(places[1] - team[1, :, None])
    owner = apart.argmin(axis=0)
    nearest = float(np.sqrt(apart[owner, np.arange(len(owner))]).mean())
    counts = np.bincount(owner, minlength=team.shape[1])
    if not counts.all():
        return nearest, float("nan")
    centroid = [np.bincount(owner, axis, len(counts)) / counts for axis in places]
    return nearest, float(np.hypot(centroid[0] - team[0], centroid[1] - team[1]).max())


def _distance(run: MeasuredRun) -> Floats | None:
    found = run.once(_coverage)
    return None if found is None else found.distance


def _offset(run: MeasuredRun) -> Floats | None:
    found = run.once(_coverage)
    return None if found is None else found.offset


def _first(run: MeasuredRun) -> float | None:
    found = run.once(_coverage)
    return None if found is None else float(found.distance[int(np.searchsorted(run.t, run.start))])


def _last(run: MeasuredRun) -> float | None:
    found = run.once(_coverage)
    return None if found is None else run.mean(np.where(ending(run), found.distance, np.nan))


def _last_offset(run: MeasuredRun) -> float | None:
    found = run.once(_coverage)
    return None if found is None else float(np.fmax.reduce(found.offset[ending(run)]))


def _number(
    key: str, label: str, definition: str, value: NumberFunction, latex: bool = False
) -> Scalar:
    return Scalar(key, label, "m", definition, "Coverage", value, latex=latex)


register(
    Metric(
        "coverage_distance",
        "mean distance of a place from the nearest robot",
        "m",
        "Mean over the arena, every place counting alike.",
        _distance,
        panel=COVERAGE,
        figure="coverage",
        legend="place to robot, mean",
        beside_replay=True,
        numbers=(
            _number(
                "coverage_start",
                "mean distance of a place from the nearest robot, at the start",
                "At the first pose, after the drive to the start where the log has one.",
                _first,
            ),
            _number(
                "coverage_end",
                "mean distance of a place from the nearest robot, at the end",
                "Mean over the last tenth of the run.",
                _last,
                latex=True,
            ),
        ),
    ),
    Metric(
        "cell_offset",
        "farthest robot from the centroid of its cell",
        "m",
        "Largest distance of a robot from the centroid of the places that are nearest to it; "
        "undefined while none is nearest to some robot.",
        _offset,
        "largest",
        panel=COVERAGE,
        figure="coverage",
        legend="robot to centroid, largest",
        numbers=(
            _number(
                "cell_offset_end",
                "farthest robot from the centroid of its cell, at the end",
                "Largest over the last tenth of the run.",
                _last_offset,
                latex=True,
            ),
        ),
    ),
)
