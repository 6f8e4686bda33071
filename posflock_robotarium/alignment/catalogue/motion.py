"""How fast robots go, and the flock as a whole."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.of_seen import centroid_of_seen, mean_of_seen
from posflock_robotarium.alignment.panels import SPEED
from posflock_robotarium.alignment.reductions import settled_mean


def _drift(run: MeasuredRun) -> Floats:
    centroid = centroid_of_seen(run.velocities("savitzky_golay"))
    speed: Floats = np.sqrt(np.square(centroid).sum(axis=1))
    return speed


register(
    Metric(
        "speed",
        "mean speed",
        "m/s",
        "Mean over robots of the Savitzky-Golay speed.",
        lambda run: mean_of_seen(run.speeds),
        panel=SPEED,
        figure="motion",
        legend="mean",
        beside_replay=True,
        numbers=(
            Scalar(
                "speed",
                "mean speed",
                "m/s",
                "Mean over robots and time {run.since}.",
                "Motion",
                settled_mean("speed"),
                latex=True,
                column="mean speed",
            ),
        ),
    ),
    Metric(
        "drift",
        "speed of the centroid",
        "m/s",
        "Speed at which the team as a whole travels.",
        _drift,
        panel=SPEED,
        figure="motion",
        legend="centroid",
        numbers=(
            Scalar(
                "drift",
                "speed of the centroid",
                "m/s",
                "Mean over time {run.since}.",
                "Motion",
                settled_mean("drift"),
            ),
        ),
    ),
    Metric(
        "speed_slowest",
        "slowest robot",
        "m/s",
        "Smallest Savitzky-Golay speed of a robot.",
        lambda run: np.fmin.reduce(run.speeds, axis=1),
        "smallest",
        panel=SPEED,
    ),
    Metric(
        "speed_fastest",
        "fastest robot",
        "m/s",
        "Largest Savitzky-Golay speed of a robot.",
        lambda run: np.fmax.reduce(run.speeds, axis=1),
        "largest",
        panel=SPEED,
    ),
)
