"""How long a step really takes: the testbed's clock as an imperfection.

A script commands once a step and means 33 ms. On the testbed the next slot comes when the loop, the
cameras and the operating system let it: most steps take within a millisecond of the nominal, some a
few milliseconds, and now and then nothing happens for a third of a second or more. The robots go on
in real time meanwhile. They drive on with what they were told last, and brake once they have heard
nothing for half a second (see :class:`~rps_compat.command_effects.Watchdog`).

What the script reads stays as it was: its steps are numbered, and its clock counts nominal steps.
Only the robots' way in a step changes. A long step is driven in parts no longer than the nominal
one, so that lag, delay and watchdog act within it and a turning robot drives an arc.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from barrier_certificates import ties
from rps_compat.distributions import Curve, require

#: Gives the seconds of the parts of one more step.
StepParts = Callable[[], tuple[float, ...]]


@dataclass(frozen=True)
class Clock:
    """Steps last as long as they were measured to, each drawn anew.

    Attributes
    ----------
    quantiles : Curve
        Pairs of a share, from 0 to 1, and the seconds within which that share of the steps is
        over; straight lines between. What is drawn are independent steps: that a testbed catches
        up after a stall is not told.
    """

    quantiles: Curve

    def __post_init__(self) -> None:
        shares = [share for share, _ in self.quantiles.points]
        seconds = [value for _, value in self.quantiles.points]
        require(
            len(shares) > 1 and shares[0] == 0.0 and shares[-1] == 1.0,
            "clock.quantiles",
            shares,
            "shares from 0 to 1",
        )
        require(
            seconds == sorted(seconds), "clock.quantiles", seconds, "seconds that do not decrease"
        )

    @property
    def mean(self) -> float:
        """Seconds of a step on average."""
        shares, seconds = (np.array(axis) for axis in zip(*self.quantiles.points, strict=True))
        return float(np.sum(np.diff(shares) * (seconds[1:] + seconds[:-1]) / 2))

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> StepParts:
        """Return what draws one step after the other.

        Parameters
        ----------
        robots : int
            Number of robots, N; time is the same for all.
        time_step : float
            Nominal duration of a step, s; the longest of a part.
        rng : Generator
            Where this effect draws from, now and in every step.
        """

        def parts() -> tuple[float, ...]:
            seconds = float(self.quantiles(np.array([rng.random()]))[0])  # type: ignore[index]
            number = max(1, -ties.whole(-seconds / time_step))
            return (seconds / number,) * number

        return parts
