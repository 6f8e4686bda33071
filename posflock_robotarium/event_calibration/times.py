r"""Gain and delay from the times at which a script printed what it printed.

A script that says when its robots arrive is an experiment without poses.  Around the best gain g
and dead time d, the time of event e in simulated runs is nearly

.. math:: T_e = a_e + b_e / g + c_e d + \text{what is random},

for a way takes the longer the slower robots are.  The coefficients come from simulated runs with
other seeds, and so does the covariance of what is random, which the real run had, too: an early
delay is in all later events.  The logged times then are a linear regression for 1/g and d.  What
scatters more than the simulated runs do is what the simulation does not explain, and widens the
intervals.

From times alone a gain cannot be told from steps that take longer than they say, or from wheels
that are slower than they should be: it is distance per commanded distance, and stands for all
three.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from posflock_robotarium.calibration.estimate import Estimate
from posflock_robotarium.calibration.identifiability import USEFUL, FittedParameter
from posflock_robotarium.event_calibration.trials import Candidate, Heard
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.event_lines import EventKey

Floats = NDArray[np.float64]
#: Simulates under candidates.
Simulate = Callable[[list[Candidate]], list[Heard]]

#: Gains that are tried first, and the delays that are tried around the best of them, s.
_COARSE = (1.15, 1.0, 0.87, 0.76, 0.66, 0.57, 0.5)
_DELAYS = (0.05, 0.55)
#: Half the width, as a share of the gain, in which times are taken for linear.
_NEAR = 0.08
#: Times that spread less than this over gains hang on the script's clock alone, s.
_SCHEDULED = 0.3
#: A time that hangs on the gain changes over these gains by so many of its own deviations.
_CLEAR = 2.0
#: Printed times are rounded to a tenth of a second.
_ROUNDING = 0.1 / np.sqrt(12)
_ROUNDS = 3


@dataclass(frozen=True)
class EventRow:
    """One event: when it was, and when it is under what was fitted.

    Attributes
    ----------
    name : str
        The printed line without its numbers.
    logged, fitted : float
        s.
    spread : float
        Standard deviation from seed to seed, s.
    """

    name: str
    logged: float
    fitted: float
    spread: float


@dataclass(frozen=True)
class EventFit:
    """What event times say.

    Attributes
    ----------
    gain : Estimate
        Mean speed gain of the robots.
    delay : Estimate or None
        Dead time, s; None where the events do not determine it.
    assumed_delay : float
        What was assumed where they do not, s.
    rows : tuple of EventRow
        The events that were used.
    scheduled : int
        Events whose times do not hang on the gain: they come when the clock says so, or by chance.
    unmatched : tuple of str
        Logged events that did not come in every simulated run.
    unexplained : float
        Standard deviation of what the simulation does not explain, s.
    runs : int
        How many runs were simulated.
    """

    gain: Estimate
    delay: Estimate | None
    assumed_delay: float
    rows: tuple[EventRow, ...]
    scheduled: int
    unmatched: tuple[str, ...]
    unexplained: float
    runs: int


def fit_events(
    logged: dict[EventKey, float], simulate: Simulate, trials: int, delay: float, seed: int = 0
) -> EventFit:
    """Fit gain and delay to logged events.

    Parameters
    ----------
    logged : dict
        From events to their times, s.
    simulate : callable
        Simulates the script under candidates.
    trials : int
        How many runs are simulated around each guess.
    delay : float
        Dead time to start from, and to assume where events do not tell it, s.
    seed : int
        First seed of the trials.

    Raises
    ------
    LogError
        Where no event of the log hangs on how fast robots are.
    """
    coarse = simulate([Candidate(gain, delay, seed) for gain in _COARSE])
    gain, heard = _best(logged, coarse), list(coarse)
    for number in range(_ROUNDS):
        heard += simulate(_around(gain, trials, seed + 1 + number * trials))
        near = [run for run in heard if abs(run.candidate.gain / gain - 1) <= 1.5 * _NEAR]
        fit = _regress(logged, near, delay, len(heard))
        if abs(fit.gain.value / gain - 1) <= _NEAR:
            return fit
        gain = float(np.clip(fit.gain.value, 0.8 * gain, 1.25 * gain))
    raise LogError(
        f"the logged times fit no gain: the search still moves at {gain:.2f} after {len(heard)}"
        " runs; is this the script that made the log?"
    )


def _best(logged: dict[EventKey, float], runs: Sequence[Heard]) -> float:
    """Return the gain of the run whose events come nearest; a missing one comes at its end."""
    if not any(logged.keys() & run.events.keys() for run in runs):
        raise LogError(
            f"none of the log's {len(logged)} timed lines is printed by the simulated script: they"
            " are matched by their text without numbers"
        )

    def off(run: Heard) -> float:
        times = [run.events.get(key, max(run.seconds, at)) for key, at in logged.items()]
        return float(np.abs(np.array(times) - np.array(list(logged.values()))).sum())

    return min(runs, key=off).candidate.gain


def _around(gain: float, trials: int, seed: int) -> list[Candidate]:
    """Spread candidates evenly over gains and delays around a guess, each with its own seed."""
    places = np.arange(trials) + 0.5
    gains = gain * (1 + _NEAR * (2 * places / trials - 1))
    # Steps of the golden ratio fill the other axis evenly, too, for any number.
    shares = (places * 0.6180339887) % 1.0
    delays = _DELAYS[0] + (_DELAYS[1] - _DELAYS[0]) * shares
    return [
        Candidate(float(g), float(d), seed + k)
        for k, (g, d) in enumerate(zip(gains, delays, strict=True))
    ]


def _regress(
    logged: dict[EventKey, float], runs: Sequence[Heard], delay: float, all_runs: int
) -> EventFit:
    """Fit 1/g and d to the logged times, with what runs around them say of both."""
    common = [key for key in logged if all(key in run.events for run in runs)]
    heard = [[run.events[key] for key in common] for run in runs]
    times: Floats = np.array(heard).reshape(len(runs), -1)
    inputs = np.array([[1.0, 1 / r.candidate.gain, r.candidate.delay] for r in runs])
    coefficients, *_ = np.linalg.lstsq(inputs, times, rcond=None)
    effect = np.abs(coefficients[1]) * np.ptp(inputs[:, 1])
    scatter = (times - inputs @ coefficients).std(axis=0)
    informative = effect > np.maximum(_SCHEDULED, _CLEAR * scatter)
    keys = [key for key, use in zip(common, informative, strict=True) if use]
    if not keys:
        raise LogError(
            f"no timed line of the log hangs on how fast robots are: {len(common)} of"
            f" {len(logged)} are printed by the simulated script, all at the same times whatever"
            " the gain"
        )
    coefficients, times = coefficients[:, informative], times[:, informative]
    residual = times - inputs @ coefficients
    random = residual.T @ residual / max(len(runs) - 3, 1)
    random = random * (1 + 3 / len(runs)) + _ROUNDING**2 * np.eye(len(keys))
    measured = np.array([logged[key] for key in keys])
    solved = _Solved(coefficients, random, measured)
    found, error, unexplained, quantile = solved.both(delay)
    return _summary(
        keys,
        measured,
        (coefficients, random, found, error, unexplained, quantile),
        (len(common) - len(keys), [key for key in logged if key not in common], all_runs, delay),
    )


class _Solved:
    """The regression of logged times on 1/g and d.

    Parameters
    ----------
    coefficients : (3, E) array
        Of each event: constant, 1/g, d.
    random : (E, E) array
        Covariance of event times from run to run, s².
    measured : (E,) array
        Logged times, s.
    """

    def __init__(self, coefficients: Floats, random: Floats, measured: Floats) -> None:
        self.coefficients, self.random, self.measured = coefficients, random, measured

    def both(self, delay: float) -> tuple[Floats, Floats, float, float]:
        """Solve for both, or for 1/g alone where d has no useful interval.

        Returns
        -------
        found, error : (2,) arrays
            1/g and d, and their standard deviations; NaN where d is assumed.
        unexplained, quantile : float
            Standard deviation of what is not explained, s; deviations that hold 99 %.
        """
        if len(self.measured) > 2:
            found, error, unexplained, quantile = self._solve(self.coefficients[1:].T, 0.0)
            if quantile * error[1] <= USEFUL[FittedParameter.DEAD_TIME] and found[1] >= 0:
                return found, error, unexplained, quantile
        known = self.coefficients[2] * delay
        found, error, unexplained, quantile = self._solve(self.coefficients[1:2].T, known)
        return np.append(found, delay), np.append(error, np.nan), unexplained, quantile

    def _solve(self, design: Floats, known: Floats | float) -> tuple[Floats, Floats, float, float]:
        target = self.measured - self.coefficients[0] - known
        events, unknowns = design.shape
        freedom = events - unknowns
        unexplained = 0.0
        for _ in range(20):
            covariance = self.random + unexplained * np.eye(events)
            weights = 1 / np.diag(covariance)
            inverse = np.linalg.pinv(design.T @ (weights[:, None] * design))
            solve = inverse @ design.T * weights
            found = solve @ target
            left = float(np.square(target - design @ found).sum()) / max(freedom, 1)
            # A robot's lateness is in all its later events: their mean variance is not their sum.
            unexplained = max(0.0, left - float(np.diag(self.random).mean())) if freedom else 0.0
        error = np.sqrt(np.diag(solve @ covariance @ solve.T))
        return found, error, float(np.sqrt(unexplained)), float(student.ppf(0.995, max(freedom, 3)))


def _summary(
    keys: list[EventKey],
    measured: Floats,
    solved: tuple[Floats, Floats, Floats, Floats, float, float],
    counts: tuple[int, list[EventKey], int, float],
) -> EventFit:
    coefficients, random, found, error, unexplained, quantile = solved
    scheduled, unmatched, runs, delay = counts
    slowness, reach = found[0], quantile * error[0]
    fastest = 1 / (slowness - reach) if slowness > reach else np.inf
    fitted = coefficients[0] + found @ coefficients[1:]
    return EventFit(
        gain=Estimate(float(1 / slowness), float(1 / (slowness + reach)), float(fastest)),
        delay=None
        if np.isnan(error[1])
        else Estimate(
            float(found[1]),
            max(0.0, float(found[1] - quantile * error[1])),
            float(found[1] + quantile * error[1]),
        ),
        assumed_delay=delay,
        rows=tuple(
            EventRow(key[0], float(at), float(under), float(spread))
            for key, at, under, spread in zip(
                keys, measured, fitted, np.sqrt(np.diag(random)), strict=True
            )
        ),
        scheduled=scheduled,
        unmatched=tuple(name for name, _ in unmatched),
        unexplained=unexplained,
        runs=runs,
    )
