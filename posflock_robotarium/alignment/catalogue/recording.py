"""What was recorded: robots, duration, samples, gaps."""

from __future__ import annotations

from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.metric_registry import Scalar, register


def _duration(run: MeasuredRun) -> float:
    return float(run.recording.t[-1] - run.recording.t[0])


def _gap_time(run: MeasuredRun) -> float:
    t, gaps = run.recording.t, run.recording.gaps
    return float((t[gaps] - t[gaps - 1]).sum()) if gaps.size else 0.0


register(
    Scalar("robots", "robots", "", "Robots in the log.", "Run", lambda run: run.recording.robots),
    Scalar("duration", "duration", "s", "From first to last pose.", "Run", _duration),
    Scalar(
        "samples",
        "samples",
        "",
        "Poses over time of each robot.",
        "Run",
        lambda run: len(run.recording.t),
    ),
    Scalar(
        "step",
        "time step",
        "s",
        "Median time between samples.",
        "Run",
        lambda run: run.recording.step,
    ),
    Scalar(
        "gaps",
        "gaps",
        "",
        "Places where more than three steps are missing; no estimate looks across one.",
        "Run",
        lambda run: len(run.recording.gaps),
    ),
    Scalar("gap_time", "time in gaps", "s", "Seconds inside gaps.", "Run", _gap_time),
)
