"""Numbers that differ from robot to robot, or with speed: what realism profiles are made of.

A :class:`RobotDistribution` is a parameter that every robot gets its own value of, once a run:
one constant for all, uniform between two bounds, normal with an optional cut, or a list with one
value a robot. A :class:`Curve` is a factor that depends on how fast the robot is told to go.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.word_enum import WordEnum
from rps_compat.errors import RobotariumError

Array = NDArray[np.float64]


class ProfileError(RobotariumError, ValueError):
    """A realism profile is not what it should be; the message names the entry and the way out."""


def require(condition: bool, name: str, got: object, expected: str) -> None:
    """Refuse an entry of a profile that does not meet its condition.

    Parameters
    ----------
    condition : bool
        Whether it does.
    name : str
        The entry, for the error.
    got : object
        What stands there.
    expected : str
        What may stand there.

    Raises
    ------
    ProfileError
        If the condition is False.
    """
    if not condition:
        raise ProfileError(f"{name}: expected {expected}, got {got!r}")


class DistributionKind(WordEnum):
    """How the robots' values come about; what profiles call it."""

    CONSTANT = "constant"
    UNIFORM = "uniform"
    NORMAL = "normal"
    #: One value a robot, listed.
    ROBOTS = "robots"


#: How many numbers each takes; None for any.
_NUMBERS = {
    DistributionKind.CONSTANT: 1,
    DistributionKind.UNIFORM: 2,
    DistributionKind.NORMAL: 2,
    DistributionKind.ROBOTS: None,
}


@dataclass(frozen=True)
class RobotDistribution:
    """One value a robot, drawn at the start of a run.

    Attributes
    ----------
    kind : DistributionKind
        How they come about.
    values : tuple of float
        The constant; low and high; mean and standard deviation; one value a robot.
    limit : float
        Largest distance of a normal value from its mean.
    """

    kind: DistributionKind
    values: tuple[float, ...]
    limit: float = np.inf

    def __post_init__(self) -> None:
        numbers = _NUMBERS[self.kind] or max(len(self.values), 1)
        require(len(self.values) == numbers, self.kind, self.values, f"{numbers} number(s)")
        require(bool(np.isfinite(self.values).all()), self.kind, self.values, "finite numbers")
        if self.kind is DistributionKind.UNIFORM:
            require(self.values[0] <= self.values[1], "uniform", self.values, "[low, high]")
        if self.kind is DistributionKind.NORMAL:
            require(self.values[1] >= 0, "normal", self.values, "[mean, sigma] with sigma ≥ 0")
            least = self.values[1] / 100  # what lies beyond is drawn again
            require(self.limit > least, "limit", self.limit, f"more than sigma/100, {least:g}")
        require(self.limit > 0, "limit", self.limit, "more than 0")

    def draw(self, robots: int, rng: np.random.Generator) -> Array:
        """Return one value a robot.

        Parameters
        ----------
        robots : int
            Number of robots, N.
        rng : Generator
            Where they are drawn from.

        Returns
        -------
        (N,) array
            The values, in the entry's unit.

        Raises
        ------
        ProfileError
            Where the profile lists another number of robots than the run has.
        """
        if hasattr(rng, "each"):  # many teams, of which each draws for itself
            return cast(Array, rng.each(robots, lambda one, number: self.draw(number, one)))
        if self.kind is DistributionKind.CONSTANT:
            return np.full(robots, self.values[0])
        if self.kind is DistributionKind.UNIFORM:
            return rng.uniform(self.values[0], self.values[1], robots)
        if self.kind is DistributionKind.ROBOTS:
            if len(self.values) != robots:
                raise ProfileError(
                    f"the profile lists values of {len(self.values)} robots, but the run has"
                    f" {robots}; list {robots}, or give a distribution such as"
                    " { uniform = [low, high] }"
                )
            return np.array(self.values)
        mean, sigma = self.values
        out = rng.normal(mean, sigma, robots)
        beyond = np.abs(out - mean) > self.limit
        while beyond.any():
            out[beyond] = rng.normal(mean, sigma, int(beyond.sum()))
            beyond = np.abs(out - mean) > self.limit
        return out

    def require_at_least(self, least: float, name: str) -> None:
        """Refuse a distribution that could give too small a value (a normal's 3 σ).

        Parameters
        ----------
        least : float
            The smallest that makes sense, in the entry's unit.
        name : str
            The entry, for the error.

        Raises
        ------
        ProfileError
            If a value below could be drawn.
        """
        low = min(self.values)
        if self.kind is DistributionKind.NORMAL:
            low = self.values[0] - min(3 * self.values[1], self.limit)
        require(low >= least, name, self.values, f"values of at least {least:g}")


def constant(value: float) -> RobotDistribution:
    """Return the distribution that is one value for every robot.

    Parameters
    ----------
    value : float
        The value, in the entry's unit.
    """
    return RobotDistribution(DistributionKind.CONSTANT, (value,))


@dataclass(frozen=True)
class Curve:
    """A positive value that depends on another: linear between points, constant beyond; empty is 1.

    Attributes
    ----------
    points : tuple of (float, float)
        At what, rising, and the value there: a speed and a factor, a share and seconds.
    """

    points: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        if not self.points:
            return
        speeds, factors = np.array(self.points).T
        require(bool((np.diff(speeds) > 0).all()), "curve", self.points, "rising first numbers")
        require(bool((factors > 0).all()), "curve", self.points, "values above 0")
        require(bool(np.isfinite(self.points).all()), "curve", self.points, "finite numbers")

    @property
    def largest(self) -> float:
        """Largest factor."""
        return max((factor for _, factor in self.points), default=1.0)

    def __call__(self, speeds: Array) -> Array | float:
        """Return the factor at some speeds.

        Parameters
        ----------
        speeds : (N,) array
            Speeds without their sign, in the unit of the points.

        Returns
        -------
        float or (N,) array
            The factors; 1.0 where there are no points.
        """
        if not self.points:
            return 1.0
        at, factors = zip(*self.points, strict=True)
        out: Array = np.interp(speeds, at, factors)
        return out


#: The curve that changes nothing.
FLAT = Curve()
#: The factor that changes nothing, for every robot.
ONE = constant(1.0)
