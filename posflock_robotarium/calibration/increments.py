"""What a log says between frames: how far robots went and turned, and what they were told."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.run import Run
from rps_compat.kinematics import wrap

Floats = NDArray[np.float64]
#: Rows below which nothing sensible can be fitted.
_LEAST_ROWS = 60
NO_COMMANDS = (
    "no commands in it; a calibration compares what robots did with what they were told, which a"
    " pose log holds"
)


@dataclass(frozen=True)
class Increments:
    """How far robots went and turned between rows, and what they were told.

    Attributes
    ----------
    along : (K, N) array
        Ways along the heading, m.
    turn : (K, N) array
        Turns of the heading, rad.
    commands : (K, 2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    """

    along: Floats
    turn: Floats
    commands: Floats


def time_step_of(log: Run, given: float | None) -> float:
    """Return the time between a log's rows, s; gaps are refused.

    Parameters
    ----------
    log : Run
        Poses over time.
    given : float or None
        What the user says, s; None for the median of the rows.

    Raises
    ------
    LogError
        Where the log is too short, or its rows are not evenly spaced.
    """
    if len(log.t) < _LEAST_ROWS:
        raise LogError(f"the log has {len(log.t)} rows; a calibration needs {_LEAST_ROWS}")
    steps = np.diff(log.t)
    dt = float(np.median(steps)) if given is None else given
    if not dt > 0 or np.abs(steps - dt).max() > 0.25 * dt:
        raise LogError(
            f"the log's rows are {steps.min():.4f} to {steps.max():.4f} s apart; a calibration"
            " needs a row every time step"
        )
    return dt


def increments_of(log: Run, offsets: Floats) -> Increments:
    """Return how far robots went and turned between rows.

    Parameters
    ----------
    log : Run
        The log, with commands.
    offsets : (N,) array
        By how much each tracked heading is off, rad; it is taken off.

    Raises
    ------
    LogError
        Where there are no commands, or a robot was never commanded anything else.
    """
    if log.commands is None:
        raise LogError(f"{log.name}: {NO_COMMANDS}")
    for row, what in ((0, "forward speed"), (1, "turn rate")):
        still = np.ptp(log.commands[:, row], axis=0) < 1e-3
        if still.any():
            raise LogError(
                f"robots {np.flatnonzero(still).tolist()} were never commanded another {what}:"
                " nothing can be learnt about how they follow it"
            )
    turn = wrap(np.diff(log.poses[:, 2], axis=0))
    heading = log.poses[:-1, 2] + turn / 2 - offsets
    moved = np.diff(log.poses[:, :2], axis=0)
    along = moved[:, 0] * np.cos(heading) + moved[:, 1] * np.sin(heading)
    return Increments(along, turn, log.commands[:-1])


def delayed(commands: Floats, dead_time: float, lag: float, time_step: float) -> Floats:
    """Return what robots at rest drive on average in each step, of what they are commanded.

    Parameters
    ----------
    commands : (K, …) array
        One row a step, held for the step.
    dead_time, lag : float
        Seconds.
    time_step : float
        Seconds.

    Returns
    -------
    (K, ...) array
        What they drive, in the unit of the commands.
    """
    from scipy.signal import lfilter

    late = dead_time / time_step
    whole, share = int(late), late - int(late)
    padded = np.concatenate([np.zeros((whole + 1, *commands.shape[1:])), commands])
    rows = len(commands)
    shifted = (1 - share) * padded[1 : rows + 1] + share * padded[:rows]
    ratio = max(lag / time_step, 1e-9)
    left = math.exp(-1 / ratio)
    # The lag's state after each step, then the mean over the step of its approach.
    state = lfilter([1 - left], [1, -left], shifted, axis=0)
    before = np.concatenate([np.zeros((1, *state.shape[1:])), state[:-1]])
    out: Floats = shifted + ratio * (1 - left) * (before - shifted)
    return out
