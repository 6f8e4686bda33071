"""When the next step may begin: in real time, so many times as fast, as fast as it computes, held.

A step has a slot of its time step divided by the speed. A loop that is late starts its next slot
at once, as on the testbed: nothing is caught up.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

#: Real seconds over which the speed that is really reached is measured.
_WINDOW = 1.5


@dataclass
class WatchPace:
    """The pace of one run.

    Attributes
    ----------
    factor : float or None
        How many times as fast as real time; None is as fast as it computes.
    paused : bool
        Whether the simulation is held.
    steps_left : int
        How many steps it may drive all the same.
    """

    factor: float | None = 1.0
    paused: bool = False
    steps_left: int = 0
    _slot: float = -math.inf
    _seen: deque[tuple[float, float]] = field(default_factory=deque)

    def go(self) -> None:
        """Go on."""
        self.paused, self.steps_left = False, 0
        self._begin()

    def pause(self) -> None:
        """Hold the simulation."""
        self.paused, self.steps_left = True, 0
        self._begin()

    def step(self, steps: int) -> None:
        """Let a held simulation drive some steps; one that runs is held after them.

        Parameters
        ----------
        steps : int
            How many.
        """
        self.paused, self.steps_left = True, steps
        self._begin()

    def run_at(self, factor: float | None) -> None:
        """Run at another speed.

        Parameters
        ----------
        factor : float or None
            How many times as fast as real time; None is as fast as it computes.
        """
        self.factor = factor
        self._begin()

    def _begin(self) -> None:
        self._slot = -math.inf
        self._seen.clear()

    def wait(self, now: float) -> float:
        """Return for how many real seconds the next step has to wait; infinity while held.

        Parameters
        ----------
        now : float
            Real time, s.
        """
        if self.paused and not self.steps_left:
            return math.inf
        return 0.0 if self.factor is None else max(self._slot - now, 0.0)

    def stepped(self, time: float, time_step: float, now: float) -> None:
        """Take note that a step begins.

        Parameters
        ----------
        time, time_step : float
            Of the run, and how long the step is, s.
        now : float
            Real time, s.
        """
        self.steps_left = max(self.steps_left - 1, 0)
        if self.factor is not None:
            begun = now if math.isinf(self._slot) else self._slot
            self._slot = max(begun + time_step / self.factor, now)
        self._seen.append((now, time))
        while now - self._seen[0][0] > _WINDOW:
            self._seen.popleft()

    @property
    def reached(self) -> float | None:
        """How many times as fast as real time it really runs; None where that is not known yet."""
        (then, before), (now, time) = (
            (self._seen[0], self._seen[-1]) if self._seen else ((0, 0),) * 2
        )
        return (time - before) / (now - then) if now - then > 0.3 * _WINDOW else None
