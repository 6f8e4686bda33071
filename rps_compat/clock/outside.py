"""Stand-ins for waits on the world outside: other processes, sockets, descriptors.

Their time is real, and simulated time goes with it. A question that is not answered yet, a process
that still runs, a socket without data, is given real time, too: the next sleep or step takes it.
Two kinds of descriptors are no world outside. The loop of ``asyncio`` has a socket to itself, by
which other threads wake it; and without a display nobody types.
"""

import contextlib
import importlib
import os
import select as _select
import selectors
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

from rps_compat.clock import real
from rps_compat.clock.time_functions import clock_of_this_thread
from rps_compat.clock.waits import PolledWait

PROCESSES = "other processes"
DESCRIPTORS = "sockets and pipes"
STDIN = 0

_multiprocessing: Any = None
with contextlib.suppress(ImportError):  # a system without semaphores
    _multiprocessing = importlib.import_module("_multiprocessing")


# --- Selectors, on which asyncio and multiprocessing wait --------------------------------------


def _is_inside(key: selectors.SelectorKey) -> bool:
    """Whether nobody outside this process writes to a registered descriptor."""
    reader = key.data[0] if isinstance(key.data, tuple) and key.data else None
    wakes_asyncio = getattr(getattr(reader, "_callback", None), "__name__", "")
    return key.fd == STDIN or wakes_asyncio == "_read_from_self"


def selector_function(kind: type[selectors.BaseSelector]) -> Callable[..., Any]:
    """Make the stand-in for ``select`` of one class of selectors.

    Parameters
    ----------
    kind : class
        A class of `selectors`.
    """
    original = real.selector_waits[kind]

    def select(self: Any, timeout: float | None = None) -> Any:
        clock = clock_of_this_thread()
        if clock is None:
            return original(self, timeout)
        inside = all(map(_is_inside, self.get_map().values()))
        found = original(self, 0)
        if found or (timeout is not None and timeout <= 0):
            if not found and not inside:
                clock.ask(DESCRIPTORS)
            return found
        if not inside:
            with clock.outside(DESCRIPTORS):
                return original(self, timeout)

        def ready(timeout: float | None) -> set[int]:
            return {key.fd for key, _ in original(self, timeout)}

        def watch(descriptor: int) -> None:
            self.register(descriptor, selectors.EVENT_READ)

        clock.wait(timeout, PolledWait(clock, watch, self.unregister, ready, clock.me().bell()))
        return original(self, 0)

    return select


def select(reads: Any, writes: Any, errors: Any, timeout: float | None = None, /) -> Any:
    """Stand in for ``select.select``.

    Parameters
    ----------
    reads, writes, errors : iterable
        Descriptors, as for ``select.select``.
    timeout : float, optional
        How long at most, s; None for no limit.
    """
    clock = clock_of_this_thread()
    if clock is None:
        return real.select_select(reads, writes, errors, timeout)
    reads, writes, errors = list(reads), list(writes), list(errors)
    if timeout is None or timeout > 0:
        inside = not (writes or errors) and all(map(_is_stdin, reads))
        if not reads and inside:
            clock.wait(timeout)
        elif not inside or timeout is None:
            with clock.outside(DESCRIPTORS):
                return real.select_select(reads, writes, errors, timeout)
        elif not real.select_select(reads, writes, errors, 0)[0]:
            clock.sleep(timeout)
    found = real.select_select(reads, writes, errors, 0)
    if not any(found) and not all(map(_is_stdin, reads)):
        clock.ask(DESCRIPTORS)
    return found


def _is_stdin(file: Any) -> bool:
    return (file if isinstance(file, int) else file.fileno()) == STDIN


class Poll:
    """Stands in for the objects of ``select.poll``."""

    def __init__(self) -> None:
        self._poll = _real_poll()
        self.register, self.modify = self._poll.register, self._poll.modify
        self.unregister = self._poll.unregister

    def poll(self, timeout: float | None = None) -> Any:
        """Wait for descriptors.

        Parameters
        ----------
        timeout : float, optional
            How long at most, milliseconds; None for no limit.
        """
        clock = clock_of_this_thread()
        if clock is None or timeout == 0:
            return self._poll.poll(timeout)
        with clock.outside(DESCRIPTORS):
            return self._poll.poll(timeout)


_real_poll: Any = getattr(_select, "poll", None)

# --- Sockets ----------------------------------------------------------------------------------


def _socket_function(name: str) -> Callable[..., Any]:
    original = getattr(socket.socket.__base__, name)

    def method(self: socket.socket, *arguments: Any, **named: Any) -> Any:
        clock = clock_of_this_thread()
        if clock is None:
            return original(self, *arguments, **named)
        if self.gettimeout() == 0:
            try:
                return original(self, *arguments, **named)
            except BlockingIOError:
                # asyncio reads until there is no more; it waits by its selector.
                if not sys._getframe(1).f_globals.get("__name__", "").startswith("asyncio"):
                    clock.ask(DESCRIPTORS)
                raise
        with clock.outside(DESCRIPTORS):
            return original(self, *arguments, **named)

    method.__name__ = name
    return method


# --- Processes --------------------------------------------------------------------------------


def _process_function(original: Callable[..., Any]) -> Callable[..., Any]:
    def method(self: subprocess.Popen[Any], *arguments: Any, **named: Any) -> Any:
        clock = clock_of_this_thread()
        if clock is None:
            return original(self, *arguments, **named)
        with clock.outside(PROCESSES):
            return original(self, *arguments, **named)

    method.__name__ = original.__name__
    return method


def poll(self: subprocess.Popen[Any]) -> int | None:
    """Stand in for ``subprocess.Popen.poll``."""
    code = real.popen_poll(self)
    clock = clock_of_this_thread()
    if code is None and clock is not None:
        clock.ask(PROCESSES)
    return code


def waitpid(process: int, options: int, /) -> tuple[int, int]:
    """Stand in for ``os.waitpid``.

    Parameters
    ----------
    process : int
        Number of the process, as for ``os.waitpid``.
    options : int
        Flags, as for ``os.waitpid``.
    """
    clock = clock_of_this_thread()
    if clock is None:
        return real.waitpid(process, options)
    if options & os.WNOHANG:
        found = real.waitpid(process, options)
        if not found[0]:
            clock.ask(PROCESSES)
        return found
    with clock.outside(PROCESSES):
        return real.waitpid(process, options)


if _multiprocessing is not None:

    class SemLock(_multiprocessing.SemLock):  # type: ignore[misc]
        """Stands in for the semaphores that processes share."""

        def acquire(self, block: bool = True, timeout: float | None = None) -> bool:
            """Take the semaphore; return whether it was to be had within `timeout` seconds."""
            clock = clock_of_this_thread()
            if clock is None or super().acquire(False):
                return clock is not None or bool(super().acquire(block, timeout))
            if not block:
                return False
            with clock.outside(PROCESSES):
                return bool(super().acquire(True, timeout))

        __enter__ = acquire


def outside_stand_ins() -> Iterator[tuple[Any, str, Any]]:
    """Yield what stands in for what: object, attribute and stand-in."""
    for kind in real.selector_waits:
        yield kind, "select", selector_function(kind)
    yield _select, "select", select
    if _real_poll is not None:
        yield _select, "poll", Poll
    for name in (
        "_accept", "connect", "recv", "recv_into", "recvfrom", "recvfrom_into", "recvmsg",
        "send", "sendall", "sendto",
    ):  # fmt: skip
        if hasattr(socket.socket, name):
            yield socket.socket, name, _socket_function(name)
    yield subprocess.Popen, "wait", _process_function(real.popen_wait)
    yield subprocess.Popen, "communicate", _process_function(real.popen_communicate)
    yield subprocess.Popen, "poll", poll
    if hasattr(os, "waitpid"):
        yield os, "waitpid", waitpid
    if _multiprocessing is not None:
        yield _multiprocessing, "SemLock", SemLock
