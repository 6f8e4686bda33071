"""The clock that a script sees: what it reads, how it sleeps, what a step takes."""

from __future__ import annotations

import math
import os
import sys
import weakref
from collections.abc import Callable

from rps_compat.clock import real
from rps_compat.clock.scheduler import Scheduler
from rps_compat.clock.threads import State
from rps_compat.clock.ticker import Ticker
from rps_compat.clock.waits import Wait

#: Seconds by which each look moves the clock on.
LOOK = 1e-6


class SimulatedClock(Scheduler):
    """Seconds since the start of a run, moved on by steps and waits.

    Parameters
    ----------
    start
        What ``time.time()`` reads at the start, seconds since 1970. By default the real time.
    charge
        Whether the script's own computing counts, too, by its CPU time. Then a step takes the
        longer of its time step and what the script spent since the last one, and looking at the
        clock is free; without, a script computes in no time.
    longest_wait
        Simulated seconds without a step after which whoever waits is told that it is for ever.

    Attributes
    ----------
    epoch, base : float
        What ``time.time()`` and ``time.monotonic()`` read at the start.
    solo : bool
        Whether a look or a sleep is but an addition: one thread, nothing that happens by itself.
    """

    def __init__(
        self, start: float | None = None, *, charge: bool = False, longest_wait: float = math.inf
    ) -> None:
        self.epoch = real.time() if start is None else start
        self.base = real.monotonic()
        self.charge = charge
        self.solo = False
        self._ticker: Ticker | None = None
        self._resumed, self._cpu = 0.0, real.process_time()
        super().__init__(longest_wait)
        _clocks.add(self)

    def _begin(self) -> None:
        super()._begin()
        self._ticker = None
        self._changed()

    def _changed(self) -> None:
        alone = len(self.threads) == 1 and not self.starting and self.next_deadline() == math.inf
        self.solo = alone and not (self.charge or self.foreign or self.stepper.asks or self.over)
        if not alone and self._ticker is None and not self.over:
            self._ticker = Ticker(self)

    # --- What the script calls ------------------------------------------------------------------

    def read(self, base: float, real_function: Callable[[], float]) -> float:
        """Return the simulated time; to a thread of others the real one.

        Parameters
        ----------
        base : float
            What the clock says at the start of the run, s.
        real_function : callable
            Tells the real time, s.
        """
        if real.get_ident() in self.foreign:
            return real_function()
        me = self.me()
        if me is not self.stepper:
            return base + me.glance(self.elapsed, LOOK)
        with self.lock:
            self._look()
            now = self.elapsed
            late = self.next_deadline() <= now
        if late:
            self.move_to(now)
        return base + now

    def _look(self) -> None:
        if self.charge:
            self._count_computing()
        elif self.busy and self._leash is not None:
            self._go_with_real_time(self.elapsed + LOOK)  # a loop that looks outruns nobody
        else:
            self.elapsed += LOOK

    def sleep(self, seconds: float) -> None:
        """Stand in for ``time.sleep``.

        Parameters
        ----------
        seconds : float
            How long, s of simulated time.

        Raises
        ------
        ValueError, TypeError
            As ``time.sleep`` does.
        Stuck
            The script has slept for too long without a step.
        """
        if seconds < 0 or seconds != seconds:
            raise ValueError("sleep length must be a non-negative number")
        seconds = float(seconds)
        if real.get_ident() in self.foreign:
            real.sleep(seconds)
        else:
            self._sleep(seconds)

    def _sleep(self, seconds: float) -> None:
        me = self.me()
        if me.state is State.OUTSIDE or (not seconds and me is not self.stepper):
            real.sleep(seconds)
        elif me.asks and me is not self.stepper:
            me.asks = False
            with self.outside(me.reason):
                real.sleep(seconds)
        else:
            if me is self.stepper and not seconds:
                self.elapsed += LOOK
            self.wait(seconds)

    def ask(self, reason: str) -> None:
        """Take note that the world outside did not answer yet: it is given real time to do so.

        Parameters
        ----------
        reason : str
            What was asked, in words for people.
        """
        if real.get_ident() not in self.foreign:
            me = self.me()
            me.asks, me.reason = True, reason
            self._changed()

    def wait(self, timeout: float | None, wait: Wait | None = None) -> bool:
        """Wait in simulated time; see :meth:`Scheduler.wait`."""
        if not self.charge or real.get_ident() != self.stepper.ident:
            return super().wait(timeout, wait)
        self._count_computing()
        try:
            return super().wait(timeout, wait)
        finally:  # what others computed meanwhile took its time
            self._cpu = real.process_time()

    # --- Steps ----------------------------------------------------------------------------------

    def advance(self, seconds: float) -> None:
        """Let a step of the running thread take time, from the end of the last one if charged.

        Negative times do not pass.

        Parameters
        ----------
        seconds : float
            Duration of the step, s.
        """
        if self.solo:
            if seconds > 0:
                self.elapsed = self.stepped = self.elapsed + float(seconds)
            return
        self.moves += 1
        begun = self._resumed if self.charge else self.elapsed
        self.move_to(max(begun + float(seconds), self.elapsed))
        self.stepped = self.elapsed
        self.resume()
        self._changed()

    #: As the pace of every Robotarium it is told of each step.
    after_step = advance

    def spent(self) -> float:
        """Seconds that the script computed and waited since the last step, if charged for it."""
        with self.lock:
            self._count_computing()
            return self.elapsed - self._resumed

    def resume(self) -> None:
        """Let the script's own time begin: what was computed since the last look was not its."""
        self._resumed, self._cpu = self.elapsed, real.process_time()

    def _count_computing(self) -> None:
        cpu = real.process_time()
        if self.charge:
            self.elapsed += cpu - self._cpu
        self._cpu = cpu

    def others_step_within(self, seconds: float) -> bool:
        """Whether other threads of the script are there, and a step was made not long ago.

        Parameters
        ----------
        seconds : float
            Not longer ago than this, s of simulated time.
        """
        return len(self.threads) > 1 and self.elapsed - self.stepped < seconds

    # --- In force -------------------------------------------------------------------------------

    def start(self) -> None:
        """Be in force from now on, in the running thread: others that run keep the real time."""
        self.foreign = set(sys._current_frames()) - {real.get_ident()}
        self.over = False
        self._changed()

    def stop(self) -> None:
        """Be in force no more: threads that still wait go on in real time."""
        with self.lock:
            self.over, self.solo = True, False
            if self._ticker is not None:
                self._ticker.stop()
                self._ticker = None
            for thread in self.threads.values():
                if thread.wait is not None:
                    thread.wait.ring()


_clocks: weakref.WeakSet[SimulatedClock] = weakref.WeakSet()


def _after_fork() -> None:
    """Begin anew in a forked process, which has one thread and none of the others' locks."""
    for clock in list(_clocks):
        clock._begin()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
