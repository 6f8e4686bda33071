"""How far the flock spreads around its centroid."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import COHESION
from posflock_robotarium.alignment.reductions import settled_mean


def _cohesive_radius(run: MeasuredRun) -> Floats:
    return run.by_stretch(lambda stretch: metrics.cohesive_radius(run.positions[stretch]))


def _spread(run: MeasuredRun) -> Floats:
    return run.by_stretch(lambda stretch: metrics.spread(run.positions[stretch]))


def _ratio(run: MeasuredRun) -> float:
    """Return the ratio over the times at which all are seen that ever are."""
    ever = run.seen.any(axis=0)
    radius = run.once(_cohesive_radius)[run.settled & run.seen[:, ever].all(axis=1)]
    return float(radius.max() / radius.min()) if radius.size and radius.min() > 0 else np.nan


register(
    Metric(
        "cohesive_radius",
        "cohesive radius",
        "m",
        "Largest distance of a robot from the centroid.",
        _cohesive_radius,
        "largest",
        panel=COHESION,
        figure="distances",
        numbers=(
            Scalar(
                "cohesive_radius",
                "cohesive radius",
                "m",
                "Mean {run.since}.",
                "Cohesion",
                settled_mean("cohesive_radius"),
                latex=True,
            ),
            Scalar(
                "cohesive_radius_ratio",
                "cohesive radius, largest over smallest",
                "",
                "Over the times {run.since} at which all robots are seen.",
                "Cohesion",
                _ratio,
            ),
        ),
    ),
    Metric(
        "spread",
        "spread",
        "m",
        "Root mean square distance of the robots from the centroid.",
        _spread,
        panel=COHESION,
        numbers=(
            Scalar(
                "spread", "spread", "m", "Mean {run.since}.", "Cohesion", settled_mean("spread")
            ),
        ),
    ),
)
