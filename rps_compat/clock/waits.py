"""A wait in simulated time, as an object that the scheduler and the waiting thread share."""

from __future__ import annotations

import contextlib
import math
import os
import threading
from collections.abc import Callable
from typing import Any, Protocol

from rps_compat.clock import real
from rps_compat.clock.threads import ScriptThread


class Waker(Protocol):
    """Who keeps account of waits, and lets threads go on when these are over.

    Attributes
    ----------
    lock
        Held by whoever asks about waits that may end meanwhile.
    """

    lock: Any

    def wake(self, wait: Wait) -> None:
        """End a wait before its deadline.

        Parameters
        ----------
        wait : Wait
            What a thread waits in; nothing happens if it is over.
        """

    def woken(self, wait: Wait) -> None:
        """Let the thread of a wait that is over go on: it has its turn.

        Parameters
        ----------
        wait : Wait
            What the thread waited in.
        """

    def is_waited(self, wait: Wait) -> bool:
        """Whether a thread of this process waits, or is about to, and can be woken.

        Parameters
        ----------
        wait : Wait
            What the thread waits in; one without a thread counts as about to.
        """


class Wait:
    """One thread waits until it is woken, or simulated time has come to a deadline.

    The thread blocks on a real lock of its own. Whoever ends the wait opens that lock; so does who
    wants the thread to look around, since it is now the one that moves time on.

    Parameters
    ----------
    scheduler : Waker
        Whose time it is.

    Attributes
    ----------
    deadline
        Simulated seconds; infinite for a wait without a limit.
    woken, expired
        Which of the two ended the wait.
    failure
        What to raise in the waiting thread.
    polled
        Whether what the thread waits for may come without a word to the scheduler.
    """

    polled = False

    def __init__(self, scheduler: Waker) -> None:
        self.scheduler = scheduler
        self.thread: ScriptThread | None = None
        self.deadline = math.inf
        self.woken = self.expired = False
        self.failure: BaseException | None = None
        self._lock = real.allocate_lock()
        self._lock.acquire()

    @property
    def over(self) -> bool:
        """Whether nothing keeps the thread any more."""
        return self.woken or self.expired

    def release(self) -> None:
        """Wake the thread: what `threading.Condition` calls when it notifies a waiter."""
        self.scheduler.wake(self)

    def fire(self) -> None:
        """Take note that time has come to the deadline."""
        self.expired = True
        self.scheduler.woken(self)

    def ring(self) -> None:
        """Let the thread look around."""
        with contextlib.suppress(RuntimeError):  # it was rung before, and has not looked yet
            self._lock.release()

    def block(self, seconds: float = -1) -> None:
        """Block until somebody rings, or for some real time.

        Parameters
        ----------
        seconds : float
            How long at most, s of real time; −1 for no limit.
        """
        self._lock.acquire(True, min(seconds, threading.TIMEOUT_MAX))

    def ready(self) -> bool:
        """Whether what a polled wait waits for is there."""
        return False


class PolledWait(Wait):
    """A wait for descriptors of this process, which are written to behind the scheduler's back.

    Parameters
    ----------
    scheduler : Waker
        Whose time it is.
    watch, unwatch
        Add and remove a descriptor among those waited for.
    select
        Waits for them in real time, up to so many seconds; returns the numbers of those ready.
    pipe
        A pipe of the waiting thread's own, by which it is rung.
    """

    polled = True

    def __init__(
        self,
        scheduler: Waker,
        watch: Callable[[int], object],
        unwatch: Callable[[int], object],
        select: Callable[[float | None], set[int]],
        pipe: tuple[int, int],
    ) -> None:
        super().__init__(scheduler)
        self._watch, self._unwatch, self._select, self._pipe = watch, unwatch, select, pipe

    def ring(self) -> None:
        """Let the thread look around."""
        with contextlib.suppress(BlockingIOError):  # full of rings: it will look around
            os.write(self._pipe[1], b".")

    def block(self, seconds: float = -1) -> None:
        """Block until a descriptor is ready, somebody rings, or for some real time."""
        bell = self._pipe[0]
        self._watch(bell)
        try:
            found = self._select(seconds if 0 <= seconds <= threading.TIMEOUT_MAX else None)
        finally:
            self._unwatch(bell)
        if bell in found:
            os.read(bell, 4096)
        if found - {bell}:
            self.scheduler.wake(self)

    def ready(self) -> bool:
        """Whether a descriptor is ready."""
        try:
            return bool(self._select(0) - {self._pipe[0]})
        except (RuntimeError, OSError, ValueError):  # polled by the thread itself, or just closed
            return False
