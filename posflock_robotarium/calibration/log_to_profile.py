"""From a log with commands to estimates: the whole fit in one call."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.calibration.estimate import Estimate
from posflock_robotarium.calibration.fit import (
    LARGEST_DEAD_TIME,
    LARGEST_LAG,
    LEAST_LAG,
    Fit,
    Fitted,
)
from posflock_robotarium.calibration.identifiability import USEFUL, FittedParameter, LeftOut
from posflock_robotarium.calibration.increments import NO_COMMANDS, increments_of
from posflock_robotarium.calibration.residuals import damaged, hidden_stalls
from posflock_robotarium.calibration.response import delayed
from posflock_robotarium.calibration.result import Calibration, Jitter, PerRobot, Unexplained
from posflock_robotarium.calibration.step_times import StepTimes, TimesOrigin, step_times_of
from posflock_robotarium.calibration.tracking import heading_offsets, lateral_jitter
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.plausibility import (
    Sightings,
    sightings_of,
)
from posflock_robotarium.logs.run import Run

Floats = NDArray[np.float64]
#: Increments without which nothing can be fitted.
_FEWEST = 60
_GAINS = (FittedParameter.SPEED_GAIN, FittedParameter.TURN_GAIN)


@dataclass(frozen=True, eq=False)
class Fitting:
    """A calibration with the motion that it was fitted to.

    Attributes
    ----------
    calibration : Calibration
        What was fitted.
    driven : (K, 2, N) array
        Speeds, m/s, and turn rates, rad/s, of robots with a gain of 1, the team's dead time and
        its lag, averaged over each step.
    went, turned : (K, N) array
        The robots' own, from their poses, m/s and rad/s.
    known : (K, N) boolean array
        Which of them are to be believed.
    """

    calibration: Calibration
    driven: Floats
    went: Floats
    turned: Floats
    known: NDArray[np.bool_]


def calibrate(log: Run, step_times: float | Floats | None = None) -> Calibration:
    """Fit the model to a log that has commands.

    Parameters
    ----------
    log : Run
        Poses as tracked, and the commands sent after each reading.
    step_times : float or (K,) array, optional
        Seconds from row to row, one for all or each; the log's own times by default.

    Raises
    ------
    LogError
        Where the log is too short, has no commands, times or units that cannot be, or determines
        nothing of how its robots follow commands.
    """
    return fitting_of(log, step_times).calibration


def fitting_of(log: Run, step_times: float | Floats | None = None) -> Fitting:
    """Fit the model, and return the motion that it was fitted to, too.

    Parameters
    ----------
    log : Run
        Poses as tracked, and the commands sent after each reading.
    step_times : float or (K,) array, optional
        Seconds from row to row, one for all or each; the log's own times by default.

    Raises
    ------
    LogError
        As `calibrate`.
    """
    if log.commands is None:
        raise LogError(f"{log.name}: {NO_COMMANDS}")
    times = step_times_of(log, step_times)
    sightings = sightings_of(log, times.t, times.origin is TimesOrigin.NOMINAL)
    if sightings.impossible:
        raise LogError(
            f"{log.name}: in {sightings.jumps.mean():.0%} of the rows robots would have driven"
            f" faster than their wheels turn, with {times}; give the time between rows with --dt,"
            " or mend the units (metres, radians)"
        )
    offsets = tuple(
        offset if offset.high - offset.value <= USEFUL[FittedParameter.HEADING_OFFSET] else None
        for offset in heading_offsets(log, times.t, sightings.known)
    )
    known = np.array([0.0 if offset is None else offset.value for offset in offsets])
    data = increments_of(log, known, times, sightings)
    if int(data.known.sum()) < _FEWEST:
        raise LogError(
            f"{log.name}: the log determines nothing of how its robots follow commands: only "
            f"{int(data.known.sum())} increments of robots that are seen in two rows one after the "
            f"other; expected at least {_FEWEST}"
        )
    fit = Fit(data)
    fitted = fit.solve()
    if times.origin is TimesOrigin.NOMINAL and (stalls := hidden_stalls(fit, sightings.stalls)):
        times = times.without(stalls)
        data = increments_of(log, known, times, sightings)
        fit = Fit(data)
        fitted = fit.solve()
    if (spikes := damaged(fit)).any():
        data = replace(data, known=data.known & ~spikes)
        fitted = Fit(data).solve()
    found = _calibration(log, times, replace(sightings, spikes=spikes), fitted, offsets)
    dead_time, lag = float(fitted.values[0]), float(fitted.values[1])
    driven = delayed(data.commands, dead_time, lag, data.steps, data.before)
    steps = data.steps[:, np.newaxis]
    return Fitting(found, driven, data.along / steps, data.turn / steps, data.known)


def _calibration(
    log: Run, times: StepTimes, sightings: Sightings, fitted: Fitted, offsets: PerRobot
) -> Calibration:
    """Put together what came out of all parts; refuse it where nothing did."""
    estimates = _estimates(fitted)
    left_out = list(fitted.left_out)
    for entry, reason in _useless(fitted, estimates):
        estimates[entry] = None
        left_out.append(LeftOut(*fitted.layout.names[entry], reason))
    follows = ~fitted.layout.of(FittedParameter.TURN_BIAS)
    if all(estimates[entry] is None for entry in np.flatnonzero(follows)):
        raise LogError(
            f"{log.name}: the log determines nothing of how its robots follow commands, so no"
            f" profile comes of it. {'; '.join(map(str, left_out))}"
        )
    for robot, offset in enumerate(offsets):
        if offset is None:
            left_out.append(
                LeftOut(FittedParameter.HEADING_OFFSET, robot, "too little driving forward")
            )

    def of(kind: FittedParameter) -> PerRobot:
        return tuple(estimates[k] for k in np.flatnonzero(fitted.layout.of(kind)))

    along, turn, dt = fitted.along, fitted.turn, times.median
    return Calibration(
        dead_time=estimates[0],
        lag=estimates[1],
        speed_gain=of(FittedParameter.SPEED_GAIN),
        turn_gain=of(FittedParameter.TURN_GAIN),
        turn_bias=of(FittedParameter.TURN_BIAS),
        heading_offset=offsets,
        jitter=Jitter(along.jitter, lateral_jitter(log, times.steps, sightings.known), turn.jitter),
        disturbance=Unexplained(along.disturbance(dt), turn.disturbance(dt)),
        left_out=tuple(left_out),
        warnings=(*times.warnings, *_warnings(times, sightings)),
        rows=len(log.t),
        time_step=dt,
        times=str(times),
    )


def _estimates(fitted: Fitted) -> list[Estimate | None]:
    """Return value and interval of every entry that is determined."""
    values, spread = fitted.values.copy(), fitted.spread
    # What ended at the search's lower bound is none.
    values[0] = values[0] if values[0] > 0.01 * spread[0] else 0.0
    values[1] = values[1] if values[1] > 1.01 * LEAST_LAG else 0.0
    return [
        Estimate.around(values[k], spread[k], least=0.0 if k < 2 else -math.inf) if free else None
        for k, free in enumerate(fitted.free)
    ]


def _useless(fitted: Fitted, estimates: list[Estimate | None]) -> Iterator[tuple[int, str]]:
    """Find what is known well, and yet describes no robot."""
    for entry, (estimate, (kind, _)) in enumerate(zip(estimates, fitted.layout.names, strict=True)):
        if estimate is None:
            continue
        largest = {
            FittedParameter.DEAD_TIME: LARGEST_DEAD_TIME,
            FittedParameter.LAG: LARGEST_LAG,
        }.get(kind, math.inf)
        if estimate.value > 0.99 * largest:
            yield entry, f"it would be beyond {largest:g} s, so robots followed other commands"
        elif kind in _GAINS and estimate.low <= 0:
            yield entry, f"it would be {estimate}: the robot did not follow its commands"


def _warnings(times: StepTimes, sightings: Sightings) -> Iterator[str]:
    """Tell of poses that are left out."""
    jumps = sightings.jumps.copy()
    jumps[np.searchsorted(times.t, [at for at, _ in times.hidden])] = False  # those are stalls
    each = [f"robot {n}: {count}" for n, count in enumerate(jumps.sum(axis=0)) if count]
    if each:
        yield (
            f"jumps faster than wheels turn ({jumps.sum()}; {', '.join(each)}) are no motion and"
            " left out"
        )
    if spikes := int(sightings.spikes.sum()):
        yield f"increments of single robots that no noise explains ({spikes}) are left out"
    if sightings.unbelieved:
        rows = sum(stretch.rows for stretch in sightings.unbelieved)
        some = "; ".join(map(str, sightings.unbelieved[:4]))
        more = "; …" if len(sightings.unbelieved) > 4 else ""
        yield (
            f"poses that are not of the robot they are written for ({rows}) are left out:"
            f" {some}{more}"
        )
