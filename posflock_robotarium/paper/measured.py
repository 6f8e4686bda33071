"""What a claim is judged by: a number, and the interval in which it could as well lie.

A number over seeds is known only as well as its seeds tell it: a share gets Wilson's interval, a
median a bootstrap interval, both 95 % (:mod:`posflock_robotarium.alignment.intervals`).  A number
that no seed changes is its own interval.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.intervals import median_interval, told_interval

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """A number, and how far it can be trusted.

    Attributes
    ----------
    value : float
        What was measured, in the unit of whoever asks; NaN where it could not be.
    interval : pair of float, optional
        The ends of its 95 % interval, the smaller first; the number twice where no seed changes
        it, None where too few seeds tell one.
    runs : int, optional
        Seeds that it is from; None where no seed changes it.
    """

    value: float
    interval: tuple[float, float] | None
    runs: int | None = None

    @property
    def text(self) -> str:
        """The number, and its interval in brackets where it is one: ``0.96 [0.902, 0.984]``."""
        return f"{self.value:.3g}{self.brackets}"

    @property
    def brackets(self) -> str:
        """The interval after a blank; empty where there is none, or no seed changes the number."""
        if self.interval is None or self.runs is None:
            return ""
        low, high = self.interval
        return f" [{low:.3g}, {high:.3g}]"


def exact(value: float) -> Measured:
    """Return a number that no seed changes.

    Parameters
    ----------
    value : float
        In any unit.
    """
    return Measured(float(value), (float(value), float(value)))


def median_of(values: Floats) -> Measured:
    """Return the median of a number over seeds, with its bootstrap interval.

    Parameters
    ----------
    values : (B,) array
        The number of each seed, in any unit; infinite ones count, one NaN makes all unknown.
    """
    low, high = median_interval(values)
    interval = None if np.isnan(low) or np.isnan(high) else (low, high)
    return Measured(float(np.median(values)), interval, len(values))


def share_of(hits: NDArray[np.bool_]) -> Measured:
    """Return the share of seeds at which something is so, with its Wilson interval.

    Parameters
    ----------
    hits : (B,) boolean array
        Whether it is, at each seed.
    """
    successes, runs = int(np.count_nonzero(hits)), len(hits)
    return Measured(successes / runs, told_interval(successes, runs), runs)
