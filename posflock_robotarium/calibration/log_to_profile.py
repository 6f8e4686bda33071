"""From a log with commands to a realism profile: the whole fit in one call."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from posflock_robotarium.calibration.estimate import Estimate
from posflock_robotarium.calibration.fit import LEAST_LAG, Fit
from posflock_robotarium.calibration.increments import increments_of, time_step_of
from posflock_robotarium.calibration.tracking import heading_offsets, lateral_jitter
from posflock_robotarium.logs.run import Run
from rps_compat.distributions import DistributionKind, RobotDistribution, constant
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


@dataclass(frozen=True)
class Jitter:
    """Standard deviations of the tracker's white noise, one for the whole team.

    Attributes
    ----------
    along, lateral : Estimate
        Of positions along and across the heading, m.
    heading : Estimate
        Of headings, rad.
    """

    along: Estimate
    lateral: Estimate
    heading: Estimate


@dataclass(frozen=True)
class Unexplained:
    """Standard deviations of the motion that the model does not explain, drawn anew each step.

    Attributes
    ----------
    speed : Estimate
        Of the velocity along the heading, m/s.
    turn : Estimate
        Of the turn rate, rad/s.
    """

    speed: Estimate
    turn: Estimate


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
    jitter : Jitter
        Of the team's poses.
    disturbance : Unexplained
        Of the team's motion.
    rows, time_step
        Of the log.
    """

    dead_time: Estimate
    lag: Estimate
    speed_gain: tuple[Estimate, ...]
    turn_gain: tuple[Estimate, ...]
    turn_bias: tuple[Estimate, ...]
    heading_offset: tuple[Estimate, ...]
    jitter: Jitter
    disturbance: Unexplained
    rows: int
    time_step: float

    def profile(self, name: str = "calibrated", pooled: bool = False) -> Profile:
        """Return the realism profile that simulates this testbed.

        Parameters
        ----------
        name : str
            What reports call the profile.
        pooled : bool
            Give distributions over robots, to draw any number of robots from, instead of the
            values of these robots.
        """

        def robots(estimates: tuple[Estimate, ...], least: float = -math.inf) -> RobotDistribution:
            values = [e.value for e in estimates]
            if not pooled:
                return RobotDistribution(DistributionKind.ROBOTS, tuple(values))
            spread = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
            spread = min(spread, (float(np.mean(values)) - least) / 3)
            if spread == 0.0:
                return constant(float(np.mean(values)))
            return RobotDistribution(
                DistributionKind.NORMAL, (float(np.mean(values)), spread), 3 * spread
            )

        return Profile(
            name=name,
            about=f"Fitted to {self.rows} steps of {len(self.speed_gain)} robots.",
            watchdog=Watchdog(),
            dead_time=DeadTime(constant(self.dead_time.value)),
            gains=Gains(speed=robots(self.speed_gain, 0.0), turn=robots(self.turn_gain, 0.0)),
            lag=Lag(constant(self.lag.value)),
            turn_bias=TurnBias(robots(self.turn_bias)),
            disturbance=Disturbance(self.disturbance.speed.value, self.disturbance.turn.value),
            heading_offset=HeadingOffset(robots(self.heading_offset)),
            tracking_jitter=TrackingJitter(
                along=self.jitter.along.value,
                lateral=self.jitter.lateral.value,
                heading=self.jitter.heading.value,
            ),
        )

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON: values, and intervals as [low, high]."""

        def plain(value: Any) -> Any:
            if isinstance(value, Estimate):
                return {"value": value.value, "interval": [value.low, value.high]}
            if isinstance(value, tuple):
                return [plain(entry) for entry in value]
            if isinstance(value, (Calibration, Jitter, Unexplained)):
                return {part.name: plain(getattr(value, part.name)) for part in fields(value)}
            return value

        said: dict[str, Any] = plain(self)
        return said


def calibrate(log: Run, time_step: float | None = None) -> Calibration:
    """Fit the model to a log that has commands.

    Parameters
    ----------
    log : Run
        Poses as tracked, and the commands sent after each reading.
    time_step : float, optional
        Seconds between rows; the log's own by default.

    Raises
    ------
    LogError
        Where the log is too short, has gaps, no commands, or robots that never moved enough to
        tell.
    """
    dt = time_step_of(log, time_step)
    offsets = heading_offsets(log)
    data = increments_of(log, np.array([offset.value for offset in offsets]))
    fit = Fit(data, dt)
    parameters, covariance, channels = fit.solve()
    dead_time, lag = parameters[:2]
    spread = np.sqrt(np.diag(covariance))
    # What ended at the search's lower bound is none.
    dead_time = dead_time if dead_time > 0.01 * spread[0] else 0.0
    lag = lag if lag > 1.01 * LEAST_LAG else 0.0
    robots = log.robots

    def estimates(first: int) -> tuple[Estimate, ...]:
        which = range(first, first + robots)
        return tuple(Estimate.around(parameters[k], spread[k]) for k in which)

    along, turn = channels
    return Calibration(
        dead_time=Estimate.around(dead_time, spread[0], least=0.0),
        lag=Estimate.around(lag, spread[1], least=0.0),
        speed_gain=estimates(2),
        turn_gain=estimates(2 + robots),
        turn_bias=estimates(2 + 2 * robots),
        heading_offset=offsets,
        jitter=Jitter(along.jitter, lateral_jitter(log), turn.jitter),
        disturbance=Unexplained(along.disturbance(dt), turn.disturbance(dt)),
        rows=len(log.t),
        time_step=dt,
    )
