"""Moves simulated time on where the thread that should do so hangs, or is busy otherwise."""

from __future__ import annotations

import contextlib
import weakref

from rps_compat.clock import real
from rps_compat.clock.scheduler import Scheduler
from rps_compat.clock.threads import IN_C, State, cpu_seconds, sleeps

#: Real seconds between two looks.
TICK = 0.01
#: Looks in a row that find the stepper asleep before it is believed to hang in an unknown wait.
HANGS = 5
#: Real seconds by which time may fall behind while the stepper computes or polls.
BEHIND = 1.0


class Ticker:
    """A thread that wakes who sleeps although nobody steps; Python's list of threads lacks it.

    Parameters
    ----------
    scheduler : Scheduler
        Whose threads it looks after; it does not keep it alive.
    """

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = weakref.ref(scheduler)
        self._bell = real.allocate_lock()
        self._bell.acquire()
        self._last = real.monotonic()
        self._moved = (scheduler.moves, self._last, scheduler.elapsed)
        self._asleep = 0
        self._cpu: float | None = None
        real.start_new_thread(self._run, ())

    def stop(self) -> None:
        """End the thread."""
        with contextlib.suppress(RuntimeError):
            self._bell.release()

    def _run(self) -> None:
        while not self._bell.acquire(True, TICK):
            scheduler = self._scheduler()
            if scheduler is None or scheduler.over:
                return
            now = real.monotonic()
            with scheduler.lock:
                self._tick(scheduler, now)
            self._last = now

    def _tick(self, scheduler: Scheduler, now: float) -> None:
        stepper = scheduler.stepper
        passed = now - self._last
        if stepper.state is State.OUTSIDE:
            scheduler.elapsed += max(now - stepper.since, 0.0)
            stepper.since = now
        elif stepper.engine is not None or stepper.state is State.WAITING:
            self._asleep = 0
            self._moved = (scheduler.moves, now, scheduler.elapsed)
            return
        elif self._hangs(scheduler):
            scheduler.elapsed += passed
            scheduler.real_reasons[IN_C] = None
        elif self._is_behind(scheduler, now):
            scheduler.elapsed += passed
            scheduler.real_reasons["a main thread that computes while others sleep"] = None
        else:
            return
        while scheduler.fire_next():
            pass

    def _hangs(self, scheduler: Scheduler) -> bool:
        """Whether the stepper waits for something that the scheduler was not told of."""
        native = scheduler.stepper.native
        cpu = cpu_seconds(native)
        still = cpu is not None and cpu == self._cpu and sleeps(native)
        self._asleep = self._asleep + 1 if still else 0
        self._cpu = cpu
        return self._asleep >= HANGS

    def _is_behind(self, scheduler: Scheduler, now: float) -> bool:
        """Whether the stepper has long done something other than stepping or waiting."""
        moves, then, elapsed = self._moved
        if moves != scheduler.moves:
            self._moved = (scheduler.moves, now, scheduler.elapsed)
            return False
        return now - then - (scheduler.elapsed - elapsed) > BEHIND
