"""Imperfections between a command and the motors: the radio and the motor controller's firmware.

As in :mod:`rps_compat.motor_effects`, each is a frozen dataclass whose ``begin`` draws a run's
numbers and returns a function of one step, in which all that a run remembers lives.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import reached, short_of
from rps_compat.distributions import FLAT, Curve, RobotDistribution, require
from rps_compat.motor_effects import OFF_SPEED, OFF_TURN, Array, MotorEffect, MotorStage


@dataclass(frozen=True)
class CommandLoss(MotorEffect):
    """A command misses its robot, which goes on with the last that arrived.

    Attributes
    ----------
    probability : float
        Of each command to each robot, from 0 to 1.
    """

    probability: float

    def __post_init__(self) -> None:
        require(0 <= self.probability <= 1, "command_loss.probability", self.probability, "0 to 1")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Start with robots that stand still and have heard nothing."""
        held, silence = np.zeros((2, robots)), np.zeros(robots)

        def lose(velocities: Array, age: Array, seconds: float) -> Array:
            arrived = (age == 0) & (rng.random(robots) >= self.probability)
            held[:, arrived] = velocities[:, arrived]
            silence[:] = np.where(arrived, 0.0, silence + seconds)
            age[:] = silence
            out: Array = held.copy()
            return out

        return lose


@dataclass(frozen=True)
class Watchdog(MotorEffect):
    """A robot brakes that has heard no command for a while.

    Attributes
    ----------
    seconds : float
        Of silence; the testbed brakes after 0.5.
    """

    seconds: float = 0.5

    def __post_init__(self) -> None:
        require(self.seconds > 0, "watchdog.seconds", self.seconds, "more than 0 s")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Start with no silence."""

        def brake(velocities: Array, age: Array, seconds: float) -> Array:
            silent = reached(age, self.seconds)
            return _stopped(velocities, silent)

        return brake


@dataclass(frozen=True)
class DeadTime(MotorEffect):
    """A command takes effect only some time after it was given.

    The delay is any number of seconds: in the step in which a command takes over, old and new
    share the step in proportion to their times in it.

    Attributes
    ----------
    seconds : RobotDistribution
        Per robot.
    by_speed : Curve
        Factor on it, at the commanded forward speed in m/s.
    """

    seconds: RobotDistribution
    by_speed: Curve = FLAT

    def __post_init__(self) -> None:
        self.seconds.require_at_least(0.0, "dead_time.seconds")
        longest = max(self.seconds.values) * self.by_speed.largest
        require(longest <= 60.0, "dead_time.seconds", self.seconds.values, "at most 60 s in all")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's dead time; the past is standing still."""
        late = self.seconds.draw(robots, rng)
        most = float(late.max(initial=0.0)) * self.by_speed.largest
        # Enough where steps are half as long as they should be; beyond, the oldest goes on.
        length = 2 * math.ceil(most / time_step) + 2
        past = np.zeros((length, 2, robots))
        ages = np.full((length + 1, 1), np.inf)  # how long ago each began, and the last one ended
        ages[-1] = 0.0

        def delay(velocities: Array, age: Array, seconds: float) -> Array:
            past[:-1], past[-1] = past[1:], velocities
            ages[1:-2] = ages[2:-1] + seconds
            ages[-2] = seconds
            behind = late * self.by_speed(np.abs(velocities[0]))
            # What acts now was commanded from `behind` + seconds until `behind` ago.
            held = np.minimum(ages[:-1], behind + seconds) - np.maximum(ages[1:], behind)
            out: Array = np.einsum("kn,kcn->cn", np.maximum(held, 0.0) / seconds, past)
            return out

        return delay


@dataclass(frozen=True)
class DeadBand(MotorEffect):
    """Motors stay off for commands below both thresholds.

    Attributes
    ----------
    speed : float
        Of |v|, m/s.
    turn : float
        Of |ω|, rad/s.
    """

    speed: float = OFF_SPEED
    turn: float = OFF_TURN

    def __post_init__(self) -> None:
        require(self.speed >= 0, "dead_band.speed", self.speed, "0 m/s or more")
        require(self.turn >= 0, "dead_band.turn", self.turn, "0 rad/s or more")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Return what one step does; there is nothing to remember."""

        def rest(velocities: Array, age: Array, seconds: float) -> Array:
            off = short_of(np.abs(velocities[0]), self.speed) & short_of(
                np.abs(velocities[1]), self.turn
            )
            return _stopped(velocities, off)

        return rest


def _stopped(velocities: Array, which: NDArray[np.bool_]) -> Array:
    """Return velocities (2, N) with those of robots `which` (N,) set to zero."""
    if not which.any():
        return velocities
    out: Array = velocities.copy()
    out[:, which] = 0.0
    return out
