"""Stand-ins for ``signal.alarm`` and ``setitimer``: the signal comes when simulated time does.

Timers of CPU time are real, as that is.
"""

from __future__ import annotations

import contextlib
import math
import signal
import sys
import threading
from collections.abc import Iterator
from types import FrameType
from typing import Any

from rps_compat.clock import real
from rps_compat.clock.simulated import LOOK, SimulatedClock
from rps_compat.clock.time_functions import clock_in_force
from rps_compat.clock.waits import Wait

#: What a shell says of a process that its alarm ended: 128 and the signal's number.
ENDED_BY_ALARM = 142


class Alarm(Wait):
    """A signal that is due at a simulated time, and then again and again, if asked.

    For the scheduler it is a wait like others, with a deadline; nobody waits in it.

    Parameters
    ----------
    clock : SimulatedClock
        Whose time it is.
    seconds : float
        Simulated time until it is due, s.
    interval : float
        Simulated time from then to the next, s; 0 for none.
    """

    def __init__(self, clock: SimulatedClock, seconds: float, interval: float) -> None:
        super().__init__(clock)
        self.clock = clock
        self.interval = interval
        self.pausing: list[Wait] = []
        clock.schedule(self, seconds)

    def fire(self) -> None:
        """Send the signal to the main thread."""
        if _handler_runs(self.clock.main.ident):  # it comes when the handler is done
            self.clock.schedule(self, LOOK)
            return
        if self.interval > 0:
            self.clock.schedule(self, self.interval)
        else:
            self.expired = True
        pausing, self.pausing = self.pausing, []
        for wait in pausing:
            wait.release()
        signal.pthread_kill(self.clock.main.ident or 0, signal.SIGALRM)

    @property
    def left(self) -> float:
        """Seconds until it is due; 0 if it never is."""
        return 0.0 if self.over else max(self.deadline - self.clock.elapsed, LOOK)


def _handler_runs(ident: int | None) -> bool:
    """Whether the handler of the last alarm is still running, in thread `ident`."""
    code = getattr(signal.getsignal(signal.SIGALRM), "__code__", None)
    frame = sys._current_frames().get(ident or 0)
    while frame is not None:
        if frame.f_code is code:
            return True
        frame = frame.f_back
    return False


def setitimer(which: int, seconds: float, interval: float = 0.0, /) -> Any:
    """Stand in for ``signal.setitimer``.

    Parameters
    ----------
    which : int
        Which of the system's timers; all but ``ITIMER_REAL`` stay real.
    seconds : float
        Simulated time until the signal, s; 0 for none.
    interval : float
        Simulated time to the next ones, s; 0 for none.

    Raises
    ------
    ItimerError
        If a time is negative.
    """
    clock = clock_in_force()
    if clock is None or which != signal.ITIMER_REAL:
        return real.setitimer(which, seconds, interval)
    if seconds < 0 or interval < 0:
        raise signal.ItimerError(22, "Invalid argument")
    before = getitimer(which)
    if isinstance(clock.alarm, Alarm):
        clock.alarm.expired = True
    clock.alarm = Alarm(clock, seconds, interval) if seconds > 0 else None
    return before


def getitimer(which: int, /) -> Any:
    """Stand in for ``signal.getitimer``.

    Parameters
    ----------
    which : int
        Which of the system's timers; all but ``ITIMER_REAL`` stay real.
    """
    clock = clock_in_force()
    if clock is None or which != signal.ITIMER_REAL:
        return real.getitimer(which)
    alarm = clock.alarm
    return (alarm.left, alarm.interval) if isinstance(alarm, Alarm) else (0.0, 0.0)


def alarm(seconds: int, /) -> int:
    """Stand in for ``signal.alarm``.

    Parameters
    ----------
    seconds : int
        Simulated time until the signal, s; 0 for none.
    """
    if clock_in_force() is None:
        return int(real.alarm(seconds))
    left: float = setitimer(signal.ITIMER_REAL, seconds)[0]
    return math.ceil(left)


def pause() -> None:
    """Stand in for ``signal.pause``."""
    clock = clock_in_force()
    if clock is None or not isinstance(clock.alarm, Alarm) or clock.alarm.over:
        with contextlib.nullcontext() if clock is None else clock.outside("signals"):
            real.pause()
        return
    wait = Wait(clock)
    clock.alarm.pausing.append(wait)
    clock.wait(None, wait)


def _expired(number: int, frame: FrameType | None) -> None:
    """End the script as its own alarm would have ended the process."""
    raise SystemExit(ENDED_BY_ALARM)


@contextlib.contextmanager
def alarms_as_python_has_them() -> Iterator[None]:
    """Let an alarm without a handler end the script, not this process."""
    if signal.getsignal(signal.SIGALRM) != signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGALRM, _expired)
    try:
        yield
    finally:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)


def can_send_alarms() -> bool:
    """Whether this is a thread and a system that get signals."""
    here = threading.current_thread() is threading.main_thread()
    return here and hasattr(signal, "setitimer") and hasattr(signal, "pthread_kill")


def alarm_stand_ins() -> Iterator[tuple[Any, str, Any]]:
    """Yield what stands in for what: object, attribute and stand-in."""
    yield signal, "alarm", alarm
    yield signal, "setitimer", setitimer
    yield signal, "getitimer", getitimer
    yield signal, "pause", pause
