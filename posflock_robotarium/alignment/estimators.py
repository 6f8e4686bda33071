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

from collections.abc import Callable, Iterator
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
from posflock_robotarium.logs.run import GAP_FACTOR, Run

Floats = NDArray[np.float64]
_SegmentEstimator = Callable[[Floats, Floats, int], Floats]

WINDOW = 0.36
"""Seconds of the Savitzky-Golay window: eleven samples at the testbed's 0.033 s."""

EVEN = 1e-6
"""Steps that differ by less than this share of their mean count as evenly spaced."""

PERSISTENT = 1.25
"""Growth of the noise from neighbouring frames to every third from which it is not their own."""

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
        whole = np.isfinite(p).all(axis=(0, 1))
        if len(t) >= 2 and whole.any():
            chosen = slice(None) if whole.all() else whole
            velocities[segment][:, :, chosen] = estimator(t, p[:, :, chosen], points)
        for n in np.flatnonzero(~whole):
            for rows in own_stretches(recording.t, positions[:, 0, n], segment):
                _estimate_one(recording, velocities, rows, int(n), points, estimator)
    return velocities


def _estimate_one(
    recording: Run,
    velocities: Floats,
    rows: NDArray[np.intp],
    n: int,
    points: int,
    estimator: _SegmentEstimator,
) -> None:
    """Estimate one robot's velocities in a stretch between its own gaps, if it is long enough."""
    # Fewer samples than half a window would have more noise than motion.
    if len(rows) >= max(2, (points + 1) // 2):
        positions = recording.poses[rows, :2, n : n + 1]
        velocities[rows, :, n : n + 1] = estimator(recording.t[rows], positions, points)


def own_stretches(t: Floats, x: Floats, segment: slice) -> list[NDArray[np.intp]]:
    """Return the stretches of one robot between its own gaps.

    Parameters
    ----------
    t : (T,) array
        Seconds of all rows.
    x : (T,) array
        One of its coordinates, NaN where it is not seen.
    segment : slice
        The rows to look at, without gaps of the whole team.

    Returns
    -------
    list of (k,) integer array
        Rows in which it is seen; a single one that is missing is no gap.
    """
    rows = segment.start + np.flatnonzero(np.isfinite(x[segment]))
    if len(rows) < 2:
        return [rows] if len(rows) else []
    steps = np.diff(t[rows])
    # As often as it is seen: a camera that sees it now and then has no gap each time.
    usual = max(float(np.median(np.diff(t[segment]))), float(np.median(steps)))
    gaps = np.flatnonzero(ties.beyond(steps, GAP_FACTOR * usual)) + 1
    return list(np.split(rows, gaps))


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
    return _weighted(positions, fit_weights(t, points)[1])


def fit_weights(t: Floats, points: int) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Return what a quadratic fitted around each sample makes of the samples in its window.

    Savitzky and Golay's filter for times that are not evenly spaced: loops that now and then miss
    their slot are common on the testbed.

    Parameters
    ----------
    t : (T,) array
        Times, s.
    points : int
        Samples in each window, odd.

    Returns
    -------
    value, slope : (T, points) array
        Weights whose sum with the window's samples is the fit's value, or its derivative.
    start : (T,) array of int
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


def _weighted(samples: Floats, weights: Floats) -> Floats:
    """Return the weighted sum of the samples in each window, laid as `fit_weights` does."""
    samples_each, points = weights.shape
    total = np.zeros_like(samples)
    # Windows move on by one sample each, but for those that are shifted inwards at both ends.
    first, last = points // 2, samples_each - points + points // 2 + 1
    for k in range(points):
        weight = weights[:, k].reshape(-1, *[1] * (samples.ndim - 1))
        total[:first] += weight[:first] * samples[k]
        total[first:last] += weight[first:last] * samples[k : k + last - first]
        total[last:] += weight[last:] * samples[samples_each - points + k]
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
    own_points = window_points(recording.step, window)
    points = max(5, own_points)
    samples = recording.poses.copy()
    samples[:, 2] = _unwrapped(samples[:, 2])
    variances, slopes, weight, robots = [], [], [], []
    for rows, columns in _stretches_of_all(recording):
        t = recording.t[rows]
        if len(t) < points:
            continue
        own = samples[rows][:, :, columns]
        value = fit_weights(t, points)[0]
        residual = own - _weighted(own, value)
        inner = slice(points // 2, len(t) - points // 2)
        centre = value[inner, points // 2]
        scaled = residual[inner] ** 2 / (1 - centre)[:, np.newaxis, np.newaxis]
        # The median forgives the few samples where a robot really jerks.
        variances.append((np.median(scaled, axis=0) / _MEDIAN_OF_CHI2).mean(axis=1))
        # As wide as the estimator's own window; at the ends of a stretch slopes are less sure.
        slopes.append(float((fit_weights(t, own_points)[1] ** 2).sum(axis=1).mean()))
        weight.append(len(t))
        robots.append(len(columns))
    if not variances:
        return TrackingNoise(float("nan"), float("nan"), float("nan"))
    by_samples = np.multiply(weight, robots)
    variance = np.average(np.array(variances), axis=0, weights=by_samples)
    position = float(np.sqrt(variance[:2].mean()))
    slope_gain = float(np.sqrt(np.average(slopes, weights=by_samples)))
    course = position * slope_gain / speed if speed > 0 else float("nan")
    return TrackingNoise(position, float(np.sqrt(variance[2])), course)


def _stretches_of_all(recording: Run) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Yield stretches without gaps: their rows, and the robots that they are of."""
    x = recording.poses[:, 0]
    for segment in recording.segments:
        whole = np.isfinite(x[segment]).all(axis=0)
        if whole.any():
            yield np.arange(segment.start, segment.stop), np.flatnonzero(whole)
        for n in np.flatnonzero(~whole):
            for rows in own_stretches(recording.t, x[:, n], segment):
                yield rows, np.array([n])


def _unwrapped(headings: Floats) -> Floats:
    """Return headings (T, N) without turns of 2π, whatever is missing in between."""
    if not np.isnan(headings).any() or np.isnan(headings).all():
        return np.asarray(np.unwrap(headings, axis=0), dtype=float)
    unwrapped = headings.copy()
    for n in range(headings.shape[1]):
        known = np.isfinite(headings[:, n])
        unwrapped[known, n] = np.unwrap(headings[known, n])
    return unwrapped


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
