"""When the experiment began in a log that holds the drive to the start, too.

Before a script goes on, the testbed drives the robots to their initial conditions. A pose log of
the script begins after that; what a tracker recorded from outside, or a script that drives its
robots itself, does not, and then the drive is no part of what is judged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.printed_log import PrintedLog
from posflock_robotarium.logs.run import Run

FARTHEST_APART = 3600.0
"""Seconds between a log and what was printed beyond which they are of two runs."""

LEAST_DRIVE = 1.0
"""Seconds below which no drive is told from two clocks, or two stamps of one moment, apart."""


def with_printed(run: Run, printed: PrintedLog | None) -> Run:
    """Return the run with what was printed, where that is of the same run, and say so.

    Parameters
    ----------
    run : Run
        As its log was read.
    printed : PrintedLog or None
        What lay beside the log.
    """
    if printed is None:
        return run
    if printed.robots is not None and printed.robots != run.robots:
        return run.noted(
            f"{printed.file} beside it not used: it tells of {printed.robots} robots, the log holds"
            f" {run.robots}"
        )
    first, began = run.first_pose_at, printed.began_at
    if first is not None and began is not None:
        length = float(run.t[-1] - run.t[0])
        if not -FARTHEST_APART - length < first - began < FARTHEST_APART:
            return run.noted(
                f"{printed.file} beside it not used: it is of a run {abs(first - began) / 60:.0f}"
                " minutes away from this one"
            )
    return replace(run, printed=printed).noted(printed.told)


def experiment_start(run: Run, drive: float | None = None) -> float:
    """Return when the experiment began, by the log's own times; without a drive its first one.

    Parameters
    ----------
    run : Run
        Poses over time.
    drive : float, optional
        Seconds from the first pose in which robots drive to the start, as the user says; by
        default what the log says as ``drive``, or what its clock and the printed lines tell.

    Raises
    ------
    ParameterError
        Where the user's drive is not within the run.
    """
    first, duration = float(run.t[0]), float(run.t[-1] - run.t[0])
    if drive is not None:
        if not 0 <= drive < duration:
            raise ParameterError(
                f"{run.name}: --drive is {drive:g} s; expected from 0 to below the {duration:.2f} s"
                " of the run"
            )
        return first + drive
    said = run.parameters.get("drive")
    if isinstance(said, (int, float)) and not isinstance(said, bool) and 0 <= said < duration:
        return first + float(said)
    return first + _drive_by_clock(run, duration)


def _drive_by_clock(run: Run, duration: float) -> float:
    """Return how many seconds of the log are before the testbed started the experiment."""
    at, began = run.first_pose_at, None if run.printed is None else run.printed.began_at
    if at is None or began is None or began - at < LEAST_DRIVE:
        return 0.0
    waited = began - at
    if run.real_time is not None:  # by its clock, and from there by its steps
        waited = float(np.interp(waited, run.real_time - run.real_time[0], run.t - run.t[0]))
    return waited if waited < duration else 0.0
