"""What noise of positions does to estimated velocities, and whether that can be known at all."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment.estimators import WINDOW, Floats, fit_weights, window_points
from posflock_robotarium.logs.readers import Run


def velocity_gain(recording: Run, estimator: str, window: float = WINDOW) -> Floats:
    """Return what an estimator makes of noise: deviation of a velocity per deviation of a position.

    Parameters
    ----------
    recording : Run
        Poses over time.
    estimator : {'savitzky_golay', 'differences'}
        Which one.
    window : float
        Seconds of the Savitzky-Golay window.

    Returns
    -------
    (T,) array
        1/s; larger at both ends of a stretch, where the window lies to one side.
    """
    gain = np.full(len(recording.t), np.nan)
    points = 2 if estimator == "differences" else window_points(recording.step, window)
    for segment in recording.segments:
        t = recording.t[segment]
        width = min(points, len(t) - 1 + len(t) % 2)
        if width >= 3:
            gain[segment] = np.sqrt(np.square(fit_weights(t, width)[1]).sum(axis=1))
        elif len(t) >= 2:
            steps = np.diff(t)
            gain[segment] = np.sqrt(2.0) / np.concatenate([steps[:1], steps])
    return gain


def noise_persistence(recording: Run) -> float:
    r"""Return how much noise seems to grow from neighbouring frames to every third one.

    It is 1 where each frame has a noise of its own. Poses that were filtered or interpolated, or
    whose noise drifts, carry it over from frame to frame: then what it does to a velocity cannot
    be known. Noise is told by third differences, which motion hardly has; those of independent
    noise have variance :math:`20 \sigma^2` whichever frames they are of.

    Parameters
    ----------
    recording : Run
        Poses over time.

    Returns
    -------
    float
        NaN where no stretch is long enough.
    """
    near, far, weight = [], [], []
    for segment in recording.segments:
        p = recording.poses[segment, :2]
        if len(p) >= 20:
            widely = np.square(p[9:] - 3 * p[6:-3] + 3 * p[3:-6] - p[:-9])
            closely = np.square(np.diff(p, 3, axis=0))
            # Of robots that are not seen throughout, what is seen.
            if (known := np.isfinite(widely)).any():
                far.append(float(np.median(widely[known])))
                near.append(float(np.median(closely[np.isfinite(closely)])))
                weight.append(int(known.sum()))
    if not near:
        return float("nan")
    closest, widest = (float(np.average(found, weights=weight)) for found in (near, far))
    if closest <= 0:
        return 1.0 if widest <= 0 else float("inf")
    return float(np.sqrt(widest / closest))
