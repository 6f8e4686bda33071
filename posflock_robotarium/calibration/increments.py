"""What a log says between rows: how far robots went and turned, and what they were told."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.calibration.step_times import MEMORY, StepTimes
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.plausibility import Sightings
from posflock_robotarium.logs.run import GAP_FACTOR, Run
from rps_compat.kinematics import wrap

Floats = NDArray[np.float64]
NO_COMMANDS = (
    "no commands in it; a calibration compares what robots did with what they were told, which a"
    " pose log holds"
)
#: Seconds at the beginning in which a robot at rest does not follow its first command yet.
_AT_REST = 0.1
#: What jitter makes of an increment, m and rad: only the ratio matters.
_UNSURE = np.array([[0.001], [0.003]])


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
    steps : (K,) array
        Seconds from row to row.
    known : (K, N) boolean array
        Which increments are to be believed.
    before : (2, N) array
        What robots had been commanded before the first row, m/s and rad/s.
    """

    along: Floats
    turn: Floats
    commands: Floats
    steps: Floats
    known: NDArray[np.bool_]
    before: Floats


def increments_of(log: Run, offsets: Floats, times: StepTimes, sightings: Sightings) -> Increments:
    """Return how far robots went and turned between rows.

    Parameters
    ----------
    log : Run
        The log, with commands.
    offsets : (N,) array
        By how much each tracked heading is off, rad; it is taken off.
    times : StepTimes
        How long steps took, and which of them do not tell what robots were told.
    sightings : Sightings
        Where each robot was really seen.

    Raises
    ------
    LogError
        Where there are no commands.
    """
    if log.commands is None:
        raise LogError(f"{log.name}: {NO_COMMANDS}")
    # In a stall the path bends in ways that its two ends do not tell; what was told still counts.
    short = times.steps <= GAP_FACTOR * times.median
    known = sightings.known & (times.usable & short)[:, None]
    turn = wrap(np.diff(log.poses[:, 2], axis=0))
    heading = log.poses[:-1, 2] + turn / 2 - offsets
    moved = np.diff(log.poses[:, :2], axis=0)
    # The way along an arc is longer than its chord.
    chord = np.sinc(turn / (2 * np.pi))
    along = (moved[:, 0] * np.cos(heading) + moved[:, 1] * np.sin(heading)) / chord
    commands, unknown = held_commands(log.commands[:-1])
    # What a robot does for a while hangs on commands that nobody knows.
    since = np.where(unknown, times.t[:-1, np.newaxis], -np.inf)
    known &= times.t[:-1, np.newaxis] - np.maximum.accumulate(since, axis=0) >= MEMORY
    along, turn = np.where(known, along, 0.0), np.where(known, turn, 0.0)
    before = np.zeros_like(commands[0])
    if not _begins_at_rest(along, turn, commands, times.steps):
        # What they had been told meanwhile is forgotten after a while; till then this is a guess.
        before = commands[0]
        known = known & (times.t[:-1] >= MEMORY)[:, None]
    return Increments(along, turn, commands, times.steps, known, before)


def held_commands(commands: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return commands with the one before in place of each that is unknown, as wheels hold it.

    Parameters
    ----------
    commands : (K, 2, N) array
        m/s and rad/s, NaN where unknown.

    Returns
    -------
    held : (K, 2, N) array
        m/s and rad/s; 0 before the first that is known.
    unknown : (K, N) boolean array
        Which are unknown.
    """
    unknown = np.asarray(np.isnan(commands).any(axis=1), dtype=bool)
    if not unknown.any():
        return commands, unknown
    rows = np.where(unknown, -1, np.arange(len(commands))[:, np.newaxis])
    last = np.maximum.accumulate(rows, axis=0)
    held = np.take_along_axis(commands, np.maximum(last, 0)[:, np.newaxis], axis=0)
    return np.where(last[:, np.newaxis] < 0, 0.0, held), unknown


def _begins_at_rest(along: Floats, turn: Floats, commands: Floats, steps: Floats) -> bool:
    """Tell from the first rows whether the team was at rest or following its first commands.

    A log begins with its run, or was cut out of one; a single robot with a small command could not
    tell these apart, the team can.
    """
    rows = max(1, int(np.searchsorted(np.cumsum(steps), _AT_REST)))
    done = np.stack([along[:rows].sum(axis=0), turn[:rows].sum(axis=0)])
    told = np.einsum("k,kcn->cn", steps[:rows], commands[:rows])
    at_rest, moving = (np.square(off / _UNSURE).sum() for off in (done, done - told))
    return bool(at_rest <= moving)
