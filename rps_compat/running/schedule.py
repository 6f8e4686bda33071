"""When a run is interrupted, killed or ended because enough was seen, and how far it is."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, NoReturn

from barrier_certificates.ties import reached
from rps_compat.arena import Arena
from rps_compat.running.plan import RunPlan
from rps_compat.running.watching import Teller

#: How often a script whose time is over gets a KeyboardInterrupt before it is ended.
_PATIENCE = 10


class Enough(BaseException):
    """The run has shown what it was for; not an Exception, so that scripts do not swallow it."""


class Schedule:
    """Counts the steps of a run, and ends it where its plan says so.

    Parameters
    ----------
    plan
        What is to happen when.
    seconds
        Returns the seconds of the run by the clock.
    teller
        Tells whoever watches how far the run is.

    Attributes
    ----------
    steps
        Calls of ``step()`` so far.
    time
        Seconds of the run at the last of them.
    interrupted
        Whether the planned KeyboardInterrupt was raised.
    over_time
        Whether the experiment's time is over.
    seen_enough
        Whether the run has shown what it was for.
    finished
        Whether it called what a script of its generation is to call at its end.
    """

    def __init__(
        self, plan: RunPlan, seconds: Callable[[], float], teller: Teller | None = None
    ) -> None:
        self.plan = plan
        self.steps, self.time = 0, 0.0
        self.interrupted = self.over_time = self.seen_enough = self.finished = False
        self._seconds = seconds
        self._refusals = 0
        self._teller = teller

    def step(self, time: float, arena: Arena) -> None:
        """Take note of a step, and end the run if it is time.

        Parameters
        ----------
        time : float
            Time of the run, s.
        arena : Arena
            The arena, as it is now.

        Raises
        ------
        Enough
            If enough of the run was seen.
        KeyboardInterrupt
            If the plan interrupts the run here.
        """
        plan = self.plan
        self.steps += 1
        self.time = time
        if self._teller is not None:
            self._teller.step(self.steps, time)
        if plan.kill_at is not None and reached(time, plan.kill_at):
            os.kill(os.getpid(), signal.SIGKILL)
        due = plan.interrupt_at is not None and reached(time, plan.interrupt_at)
        if due and not self.interrupted:
            self.interrupted = True
            raise KeyboardInterrupt
        if plan.longest is not None and reached(max(self._seconds(), time), plan.longest):
            self.over_time = True
            self._refusals += 1
            if self._refusals < _PATIENCE:
                raise KeyboardInterrupt
            if plan.kills_deaf:
                os.kill(os.getpid(), signal.SIGKILL)
            raise Enough

    @contextlib.contextmanager
    def listening(self) -> Iterator[None]:
        """Hear of the finishing call, and of the start where that is enough."""
        generation = self.plan.generation
        kind = import_module(f"..v{generation}.robotarium", __package__).Robotarium
        finish = "debug" if generation == 2 else "call_at_scripts_end"
        finishing = getattr(kind, finish)

        def finished(robotarium: Any) -> None:
            self.finished = True
            finishing(robotarium)

        def enough(robotarium: Any) -> NoReturn:
            self.seen_enough = True
            raise Enough

        changes: dict[str, Callable[[Any], None]] = {finish: finished}
        if self.plan.only_start:
            changes["get_poses"] = enough
        before = {name: vars(kind).get(name) for name in changes}
        for name, change in changes.items():
            setattr(kind, name, change)
        try:
            yield
        finally:
            for name, own in before.items():
                if own is None:
                    delattr(kind, name)
                else:
                    setattr(kind, name, own)
