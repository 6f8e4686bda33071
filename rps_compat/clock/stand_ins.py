"""Puts a clock in force: its stand-ins into Python's modules, and takes them back."""

import _thread
import contextlib
import ctypes
import datetime
import gc
import queue
import sys
import threading
import time
import timeit
from collections.abc import Iterator
from typing import Any

from rps_compat.clock import alarms, locks, real, thread_functions, time_functions
from rps_compat.clock.outside import outside_stand_ins
from rps_compat.clock.simulated import SimulatedClock

_TIME = (
    "time", "time_ns", "monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns", "sleep",
    "localtime", "gmtime", "ctime", "asctime", "strftime", "clock_gettime", "clock_gettime_ns",
)  # fmt: skip
_ABSENT = object()


def _stand_ins() -> Iterator[tuple[Any, str, Any]]:
    for name in _TIME:
        if hasattr(time, name):
            yield time, name, getattr(time_functions, name)
    # Names under which modules of Python's own took the originals when they were imported.
    yield threading, "_time", time_functions.monotonic
    yield queue, "time", time_functions.monotonic
    yield timeit, "default_timer", time_functions.perf_counter
    if "sched" in sys.modules:
        import sched

        times = (time_functions.monotonic, time_functions.sleep)
        yield sched.scheduler.__init__, "__defaults__", times
    yield threading.Condition, "wait", thread_functions.condition_wait
    yield threading.Thread, "start", thread_functions.start
    yield threading.Thread, "_bootstrap_inner", thread_functions.life
    yield threading.Thread, "join", thread_functions.join
    yield _thread, "start_new_thread", thread_functions.start_new_thread
    yield threading, "Lock", locks.Lock
    yield threading, "RLock", locks.RLock
    yield queue, "SimpleQueue", real.PythonSimpleQueue  # C's waits by itself
    yield from outside_stand_ins()
    if alarms.can_send_alarms():
        yield from alarms.alarm_stand_ins()


@contextlib.contextmanager
def in_force(clock: SimulatedClock) -> Iterator[SimulatedClock]:
    """Let the process live by a clock within the ``with`` block; blocks may be nested.

    Threads that ran before keep the real time. What stood in for Python's own functions is taken
    back at the end, and threads that still wait go on in real time.

    Parameters
    ----------
    clock : SimulatedClock
        Tells the time to the running thread and to those that it starts.
    """
    clock.start()
    with contextlib.ExitStack() as back:
        back.callback(clock.stop)
        if alarms.can_send_alarms():
            back.enter_context(alarms.alarms_as_python_has_them())
        back.callback(time_functions.put_in_force, time_functions.put_in_force(clock))
        for owner, name, stand_in in _stand_ins():
            before = vars(owner).get(name, _ABSENT) if isinstance(owner, type) else None
            if before is None:
                before = getattr(owner, name)
            back.callback(_put, owner, name, before)
            setattr(owner, name, stand_in)
        for name in ("now", "utcnow"):
            stand_in = classmethod(getattr(time_functions, name))
            back.callback(_put_into_datetime, name, datetime.datetime.__dict__[name])
            _put_into_datetime(name, stand_in)
        yield clock


def _put(owner: Any, name: str, value: Any) -> None:
    if value is _ABSENT:
        delattr(owner, name)
    else:
        setattr(owner, name, value)


def _put_into_datetime(name: str, value: Any) -> None:
    """Replace a method of ``datetime.datetime``, which as a type written in C resists that.

    A subclass in its place would change what ``type(moment) is datetime`` says, what can be
    pickled, and what was imported before.
    """
    (names,) = gc.get_referents(datetime.datetime.__dict__)
    names[name] = value
    ctypes.pythonapi.PyType_Modified(ctypes.py_object(datetime.datetime))
