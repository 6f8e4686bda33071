"""Variable projection: a search over dead time and lag, all else solved for exactly.

What the log does not determine is fixed and named, and the rest is fitted again, until every
interval is worth having.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from posflock_robotarium.calibration.identifiability import (
    FittedParameter,
    Flags,
    LeftOut,
    ParameterLayout,
    covariance,
    undetermined,
)
from posflock_robotarium.calibration.increments import Increments
from posflock_robotarium.calibration.noise import Chain, Noise, Whitener
from posflock_robotarium.calibration.response import delayed
from rps_compat.motor_effects import OFF_SPEED, OFF_TURN

Floats = NDArray[np.float64]
LARGEST_DEAD_TIME, LARGEST_LAG = 1.0, 1.0
#: A lag of which nothing is left after a step, s; the search needs one above 0.
LEAST_LAG = 1e-4
#: Turn biases of GRITSBot X robots have this standard deviation, rad/s: what is assumed of one that
#: a log does not tell from the turn gain.
_USUAL_BIAS = 0.010
_DEAD_TIME, _LAG = 0, 1
#: The noise settles in two or three rounds, in some logs of uneven steps in five.
_ROUNDS = 12


@dataclass(frozen=True)
class Fitted:
    """What comes out of the fit.

    Attributes
    ----------
    values, spread : (p,) array
        Parameters and the standard deviations of their errors, as `layout` orders them.
    free : (p,) boolean array
        Which of them the log determines.
    left_out : tuple of LeftOut
        What it does not determine, and why.
    along, turn : Noise
        Of the increments along the heading, and of the heading.
    layout : ParameterLayout
        What the parameters are.
    """

    values: Floats
    spread: Floats
    free: Flags
    left_out: tuple[LeftOut, ...]
    along: Noise
    turn: Noise
    layout: ParameterLayout


class Fit:
    """Nonlinear least squares over dead time, lag, gains and bias, whitened.

    Parameters
    ----------
    data : Increments
        What robots did and were told.
    """

    def __init__(self, data: Increments) -> None:
        self.data = data
        self.robots = data.along.shape[1]
        self.layout = ParameterLayout(self.robots)
        self.free = np.ones(len(self.layout.names), dtype=bool)
        self.shape = (0.15, 0.15)
        self.owner, self.row = np.nonzero(data.known.T)
        steps = data.steps[self.row]
        self.chain = Chain(self.owner, self.row, steps / np.median(data.steps))
        self.along, self.turn, self.steps = self._flat(data.along), self._flat(data.turn), steps
        sizes = [float(self.along.std()) or 1.0, float(self.turn.std()) or 1.0]
        self._whiten_by([partial(np.multiply, 1 / size) for size in sizes])

    def solve(self) -> Fitted:
        """Fit all that the log determines.

        Returns
        -------
        Fitted
            Parameters, their errors, and what is left out.
        """
        left_out: list[LeftOut] = []
        while True:
            noise = self._fit()
            # A likely noise of none would make intervals too narrow: they allow for its own error.
            self._whiten_by([self.chain.whitener(n.q + n.spread[0], n.r) for n in noise])
            shape, information = self.shape, self._information(self.shape)
            lost = undetermined(information, self.free, self.layout)
            if not lost:
                break
            for entry, reason in lost:
                self.free[entry] = False
                left_out.append(LeftOut(*self.layout.names[entry], reason))
        values = np.concatenate([shape, *self._linear(shape)])
        spread = np.sqrt(np.diag(self._errors(information)))
        return Fitted(values, spread, self.free, tuple(left_out), *noise, self.layout)

    def _flat(self, values: Floats) -> Floats:
        flat: Floats = values[self.row, self.owner]
        return flat

    def _whiten_by(self, whiten: list[Whitener]) -> None:
        self.whiten = whiten
        self.white = whiten[0](self.along), whiten[1](self.turn)

    def predictions(self, bias: bool = True) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        """Return what was measured and what the fit says of it.

        Parameters
        ----------
        bias : bool
            Whether turn biases count; otherwise only what robots were told.

        Returns
        -------
        along, turn : pairs of (n,) arrays
            Measured and predicted increments, m and rad.
        """
        forward, turning, on = self._features(self.shape)
        speed, turn, drift = (part[self.owner] for part in self._linear(self.shape))
        turned = turn * turning + (drift * on if bias else 0.0)
        return (self.along, speed * forward), (self.turn, turned)

    def _fit(self) -> tuple[Noise, Noise]:
        """Alternate between parameters and noise until the noise does not change."""
        self.shape = self._search(self._best_of_grid())
        noise = self._noise()
        for _ in range(_ROUNDS):
            before = noise
            self._whiten_by([self.chain.whitener(part.q, part.r) for part in before])
            self.shape = self._search(self.shape)
            noise = self._noise()
            if all(old.is_close_to(new) for old, new in zip(before, noise, strict=True)):
                break
        return noise

    def _noise(self) -> tuple[Noise, Noise]:
        along, turn = (self.chain.noise_of(did - said) for did, said in self.predictions())
        return along, turn

    def _features(self, shape: tuple[float, float]) -> tuple[Floats, Floats, Floats]:
        """Return what each increment is made of, (n,) each.

        How far a robot of gain 1 drives and turns, m and rad, and how long its motors are on, s: a
        robot that stands has no turn bias.
        """
        data = self.data
        driven = delayed(data.commands, *shape, data.steps, data.before)
        time = data.steps[:, None]
        on = (np.abs(driven[:, 0]) >= OFF_SPEED) | (np.abs(driven[:, 1]) >= OFF_TURN)
        parts = driven[:, 0] * time, driven[:, 1] * time, np.where(on, time, 0.0)
        forward, turning, moving = (self._flat(part) for part in parts)
        return forward, turning, moving

    def _white_features(self, shape: tuple[float, float]) -> tuple[Floats, Floats, Floats]:
        forward, turning, on = self._features(shape)
        return self.whiten[0](forward), self.whiten[1](turning), self.whiten[1](on)

    def _sum(self, values: Floats) -> Floats:
        """Sum values (n,) robot by robot, (N,)."""
        return np.bincount(self.owner, values, self.robots).astype(float)

    def _linear(
        self, shape: tuple[float, float], white: tuple[Floats, Floats, Floats] | None = None
    ) -> tuple[Floats, Floats, Floats]:
        """Solve for gains and bias, robot by robot, at a given dead time and lag."""
        x, z, o = white or self._white_features(shape)
        y, w = self.white
        speed = self._sum(x * y) / np.maximum(self._sum(x * x), 1e-300)
        zz, zo, oo = self._sum(z * z), self._sum(z * o), np.maximum(self._sum(o * o), 1e-300)
        zw, ow = self._sum(z * w), self._sum(o * w)
        determinant = zz * oo - zo * zo
        both = self.free[self.layout.of(FittedParameter.TURN_BIAS)] & (
            determinant > 1e-12 * zz * oo
        )
        safe = np.where(both, determinant, 1.0)
        turn = np.where(both, (oo * zw - zo * ow) / safe, zw / np.maximum(zz, 1e-300))
        # A robot that never turned has a bias and no gain.
        only_bias = np.where(zz > 0, 0.0, ow / oo)
        bias = np.where(both, (zz * ow - zo * zw) / safe, only_bias)
        return speed, turn, bias

    def _residual(self, shape: tuple[float, float]) -> Floats:
        """Return the whitened residuals (2 n,) with the best gains and biases for this shape."""
        white = self._white_features(shape)
        return self._residual_of(white, self._linear(shape, white))

    def _residual_of(
        self, white: tuple[Floats, Floats, Floats], gains: tuple[Floats, Floats, Floats]
    ) -> Floats:
        speed, turn, bias = (part[self.owner] for part in gains)
        y, w = self.white
        # Whitening never mixes robots, so that gains may be applied after it.
        return np.concatenate([y - speed * white[0], w - turn * white[1] - bias * white[2]])

    def _admitted(self, shape: tuple[float, float]) -> tuple[float, float]:
        free = self.free
        return (shape[0] if free[_DEAD_TIME] else 0.0), (shape[1] if free[_LAG] else LEAST_LAG)

    def _best_of_grid(self) -> tuple[float, float]:
        grid = [(0.05 * k, lag) for k in range(10) for lag in (0.02, 0.1, 0.2, 0.35)]
        shapes = dict.fromkeys(self._admitted(shape) for shape in [self.shape, *grid])
        return min(shapes, key=lambda shape: float(np.square(self._residual(shape)).sum()))

    def _search(self, best: tuple[float, float]) -> tuple[float, float]:
        """Find dead time and lag by least squares."""
        free = self.free[[_DEAD_TIME, _LAG]]
        if not free.any():
            return best

        def whole(part: Floats) -> tuple[float, float]:
            full = np.array(best)
            full[free] = part
            return float(full[0]), float(full[1])

        lower, upper = np.array([[0.0, LEAST_LAG], [LARGEST_DEAD_TIME, LARGEST_LAG]])[:, free]
        found = least_squares(
            lambda part: self._residual(whole(part)),
            np.array(best)[free],
            bounds=(lower, upper),
            diff_step=1e-3,
            x_scale=np.full(int(free.sum()), 0.05),
        )
        return whole(found.x)

    def _information(self, shape: tuple[float, float]) -> Floats:
        """Return the information matrix of all parameters, fitted or fixed."""
        gains = self._linear(shape)
        white = self._white_features(shape)
        slopes = []
        for entry in (_DEAD_TIME, _LAG):
            # A tenth of a frame, and never below no dead time or no lag.
            step = np.zeros(2)
            step[entry] = 0.1 * float(np.median(self.data.steps))
            low = np.maximum(np.array(shape) - step, [0.0, LEAST_LAG])
            high = np.array(shape) + step
            ends = [self._white_features((float(d), float(t))) for d, t in (low, high)]
            change = self._residual_of(ends[1], gains) - self._residual_of(ends[0], gains)
            slopes.append(change / (high - low)[entry])
        return self._assembled(np.stack(slopes), white)

    def _assembled(self, slopes: Floats, white: tuple[Floats, Floats, Floats]) -> Floats:
        n, along = self.robots, len(self.owner)
        speed, turn, bias = (slice(2 + k * n, 2 + (k + 1) * n) for k in range(3))
        x, z, o = white
        out = np.zeros((2 + 3 * n, 2 + 3 * n))
        out[:2, :2] = slopes @ slopes.T
        for entry in (_DEAD_TIME, _LAG):
            ahead, round_ = slopes[entry, :along], slopes[entry, along:]
            for part, product in ((speed, ahead * x), (turn, round_ * z), (bias, round_ * o)):
                out[entry, part] = out[part, entry] = -self._sum(product)
        for part, other, product in (
            (speed, speed, x * x),
            (turn, turn, z * z),
            (bias, bias, o * o),
            (turn, bias, z * o),
        ):
            out[part, other] = out[other, part] = np.diag(self._sum(product))
        return out

    def _errors(self, information: Floats) -> Floats:
        """Return the covariance of all errors, with what fixed biases may add to it."""
        known = covariance(information, self.free)
        fixed = self.layout.of(FittedParameter.TURN_BIAS) & ~self.free
        shift = known @ information[:, fixed] * _USUAL_BIAS
        out: Floats = known + shift @ shift.T
        return out
