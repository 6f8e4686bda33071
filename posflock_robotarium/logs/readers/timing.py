"""Seconds for each sample: the file's own times, whatever their unit, or counted steps.

Clocks count seconds since 1970, or thousandths, millionths or milliardths of them: which, their
size says, since no run was logged before 1973. Times that are none (they stand still, or jump back
and forth) are not used where the user says the step.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.found import Found, LogClock, ReadOptions
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]

LONGEST_STEP = 5.0
"""Seconds between poses beyond which nothing is told of motion, and times have another unit."""

USELESS = 0.2
"""Share of steps that do not go forward from which on times are no times."""

_FEW = 10
"""Steps of which nothing is told."""

SINCE_1970 = 1e8
"""Seconds from which on a clock counts from 1970, since no run was logged before 1973."""

_SINCE_1970 = {SINCE_1970: (1.0, "s"), 1e11: (1e-3, "ms"), 1e14: (1e-6, "µs"), 1e17: (1e-9, "ns")}
"""Seconds of one unit, by the smallest number that it has in 1973."""


def timed(found: Found, where: str, options: ReadOptions) -> Found:
    """Give each pose its seconds.

    Parameters
    ----------
    found : Found
        Poses with the file's times, if it has any.
    where : str
        File name for messages.
    options : ReadOptions
        Its ``dt`` is for files without times, or with useless ones.

    Raises
    ------
    LogError
        Where there are not as many times as poses.
    LayoutError
        Where there is no time, or one that must have another unit.
    """
    found = _without_useless_times(found, where, options)
    if found.t is None:
        dt = options.dt or found.dt
        if dt is None:
            raise LayoutError(
                f"{where}: no time in it; say the seconds between samples, for example "
                "--dt 0.033 (the testbed's step)"
            )
        counted: Floats = dt * np.arange(len(found.poses), dtype=float)
        return replace(found.noted(f"no time in the file: samples {dt:g} s apart"), t=counted)
    if options.dt is not None:
        found = found.noted("--dt not used: the file has times of its own")
    if len(t := np.asarray(found.t)) != len(found.poses):
        raise LogError(f"{where}: {len(t)} times for {len(found.poses)} poses")
    found = _in_seconds(found)
    t = np.asarray(found.t)
    if (step := _usual_step(t)) > LONGEST_STEP:
        unit, name = ("microseconds", "time_us") if step > 1e3 else ("milliseconds", "time_ms")
        raise LayoutError(
            f"{where}: {step:g} s from one pose to the next, expected at most {LONGEST_STEP:g} s: "
            f"are the times in {unit}? Write them in seconds, or name the column {name}"
        )
    return found


def _without_useless_times(found: Found, where: str, options: ReadOptions) -> Found:
    """Pass over times that are none, where the step is known."""
    if found.t is None:
        return found
    if options.clock is LogClock.NONE:
        return replace(found.noted("the file's times are not used, as asked"), t=None)
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.diff(found.t)
    back = float(np.mean(steps <= 0)) if len(steps) else 0.0
    # A few such steps are damage, which is told with its row.
    if back == 0 or (options.dt is None and (back < USELESS or len(steps) < _FEW)):
        return found
    if options.dt is None:
        raise LayoutError(
            f"{where}: its times are none: {100 * back:.0f} % of them are not later than the one "
            "before; say the seconds between samples instead, for example --dt 0.033"
        )
    told = f"times not used: {100 * back:.0f} % of them are not later than the one before"
    return replace(found.noted(told), t=None)


def _in_seconds(found: Found) -> Found:
    """Tell the unit of a clock that counts from 1970."""
    t = np.asarray(found.t)
    first = float(t[0]) if len(t) else 0.0
    fitting = [unit for least, unit in _SINCE_1970.items() if first >= least]
    if not fitting or fitting[-1][0] == 1.0:
        return found
    second, name = fitting[-1]
    return replace(found.noted(f"times since 1970 in {name}"), t=t * second)


def _usual_step(t: Floats) -> float:
    """Return the median time between poses, s; 0 where no two times are known."""
    known = t[np.isfinite(t)]
    with np.errstate(over="ignore"):
        return float(np.median(np.diff(known))) if len(known) > 1 else 0.0
