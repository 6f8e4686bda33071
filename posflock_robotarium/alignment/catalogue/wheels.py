"""What the logged commands ask of the wheels, against what they can do."""

from __future__ import annotations

import numpy as np

from barrier_certificates import ties
from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import WHEELS
from posflock_robotarium.alignment.reductions import largest


def _fastest(run: MeasuredRun) -> Floats | None:
    commands, robot = run.recording.commands, run.robot
    if commands is None:
        return None
    return metrics.fastest_wheel(commands, robot.wheel_radius, robot.base_length)


def _excess(run: MeasuredRun) -> Floats | None:
    """Return how far the fastest wheel is asked to go beyond its limit, rad/s; 0 within it."""
    fastest = run.once(_fastest)
    if fastest is None:
        return None
    excess = fastest - run.robot.max_wheel_velocity
    return np.where(ties.beyond(excess, 0.0) | np.isnan(excess), excess, 0.0)


def _largest_excess(run: MeasuredRun) -> float | None:
    excess = run.once(_excess)
    return None if excess is None else float(np.nanmax(excess))


def _steps_in_excess(run: MeasuredRun) -> int | None:
    excess = run.once(_excess)
    return None if excess is None else int((excess > 0).sum())


register(
    Metric(
        "fastest_wheel",
        "fastest wheel asked for",
        "rad/s",
        "Largest wheel speed that the logged commands ask for.",
        _fastest,
        "largest",
        panel=WHEELS,
        numbers=(
            Scalar(
                "fastest_wheel",
                "fastest wheel asked for",
                "rad/s",
                "Whole run; axle {run.robot.base_length:g} m.",
                "Motion",
                largest("fastest_wheel"),
            ),
            Scalar(
                "wheel_excess",
                "largest excess over the wheel limit",
                "rad/s",
                "How far a command asks for more than {run.robot.max_wheel_velocity:g} rad/s; "
                "axle {run.robot.base_length:g} m.",
                "Motion",
                _largest_excess,
            ),
            Scalar(
                "wheel_excess_steps",
                "steps over the wheel limit",
                "",
                "Samples with at least one wheel asked for too much.",
                "Motion",
                _steps_in_excess,
            ),
        ),
    ),
)
