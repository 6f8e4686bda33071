r"""How motion is estimated from noisy poses, and how far each estimate can be trusted.

A tracking system reports where robots are, not where they go. Three estimators answer that:

``headings``
    the tracked heading. Little noise, but blind to standing still: parked robots have headings.
``savitzky_golay``
    the slope of a quadratic fitted to a short window of positions. The report's own answer.
``differences``
    one-frame differences. Shown because people use them: at 0.05 m/s and 0.5 mm of tracking
    noise they make perfectly parallel robots look misaligned.

For a course error of standard deviation σ per robot, the cosine between two parallel robots reads
:math:`e^{-\sigma^2}`, so noise always biases γ downwards. `tracking_noise` measures the noise
from the log itself, and `expected_bias` turns it into how much γ is under-read.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.metrics import (
    heading_vectors,
    smoothed_velocities,
    velocities_by_differences,
)
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.readers import Run

Floats = NDArray[np.float64]
_SegmentEstimator = Callable[[Floats, Floats, int], Floats]

WINDOW = 0.36
"""Seconds of the Savitzky-Golay window: eleven samples at the testbed's 0.033 s."""

EVEN = 1e-6
"""Steps that differ by less than this share of their mean count as evenly spaced."""

ESTIMATORS = {
    "headings": "tracked headings",
    "savitzky_golay": "Savitzky-Golay motion",
    "differences": "one-frame differences",
}


@dataclass(frozen=True, eq=False)
class Motion:
    """Velocities estimated from a recording.

    Attributes
    ----------
    estimator : str
        A key of `ESTIMATORS`.
    velocities : (T, 2, N) array
        m/s (unit vectors for ``headings``); NaN where a stretch is too short to tell.
    points : int
        Samples that each estimate uses.
    description : str
        The sentence for the report.
    """

    estimator: str
    velocities: Floats
    points: int
    description: str


def estimate(recording: Run, estimator: str, window: float = WINDOW) -> Motion:
    """Estimate motion by one of the three estimators; none looks across a gap.

    Parameters
    ----------
    recording : Run
        Poses over time.
    estimator : {'headings', 'savitzky_golay', 'differences'}
        Which one.
    window : float
        Seconds of the Savitzky-Golay window, rounded to an odd number of samples, at least 3.

    Returns
    -------
    Motion
        One velocity a sample and robot.

    Raises
    ------
    ParameterError
        For an unknown estimator or a window that is not positive.
    """
    if estimator == "headings":
        return Motion(
            estimator, heading_vectors(recording.poses), 1, "unit vectors along tracked headings"
        )
    if estimator == "differences":
        velocities = _by_segment(recording, 2, _differences)
        return Motion(estimator, velocities, 2, "differences of successive positions over time")
    if estimator != "savitzky_golay":
        raise ParameterError(f"estimator {estimator!r} is none of {', '.join(ESTIMATORS)}")
    points = window_points(recording.step, window)
    velocities = _by_segment(recording, points, _savitzky_golay)
    return Motion(
        estimator,
        velocities,
        points,
        f"slope of a quadratic fitted to {points} samples ({points * recording.step:.2f} s)",
    )


def window_points(step: float, window: float) -> int:
    """Return the odd number of samples (at least 3) nearest to a window.

    Of two as near, as for a window of an even number of steps, it is the smaller one.

    Parameters
    ----------
    step : float
        Time between samples, s.
    window : float
        Length of the window, s.

    Raises
    ------
    ParameterError
        Where the window is no positive number.
    """
    if not (np.isfinite(window) and window > 0):
        raise ParameterError(f"window is {window} s; expected a positive number of seconds")
    return max(3, 1 - 2 * ties.nearest_whole((1 - window / step) / 2))


def _by_segment(recording: Run, points: int, estimator: _SegmentEstimator) -> Floats:
    positions = recording.poses[:, :2]
    velocities = np.full(positions.shape, np.nan)
    for segment in recording.segments:
        t, p = recording.t[segment], positions[segment]
        if len(t) >= 2:
            velocities[segment] = estimator(t, p, points)
    return velocities


def _even_step(t: Floats) -> float | None:
    """Return the time step if samples are evenly spaced, None otherwise."""
    step = (t[-1] - t[0]) / (len(t) - 1)
    return float(step) if np.abs(np.diff(t) - step).max() <= EVEN * step else None


def _differences(t: Floats, positions: Floats, _: int) -> Floats:
    step = _even_step(t)
    if step is not None:
        return velocities_by_differences(positions, step)
    slopes = np.diff(positions, axis=0) / np.diff(t)[:, np.newaxis, np.newaxis]
    return np.concatenate([slopes[:1], slopes])


def _savitzky_golay(t: Floats, positions: Floats, points: int) -> Floats:
    if len(t) < points:  # a short stretch between gaps: the longest odd window that fits
        points = len(t) - 1 + len(t) % 2
    if points < 3:
        return _differences(t, positions, points)
    step = _even_step(t)
    if step is not None:
        return smoothed_velocities(positions, step, points)
    return _weighted(positions, *_fit_weights(t, points)[1:])


def _fit_weights(t: Floats, points: int) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Return what a quadratic fitted around each sample makes of the samples in its window.

    Savitzky and Golay's filter for times that are not evenly spaced: loops that now and then miss
    their slot are common on the testbed.

    Returns
    -------
    value, slope : ndarray, shape (T, points)
        Weights whose sum with the window's samples is the fit's value, or its derivative.
    start : ndarray of int, shape (T,)
        Where each window begins (windows are shifted inwards at both ends).
    """
    half = points // 2
    start = np.clip(np.arange(len(t)) - half, 0, len(t) - points)
    offset = t[start[:, np.newaxis] + np.arange(points)] - t[:, np.newaxis]
    scale = np.abs(offset).max(axis=1, keepdims=True)
    offset = offset / scale
    design = np.stack([np.ones_like(offset), offset, offset**2], axis=-1)
    normal = np.swapaxes(design, 1, 2) @ design
    weights = np.linalg.solve(normal, np.swapaxes(design, 1, 2))
    return weights[:, 0], weights[:, 1] / scale, start


def _weighted(samples: Floats, weights: Floats, start: NDArray[np.intp]) -> Floats:
    total = np.zeros_like(samples)
    for k in range(weights.shape[1]):
        total += weights[:, k].reshape(-1, *[1] * (samples.ndim - 1)) * samples[start + k]
    return total


@dataclass(frozen=True)
class TrackingNoise:
    """Tracking noise seen in a log, as standard deviations.

    Attributes
    ----------
    position : float
        Metres, each coordinate.
    heading : float
        Radians.
    course : float
        Radians: error of the Savitzky-Golay direction of motion at the flock's median speed; NaN
        when the flock stands.
    """

    position: float
    heading: float
    course: float


def tracking_noise(recording: Run, speed: float, window: float = WINDOW) -> TrackingNoise:
    r"""Measure tracking noise by what a local quadratic cannot explain.

    The residual of a least-squares fit at its own sample has variance :math:`\sigma^2 (1 - w)`,
    where :math:`w` is the weight the fit gives to that sample.

    Parameters
    ----------
    recording : Run
        Poses over time.
    speed : float
        Median speed of the robots, m/s.
    window : float
        Seconds of the window.

    Returns
    -------
    TrackingNoise
        NaN where no stretch between gaps holds a whole window.
    """
    points = max(5, window_points(recording.step, window))
    samples = recording.poses.copy()
    samples[:, 2] = np.unwrap(samples[:, 2], axis=0)
    variances, slopes, weight = [], [], []
    for segment in recording.segments:
        t = recording.t[segment]
        if len(t) < points:
            continue
        value, slope, start = _fit_weights(t, points)
        residual = samples[segment] - _weighted(samples[segment], value, start)
        inner = slice(points // 2, len(t) - points // 2)
        own = value[inner, points // 2]
        scaled = residual[inner] ** 2 / (1 - own)[:, np.newaxis, np.newaxis]
        variances.append(np.median(scaled, axis=0) / _MEDIAN_OF_CHI2)
        slopes.append(float(np.sqrt((slope[inner] ** 2).sum(axis=1)).mean()))
        weight.append(len(t))
    if not variances:
        return TrackingNoise(float("nan"), float("nan"), float("nan"))
    # The median forgives the few samples where a robot really jerks.
    variance = np.average(np.array(variances), axis=0, weights=weight)
    position = float(np.sqrt(variance[:2].mean()))
    slope_gain = float(np.average(slopes, weights=weight))
    course = position * slope_gain / speed if speed > 0 else float("nan")
    return TrackingNoise(position, float(np.sqrt(variance[2].mean())), course)


_MEDIAN_OF_CHI2 = 0.454936423119572
"""Median of a squared standard normal variable."""


def expected_bias(course: float) -> float:
    r"""Return how much γ of parallel robots is under-read: 1 − exp(−σ²).

    Parameters
    ----------
    course : float
        Error of the course, σ, rad.
    """
    return float(-np.expm1(-(course**2)))
