"""When the flock aligned, for good or for once, and how steadily."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.catalogue.gamma import alignment_of
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import NumberFunction, Scalar, register


def _aligned(run: MeasuredRun, estimator: str) -> NDArray[np.bool_]:
    """Return at which samples γ is at the threshold or above; never where it is undefined."""
    gamma = run.once(alignment_of, estimator).gamma
    return np.asarray(ties.reached(np.nan_to_num(gamma, nan=-2.0), run.options.threshold))


def _told(run: MeasuredRun, estimator: str) -> NDArray[np.bool_]:
    """Return at which samples γ could be known: two robots have a direction or none, but are seen.

    A flock that stands is not aligned; of one that nobody sees nothing is known.
    """
    if run.all_seen:
        return np.ones(len(run.recording.t), dtype=bool)
    known = np.isfinite(run.velocities(estimator)[:, 0]).sum(axis=1)
    return np.asarray(known > min(1, run.recording.robots - 1))


def _whether(run: MeasuredRun, estimator: str) -> Floats:
    """Return 1 where the flock is aligned, 0 where it is not, NaN where that is unknown."""
    return np.where(run.once(_told, estimator), _aligned(run, estimator).astype(float), np.nan)


def _first_time(run: MeasuredRun, estimator: str) -> float:
    t = run.recording.t
    reached = np.flatnonzero(_aligned(run, estimator) & (t >= run.start))
    return float(t[reached[0]] - run.start) if reached.size else float("nan")


def _time_for_good(run: MeasuredRun, estimator: str) -> float:
    # NaN where the last sample itself is below: alignment that ended is not for good.
    t = run.recording.t
    known = run.once(_told, estimator)
    below = np.flatnonzero((~_aligned(run, estimator) & known) | (t < run.start))
    lasting = int(below[-1]) + 1 if below.size else 0
    return float(t[lasting] - run.start) if lasting < len(t) else float("nan")


def _of_neighbours(value: Callable[[MeasuredRun, str], float], estimator: str) -> NumberFunction:
    """Return a number of γ by one estimator, that says nothing where no neighbours are known."""
    return lambda run: value(run, estimator) if run.has_neighbours else None


def _share(run: MeasuredRun, estimator: str) -> float:
    return run.mean(_whether(run, estimator))


def _steadiness(run: MeasuredRun, estimator: str) -> float:
    return run.settled_mean(_whether(run, estimator))


def _times(short: str, estimator: str, latex: bool) -> tuple[Scalar, ...]:
    threshold = "γ ≥ {run.options.threshold:g}"
    return (
        Scalar(
            f"time_to_alignment_{short}",
            f"time to {threshold} from {short}",
            "s",
            "From the start of the experiment to the first sample at or above the threshold; "
            "undefined when it is never reached.",
            "Alignment",
            _of_neighbours(_first_time, estimator),
        ),
        Scalar(
            f"time_aligned_for_good_{short}",
            f"time from which {threshold} for good, from {short}",
            "s",
            "From the start of the experiment to the last time γ rises to the threshold and stays; "
            "undefined when the run ends below it.",
            "Alignment",
            _of_neighbours(_time_for_good, estimator),
            latex=latex,
        ),
        Scalar(
            f"share_aligned_{short}",
            f"time with {threshold} from {short}",
            "share",
            "Share of the whole run; samples where γ is undefined count as not aligned, and "
            "those at which fewer than two robots are seen do not count.",
            "Alignment",
            _of_neighbours(_share, estimator),
            latex=latex,
        ),
        Scalar(
            f"steadiness_{short}",
            f"time with {threshold} from {short}, settled",
            "share",
            "The same {run.since}.",
            "Alignment",
            _of_neighbours(_steadiness, estimator),
        ),
    )


register(*_times("motion", "savitzky_golay", latex=True))
register(*_times("headings", "headings", latex=False))
