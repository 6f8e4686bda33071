"""The noise of increments: unexplained motion, and the difference of two jitters.

Neighbouring increments share a jitter, so their covariance is tridiagonal and the discrete sine
transform diagonalises it. There both variances are found by maximum likelihood, and there
increments are made white.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dst
from scipy.optimize import minimize

from posflock_robotarium.calibration.estimate import Estimate, Z

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Noise:
    """The noise of one kind of increment.

    Attributes
    ----------
    q : float
        Variance of unexplained motion, m² or rad².
    r : float
        Variance of the jitter of tracking, m² or rad².
    spread : (float, float)
        Standard deviations of the estimates q and r.
    """

    q: float
    r: float
    spread: tuple[float, float]  # standard deviations of the estimates q and r

    @property
    def jitter(self) -> Estimate:
        """Standard deviation of the jitter."""
        return self._deviation(self.r, self.spread[1], 1.0)

    def disturbance(self, dt: float) -> Estimate:
        """Return the standard deviation of the velocity that the model does not explain.

        Parameters
        ----------
        dt : float
            Time between rows, s.
        """
        return self._deviation(self.q, self.spread[0], dt)

    @staticmethod
    def _deviation(variance: float, spread: float, dt: float) -> Estimate:
        """Return the root of a variance; from 0 on where it cannot be told from none at all."""
        if variance > Z * spread:
            value, factor = math.sqrt(variance) / dt, math.exp(Z * spread / variance / 2)
            return Estimate(value, value / factor, value * factor)
        # Far below its own uncertainty it is where a flat likelihood left the search.
        value = 0.0 if variance < 0.01 * spread else math.sqrt(variance) / dt
        return Estimate(value, 0.0, math.sqrt(variance + Z * spread) / dt)


def noise_of(residual: Floats) -> Noise:
    """Find both variances of a noise by maximum likelihood, in the sine transform.

    Parameters
    ----------
    residual : (K, N) array
        Increments less what the model explains, m or rad.
    """
    rows = len(residual)
    power = np.square(_sine_transform(residual)).mean(axis=1)
    shape = _jitter_shape(rows)

    def spectrum(logs: Floats) -> Floats:
        out: Floats = math.exp(logs[0]) + math.exp(logs[1]) * shape
        return out

    def cost(logs: Floats) -> tuple[float, Floats]:
        lines = spectrum(logs)
        slope = (1 - power / lines) / lines
        gradient = [math.exp(logs[0]) * slope.sum(), math.exp(logs[1]) * (slope * shape).sum()]
        return float((np.log(lines) + power / lines).sum()) / rows, np.array(gradient) / rows

    mean = max(float(power.mean()), 1e-30)
    bounds = [(math.log(mean) - 25, math.log(mean) + 2)] * 2
    starts = ([0.9, 0.05], [0.01, 0.5])
    found = min(
        (
            minimize(cost, np.log(np.array(share) * mean), jac=True, bounds=bounds)
            for share in starts
        ),
        key=lambda result: float(result.fun),
    )
    q, r = np.exp(found.x)
    parts = np.stack([np.full(rows, mean), mean * shape]) / spectrum(found.x)
    information = residual.shape[1] / 2 * parts @ parts.T
    spread = mean * np.sqrt(np.diag(np.linalg.pinv(information)))
    return Noise(float(q), float(r), (float(spread[0]), float(spread[1])))


def _jitter_shape(rows: int) -> Floats:
    """Eigenvalues of the covariance of differences of white noise of unit variance."""
    return 2 * (1 - np.cos(np.pi * np.arange(1, rows + 1) / (rows + 1)))


def _sine_transform(increments: Floats) -> Floats:
    out: Floats = dst(increments, type=1, axis=0, norm="ortho")
    return out


def whitener(channel: Noise, rows: int) -> Callable[[Floats], Floats]:
    """Return what makes increments with this noise white and of unit variance.

    Parameters
    ----------
    channel : Noise
        Variances of the increments' noise.
    rows : int
        Number of increments, K.
    """
    scale = 1 / np.sqrt(channel.q + channel.r * _jitter_shape(rows))[:, None]

    def whiten(increments: Floats) -> Floats:
        return scale * _sine_transform(increments)

    return whiten
