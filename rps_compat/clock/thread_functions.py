"""Stand-ins for what threads do to each other: start, end, join, and wait to be notified."""

import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

from rps_compat.clock import real
from rps_compat.clock.stuck import line_of_the_script
from rps_compat.clock.time_functions import clock_in_force, clock_of_this_thread
from rps_compat.clock.waits import Wait


def condition_wait(self: Any, timeout: float | None = None) -> bool:
    """Stand in for ``threading.Condition.wait``.

    Parameters
    ----------
    timeout : float, optional
        How long at most, s of simulated time; None for no limit.

    Raises
    ------
    RuntimeError
        If the thread does not hold the condition's lock.
    """
    clock = clock_of_this_thread()
    if clock is None or (timeout is not None and timeout <= 0):
        return real.condition_wait(self, timeout)
    if not self._is_owned():
        raise RuntimeError("cannot wait on un-acquired lock")
    wait = Wait(clock)
    self._waiters.append(wait)
    state = self._release_save()
    notified = False
    try:
        notified = clock.wait(timeout, wait)
        return notified
    finally:
        self._acquire_restore(state)
        if not notified and wait in self._waiters:
            self._waiters.remove(wait)


def start(self: threading.Thread) -> None:
    """Stand in for ``threading.Thread.start``: time stands still until the thread runs."""
    clock = clock_of_this_thread()
    if clock is None or self.ident is not None:
        real.thread_start(self)
        return
    clock.expect(self, line_of_the_script(sys._getframe(1)))
    try:
        real.thread_start(self)
    except BaseException:
        if self.ident is None:
            clock.ended(self)
        raise


def life(self: threading.Thread) -> None:
    """Stand in for what a thread does from its first line to its last."""
    clock = clock_in_force()
    if clock is None:
        real.thread_life(self)
        return
    clock.arrived(self)
    try:
        real.thread_life(self)
    finally:
        clock.ended(self)


def join(self: threading.Thread, timeout: float | None = None) -> None:
    """Stand in for ``threading.Thread.join``.

    Parameters
    ----------
    timeout : float, optional
        How long at most, s of simulated time; None for no limit.
    """
    clock = clock_of_this_thread()
    if clock is not None and self is not threading.current_thread():
        wait = clock.wait_for_end(self)
        if wait is not None and not clock.wait(timeout, wait):
            return
    real.thread_join(self, timeout)


def start_new_thread(
    function: Callable[..., object],
    arguments: tuple[Any, ...],
    names: Mapping[str, Any] | None = None,
    /,
) -> int:
    """Stand in for ``_thread.start_new_thread``.

    Parameters
    ----------
    function : callable
        What the thread does.
    arguments : tuple
        What it is called with.
    names : mapping, optional
        The same by name.
    """
    clock = clock_of_this_thread()
    if clock is None:
        return real.start_new_thread(function, arguments, dict(names or {}))
    token = object()
    clock.expect(token, line_of_the_script(sys._getframe(1)))

    def run() -> None:
        clock.arrived(token)
        try:
            function(*arguments, **(names or {}))
        finally:
            clock.ended(token)

    return real.start_new_thread(run, ())
