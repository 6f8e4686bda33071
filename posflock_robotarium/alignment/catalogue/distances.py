"""How close robots come to each other; a robot alone has no such distance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.faults import count, faults_of
from posflock_robotarium.alignment.measured_run import CurveFunction, Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import (
    Metric,
    NumberFunction,
    Scalar,
    register,
)
from posflock_robotarium.alignment.panels import DISTANCE
from posflock_robotarium.alignment.reductions import settled_mean, smallest
from rps_compat.violations import FaultKind


def _to_nearest(run: MeasuredRun) -> Floats:
    """Return how far each robot's nearest other is, m, shape (T, N)."""
    parts = [metrics.distances_to_nearest(run.positions[rows]) for rows in run.stretches()]
    return np.concatenate(parts)


def _between_centres(measure: Callable[[Floats], Floats]) -> CurveFunction:
    def curve(run: MeasuredRun) -> Floats | None:
        if run.recording.robots < 2:
            return None
        distances = measure(run.once(_to_nearest))
        return np.where(np.isinf(distances), np.nan, distances)

    return curve


def _between_collision_points(run: MeasuredRun) -> Floats | None:
    if run.recording.robots < 2 or not run.recording.headed:
        return None
    offset, headings = run.robot.collision_offset, run.velocities("headings")
    distances = run.by_stretch(
        lambda stretch: metrics.smallest_distance(
            run.positions[stretch] + offset * headings[stretch]
        )
    )
    return np.where(np.isinf(distances), np.nan, distances)


def _of_pairs(value: NumberFunction) -> NumberFunction:
    """Return the same function, that says nothing of a robot alone, or without headings."""
    return lambda run: value(run) if run.recording.robots > 1 and run.recording.headed else None


register(
    Metric(
        "nearest_neighbour",
        "nearest neighbour, mean",
        "m",
        "Mean over robots of the distance to the nearest other robot, centre to centre.",
        _between_centres(metrics.mean_to_nearest),
        panel=DISTANCE,
        figure="distances",
        legend="nearest neighbour",
        numbers=(
            Scalar(
                "nearest_neighbour",
                "nearest neighbour",
                "m",
                "Mean over robots and time {run.since}.",
                "Safety",
                settled_mean("nearest_neighbour"),
                latex=True,
            ),
        ),
    ),
    Metric(
        "smallest_distance",
        "closest pair",
        "m",
        "Smallest distance between two robots' centres.",
        _between_centres(lambda nearest: np.asarray(nearest.min(axis=1))),
        "smallest",
        panel=DISTANCE,
        figure="distances",
        beside_replay=True,
        numbers=(
            Scalar(
                "smallest_distance",
                "smallest distance of two robots",
                "m",
                "Centre to centre, whole run.",
                "Safety",
                smallest("smallest_distance"),
                latex=True,
                column="closest pair",
            ),
        ),
    ),
    Metric(
        "smallest_collision_distance",
        "closest pair, collision points",
        "m",
        "Smallest distance between the points ahead of the centres that the testbed's collision "
        "test looks at.",
        _between_collision_points,
        "smallest",
        panel=DISTANCE,
        numbers=(
            Scalar(
                "smallest_collision_distance",
                "smallest distance of collision points",
                "m",
                "Points {run.robot.collision_offset:g} m ahead of the centres, whole run; the "
                "testbed calls less than {run.robot.collision_diameter:g} m a collision.",
                "Safety",
                smallest("smallest_collision_distance"),
            ),
            Scalar(
                "collisions",
                "collisions",
                "",
                "Times a pair came too close by the testbed's own test, each counted once.",
                "Safety",
                _of_pairs(lambda run: count(run, FaultKind.COLLISION)),
                latex=True,
                column="collisions",
            ),
            Scalar(
                "collision_steps",
                "pairs too close, summed over steps",
                "",
                "As the testbed counts.",
                "Safety",
                _of_pairs(lambda run: run.once(faults_of).close_pairs),
            ),
        ),
    ),
)
