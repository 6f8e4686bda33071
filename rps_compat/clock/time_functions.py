"""Stand-ins for the functions of ``time`` and for ``datetime.now``: they tell simulated time.

They are functions of this module, not of one clock, and ask for the clock that is in force. So a
name that a library once took, ``from time import monotonic``, tells the time of every later run,
and the real time between the runs.
"""

import datetime as _datetime
from typing import Any

from rps_compat.clock import real
from rps_compat.clock.simulated import LOOK, SimulatedClock

_clock: SimulatedClock | None = None


def clock_in_force() -> SimulatedClock | None:
    """Return the clock that the process sees; None where it is the real one."""
    return _clock


def clock_of_this_thread() -> SimulatedClock | None:
    """Return the clock in force; None, too, for a thread that keeps the real time."""
    clock = _clock
    return None if clock is None or real.get_ident() in clock.foreign else clock


def put_in_force(clock: SimulatedClock | None) -> SimulatedClock | None:
    """Let the process see a clock; return the one that it saw before.

    Parameters
    ----------
    clock : SimulatedClock or None
        The clock; None for the real one.
    """
    global _clock
    before, _clock = _clock, clock
    return before


def time() -> float:
    """Return the seconds since 1970."""
    clock = _clock
    if clock is None:
        return real.time()
    if clock.solo:
        clock.elapsed = elapsed = clock.elapsed + LOOK
        return clock.epoch + elapsed
    return clock.read(clock.epoch, real.time)


def monotonic() -> float:
    """Return the seconds of a clock that nobody sets."""
    clock = _clock
    if clock is None:
        return real.monotonic()
    if clock.solo:
        clock.elapsed = elapsed = clock.elapsed + LOOK
        return clock.base + elapsed
    return clock.read(clock.base, real.monotonic)


def perf_counter() -> float:
    """Return the seconds of the finest clock; simulated, it is the monotonic one."""
    return real.perf_counter() if _clock is None else monotonic()


def time_ns() -> int:
    """Return the nanoseconds since 1970."""
    return real.time_ns() if _clock is None else round(time() * 1e9)


def monotonic_ns() -> int:
    """Return the nanoseconds of a clock that nobody sets."""
    return round(monotonic() * 1e9)


def perf_counter_ns() -> int:
    """Return the nanoseconds of the finest clock."""
    return round(perf_counter() * 1e9)


def sleep(seconds: float, /) -> None:
    """Let simulated time pass.

    Parameters
    ----------
    seconds : float
        How long, s.
    """
    clock = _clock
    if clock is None:
        real.sleep(seconds)
    elif clock.solo and seconds > 0:
        clock.elapsed = elapsed = clock.elapsed + float(seconds)
        if elapsed - clock.stepped > clock.longest_wait:
            clock.check_length()
    else:
        clock.sleep(seconds)


def localtime(seconds: float | None = None, /) -> Any:
    """Return the local time, by default the present one.

    Parameters
    ----------
    seconds : float, optional
        Since the epoch, s.
    """
    return real.localtime(time() if seconds is None else seconds)


def gmtime(seconds: float | None = None, /) -> Any:
    """Return the universal time, by default the present one.

    Parameters
    ----------
    seconds : float, optional
        Since the epoch, s.
    """
    return real.gmtime(time() if seconds is None else seconds)


def ctime(seconds: float | None = None, /) -> str:
    """Return the local time as text, by default the present one.

    Parameters
    ----------
    seconds : float, optional
        Since the epoch, s.
    """
    return real.ctime(time() if seconds is None else seconds)


def asctime(*moment: Any) -> str:
    """Return a moment as text, by default the present one.

    Parameters
    ----------
    *moment : struct_time
        One at most.
    """
    return real.asctime(*moment or (localtime(),))


def strftime(form: str, *moment: Any) -> str:
    """Return a moment as text of a given form, by default the present one.

    Parameters
    ----------
    form : str
        The form, as for ``time.strftime``.
    *moment : struct_time
        One at most.
    """
    return real.strftime(form, *moment or (localtime(),))


def clock_gettime(clock: int, /) -> float:
    """Return the seconds of one of the system's clocks; those of CPU time are real.

    Parameters
    ----------
    clock : int
        Which one, such as ``time.CLOCK_MONOTONIC``.
    """
    if clock == real.CLOCK_REALTIME:
        return time()
    if clock in real.MONOTONIC_CLOCKS:
        return monotonic()
    return float(real.clock_gettime(clock))


def clock_gettime_ns(clock: int, /) -> int:
    """Return the nanoseconds of one of the system's clocks; those of CPU time are real.

    Parameters
    ----------
    clock : int
        Which one, such as ``time.CLOCK_MONOTONIC``.
    """
    if clock == real.CLOCK_REALTIME or clock in real.MONOTONIC_CLOCKS:
        return round(clock_gettime(clock) * 1e9)
    return int(real.clock_gettime_ns(clock))


def now(cls: type[_datetime.datetime], tz: _datetime.tzinfo | None = None) -> _datetime.datetime:
    """Return the present date and time, by default the local one without a zone.

    Parameters
    ----------
    tz : tzinfo, optional
        Time zone of the answer.
    """
    return cls.fromtimestamp(time(), tz)


def utcnow(cls: type[_datetime.datetime]) -> _datetime.datetime:
    """Return the present universal date and time, without a zone."""
    return cls.fromtimestamp(time(), _datetime.timezone.utc).replace(tzinfo=None)
