"""Imperfections between a command that has arrived and the motion: motors, wheels, floor.

Each is a frozen dataclass that says how large the effect is. Its ``begin`` draws a run's numbers
and returns a function of one step, so that all that a run remembers (a queue of late commands, a
filter's state) lives in that function and a profile can be used for any number of runs.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import reached
from rps_compat.distributions import FLAT, ONE, Curve, RobotDistribution, require
from rps_compat.testbed import GRITSBOT_X

Array = NDArray[np.float64]
#: Takes commands (2, N), each robot's seconds since its last command (N,), which it may change in
#: place, and for how many seconds they are driven; gives the commands (2, N) handed on.
MotorStage = Callable[[Array, Array, float], Array]

#: The GTernal firmware switches its motors off below both.
OFF_SPEED, OFF_TURN = 1e-4, 0.01


class MotorEffect(Protocol):
    """An imperfection between command and motion."""

    @abstractmethod
    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw this run's numbers and return what one step does.

        Parameters
        ----------
        robots : int
            Number of robots, N.
        time_step : float
            Nominal duration of a step, s.
        rng : Generator
            Where this effect draws from, now and in every step.

        Returns
        -------
        callable
            From velocities (2, N), m/s and rad/s, the age of each command (N,), s, and the time
            for which they are driven, s, to the velocities after this effect, on average over it.
        """


@dataclass(frozen=True)
class Gains(MotorEffect):
    """Robots drive and turn a little faster or slower than they are told.

    Attributes
    ----------
    speed, turn : RobotDistribution
        Factors on v and ω, per robot.
    by_speed, by_turn : Curve
        Further factors, at the commanded |v| in m/s and |ω| in rad/s.
    """

    speed: RobotDistribution = ONE
    turn: RobotDistribution = ONE
    by_speed: Curve = FLAT
    by_turn: Curve = FLAT

    def __post_init__(self) -> None:
        self.speed.require_at_least(0.0, "gains.speed")
        self.turn.require_at_least(0.0, "gains.turn")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's two gains."""
        speed, turn = self.speed.draw(robots, rng), self.turn.draw(robots, rng)

        def scale(velocities: Array, age: Array, seconds: float) -> Array:
            out = np.empty_like(velocities)
            out[0] = speed * self.by_speed(np.abs(velocities[0])) * velocities[0]
            out[1] = turn * self.by_turn(np.abs(velocities[1])) * velocities[1]
            return out

        return scale


@dataclass(frozen=True)
class Lag(MotorEffect):
    """Speeds approach what is commanded exponentially.

    The step is integrated exactly: what is handed on is the mean velocity over it.

    Attributes
    ----------
    seconds : RobotDistribution
        Time constant, per robot.
    by_speed : Curve
        Factor on it, at the commanded forward speed in m/s.
    """

    seconds: RobotDistribution
    by_speed: Curve = FLAT

    def __post_init__(self) -> None:
        self.seconds.require_at_least(0.0, "lag.seconds")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's time constant; start at rest."""
        base = self.seconds.draw(robots, rng)
        state = np.zeros((2, robots))

        def follow(velocities: Array, age: Array, seconds: float) -> Array:
            ratio = np.maximum(base * self.by_speed(np.abs(velocities[0])) / seconds, 1e-9)
            left = np.exp(-1 / ratio)
            gap = state - velocities
            state[:] = velocities + left * gap
            out: Array = velocities + ratio * (1 - left) * gap
            return out

        return follow


@dataclass(frozen=True)
class WheelSlew(MotorEffect):
    """A wheel cannot change its speed faster than its motor allows.

    Attributes
    ----------
    limit : float
        Largest change of a wheel's speed, rad/s².
    """

    limit: float

    def __post_init__(self) -> None:
        require(self.limit > 0, "wheel_slew.limit", self.limit, "more than 0 rad/s²")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Start at rest."""
        # Both wheels, times R: v ∓ ω L/2.
        most = self.limit * GRITSBOT_X.wheel_radius
        half = GRITSBOT_X.base_length / 2
        rim = np.zeros((2, robots))

        def slew(velocities: Array, age: Array, seconds: float) -> Array:
            v, w = velocities[0], half * velocities[1]
            change = most * seconds
            rim[:] += np.clip(np.stack([v - w, v + w]) - rim, -change, change)
            return np.stack([(rim[0] + rim[1]) / 2, (rim[1] - rim[0]) / (2 * half)])

        return slew


@dataclass(frozen=True)
class TurnBias(MotorEffect):
    """A robot that is told to drive straight drives a wide curve.

    Attributes
    ----------
    rate : RobotDistribution
        rad/s, per robot and run, while the motors are on.
    """

    rate: RobotDistribution

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's bias."""
        rate = self.rate.draw(robots, rng)

        def turn(velocities: Array, age: Array, seconds: float) -> Array:
            out: Array = velocities.copy()
            out[1] += np.where(_on(velocities), rate, 0.0)
            return out

        return turn


@dataclass(frozen=True)
class Disturbance(MotorEffect):
    """What the model does not explain: white noise on both velocities while the motors are on.

    Attributes
    ----------
    speed, turn : float
        Standard deviations per nominal step, m/s and rad/s; over a shorter time, in proportion to
        its inverse square root, they are larger.
    """

    speed: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        require(self.speed >= 0, "disturbance.speed", self.speed, "0 m/s or more")
        require(self.turn >= 0, "disturbance.turn", self.turn, "0 rad/s or more")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Return what one step does; nothing is drawn before the first."""
        scale = np.array([[self.speed], [self.turn]])

        def disturb(velocities: Array, age: Array, seconds: float) -> Array:
            noise = math.sqrt(time_step / seconds) * scale * rng.standard_normal((2, robots))
            out: Array = velocities + np.where(_on(velocities), noise, 0.0)
            return out

        return disturb


def _on(velocities: Array) -> NDArray[np.bool_]:
    """Whose motors turn, (N,), at velocities (2, N)."""
    on: NDArray[np.bool_] = reached(np.abs(velocities[0]), OFF_SPEED) | reached(
        np.abs(velocities[1]), OFF_TURN
    )
    return on
