"""Imperfections between a pose and its measurement: the camera and the tracker.

Each is a frozen dataclass that says how large the effect is; its ``begin`` draws a run's numbers
and returns a function of one measurement.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rps_compat.distributions import FLAT, Curve, RobotDistribution, require
from rps_compat.kinematics import wrap

Array = NDArray[np.float64]
#: Takes poses (3, N) and true forward speeds (N,); gives the poses (3, N) handed on.
TrackingStage = Callable[[Array, Array], Array]


class TrackingEffect(Protocol):
    """An imperfection between pose and measurement."""

    @abstractmethod
    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Draw this run's numbers and return what one measurement does.

        Parameters
        ----------
        robots : int
            Number of robots, N.
        time_step : float
            Duration of a step, s.
        rng : Generator
            Where this effect draws from, now and in every step.

        Returns
        -------
        callable
            From poses (3, N), m and rad, and forward speeds (N,), m/s, to the poses after this
            effect.
        """


@dataclass(frozen=True)
class HeadingOffset(TrackingEffect):
    """The marker sits askew on the robot, so its tracked heading is off by a constant.

    Attributes
    ----------
    radians : RobotDistribution
        Per robot.
    """

    radians: RobotDistribution

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Draw each robot's offset."""
        offset = self.radians.draw(robots, rng)

        def skew(poses: Array, speeds: Array) -> Array:
            out: Array = poses.copy()
            out[2] = wrap(out[2] + offset)
            return out

        return skew


@dataclass(frozen=True)
class TrackingJitter(TrackingEffect):
    """White noise on tracked poses, in the robot's own directions.

    Attributes
    ----------
    along, lateral : float
        Standard deviations along and across the heading, metres.
    heading : float
        Standard deviation, radians.
    by_speed : Curve
        Factor on `along`, at the true forward speed in m/s.
    """

    along: float = 0.0
    lateral: float = 0.0
    heading: float = 0.0
    by_speed: Curve = FLAT

    def __post_init__(self) -> None:
        for name in ("along", "lateral", "heading"):
            require(getattr(self, name) >= 0, f"tracking_jitter.{name}", getattr(self, name), "≥ 0")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Return what one measurement does; nothing is drawn before the first."""

        def jitter(poses: Array, speeds: Array) -> Array:
            along, lateral, heading = rng.standard_normal((3, robots))
            along *= self.along * self.by_speed(speeds)
            lateral *= self.lateral
            cosine, sine = np.cos(poses[2]), np.sin(poses[2])
            out = np.empty_like(poses)
            out[0] = poses[0] + cosine * along - sine * lateral
            out[1] = poses[1] + sine * along + cosine * lateral
            out[2] = wrap(poses[2] + self.heading * heading)
            return out

        return jitter


@dataclass(frozen=True)
class TrackingDropout(TrackingEffect):
    """The tracker loses a robot now and then, and repeats its last pose meanwhile.

    Attributes
    ----------
    probability : float
        That a robot is lost, per robot and measurement.
    seconds : float
        How long it stays lost, on average (exponential).
    """

    probability: float
    seconds: float = 0.1

    def __post_init__(self) -> None:
        name = "tracking_dropout"
        require(0 <= self.probability <= 1, f"{name}.probability", self.probability, "0 to 1")
        require(self.seconds > 0, f"{name}.seconds", self.seconds, "more than 0 s")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Start with every robot in sight."""
        last: Array | None = None
        until = np.zeros(robots)
        time = 0.0

        def drop(poses: Array, speeds: Array) -> Array:
            nonlocal last, time
            chance, length = rng.random(robots), rng.exponential(self.seconds, robots)
            if last is None:  # the tracker has to see a robot once before it can lose it
                last = poses.copy()
            else:
                starts = (until <= time) & (chance < self.probability)
                until[starts] = time + length[starts]
                seen = until <= time
                last[:, seen] = poses[:, seen]
            time += time_step
            out: Array = last.copy()
            return out

        return drop
