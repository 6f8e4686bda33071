"""What a calibration found: estimates, what is left out and why, and the profile of both."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from enum import Enum
from typing import Any

import numpy as np

from posflock_robotarium.calibration.estimate import Estimate
from posflock_robotarium.calibration.identifiability import LeftOut
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

#: One estimate a robot; None where the log does not determine it.
PerRobot = tuple[Estimate | None, ...]


@dataclass(frozen=True)
class Jitter:
    """Standard deviations of the tracker's white noise, one for the whole team.

    Attributes
    ----------
    along, lateral : Estimate or None
        Of positions along and across the heading, m.
    heading : Estimate or None
        Of headings, rad.
    """

    along: Estimate | None
    lateral: Estimate | None
    heading: Estimate | None


@dataclass(frozen=True)
class Unexplained:
    """Standard deviations of the motion that the model does not explain, drawn anew each step.

    Attributes
    ----------
    speed : Estimate or None
        Of the velocity along the heading, m/s.
    turn : Estimate or None
        Of the turn rate, rad/s.
    """

    speed: Estimate | None
    turn: Estimate | None


@dataclass(frozen=True)
class Calibration:
    """What was fitted; None stands for what the log does not determine.

    Attributes
    ----------
    dead_time, lag : Estimate or None
        Seconds, of the team.
    speed_gain, turn_gain : tuple of Estimate or None
        Per robot.
    turn_bias : tuple of Estimate or None
        rad/s, per robot.
    heading_offset : tuple of Estimate or None
        rad, per robot.
    jitter : Jitter
        Of the team's poses.
    disturbance : Unexplained
        Of the team's motion.
    left_out : tuple of LeftOut
        What is None, and why.
    warnings : tuple of str
        What must be known before the estimates are believed, a sentence each.
    rows : int
        Of the log.
    time_step : float
        Median step of the log, s.
    times : str
        How long its steps took, in words.
    """

    dead_time: Estimate | None
    lag: Estimate | None
    speed_gain: PerRobot
    turn_gain: PerRobot
    turn_bias: PerRobot
    heading_offset: PerRobot
    jitter: Jitter
    disturbance: Unexplained
    left_out: tuple[LeftOut, ...]
    warnings: tuple[str, ...]
    rows: int
    time_step: float
    times: str

    @property
    def about(self) -> str:
        """Where the numbers come from, and which are missing, as the profile says it."""
        said = [f"Fitted to {self.rows} rows of {len(self.speed_gain)} robots: {self.times}."]
        if self.left_out:
            said.append("Not determined: " + "; ".join(map(str, self.left_out)) + ".")
        said += [f"Warning: {warning}." for warning in self.warnings]
        return " ".join(said)

    def profile(self, name: str = "calibrated", pooled: bool = False) -> Profile:
        """Return the realism profile that simulates this testbed.

        An effect of which nothing was determined is absent; a robot whose value was not gets the
        mean of the others.

        Parameters
        ----------
        name : str
            What reports call the profile.
        pooled : bool
            Give distributions over robots, to draw any number of robots from, instead of the
            values of these robots.
        """

        def robots(estimates: PerRobot, least: float = -math.inf) -> RobotDistribution | None:
            return _distribution(estimates, pooled, least)

        speed, turn = robots(self.speed_gain, 0.0), robots(self.turn_gain, 0.0)
        bias, offset = robots(self.turn_bias), robots(self.heading_offset)
        gains = None
        if speed is not None or turn is not None:
            gains = Gains(speed=speed or constant(1.0), turn=turn or constant(1.0))
        jitter, unexplained = self.jitter, self.disturbance
        return Profile(
            name=name,
            about=self.about,
            watchdog=Watchdog(),
            dead_time=_or_none(DeadTime, self.dead_time),
            gains=gains,
            lag=_or_none(Lag, self.lag),
            turn_bias=None if bias is None else TurnBias(bias),
            disturbance=Disturbance(_or_0(unexplained.speed), _or_0(unexplained.turn)),
            heading_offset=None if offset is None else HeadingOffset(offset),
            tracking_jitter=TrackingJitter(
                along=_or_0(jitter.along),
                lateral=_or_0(jitter.lateral),
                heading=_or_0(jitter.heading),
            ),
        )

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON: values, and intervals as [low, high]."""
        said: dict[str, Any] = _plain(self)
        return said


def _plain(value: Any) -> Any:
    if isinstance(value, Estimate):
        return {"value": value.value, "interval": [value.low, value.high]}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, (Calibration, Jitter, Unexplained, LeftOut)):
        return {part.name: _plain(getattr(value, part.name)) for part in fields(value)}
    return value


def _or_0(estimate: Estimate | None) -> float:
    """Return an effect's size, whose 0 is its absence."""
    return 0.0 if estimate is None else estimate.value


def _or_none(effect: Any, estimate: Estimate | None) -> Any:
    return None if estimate is None else effect(constant(estimate.value))


def _distribution(estimates: PerRobot, pooled: bool, least: float) -> RobotDistribution | None:
    """Return these robots' values, or a distribution over robots; None where none was fitted."""
    fitted = [estimate.value for estimate in estimates if estimate is not None]
    if not fitted:
        return None
    mean = float(np.mean(fitted))
    if not pooled:
        values = tuple(mean if e is None else e.value for e in estimates)
        return RobotDistribution(DistributionKind.ROBOTS, values)
    spread = float(np.std(fitted, ddof=1)) if len(fitted) > 1 else 0.0
    spread = min(spread, (mean - least) / 3)
    if spread == 0.0:
        return constant(mean)
    return RobotDistribution(DistributionKind.NORMAL, (mean, spread), 3 * spread)
