"""The noise of increments: unexplained motion, and the difference of two jitters.

Neighbouring increments of a robot share a jitter, so the covariance of all increments is
tridiagonal, with a break wherever one is left out or another robot begins.  Its Cholesky factor has
two diagonals: whitening a million increments is one pass.  Both variances are found by maximum
likelihood.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky_banded, solve_banded
from scipy.optimize import minimize_scalar

from posflock_robotarium.calibration.estimate import Estimate, Z

Floats = NDArray[np.float64]
Whitener = Callable[[Floats], Floats]
#: Logits of the jitter's share of the variance: at both ends the other part is as good as none.
_SHARES = np.linspace(-18.0, 18.0, 19)


@dataclass(frozen=True)
class Noise:
    """The noise of one kind of increment.

    Attributes
    ----------
    q : float
        Variance of unexplained motion in a step of median length, m² or rad².
    r : float
        Variance of the jitter of tracking, m² or rad².
    spread : (float, float)
        Standard deviations of the estimates q and r.
    """

    q: float
    r: float
    spread: tuple[float, float]

    @property
    def jitter(self) -> Estimate:
        """Standard deviation of the jitter."""
        return self._deviation(self.r, self.spread[1], 1.0)

    def disturbance(self, dt: float) -> Estimate:
        """Return the standard deviation of the velocity that the model does not explain.

        Parameters
        ----------
        dt : float
            Median time between rows, s.
        """
        return self._deviation(self.q, self.spread[0], dt)

    def is_close_to(self, other: Noise) -> bool:
        """Whether both noises make the same of increments, as far as anyone can tell.

        Parameters
        ----------
        other : Noise
            The other one.
        """
        pairs = zip((self.q, self.r), (other.q, other.r), self.spread, strict=True)
        return all(abs(mine - its) < 0.1 * spread for mine, its, spread in pairs)

    @staticmethod
    def _deviation(variance: float, spread: float, dt: float) -> Estimate:
        """Return the root of a variance; from 0 on where it cannot be told from none at all."""
        if variance > Z * spread:
            value, factor = math.sqrt(variance) / dt, math.exp(Z * spread / variance / 2)
            return Estimate(value, value / factor, value * factor)
        # Far below its own uncertainty it is where a flat likelihood left the search.
        value = 0.0 if variance < 0.01 * spread else math.sqrt(variance) / dt
        return Estimate(value, 0.0, math.sqrt(variance + Z * spread) / dt)


class Chain:
    """Increments of all robots one after another, and which of them share a jitter.

    Parameters
    ----------
    owner, row : (n,) int array
        Robot and row of each increment, robot by robot, rows rising.
    length : (n,) array
        How long each took, in median steps; unexplained motion grows with it.
    """

    def __init__(self, owner: NDArray[np.intp], row: NDArray[np.intp], length: Floats) -> None:
        self.linked = (np.diff(owner) == 0) & (np.diff(row) == 1)
        self.stretch = np.square(length)
        robots = max(len(np.unique(owner)), 1)
        self._rows = max(len(owner) // robots, 1)
        self._robots = len(owner) / self._rows

    def whitener(self, q: float, r: float) -> Whitener:
        """Return what makes increments with this noise white and of unit variance.

        Parameters
        ----------
        q, r : float
            Variances of unexplained motion and of the jitter, m² or rad².
        """
        factor = self._factor(q, r)
        return lambda increments: self._white(factor, increments)

    def noise_of(self, residual: Floats) -> Noise:
        """Find both variances of a noise by maximum likelihood.

        Parameters
        ----------
        residual : (n,) array
            Increments less what the model explains, m or rad.
        """

        def scale_and_cost(logit: float) -> tuple[float, float]:
            share = 1 / (1 + math.exp(-logit))
            factor = self._factor(1 / (1 + math.exp(logit)), share)
            scale = max(float(np.square(self._white(factor, residual)).mean()), 1e-30)
            return scale, math.log(scale) + 2 * float(np.log(factor[0]).mean())

        costs = [scale_and_cost(logit)[1] for logit in _SHARES]
        best, wide = _SHARES[int(np.argmin(costs))], _SHARES[1] - _SHARES[0]
        found = minimize_scalar(
            lambda logit: scale_and_cost(logit)[1],
            bounds=(best - wide, best + wide),
            method="bounded",
        )
        logit = float(found.x)
        scale = scale_and_cost(logit)[0]
        q, r = scale / (1 + math.exp(logit)), scale / (1 + math.exp(-logit))
        return Noise(q, r, self._spread(q, r))

    def _factor(self, q: float, r: float) -> Floats:
        """Return the diagonals (2, n) of the covariance's Cholesky factor."""
        bands = np.zeros((2, len(self.stretch)))
        bands[0] = q * self.stretch + 2 * r
        bands[1, :-1] = -r * self.linked
        factor: Floats = cholesky_banded(bands, lower=True, check_finite=False)
        return factor

    @staticmethod
    def _white(factor: Floats, increments: Floats) -> Floats:
        white: Floats = solve_banded((1, 0), factor, increments, check_finite=False)
        return white

    def _spread(self, q: float, r: float) -> tuple[float, float]:
        """Return standard deviations of both variances, as of even steps without breaks.

        The eigenvalues of the covariance are known then: q + 2 r (1 - cos(π j / (K + 1))).
        """
        rows = self._rows
        shape = 2 * (1 - np.cos(np.pi * np.arange(1, rows + 1) / (rows + 1)))
        parts = np.stack([np.ones(rows), shape]) * (q + r) / (q + r * shape)
        spread = (q + r) * np.sqrt(np.diag(np.linalg.pinv(self._robots / 2 * parts @ parts.T)))
        return float(spread[0]), float(spread[1])
