"""A fitted number and how sure it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: 99 % of a normal distribution lie within so many standard deviations.
Z = 2.575829


@dataclass(frozen=True)
class Estimate:
    """A fitted number with its 99 % interval.

    Attributes
    ----------
    value, low, high : float
        In the quantity's unit.
    """

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.4g} ({self.low:.4g} to {self.high:.4g})"

    @classmethod
    def around(cls, value: float, spread: float, least: float = -math.inf) -> Estimate:
        """Return the estimate with a normal error.

        Parameters
        ----------
        value : float
            What was fitted.
        spread : float
            Standard deviation of the error, in the same unit.
        least : float
            No value is smaller, and so the interval begins here or later.
        """
        value = float(value)
        return cls(value, max(least, value - Z * float(spread)), value + Z * float(spread))
