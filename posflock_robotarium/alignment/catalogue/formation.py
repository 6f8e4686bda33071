"""Whether a team takes up a shape and keeps it, whichever shape that is.

The shape is told by the distances of all pairs, which neither travelling nor turning changes. It is
compared with the shape that the run ends in; computed only where a run is asked about formation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import FORMATION
from posflock_robotarium.alignment.questions import Questions

LAST_SHARE = 0.1
"""How much of a run is its end, whose mean shape is the one that it is compared with."""

KEPT = 0.05
"""Metres by which distances may be off in a shape that is kept: how exactly the testbed brings
robots to their places."""


def ending(run: MeasuredRun) -> NDArray[np.bool_]:
    """Return which samples are the end of a run, the last tenth of its experiment.

    Parameters
    ----------
    run : MeasuredRun
        Whose drive to the start, where the log has one, is no part of the experiment.

    Returns
    -------
    (T,) boolean array
        Whether each sample is.
    """
    t = run.t
    return np.asarray(ties.reached(t, t[-1] - LAST_SHARE * (t[-1] - run.start)))


def _shape_change(run: MeasuredRun) -> Floats | None:
    if run.options.questions is not Questions.FORMATION or run.robots < 2:
        return None
    first, second = np.triu_indices(run.robots, 1)
    x, y = run.positions[:, 0], run.positions[:, 1]
    apart = np.hypot(x[:, first] - x[:, second], y[:, first] - y[:, second])
    off = np.square(apart - _mean(apart[ending(run)], axis=0))
    change: Floats = np.sqrt(_mean(off, axis=1))
    return change


def _mean(values: Floats, axis: int) -> Floats:
    """Return means of what is known, NaN where nothing is: a pair of which one is not seen."""
    known = np.isfinite(values)
    count = known.sum(axis=axis)
    total = np.where(known, values, 0.0).sum(axis=axis)
    return np.asarray(np.divide(total, count, out=np.full(count.shape, np.nan), where=count > 0))


def _kept_from(run: MeasuredRun) -> float | None:
    change = run.curve("shape_change")
    if change is None:
        return None
    off = np.flatnonzero(ties.beyond(change, KEPT) | ties.short_of(run.t, run.start))
    first = int(off[-1]) + 1 if off.size else 0
    return float(run.t[first] - run.start) if first < len(run.t) else float("nan")


def _at_end(run: MeasuredRun) -> float | None:
    change = run.curve("shape_change")
    return None if change is None else float(np.fmax.reduce(change[ending(run)]))


register(
    Metric(
        "shape_change",
        "change of shape",
        "m",
        "Root mean square over pairs that are seen of how far their distance is from its mean over "
        "the last tenth of the run: 0 while the team has the shape that it ends in.",
        _shape_change,
        "largest",
        panel=FORMATION,
        figure="formation",
        beside_replay=True,
        numbers=(
            Scalar(
                "shape_change_end",
                "change of shape at the end",
                "m",
                "Largest over the last tenth of the run.",
                "Formation",
                _at_end,
                latex=True,
                column="change of shape",
            ),
            Scalar(
                "shape_kept_from",
                "time from which the shape is kept",
                "s",
                "From the first pose, or the end of the drive to the start where the log has one, "
                f"until the change of shape stays at {KEPT:g} m or less; "
                "undefined when the run ends above it.",
                "Formation",
                _kept_from,
                latex=True,
            ),
        ),
    ),
)
