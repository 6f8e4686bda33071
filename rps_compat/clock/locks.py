"""Stand-ins for ``threading.Lock`` and ``threading.RLock``: who waits for one says so.

Everything else in Python waits by these and by `Condition.wait`: events, semaphores, barriers,
timers, queues, futures, thread pools. A lock that is given back goes to who has waited longest,
since the thread that steps gives it back and takes it again within the same moment of simulated
time, and nobody else would ever have it. Without a clock in force they behave as the originals do.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from rps_compat.clock import real
from rps_compat.clock.time_functions import clock_of_this_thread
from rps_compat.clock.waits import Wait


class _Queue:
    """Those who wait for one lock, and the one for whom it is kept."""

    def __init__(self) -> None:
        self._waits: deque[Wait] = deque()
        self.heir: Wait | None = None

    def next(self) -> None:
        """Keep the lock, which is free, for who has waited longest."""
        while self._waits:
            wait = self._waits.popleft()
            with wait.scheduler.lock:
                if wait.scheduler.is_waited(wait):
                    self.heir = wait
                    wait.release()
                    return

    def acquire(
        self, take: Callable[[], bool], block: Callable[[bool, float], bool], timeout: float
    ) -> bool:
        """Wait until `take` succeeds; without a clock, let `block` do so in real time."""
        clock = clock_of_this_thread()
        deadline = None if clock is None or timeout < 0 else clock.elapsed + timeout
        while clock is not None and not clock.over:
            wait = Wait(clock)
            self._waits.append(wait)
            try:
                if self.heir is None and take():  # it was freed before the wait was known
                    return True
                clock.wait(None if deadline is None else deadline - clock.elapsed, wait)
                if (self.heir is wait or wait.woken) and take():
                    return True
                if not wait.woken:
                    return False
            except BaseException:
                if self.heir is wait:  # it never came to it: the next may
                    self.heir = None
                    self.next()
                raise
            finally:
                self._withdraw(wait)
        return block(True, timeout)

    def _withdraw(self, wait: Wait) -> None:
        if self.heir is wait:
            self.heir = None
        elif not wait.woken and wait in self._waits:
            self._waits.remove(wait)


class Lock:
    """Stands in for ``threading.Lock``."""

    __slots__ = ("__weakref__", "_lock", "_queue", "locked")

    def __init__(self) -> None:
        self._at_fork_reinit()

    def _at_fork_reinit(self) -> None:
        self._lock = real.allocate_lock()
        self._queue = _Queue()
        self.locked = self._lock.locked

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take the lock; return whether it was to be had.

        Parameters
        ----------
        blocking : bool
            Whether to wait for it.
        timeout : float
            How long at most, s of simulated time; −1 for no limit.
        """
        lock, queue = self._lock, self._queue
        if timeout != -1 and not (blocking and timeout >= 0):
            return lock.acquire(blocking, timeout)  # raises what is wrong with that
        if queue.heir is None and lock.acquire(False):
            return True
        return blocking and queue.acquire(lambda: lock.acquire(False), lock.acquire, timeout)

    def release(self) -> None:
        """Give the lock back."""
        self._lock.release()
        self._queue.next()

    __enter__ = acquire
    acquire_lock, release_lock = acquire, release

    def __exit__(self, *_: object) -> None:
        self.release()

    def __repr__(self) -> str:
        return f"<{'locked' if self.locked() else 'unlocked'} lock at {id(self):#x}>"


class RLock(real.reentrant_lock):  # type: ignore[misc]
    """Stands in for ``threading.RLock``."""

    def __init__(self) -> None:
        self._queue = _Queue()

    def _at_fork_reinit(self) -> None:
        super()._at_fork_reinit()
        self._queue = _Queue()

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take the lock; return whether it was to be had.

        Parameters
        ----------
        blocking : bool
            Whether to wait for it.
        timeout : float
            How long at most, s of simulated time; −1 for no limit.
        """
        take, queue = super().acquire, self._queue
        if timeout != -1 and not (blocking and timeout >= 0):
            return bool(take(blocking, timeout))  # raises what is wrong with that
        if (queue.heir is None or self._is_owned()) and take(False):
            return True
        return blocking and queue.acquire(lambda: bool(take(False)), take, timeout)

    def release(self) -> None:
        """Give the lock back, once for each time that it was taken."""
        super().release()
        if not self._is_owned():
            self._queue.next()

    __enter__ = acquire

    def __exit__(self, *_: object) -> None:
        self.release()

    def _release_save(self) -> Any:
        state = super()._release_save()
        self._queue.next()
        return state

    def _acquire_restore(self, state: Any) -> None:
        self.acquire()
        for _ in range(state[0] - 1):
            super().acquire()
