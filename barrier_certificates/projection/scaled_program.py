"""Programs of large numbers, put into a unit of speed in which tolerances mean something.

A row holds when it is broken by no more than 1e-9 m/s. That is meant for robots, which drive at
decimetres a second. Where nothing limits speeds, a firm certificate can ask robots that overlap to
part at a hundred kilometres a second, and 1e-9 m/s is less than the rounding of such numbers: no
answer holds, the best one is refused, and a state that has a safe velocity passes for one that has
none. The program is the same in any unit. So it is solved in one of its own: bounds and command are
divided by a speed, the answer is multiplied by it.

That speed is the largest excess of a row at the command, since no answer is nearer to the command
than that; but no more than the top speed of the robots, since no answer is faster. Up to 10 m/s the
unit is 1 m/s, so that nothing changes for robots.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray
from barrier_certificates.rows.row_set import Rows

TOLERANCE = 1e-9
"""A row holds when it is broken by no more than this, in the unit of the program."""

_FAST = 10.0  # m/s
_FAR = 1e5
"""Beyond this many times the top speed a command says no more than its direction."""
_LARGE = 1e5  # m/s; rounding of such numbers would hide what robots that have a top speed can do


class QuadraticProgram(NamedTuple):
    """``min ‖v − target‖²`` over rows, in a unit of speed.

    Attributes
    ----------
    target : (2N,) array
        The commands, robot by robot.
    rows : Rows
        What must hold.
    excess : (m,) array
        ``rows.excess(target)``.
    worst : float
        The largest of it; zero where there are no rows.
    top_speed : float
        No robot can be faster; infinite where nothing limits speeds.
    unit : float
        One unit of speed in m/s.
    """

    target: FloatArray
    rows: Rows
    excess: FloatArray
    worst: float
    top_speed: float
    unit: float = 1.0

    @classmethod
    def of(cls, target: FloatArray, rows: Rows, top_speed: float) -> QuadraticProgram:
        """Return the program for a target and rows, in m/s.

        Parameters
        ----------
        target : (size,) array
            The command, m/s.
        rows : Rows
            What must hold.
        top_speed : float
            No robot can be faster, m/s.
        """
        excess = rows.excess(target)
        # argmax costs a tenth of max on small arrays.
        worst = float(excess[excess.argmax()]) if excess.shape[0] else 0.0
        return cls(target, rows, excess, worst, top_speed)

    def scaled(self) -> QuadraticProgram:
        """Return the same program in a unit of speed that suits its numbers."""
        if self.worst <= _FAST:
            return self
        near = self._brought_near()
        unit = min(near.worst, self.top_speed)
        if unit <= _FAST:
            return near
        rows = self.rows.with_bound(self.rows.bound / unit)
        speeds = (near.worst / unit, self.top_speed / unit)
        return QuadraticProgram(near.target / unit, rows, near.excess / unit, *speeds, unit)

    def _brought_near(self) -> QuadraticProgram:
        """Return it with no command longer than 100,000 times the top speed, if that is finite."""
        if self.worst <= _LARGE or not math.isfinite(self.top_speed):
            return self
        limit = _FAR * self.top_speed
        x, y = self.target.reshape(-1, 2).T
        shorter = np.repeat(limit / np.maximum(np.hypot(x, y), limit), 2)
        return QuadraticProgram.of(self.target * shorter, self.rows, self.top_speed)

    def is_out_of_reach(self) -> bool:
        """Whether some row asks for more than robots at top speed can do, and cannot hold.

        A row has unit norm, so two robots change its left side by √2 times their speed at most.
        """
        if not math.isfinite(self.top_speed):
            return False
        bound = self.rows.bound
        furthest = float(bound[bound.argmin()])
        return furthest < -(1.0 + TOLERANCE) * math.sqrt(2.0) * self.top_speed
