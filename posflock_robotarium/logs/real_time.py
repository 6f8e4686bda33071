"""The two clocks of a run: the steps that its script counts, and the real time that passed.

A loop that is written for 33 ms does not take 33 ms, so that `Run.t` (most often the number of the
step times 33 ms) and the clock on the wall drift apart, and a stall is seen on the latter alone. A
pose log of ours holds both; other logs hold one, which was read from a clock or was counted.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.run import Run

Floats = NDArray[np.float64]

EQUAL = 0.01
"""Steps that are equal to this share of them were counted, not read from a clock."""

SLOWEST_CLOCK = 0.5
"""Share of the time by steps below which real time is that of a simulation, not of robots."""


def believed(real_time: Floats, t: Floats, simulated: bool) -> tuple[Floats | None, str]:
    """Tell whether a logged real time is one in which robots drove.

    Parameters
    ----------
    real_time, t : (T,) array
        Seconds by the clock, NaN where unknown, and by the steps.
    simulated : bool
        Whether the log says that it was simulated.

    Returns
    -------
    real_time : (T,) array, or None
        The same, counted from the log's opening; None where it tells nothing.
    why : str
        Why not, for the report; empty where there is nothing to say.
    """
    if np.isnan(real_time).all() or simulated:
        return None, ""
    steps = np.diff(real_time)
    bad = np.flatnonzero(~(np.isfinite(real_time[1:]) & (steps > 0)))
    if bad.size or not np.isfinite(real_time[0]):
        row = int(bad[0]) + 1 if bad.size else 0
        return None, f"real time not used: in row {row} it does not go forward"
    taken, counted = float(real_time[-1] - real_time[0]), float(t[-1] - t[0])
    if taken < SLOWEST_CLOCK * counted:
        return None, (
            f"real time not used: {counted:.1f} s of steps were written in {taken:.3g} s, as in a "
            "simulation, not on robots"
        )
    return real_time, ""


def on_a_grid(steps: Floats) -> bool:
    """Tell whether steps were counted, not measured: each is the median one or a multiple of it.

    Parameters
    ----------
    steps : (K,) array
        Seconds from row to row.
    """
    counts = steps / np.median(steps)
    return bool(np.abs(counts - np.round(counts)).max() < EQUAL)


def clock_of(run: Run) -> Floats | None:
    """Return the seconds of each row by a clock; None where the log's times were counted.

    Parameters
    ----------
    run : Run
        Its real time counts where it is known, else its own times where these are uneven.

    Returns
    -------
    (T,) array, or None
        Seconds, of any origin.
    """
    if run.real_time is not None:
        return run.real_time
    return None if not run.timed or on_a_grid(np.diff(run.t)) else run.t


def over_real_time(run: Run) -> Run:
    """Return the same run with the real time in the place of its times.

    Parameters
    ----------
    run : Run
        With a real time, as our pose log has it.

    Raises
    ------
    LogError
        Where its real time is unknown.
    """
    if run.real_time is None:
        raise LogError(
            f"{run.name}: no real time in it, which pose logs of format 3 written on robots have; "
            "leave --time real out"
        )
    t = run.t[0] + run.real_time - run.real_time[0]
    return replace(run, t=t).noted("times are the real ones, by the clock of the log")
