"""Who is seen: how many robots the other numbers speak for, and what the others may change.

Nothing is told of a log in which everybody is seen all the time.
"""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.of_seen import mean_of_seen
from posflock_robotarium.alignment.panels import SEEN
from posflock_robotarium.logs.told_sightings import Losses, losses_of

_ROWS = 400
"""Samples by which is judged how much γ hangs on one robot."""


def _robots_seen(run: MeasuredRun) -> Floats | None:
    return None if run.all_seen else run.seen.sum(axis=1).astype(float)


def _losses(run: MeasuredRun) -> Losses:
    return losses_of(run.logged, run.sightings)


def _jumps(run: MeasuredRun) -> int | None:
    count = int(run.sightings.jumps.sum())
    return count or None


def _shift(run: MeasuredRun) -> float | None:
    """Return how far γ from motion may be off for the robots that are not seen.

    What a robot means to γ is measured where it is seen: by leaving it out.  One that is never seen
    may mean as much as the one that means most.
    """
    if not run.has_neighbours:
        return None
    if run.all_seen or run.recording.robots < 3:
        return None if run.all_seen else float("nan")
    settled = np.flatnonzero(run.settled)
    rows = settled[:: max(1, len(settled) // _ROWS)]
    velocities, positions = run.velocities("savitzky_golay")[rows], run.positions[rows]
    unseen = 1.0 - run.seen[run.settled].mean(axis=0)

    slowest = run.options.slowest
    whole = metrics.alignment(velocities, positions, run.radius, slowest=slowest).gamma
    without = metrics.alignment_without_each(velocities, positions, run.radius, slowest=slowest)
    there = np.isfinite(velocities[:, 0])
    meant = mean_of_seen(np.where(there, np.abs(whole[:, np.newaxis] - without), np.nan), axis=0)
    if np.isnan(meant).all():
        return float("nan")
    meant[np.isnan(meant)] = np.nanmax(meant)
    return float((unseen * meant).sum())


register(
    Metric(
        "robots_seen",
        "robots seen",
        "",
        "Number of robots whose pose is there and believed; all other metrics are of these.",
        _robots_seen,
        "smallest",
        panel=SEEN,
        numbers=(
            Scalar(
                "robots_seen",
                "robots seen",
                "",
                "Mean over the run. A frame that was written twice counts once.",
                "Confidence",
                lambda run: None if run.all_seen else run.once(_losses).seen * run.recording.robots,
                latex=True,
            ),
            Scalar(
                "longest_unseen",
                "longest time that a robot is not seen",
                "s",
                "Of the robots that are seen at all.",
                "Confidence",
                lambda run: None if run.all_seen else run.once(_losses).longest,
            ),
            Scalar(
                "gamma_unseen",
                "γ from motion may be shifted by the robots not seen by up to",
                "",
                "Sum over robots of the share of the time {run.since} for which each is not seen, "
                "times what leaving it out changes where it is seen, on average.",
                "Confidence",
                _shift,
            ),
        ),
    ),
    Scalar(
        "jumps",
        "jumps that no wheels can drive",
        "",
        "Robots that went farther or turned more from one pose to the next than at one and a half "
        "times their full speed.",
        "Confidence",
        _jumps,
    ),
)
