"""How far the numbers can be trusted: tracking noise of this log, and what it takes from γ."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment.estimators import TrackingNoise, expected_bias, tracking_noise
from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.metric_registry import Scalar, register


def noise_of(run: MeasuredRun) -> TrackingNoise:
    """Return the noise, and its effect at the median speed of the robots that move.

    Parameters
    ----------
    run : MeasuredRun
        The run; ask by ``run.once(noise_of)``.
    """
    moving = run.speeds[run.settled]
    moving = moving[np.isfinite(moving) & (moving > run.options.slowest)]
    speed = float(np.median(moving)) if moving.size else 0.0
    return tracking_noise(run.recording, speed, run.options.window)


def _heading_offset(run: MeasuredRun) -> float:
    """Return the median angle between the heading and the line along which a robot moves."""
    r = run.recording
    stride = max(1, len(r.t) // 5000)
    ahead = min(10, len(r.t) - 1)
    start = np.arange(0, len(r.t) - ahead, stride)
    step = r.poses[start + ahead, :2] - r.poses[start, :2]
    within = (r.t[start + ahead] - r.t[start]) < 3 * ahead * r.step
    length = np.hypot(step[:, 0], step[:, 1])
    least = max(run.options.slowest * ahead * r.step, 0.005)
    moving = (length > least) & within[:, np.newaxis]
    if not moving.any():
        return float("nan")
    middle = r.poses[start + ahead // 2, 2]
    moving &= np.isfinite(middle)
    if not moving.any():
        return float("nan")
    across = -np.sin(middle) * step[:, 0] + np.cos(middle) * step[:, 1]
    along = np.cos(middle) * step[:, 0] + np.sin(middle) * step[:, 1]
    return float(np.median(np.arctan2(np.abs(across), np.abs(along))[moving]))


register(
    Scalar(
        "noise_position",
        "tracking noise, position",
        "m",
        "Standard deviation of each coordinate around local quadratics, measured in this log.",
        "Confidence",
        lambda run: run.once(noise_of).position,
    ),
    Scalar(
        "noise_heading",
        "tracking noise, heading",
        "rad",
        "The same for headings.",
        "Confidence",
        lambda run: run.once(noise_of).heading,
    ),
    Scalar(
        "noise_course",
        "error of the direction of motion",
        "rad",
        "Standard deviation that this noise gives the Savitzky-Golay direction of a robot at "
        "the median speed of those that move.",
        "Confidence",
        lambda run: run.once(noise_of).course,
    ),
    Scalar(
        "gamma_bias",
        "γ from motion is under-read by about",
        "",
        "1 - exp(-σ²) with that error σ: what perfectly parallel robots would lose.",
        "Confidence",
        lambda run: expected_bias(run.once(noise_of).course),
    ),
    Scalar(
        "heading_offset",
        "heading against direction of motion",
        "rad",
        "Median over robots and time of the angle between heading and line of motion; "
        "large when the headings are not in radians or belong to other robots.",
        "Confidence",
        _heading_offset,
    ),
)
