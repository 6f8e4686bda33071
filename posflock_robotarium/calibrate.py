r"""What a returned log says about the testbed: dead time, lag, gains, bias and noise, fitted.

A log that holds commands u next to tracked poses is an open-loop experiment, whatever closed the
loop.  The model is the one that realism profiles simulate: commands pass a dead time
:math:`\tau_d` and a first-order lag :math:`\tau_l`, both the team's; then robot i drives

.. math:: v = g^v_i F(u_v), \qquad \omega = g^\omega_i F(u_\omega) + b_i,

with F the delayed and lagged command, averaged over a step.  Poses are seen with white jitter
and a heading offset.

The fit looks at increments between frames: of the heading, and of the position along the
heading.  For given :math:`\tau_d, \tau_l` they are linear in gains and bias, so those are solved
for exactly and the search is over two numbers (variable projection).  An increment's noise is what
the model does not explain, w, plus the difference of two jitters,

.. math:: e_k = w_k + n_{k+1} - n_k,

so neighbouring increments are correlated, by minus the jitter's variance r.  Their covariance is
tridiagonal, the discrete sine transform diagonalises it, and its eigenvalues are
:math:`q + 2 r (1 - \\cos(\\pi j / (K + 1)))`.  So both variances are found by maximum likelihood
in the transformed residuals, and the fit is repeated with the increments whitened by them, which
makes the intervals honest.  Both variances are results, too.

Heading offsets are found as the angle between the heading that is seen and the course that is
driven.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dst
from scipy.optimize import least_squares, minimize

from posflock_robotarium.errors import LogError, OutputError
from posflock_robotarium.poselog import Log, PoseLog
from rps_compat.draws import Draw, constant
from rps_compat.realism import (
    DeadTime,
    Disturbance,
    Gains,
    HeadingOffset,
    Lag,
    Profile,
    TrackingJitter,
    TurnBias,
    Watchdog,
)

Floats = NDArray[np.float64]

#: 99 % of a normal distribution lie within so many standard deviations.
_Z = 2.575829
#: Rows below which nothing sensible can be fitted.
_LEAST_ROWS = 60
_LARGEST_DEAD_TIME, _LARGEST_LAG = 1.0, 1.0
#: A lag of which nothing is left after a step, s; the search needs one above 0.
_LEAST_LAG = 1e-4


@dataclass(frozen=True)
class Estimate:
    """A fitted number with its 99 % interval.

    Attributes
    ----------
    value, low, high : float
        In the quantity's unit.
    """

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.4g} ({self.low:.4g} to {self.high:.4g})"


@dataclass(frozen=True)
class Calibration:
    """What was fitted.

    Attributes
    ----------
    dead_time, lag : Estimate
        Seconds, of the team.
    speed_gain, turn_gain : tuple of Estimate
        Per robot.
    turn_bias : tuple of Estimate
        rad/s, per robot.
    heading_offset : tuple of Estimate
        rad, per robot.
    jitter : dict of str to Estimate
        ``along``, ``lateral`` (m) and ``heading`` (rad), standard deviations of the team.
    disturbance : dict of str to Estimate
        ``speed`` (m/s) and ``turn`` (rad/s), what the model does not explain, per step.
    rows, time_step
        Of the log.
    """

    dead_time: Estimate
    lag: Estimate
    speed_gain: tuple[Estimate, ...]
    turn_gain: tuple[Estimate, ...]
    turn_bias: tuple[Estimate, ...]
    heading_offset: tuple[Estimate, ...]
    jitter: dict[str, Estimate]
    disturbance: dict[str, Estimate]
    rows: int
    time_step: float

    def profile(self, name: str = "calibrated", pooled: bool = False) -> Profile:
        """Return the realism profile that simulates this testbed.

        Parameters
        ----------
        name : str
            Its name.
        pooled : bool
            Give distributions over robots, to draw any number of robots from, instead of the
            values of these robots.
        """

        def robots(estimates: tuple[Estimate, ...], least: float = -math.inf) -> Draw:
            values = [e.value for e in estimates]
            if not pooled:
                return Draw("robots", tuple(values))
            spread = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
            spread = min(spread, (float(np.mean(values)) - least) / 3)
            if spread == 0.0:
                return constant(float(np.mean(values)))
            return Draw("normal", (float(np.mean(values)), spread), 3 * spread)

        return Profile(
            name=name,
            about=f"Fitted to {self.rows} steps of {len(self.speed_gain)} robots.",
            watchdog=Watchdog(),
            dead_time=DeadTime(constant(self.dead_time.value)),
            gains=Gains(speed=robots(self.speed_gain, 0.0), turn=robots(self.turn_gain, 0.0)),
            lag=Lag(constant(self.lag.value)),
            turn_bias=TurnBias(robots(self.turn_bias)),
            disturbance=Disturbance(
                self.disturbance["speed"].value, self.disturbance["turn"].value
            ),
            heading_offset=HeadingOffset(robots(self.heading_offset)),
            tracking_jitter=TrackingJitter(
                along=self.jitter["along"].value,
                lateral=self.jitter["lateral"].value,
                heading=self.jitter["heading"].value,
            ),
        )

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON: values, and intervals as [low, high]."""

        def plain(value: Any) -> Any:
            if isinstance(value, Estimate):
                return {"value": value.value, "interval": [value.low, value.high]}
            if isinstance(value, tuple):
                return [plain(entry) for entry in value]
            if isinstance(value, dict):
                return {key: plain(entry) for key, entry in value.items()}
            return value

        return {name: plain(getattr(self, name)) for name in self.__dataclass_fields__}


def calibrate(log: Log, time_step: float | None = None) -> Calibration:
    """Fit the model to a log that has commands.

    Parameters
    ----------
    log : Log
        Poses as tracked, and the commands sent after each reading.
    time_step : float, optional
        Seconds between rows; the log's own by default.

    Raises
    ------
    LogError
        Where the log is too short, has gaps, no commands, or robots that never moved enough to
        tell.
    """
    dt = _time_step(log, time_step)
    offsets = _heading_offsets(log)
    data = _increments(log, np.array([offset.value for offset in offsets]))
    fit = _Fit(data, dt)
    parameters, covariance, channels = fit.solve()
    dead_time, lag = parameters[:2]
    spread = np.sqrt(np.diag(covariance))
    # What ended at the search's lower bound is none.
    dead_time = dead_time if dead_time > 0.01 * spread[0] else 0.0
    lag = lag if lag > 1.01 * _LEAST_LAG else 0.0
    robots = log.robots

    def estimates(first: int) -> tuple[Estimate, ...]:
        which = range(first, first + robots)
        return tuple(_estimate(parameters[k], spread[k]) for k in which)

    along, turn = channels
    return Calibration(
        dead_time=_estimate(dead_time, spread[0], least=0.0),
        lag=_estimate(lag, spread[1], least=0.0),
        speed_gain=estimates(2),
        turn_gain=estimates(2 + robots),
        turn_bias=estimates(2 + 2 * robots),
        heading_offset=offsets,
        jitter={
            "along": along.jitter,
            "lateral": _lateral_jitter(log),
            "heading": turn.jitter,
        },
        disturbance={"speed": along.disturbance(dt), "turn": turn.disturbance(dt)},
        rows=len(log.t),
        time_step=dt,
    )


# --- From a log to increments ------------------------------------------------------------------


@dataclass(frozen=True)
class _Data:
    """Increments (K, N), along the heading (m) and of it (rad), and commands (K, 2, N)."""

    along: Floats
    turn: Floats
    commands: Floats


def _time_step(log: Log, given: float | None) -> float:
    if len(log.t) < _LEAST_ROWS:
        raise LogError(f"the log has {len(log.t)} rows; a calibration needs {_LEAST_ROWS}")
    steps = np.diff(log.t)
    dt = float(np.median(steps)) if given is None else given
    if not dt > 0 or np.abs(steps - dt).max() > 0.25 * dt:
        raise LogError(
            f"the log's rows are {steps.min():.4f} to {steps.max():.4f} s apart; a calibration"
            " needs a row every time step"
        )
    return dt


def _increments(log: Log, offsets: Floats) -> _Data:
    if not (np.isfinite(log.poses).all() and np.isfinite(log.commands).all()):
        raise LogError("the log has values that are not finite")
    for row, what in ((0, "forward speed"), (1, "turn rate")):
        still = np.ptp(log.commands[:, row], axis=0) < 1e-3
        if still.any():
            raise LogError(
                f"robots {np.flatnonzero(still).tolist()} were never commanded another {what}:"
                " nothing can be learnt about how they follow it"
            )
    turn = _wrapped(np.diff(log.poses[:, 2], axis=0))
    heading = log.poses[:-1, 2] + turn / 2 - offsets
    moved = np.diff(log.poses[:, :2], axis=0)
    along = moved[:, 0] * np.cos(heading) + moved[:, 1] * np.sin(heading)
    return _Data(along, turn, log.commands[:-1])


def _wrapped(angles: Floats) -> Floats:
    out: Floats = np.arctan2(np.sin(angles), np.cos(angles))
    return out


def delayed(commands: Floats, dead_time: float, lag: float, time_step: float) -> Floats:
    """Return what robots at rest drive on average in each step, of what they are commanded.

    Parameters
    ----------
    commands : (K, …) array
        One row a step, held for the step.
    dead_time, lag : float
        Seconds.
    time_step : float
        Seconds.
    """
    from scipy.signal import lfilter

    late = dead_time / time_step
    whole, share = int(late), late - int(late)
    padded = np.concatenate([np.zeros((whole + 1, *commands.shape[1:])), commands])
    rows = len(commands)
    shifted = (1 - share) * padded[1 : rows + 1] + share * padded[:rows]
    ratio = max(lag / time_step, 1e-9)
    left = math.exp(-1 / ratio)
    # The lag's state after each step, then the mean over the step of its approach.
    state = lfilter([1 - left], [1, -left], shifted, axis=0)
    before = np.concatenate([np.zeros((1, *state.shape[1:])), state[:-1]])
    out: Floats = shifted + ratio * (1 - left) * (before - shifted)
    return out


# --- The fit -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Channel:
    """The noise of one kind of increment: variances of unexplained motion q and of jitter r."""

    q: float
    r: float
    spread: tuple[float, float]  # standard deviations of the estimates q and r

    @property
    def jitter(self) -> Estimate:
        """Standard deviation of the jitter."""
        return self._deviation(self.r, self.spread[1], 1.0)

    def disturbance(self, dt: float) -> Estimate:
        """Return the standard deviation of the velocity that the model does not explain."""
        return self._deviation(self.q, self.spread[0], dt)

    @staticmethod
    def _deviation(variance: float, spread: float, dt: float) -> Estimate:
        """Return the root of a variance; from 0 on where it cannot be told from none at all."""
        if variance > _Z * spread:
            value, factor = math.sqrt(variance) / dt, math.exp(_Z * spread / variance / 2)
            return Estimate(value, value / factor, value * factor)
        # Far below its own uncertainty it is where a flat likelihood left the search.
        value = 0.0 if variance < 0.01 * spread else math.sqrt(variance) / dt
        return Estimate(value, 0.0, math.sqrt(variance + _Z * spread) / dt)


class _Fit:
    """Nonlinear least squares over dead time, lag, gains and bias, whitened."""

    def __init__(self, data: _Data, dt: float) -> None:
        self.data, self.dt = data, dt
        self.rows, self.robots = data.along.shape
        self.whiten: list[Callable[[Floats], Floats]] = [lambda e: e, lambda e: e]
        self.scale = [float(data.along.std()) or 1.0, float(data.turn.std()) or 1.0]

    def solve(self) -> tuple[Floats, Floats, tuple[_Channel, _Channel]]:
        """Return parameters, covariance and the noise of both kinds of increment."""
        shape = self._search((0.15, 0.15))
        for _ in range(2):
            channels = self._noise(self._residuals(*self._linear(*shape), *shape))
            self.whiten = [_whitener(c, self.rows) for c in channels]
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
            bounds=([0.0, _LEAST_LAG], [_LARGEST_DEAD_TIME, _LARGEST_LAG]),
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

    def _noise(self, residuals: tuple[Floats, Floats]) -> tuple[_Channel, _Channel]:
        along, turn = (_channel(residual) for residual in residuals)
        return along, turn


def _channel(residual: Floats) -> _Channel:
    """Find both variances of a noise by maximum likelihood, in the sine transform."""
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
    return _Channel(float(q), float(r), (float(spread[0]), float(spread[1])))


def _jitter_shape(rows: int) -> Floats:
    """Eigenvalues of the covariance of differences of white noise of unit variance."""
    return 2 * (1 - np.cos(np.pi * np.arange(1, rows + 1) / (rows + 1)))


def _sine_transform(increments: Floats) -> Floats:
    out: Floats = dst(increments, type=1, axis=0, norm="ortho")
    return out


def _whitener(channel: _Channel, rows: int) -> Callable[[Floats], Floats]:
    """Return what makes increments with this noise white and of unit variance."""
    scale = 1 / np.sqrt(channel.q + channel.r * _jitter_shape(rows))[:, None]

    def whiten(increments: Floats) -> Floats:
        return scale * _sine_transform(increments)

    return whiten


# --- Offsets and jitter that need no command ---------------------------------------------------


def _heading_offsets(log: Log) -> tuple[Estimate, ...]:
    """Estimate by how much each tracked heading is off the course driven.

    Motion over half a second, across and along the mean tracked heading: the slope is minus the
    offset. A second regressor, the turn meanwhile, takes up how a turning robot's course relates
    to its headings at the frames. Blocks do not overlap, so their scatter gives the interval.
    """
    block = 15
    starts = np.arange(0, len(log.t) - block, block)
    out = []
    for robot in range(log.robots):
        x, y, theta = log.poses[:, :, robot].T
        heading = np.unwrap(theta)
        dx, dy = x[starts + block] - x[starts], y[starts + block] - y[starts]
        mean = np.array([heading[s : s + block + 1].mean() for s in starts])
        along = dx * np.cos(mean) + dy * np.sin(mean)
        across = dy * np.cos(mean) - dx * np.sin(mean)
        if np.abs(along).max() < 0.01:  # it never moved a centimetre
            out.append(Estimate(0.0, -math.pi, math.pi))
            continue
        design = np.stack([along, along * (heading[starts + block] - heading[starts])], axis=1)
        normal = np.linalg.pinv(design.T @ design)
        slope = normal @ design.T @ across
        error = across - design @ slope
        robust = normal @ (design.T * error**2) @ design @ normal
        out.append(_estimate(-math.atan(float(slope[0])), math.sqrt(float(robust[0, 0]))))
    return tuple(out)


def _lateral_jitter(log: Log) -> Estimate:
    """Estimate the jitter across the heading from second differences, which smooth motion has not.

    A robot cannot go sideways, and in three frames its path bends by next to nothing.
    """
    second = np.diff(log.poses[:, :2], n=2, axis=0)
    theta = log.poses[1:-1, 2]
    turn = _wrapped(log.poses[2:, 2] - log.poses[:-2, 2]) / 2
    moved = np.linalg.norm(log.poses[2:, :2] - log.poses[:-2, :2], axis=1) / 2
    across = -second[:, 0] * np.sin(theta) + second[:, 1] * np.cos(theta) - moved * turn
    variance = np.square(across) / 6
    mean = float(variance.mean())
    spread = float(variance.std() / math.sqrt(variance.size / 3))
    return Estimate(
        math.sqrt(mean),
        math.sqrt(max(0.0, mean - _Z * spread)),
        math.sqrt(mean + _Z * spread),
    )


def _estimate(value: float, spread: float, least: float = -math.inf) -> Estimate:
    return Estimate(
        float(value), max(least, float(value - _Z * spread)), float(value + _Z * spread)
    )


# --- Reading a log, and simulating with what was fitted ------------------------------------------


def read_commanded(path: Path | str) -> Log:
    """Read a log that has commands from any file that the report reads.

    Parameters
    ----------
    path : path
        A pose log, with or without ``.npy``, or an archive with poses, times and commands.

    Raises
    ------
    LogError
        Where the file is missing, damaged, ambiguous or holds no commands.
    """
    from posflock_robotarium.report.readers import LayoutError, read

    try:
        run = read(path)
    except LayoutError as error:
        raise LogError(
            f"{error}; `posflock convert --to npz` with that option writes a file that says so"
        ) from error
    rows = len(run.t)
    if run.command is None:
        raise LogError(
            f"{path}: no commands in it; a calibration compares what robots did with what they"
            " were told, which a pose log holds"
        )
    return Log(
        t=run.t,
        poses=run.poses,
        commands=run.command,
        status=np.full(rows, "none") if run.status is None else run.status,
        moved=np.zeros(rows) if run.moved is None else run.moved,
        smallest_h=np.full(rows, math.nan) if run.smallest_h is None else run.smallest_h,
        metadata=dict(run.parameters),
    )


def resimulate(log: Log, profile: Profile, seed: int = 0) -> Log:
    """Drive simulated robots with a log's commands, under a profile, from its first poses.

    Parameters
    ----------
    log : Log
        With commands.
    profile : Profile
        Such as :meth:`Calibration.profile`.
    seed : int
        Of the profile's randomness.

    Returns
    -------
    Log
        The same times and commands, and the poses that the simulator gives.
    """
    from rps_compat.arena import Arena

    dt = _time_step(log, None)
    start = log.poses[0].copy()
    if profile.heading_offset is not None and profile.heading_offset.radians.kind == "robots":
        # The log's first headings have the offset already, which the profile will add.
        start[2] -= profile.heading_offset.radians.draw(log.robots, np.random.default_rng(seed))
    arena = Arena(start, realism=profile.start(), rng=np.random.default_rng(seed))
    poses = np.empty_like(log.poses)
    for k, command in enumerate(log.commands):
        poses[k] = arena.observe()
        arena.commands = np.array(command)
        arena.step()
    known = {**log.metadata, "resimulated_with": profile.name, "seed": seed, "time_step": dt}
    return Log(log.t, poses, log.commands, log.status, log.moved, log.smallest_h, known)


def write_log(log: Log, path: Path) -> Path:
    """Write a log to ``path`` (.npy and .json) and return the array's path."""
    known = {k: v for k, v in log.metadata.items() if k not in ("ended", "format", "versions")}
    with PoseLog(path, log.robots, len(log.t), known) as out:
        for k, t in enumerate(log.t):
            out.append(float(t), log.poses[k], log.commands[k], status=str(log.status[k]))
    return out.path


def write_profile(profile: Profile, path: Path) -> None:
    """Write a profile as TOML.

    Raises
    ------
    OutputError
        Where that is not possible.
    """
    from rps_compat.profiles import profile_to_toml

    try:
        path.write_text(profile_to_toml(profile), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write the profile {path}: {error}") from error
