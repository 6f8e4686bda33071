"""Variable projection: a search over dead time and lag, all else solved for exactly."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from posflock_robotarium.calibration.increments import Increments, delayed
from posflock_robotarium.calibration.noise import Noise, noise_of, whitener
from posflock_robotarium.flocking.errors import LogError

Floats = NDArray[np.float64]
_LARGEST_DEAD_TIME, _LARGEST_LAG = 1.0, 1.0
#: A lag of which nothing is left after a step, s; the search needs one above 0.
LEAST_LAG = 1e-4


class Fit:
    """Nonlinear least squares over dead time, lag, gains and bias, whitened.

    Parameters
    ----------
    data : Increments
        What robots did and were told.
    dt : float
        Time between rows, s.
    """

    def __init__(self, data: Increments, dt: float) -> None:
        self.data, self.dt = data, dt
        self.rows, self.robots = data.along.shape
        self.whiten: list[Callable[[Floats], Floats]] = [lambda e: e, lambda e: e]
        self.scale = [float(data.along.std()) or 1.0, float(data.turn.std()) or 1.0]

    def solve(self) -> tuple[Floats, Floats, tuple[Noise, Noise]]:
        """Return parameters, covariance and the noise of both kinds of increment.

        Returns
        -------
        parameters : (p,) array
            Dead time, lag, then gains and biases of the robots.
        covariance : (p, p) array
            Of their errors.
        noise : tuple of Noise
            Of the increments along the heading, and of the heading.
        """
        shape = self._search((0.15, 0.15))
        for _ in range(2):
            channels = self._noise(self._residuals(*self._linear(*shape), *shape))
            self.whiten = [whitener(c, self.rows) for c in channels]
            self.scale = [1.0, 1.0]
            shape = self._search(shape)
        speed, turn, bias = self._linear(*shape)
        channels = self._noise(self._residuals(speed, turn, bias, *shape))
        parameters = np.concatenate([shape, speed, turn, bias])
        jacobian = self._jacobian(parameters)
        return parameters, self._covariance(jacobian), channels

    def _covariance(self, jacobian: Floats) -> Floats:
        """Return the parameters' covariance, or refuse a log that leaves one undetermined."""
        size = np.linalg.norm(jacobian, axis=0)
        names = ["the dead time", "the lag"]
        for what in ("speed gain", "turn gain", "turn bias"):
            names += [f"the {what} of robot {robot}" for robot in range(self.robots)]
        lost = [name for name, s in zip(names, size, strict=True) if not (0 < s < math.inf)]
        if not lost:
            scaled = jacobian / size
            try:
                return np.linalg.inv(scaled.T @ scaled) / np.outer(size, size)
            except np.linalg.LinAlgError:
                lost = names[:2]
        raise LogError(
            f"the log does not determine {', '.join(lost[:3])}: drive the robots so that they"
            " follow commands that change"
        )

    def _features(self, dead_time: float, lag: float) -> tuple[Floats, Floats]:
        driven = delayed(self.data.commands, dead_time, lag, self.dt) * self.dt
        return driven[:, 0], driven[:, 1]

    def _linear(self, dead_time: float, lag: float) -> tuple[Floats, Floats, Floats]:
        """Solve for gains and bias, robot by robot, at a given dead time and lag."""
        forward, turning = self._features(dead_time, lag)
        white_v, white_w = self.whiten
        x, y = white_v(forward), white_v(self.data.along)
        speed = (x * y).sum(axis=0) / np.maximum((x * x).sum(axis=0), 1e-300)
        x, y = white_w(turning), white_w(self.data.turn)
        ones = white_w(np.full((self.rows, 1), self.dt))
        xx, xo, oo = (x * x).sum(0), (x * ones).sum(0), (ones * ones).sum(0)
        xy, oy = (x * y).sum(0), (ones * y).sum(0)
        determinant = xx * oo - xo * xo
        return speed, (oo * xy - xo * oy) / determinant, (xx * oy - xo * xy) / determinant

    def _residuals(
        self, speed: Floats, turn: Floats, bias: Floats, dead_time: float, lag: float
    ) -> tuple[Floats, Floats]:
        forward, turning = self._features(dead_time, lag)
        return (
            self.data.along - speed * forward,
            self.data.turn - turn * turning - bias * self.dt,
        )

    def _white(self, residuals: tuple[Floats, Floats]) -> Floats:
        parts = [
            white(residual).ravel(order="F") / scale
            for white, residual, scale in zip(self.whiten, residuals, self.scale, strict=True)
        ]
        return np.concatenate(parts)

    def _search(self, start: tuple[float, float]) -> tuple[float, float]:
        """Find dead time and lag: a coarse grid, then least squares from its best point."""

        def cost(shape: tuple[float, float]) -> Floats:
            return self._white(self._residuals(*self._linear(*shape), *shape))

        grid = [(d, t) for d in np.arange(0.0, 0.5, 0.05) for t in (0.02, 0.1, 0.2, 0.35)]
        best = min([start, *grid], key=lambda shape: float(np.square(cost(shape)).sum()))
        found = least_squares(
            lambda shape: cost((float(shape[0]), float(shape[1]))),
            best,
            bounds=([0.0, LEAST_LAG], [_LARGEST_DEAD_TIME, _LARGEST_LAG]),
            diff_step=1e-3,
            x_scale=[0.05, 0.05],
        )
        return float(found.x[0]), float(found.x[1])

    def _jacobian(self, parameters: Floats) -> Floats:
        """Differentiate the whitened residuals with respect to all parameters."""
        n = self.robots

        def white(p: Floats) -> Floats:
            gains = (p[2 : 2 + n], p[2 + n : 2 + 2 * n], p[2 + 2 * n :])
            return self._white(self._residuals(*gains, p[0], max(p[1], 1e-6)))

        columns = []
        for k in range(len(parameters)):
            step = np.zeros_like(parameters)
            # The dead time enters piecewise: a step of a tenth of a frame averages over a kink.
            step[k] = 0.1 * self.dt if k < 2 else 1e-3
            columns.append((white(parameters + step) - white(parameters - step)) / (2 * step[k]))
        return np.stack(columns, axis=1)

    def _noise(self, residuals: tuple[Floats, Floats]) -> tuple[Noise, Noise]:
        along, turn = (noise_of(residual) for residual in residuals)
        return along, turn
