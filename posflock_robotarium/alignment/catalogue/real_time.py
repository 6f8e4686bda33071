"""How long steps really took, and how long the robots drove to their initial conditions."""

from __future__ import annotations

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import STEPS
from posflock_robotarium.alignment.reductions import largest
from posflock_robotarium.logs.real_time import clock_of
from rps_compat.testbed import WATCHDOG

LATE = 0.25
"""Share of the median step by which a step is off that counts as irregular."""


def _steps(run: MeasuredRun) -> Floats | None:
    """Return the seconds from each row to the next by a clock; None of times that were counted."""
    clock = None if run.recording.simulated else clock_of(run.recording)
    return None if clock is None else np.diff(clock)


def _step_time(run: MeasuredRun) -> Floats | None:
    steps = run.once(_steps)
    return None if steps is None else np.append(steps, np.nan)


def _mean(run: MeasuredRun) -> float | None:
    steps = run.once(_steps)
    return None if steps is None else float(steps.mean())


def _median(run: MeasuredRun) -> float | None:
    steps = run.once(_steps)
    return None if steps is None else float(np.median(steps))


def _irregular(run: MeasuredRun) -> float | None:
    steps = run.once(_steps)
    if steps is None:
        return None
    median = float(np.median(steps))
    return float(ties.beyond(np.abs(steps - median), LATE * median).mean())


def _over(run: MeasuredRun) -> int | None:
    steps = run.once(_steps)
    return None if steps is None else int(ties.beyond(steps, WATCHDOG).sum())


def _braked(run: MeasuredRun) -> float | None:
    steps = run.once(_steps)
    if steps is None:
        return None
    return float((steps[ties.beyond(steps, WATCHDOG)] - WATCHDOG).sum())


def _longest_at(run: MeasuredRun) -> float | None:
    steps = run.once(_steps)
    return None if steps is None else float(run.recording.t[int(np.argmax(steps))])


def _real_duration(run: MeasuredRun) -> float | None:
    clock = run.recording.real_time
    return None if clock is None else float(clock[-1] - clock[0])


def _drive(run: MeasuredRun) -> float | None:
    return None if run.recording.printed is None else run.recording.printed.drive


def _drive_in_log(run: MeasuredRun) -> float | None:
    seconds = run.start - float(run.recording.t[0])
    return seconds if seconds > 0 else None


register(
    Metric(
        "step_time",
        "time of a step",
        "s",
        "From each row to the next by a clock: the log's real time, or its own times where they "
        f"were not counted. Robots brake that hear nothing for {WATCHDOG:g} s.",
        _step_time,
        "largest",
        panel=STEPS,
        figure="steps",
        numbers=(
            Scalar(
                "real_duration",
                "duration in real time",
                "s",
                "From first to last row, by the real time beside the log's steps.",
                "Run",
                _real_duration,
            ),
            Scalar("step_mean", "mean step", "s", "Mean time of a step by a clock.", "Run", _mean),
            Scalar("step_median", "median step", "s", "Median of the same.", "Run", _median),
            Scalar("step_longest", "longest step", "s", "Whole run.", "Run", largest("step_time")),
            Scalar(
                "step_longest_at",
                "when the longest step began",
                "s",
                "By the log's own times.",
                "Run",
                _longest_at,
            ),
            Scalar(
                "steps_irregular",
                "irregular steps",
                "share",
                f"Steps that are more than {LATE:.0%} off the median one.",
                "Run",
                _irregular,
            ),
            Scalar(
                "steps_over_watchdog",
                "steps in which robots braked",
                "",
                f"Steps over the {WATCHDOG:g} s without a command after which robots brake.",
                "Run",
                _over,
            ),
            Scalar(
                "time_braked",
                "time in which robots braked",
                "s",
                f"What these steps took beyond {WATCHDOG:g} s.",
                "Run",
                _braked,
            ),
        ),
    ),
    Scalar(
        "drive_time",
        "drive to the start",
        "s",
        "From the beginning of the drive to the initial conditions to its end, as the testbed "
        "stamped it.",
        "Run",
        _drive,
    ),
    Scalar(
        "drive_in_log",
        "drive to the start, in the log",
        "s",
        "Seconds from the first pose that are no part of the experiment: settled numbers and times "
        "to alignment leave them out.",
        "Run",
        _drive_in_log,
    ),
)
