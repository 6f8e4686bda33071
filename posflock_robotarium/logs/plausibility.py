"""Where a log's poses are really those of the robot: no teleports, no placeholders, no other robot.

A tracker that loses a robot writes nothing, its last pose, zeros or -9999, and one that mistakes
robots for each other writes the other's pose.  Each robot's poses are believed or not on their own:

- what is missing, or was held (`held`), is no pose;
- jumps that no wheels can drive tell placeholders and other things from the robot (`teleports`);
- robots that exchange their places exchanged their names (`exchanges`): these poses are somebody's,
  and count for the team, not for the robot whose name they have.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.exchanges import Exchange, by_robot, exchanges_of, undone
from posflock_robotarium.logs.held import held_poses, nobody_new, stretches_of
from posflock_robotarium.logs.run import Run
from posflock_robotarium.logs.teleports import (
    REACH,
    elsewhere,
    fastest,
    jumps_of,
    placeholders_of,
)

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
#: Share of the increments that may be jumps before the times or the units are to blame.
TOO_MANY_JUMPS = 0.2
#: As far as a robot drives in a stall, m.
_STALLED = 1.0


class Why(Enum):
    """Why rows of a robot are not believed."""

    MISSING = "missing"
    UNHEADED = "heading missing"
    HELD = "an old pose again"
    UNSEEN = "not tracked"
    ELSEWHERE = "taken for something else"
    EXCHANGED = "taken for another robot"


@dataclass(frozen=True)
class Unbelieved:
    """Rows of one robot that are not its own poses.

    Attributes
    ----------
    robot : int
        Whose.
    start, end : float
        Times of the first and the last of the rows, s.
    rows : int
        How many.
    why : Why
        What they are taken for.
    """

    robot: int
    start: float
    end: float
    rows: int
    why: Why

    def __str__(self) -> str:
        return f"robot {self.robot}, {self.start:.1f} to {self.end:.1f} s: {self.why.value}"


@dataclass(frozen=True)
class Sightings:
    """Which increments are to be believed, and what the others are.

    Attributes
    ----------
    known : (K, N) boolean array
        Whether both ends are the robot's own poses, and no jump lies between them.
    jumps : (K, N) boolean array
        Faster than wheels turn.
    unbelieved : tuple of Unbelieved
        Stretches that are left out, those under another robot's name among them.
    stalls : (K,) boolean array
        Rows in which most robots at once went too far for a nominal step: no teleports, but stalls
        of the loop that the log's times hide.
    spikes : (K, N) boolean array
        Increments that no noise explains; none before there is a fit.
    placed : (T, N) boolean array
        Which poses are those of a robot of the team, under whatever name.
    names : (T, N) integer array
        Column in which the pose of each robot stands.
    exchanges : tuple of Exchange
        When this changed.
    repeated : (T,) boolean array
        Rows in which all who are seen have old poses: nothing is lost in them, since the next frame
        says where robots are.
    impossible : bool
        Whether so much of the motion is too fast that no such robot moves like that.
    """

    known: Booleans
    jumps: Booleans
    unbelieved: tuple[Unbelieved, ...]
    stalls: Booleans
    spikes: Booleans
    placed: Booleans
    names: NDArray[np.intp]
    exchanges: tuple[Exchange, ...]
    repeated: Booleans
    impossible: bool = False


def sightings_of(log: Run, t: Floats, counted: bool = False) -> Sightings:
    """Tell a robot's own poses from teleports and placeholders.

    Parameters
    ----------
    log : Run
        Poses as tracked.
    t : (T,) array
        Seconds of the rows.
    counted : bool
        Whether these were counted, not read from a clock, and so may hide stalls.
    """
    poses, robot, seen = log.poses, log.robot, log.seen
    jumps = jumps_of(poses, t, seen, robot)
    stalls = _together(poses, jumps[1:]) & counted
    jumps[1:] &= ~stalls[:, np.newaxis]
    shown = jumps[1:].copy()
    unseen = seen & placeholders_of(poses, seen, jumps, robot)
    held = held_poses(np.where(unseen[:, np.newaxis], np.nan, poses)) & seen & ~unseen
    repeated = nobody_new(held, seen & ~unseen)
    here = seen & ~unseen & ~held
    if (here != seen).any():
        jumps = jumps_of(poses, t, here, robot)
        jumps[1:] &= ~stalls[:, np.newaxis]
    names, exchanges = exchanges_of(poses, t, here, jumps, robot)
    strange = _strange(log, t, here, names, stalls) if jumps.any() else here & False
    placed = here & ~strange
    remaining = _remaining(log, t, placed, names, stalls) if jumps.any() else 0.0
    if remaining > TOO_MANY_JUMPS:  # no robot's poses, in these units and at these times
        nothing = shown & False
        order = np.broadcast_to(np.arange(log.robots), names.shape)
        return Sightings(~shown, shown, (), stalls, nothing, seen, order, (), repeated, True)
    exchanged = placed & (names != np.arange(log.robots))
    own = placed & ~exchanged
    reasons = (
        (~seen, Why.MISSING),
        (seen & np.isnan(poses[:, 2]) & log.headed, Why.UNHEADED),
        (held & ~repeated[:, np.newaxis], Why.HELD),
        (unseen, Why.UNSEEN),
        (strange, Why.ELSEWHERE),
        (exchanged, Why.EXCHANGED),
    )
    return Sightings(
        known=~shown & own[1:] & own[:-1],
        jumps=shown,
        unbelieved=tuple(_named(reasons, t)),
        stalls=stalls,
        spikes=shown & False,
        placed=placed,
        names=names,
        exchanges=exchanges,
        repeated=repeated,
    )


def believed(run: Run) -> Run:
    """Return a run with each robot's own poses, and NaN where there is none to be believed.

    Parameters
    ----------
    run : Run
        Poses as tracked. A robot that is taken for another one is put back in its place: whoever
        measures a team needs ways without jumps, and no names.
    """
    found = sightings_of(run, run.t, counted=not run.timed)
    return run if found.impossible else of_robots(run, found)


def of_robots(run: Run, found: Sightings) -> Run:
    """Return a run without what is not believed of it.

    Parameters
    ----------
    run : Run
        Poses as tracked.
    found : Sightings
        What is to be believed of them.
    """
    if found.placed.all() and not found.exchanges:
        return run
    poses = np.where(found.placed[:, np.newaxis], run.poses, np.nan)
    return replace(run, poses=by_robot(poses, found.names))


def without_exchanges(run: Run) -> Run:
    """Return a run with every pose under the name of its robot, and say what was changed.

    Parameters
    ----------
    run : Run
        Poses as tracked.
    """
    found = sightings_of(run, run.t, counted=not run.timed)
    return undone(run, found.names, found.exchanges)


def _together(poses: Floats, jumps: Booleans) -> Booleans:
    """Return rows (K,) in which most robots jump, a little and to or from no placeholders."""
    most = jumps.sum(axis=1) > max(1.0, jumps.shape[1] / 2)
    moved = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1)
    still = (np.diff(poses, axis=0) == 0).all(axis=1)
    never = still[:1] & False
    lost = jumps & (np.concatenate([still[1:], never]) | np.concatenate([never, still[:-1]]))
    together: Booleans = most & ~lost.any(axis=1) & (moved < _STALLED).all(axis=1)
    return together


def _strange(
    log: Run, t: Floats, here: Booleans, names: NDArray[np.intp], stalls: Booleans
) -> Booleans:
    """Return which poses (T, N) are of no robot of the team, by the columns in which they stand."""
    poses, known = by_robot(log.poses, names), np.take_along_axis(here, names, axis=1)
    jumps = jumps_of(poses, t, known, log.robot)
    jumps[1:] &= ~stalls[:, np.newaxis]
    strange = np.zeros(here.shape, dtype=bool)
    for n in np.flatnonzero(jumps.any(axis=0)):
        rows = np.flatnonzero(known[:, n])
        edges = np.flatnonzero(jumps[rows, n])
        for stretch in elsewhere(poses[:, :, n], t, rows, edges, log.robot):
            strange[stretch, n] = True
        # Two names for one robot: the one that jumped there is wrong.
        bounds = [*edges.tolist(), len(rows)]
        for first, last in pairwise(bounds):
            row = rows[first]
            apart = np.hypot(*(poses[row, :2] - poses[row, :2, n, np.newaxis]))
            apart[n] = np.inf
            if np.nanmin(np.where(known[row], apart, np.inf), initial=np.inf) < REACH:
                strange[rows[first:last], n] = True
    in_columns = np.zeros_like(strange)
    np.put_along_axis(in_columns, names, strange, axis=1)
    return in_columns


def _remaining(
    log: Run, t: Floats, placed: Booleans, names: NDArray[np.intp], stalls: Booleans
) -> float:
    """Return the share of increments that are jumps still, of those poses that are believed."""
    known = np.take_along_axis(placed, names, axis=1)
    jumps = jumps_of(by_robot(log.poses, names), t, known, log.robot)
    jumps[1:] &= ~stalls[:, np.newaxis]
    return float(jumps.sum() / max(1, known.sum() - known.any(axis=0).sum()))


def _named(reasons: tuple[tuple[Booleans, Why], ...], t: Floats) -> Iterator[Unbelieved]:
    """Tell each stretch of flagged rows by robot and time, in that order."""
    for n in range(reasons[0][0].shape[1]):
        found = [
            Unbelieved(
                n, float(t[rows.start]), float(t[rows.stop - 1]), rows.stop - rows.start, why
            )
            for flags, why in reasons
            for rows in stretches_of(flags[:, n])
        ]
        yield from sorted(found, key=lambda entry: entry.start)


__all__ = [
    "TOO_MANY_JUMPS",
    "Exchange",
    "Sightings",
    "Unbelieved",
    "Why",
    "believed",
    "fastest",
    "of_robots",
    "sightings_of",
    "without_exchanges",
]
