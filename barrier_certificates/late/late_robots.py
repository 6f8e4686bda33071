"""What is known of robots that answer late: ranges, one for all robots of a team."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass

from barrier_certificates import checks
from barrier_certificates.certificate_errors import ParameterError

__all__ = ["LateRobots", "Range"]

Range = tuple[float, float]
"""The least and the greatest value of a robot of the team."""


@dataclass(frozen=True)
class LateRobots:
    """How late, how exactly and how noisily robots answer, and how exactly they are seen.

    Each robot has numbers of its own within the ranges, which do not change while commands are in
    flight. The defaults are robots that obey at once, exactly, and are seen exactly.

    Parameters
    ----------
    dead_time : (least, greatest)
        From a command to its first effect, s.
    lag : (least, greatest)
        Time constant with which speeds then approach it, s.
    speed_gain, turn_gain : (least, greatest)
        Speed and turn rate driven, as parts of those commanded.
    speed_noise, turn_noise : float
        Largest error of the speed (m/s) and turn rate (rad/s) driven in a step, new in each.
    turn_bias : float
        Largest constant error of the turn rate while a robot drives, rad/s.
    position_error : float
        How far a tracked position may be off, m.
    heading_error : float
        How far a tracked heading may be off, rad.
    longest_step : float
        Longest time for which robots drive on by one command, s; zero stands for the time step.
    told : bool
        Whether the certificate is told how long steps really took, where these differ.
    unbounded : tuple of str
        What has no bound, in words, so that nothing can be guaranteed.

    Raises
    ------
    ParameterError
        If a number makes no sense.
    """

    _: KW_ONLY
    dead_time: Range = (0.0, 0.0)
    lag: Range = (0.0, 0.0)
    speed_gain: Range = (1.0, 1.0)
    turn_gain: Range = (1.0, 1.0)
    speed_noise: float = 0.0
    turn_noise: float = 0.0
    turn_bias: float = 0.0
    position_error: float = 0.0
    heading_error: float = 0.0
    longest_step: float = 0.0
    told: bool = True
    unbounded: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("dead_time", "lag", "speed_gain", "turn_gain"):
            least, greatest = getattr(self, name)
            if not (0.0 <= least <= greatest < math.inf):
                raise ParameterError(
                    f"{name} is {getattr(self, name)!r}; expected (least, greatest), not negative"
                )
        checks.positive("least speed_gain", self.speed_gain[0])
        checks.positive("least turn_gain", self.turn_gain[0])
        for name in (
            "speed_noise",
            "turn_noise",
            "turn_bias",
            "position_error",
            "heading_error",
            "longest_step",
        ):
            checks.not_negative(name, getattr(self, name))

    @property
    def delay(self) -> float:
        """Dead time and lag that predictions are made with, added up: the middles, s."""
        return middle(self.dead_time) + middle(self.lag)

    @property
    def gain(self) -> float:
        """The largest of all gains."""
        return max(self.speed_gain[1], self.turn_gain[1])


def middle(limits: Range) -> float:
    """Return the middle of a range, which predictions are made with.

    Parameters
    ----------
    limits : (least, greatest)
        Of any unit.
    """
    return 0.5 * (limits[0] + limits[1])


def half(limits: Range) -> float:
    """Return how far a value may be from the middle of its range.

    Parameters
    ----------
    limits : (least, greatest)
        Of any unit.
    """
    return 0.5 * (limits[1] - limits[0])
