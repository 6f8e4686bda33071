"""Ends a process that no Python code can end: C code that keeps the interpreter to itself.

While one C function computes without giving the interpreter back, ``sum(range(10**12))``, no other
thread of Python and no signal handler runs. A timer of the kernel, whose expiry calls C's ``_exit``
in a thread of its own, needs neither. Nothing can be written then: the log is as its last step left
it.
"""

import contextlib
import ctypes
import math
import sys
from collections.abc import Iterator

_MONOTONIC, _CALL_IN_THREAD = 1, 2


class _Expiry(ctypes.Structure):
    """``struct sigevent``: what happens when the timer expires."""

    _fields_ = (
        ("value", ctypes.c_void_p),
        ("signal", ctypes.c_int),
        ("notify", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("rest", ctypes.c_byte * 40),
    )


class _Time(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


@contextlib.contextmanager
def last_resort(seconds: float, exit_code: int) -> Iterator[None]:
    """End the process if it is still in the ``with`` block after some real time.

    On systems without such timers it does nothing.

    Parameters
    ----------
    seconds : float
        How long it may take, s of real time.
    exit_code : int
        What the process then ends with.
    """
    libc = ctypes.CDLL(None) if sys.platform == "linux" and sys.maxsize > 2**32 else None
    if not hasattr(libc, "timer_create"):
        yield
        return
    assert libc is not None
    ends = ctypes.cast(libc._exit, ctypes.c_void_p).value
    timer = ctypes.c_void_p()
    expiry = _Expiry(exit_code, 0, _CALL_IN_THREAD, ends)
    if libc.timer_create(_MONOTONIC, ctypes.byref(expiry), ctypes.byref(timer)):
        yield
        return
    times = (_Time * 2)(_Time(0, 0), _Time(math.ceil(seconds), 0))
    libc.timer_settime(timer, 0, ctypes.byref(times), None)
    try:
        yield
    finally:
        libc.timer_delete(timer)
