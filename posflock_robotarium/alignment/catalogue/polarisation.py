"""Polarisation (order parameter), and the heading that the flock has in common."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.catalogue.gamma import least_speed
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import HEADING, POLARISATION
from posflock_robotarium.alignment.reductions import settled_mean

SHARED = 0.1
"""Polarisation below which headings have no common direction, only what noise leaves of one."""


def _polarisation(run: MeasuredRun, estimator: str) -> Floats:
    velocities, slowest = run.velocities(estimator), least_speed(run, estimator)
    return run.by_stretch(
        lambda stretch: metrics.polarisation(velocities[stretch], slowest=slowest)
    )


def _polarisation_number(short: str) -> Scalar:
    return Scalar(
        f"polarisation_{short}",
        f"polarisation, {short}",
        "",
        "Mean over time {run.since}, where defined.",
        "Alignment",
        settled_mean(f"polarisation_{short}"),
    )


def _heading(run: MeasuredRun) -> Floats:
    """Return the angle of the mean heading vector, where headings have one in common."""
    headings = run.velocities("headings")
    common = run.by_stretch(lambda stretch: metrics.common_heading(headings[stretch]))
    return np.where(run.once(_polarisation, "headings") >= SHARED, common, np.nan)


def _heading_spread(run: MeasuredRun) -> float:
    angles = run.once(_heading)[run.settled]
    known = angles[np.isfinite(angles)]
    if not known.size:
        return float("nan")
    length = min(1.0, float(np.abs(np.exp(1j * known).mean())))
    return float(np.sqrt(-2.0 * np.log(length))) if length > 0 else float("inf")


register(
    Metric(
        "polarisation_motion",
        "polarisation, motion",
        "",
        "The order parameter: length of the mean of the unit directions of motion.",
        lambda run: run.once(_polarisation, "savitzky_golay"),
        panel=POLARISATION,
        numbers=(_polarisation_number("motion"),),
    ),
    Metric(
        "polarisation_headings",
        "polarisation, headings",
        "",
        "The order parameter: length of the mean of the heading unit vectors, 1 when all robots "
        "point one way.",
        lambda run: run.once(_polarisation, "headings"),
        panel=POLARISATION,
        numbers=(_polarisation_number("headings"),),
    ),
    Metric(
        "heading",
        "heading of the team",
        "rad",
        f"Angle of the mean heading vector; undefined where polarisation is below {SHARED:g}.",
        _heading,
        panel=HEADING,
        numbers=(
            Scalar(
                "heading_spread",
                "spread of the team's heading",
                "rad",
                "Circular standard deviation over time of the mean heading {run.since}.",
                "Alignment",
                _heading_spread,
            ),
        ),
    ),
)
