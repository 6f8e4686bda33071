"""Who stands, who stalls against a command, and how far the flock has come."""

from __future__ import annotations

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun, weighted_mean
from posflock_robotarium.alignment.metric_registry import Scalar, register
from posflock_robotarium.alignment.of_seen import mean_of_seen

LAST_SHARE = 0.1
"""How much of a run is its end: long enough that a script's own last stop is not parking."""

STALL_COMMAND = 0.02
"""Commanded speed in m/s above which a standing robot stalls."""

STALL_SECONDS = 1.0
"""Seconds a robot must stand against its command; the testbed's dead time is 0.2 s."""


def _stands(run: MeasuredRun) -> Floats:
    """Return which robot stands (1) or moves (0) when, shape (T, N); NaN where that is unknown."""
    stands = ties.within(run.speeds, run.options.slowest).astype(float)
    return np.where(np.isfinite(run.speeds), stands, np.nan)


def _standing(run: MeasuredRun) -> float:
    return run.settled_mean(mean_of_seen(run.once(_stands)))


def _robots_standing(run: MeasuredRun) -> float:
    stood = np.array([run.settled_mean(robot) for robot in run.once(_stands).T])
    return float(ties.beyond(stood, 0.5).sum())


def _standing_end(run: MeasuredRun) -> float:
    t = run.recording.t
    final = ties.reached(t, t[-1] - LAST_SHARE * (t[-1] - t[0]))
    return weighted_mean(mean_of_seen(run.once(_stands))[final], run.weights[final])


def _displacement(run: MeasuredRun) -> float:
    # Of each robot from where it was first seen to where last: who is not seen is no displacement.
    ends = [
        run.positions[rows[-1], :, n] - run.positions[rows[0], :, n]
        for n, rows in enumerate(np.flatnonzero(seen) for seen in run.seen.T)
        if rows.size
    ]
    return float(np.hypot(*np.mean(ends, axis=0)))


def _stalls(run: MeasuredRun) -> tuple[int, float] | None:
    """Count stalls and their seconds, robot by robot; None where no command is known."""
    t, commands = run.recording.t, run.recording.commands
    if commands is None:
        return None
    stuck = (run.once(_stands) == 1) & ties.reached(np.abs(commands[:, 0]), STALL_COMMAND)
    count, seconds = 0, 0.0
    for column in stuck.T:
        edges = np.diff(np.concatenate([[0], column.astype(np.int8), [0]]))
        for first, last in zip(
            np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1, strict=True
        ):
            length = float(t[last] - t[first])
            if ties.beyond(length, STALL_SECONDS):
                count += 1
                seconds += length
    return count, seconds


def _stall_count(run: MeasuredRun) -> int | None:
    found = run.once(_stalls)
    return None if found is None else found[0]


def _stall_time(run: MeasuredRun) -> float | None:
    found = run.once(_stalls)
    return None if found is None else found[1]


register(
    Scalar(
        "standing",
        "standing robots",
        "share",
        "Share of robots and time {run.since} at no more than {run.options.slowest:g} m/s.",
        "Motion",
        _standing,
        latex=True,
        column="standing",
    ),
    Scalar(
        "robots_standing",
        "robots that stood",
        "",
        "Robots that moved at no more than {run.options.slowest:g} m/s for over half the time "
        "{run.since}.",
        "Motion",
        _robots_standing,
    ),
    Scalar(
        "standing_end",
        "standing robots at the end",
        "share",
        "The same over the last tenth of the run.",
        "Motion",
        _standing_end,
    ),
    Scalar(
        "centroid_displacement",
        "displacement of the centroid",
        "m",
        "Straight line from the first to the last position of the team's centroid; of a robot "
        "that is not seen throughout, between those at which it is.",
        "Motion",
        _displacement,
    ),
    Scalar(
        "stalls",
        "stalls",
        "",
        f"Times a robot stood for over {STALL_SECONDS:g} s though commanded to drive at "
        f"{STALL_COMMAND:g} m/s or more.",
        "Motion",
        _stall_count,
    ),
    Scalar("stall_time", "time stalled", "s", "Sum over robots.", "Motion", _stall_time),
)
