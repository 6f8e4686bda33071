"""Robots that a tracker takes for each other: found by who jumps to where another one was.

A tracker that mistakes two robots goes on writing their poses, each under the other's name.  To the
team nothing is lost: the same places are taken.  Only what is told of one robot, and of its way
across the moment of the exchange, is wrong.  It is named, and undone where the user asks for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.run import Run
from posflock_robotarium.logs.teleports import in_reach
from rps_compat.testbed import RobotModel

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.intp]


@dataclass(frozen=True)
class Exchange:
    """A moment from which on poses are written under other robots' names.

    Attributes
    ----------
    row : int
        The first row of it.
    t : float
        Its time, s.
    robots : tuple of int
        Who is written under other names from then on.
    mended : bool
        Whether it ends a mistake: from then on each of them has its own name again.
    """

    row: int
    t: float
    robots: tuple[int, ...]
    mended: bool

    def __str__(self) -> str:
        who = " and ".join(map(str, self.robots))
        what = "have their own names again" if self.mended else "are taken for each other"
        return f"robots {who} {what} from {self.t:.1f} s on"


def exchanges_of(
    poses: Floats, t: Floats, known: Booleans, jumps: Booleans, robot: RobotModel
) -> tuple[Integers, tuple[Exchange, ...]]:
    """Find under which name each robot's pose is written.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses as written, m and rad.
    t : (T,) array
        Seconds.
    known, jumps : (T, N) boolean array
        Which poses are looked at, and which of them are arrived at by a jump.
    robot : RobotModel
        Whose wheels.

    Returns
    -------
    names : (T, N) integer array
        Column in which the pose of each robot stands.
    exchanges : tuple of Exchange
        When this changed.
    """
    rows, robots = known.shape
    order = np.arange(robots)
    names = np.broadcast_to(order, (rows, robots)).copy()
    found = []
    for row in np.flatnonzero(jumps.sum(axis=1) > 1):
        came_from = _exchanged(poses, t, known, np.flatnonzero(jumps[row]), int(row), robot)
        if not came_from:
            continue
        # Column `here` now holds whom column `before` held; who that is says the order till now.
        whose = {before: int(np.flatnonzero(order == before)[0]) for before in came_from.values()}
        order = order.copy()
        for here, before in came_from.items():
            order[whose[before]] = here
        names[row:] = order
        who = sorted(whose.values())
        mended = bool((order[who] == who).all())
        found.append(Exchange(int(row), float(t[row]), tuple(who), mended))
    return names, tuple(found)


def _exchanged(
    poses: Floats, t: Floats, known: Booleans, jumpers: Integers, row: int, robot: RobotModel
) -> dict[int, int]:
    """Return for each column that another robot came into at a row, from which column it came."""
    from scipy.optimize import linear_sum_assignment

    last = np.array([int(np.flatnonzero(known[:row, n])[-1]) for n in jumpers])
    before = poses[last, :, jumpers]
    after = poses[row][:, jumpers].T
    elapsed = np.maximum(t[row] - t[last], float(np.median(np.diff(t))))
    reached = in_reach(before[np.newaxis], after[:, np.newaxis], elapsed[np.newaxis], robot)
    while True:  # only whole circles of robots are exchanged
        sound = reached.any(axis=1) & reached.any(axis=0)
        if sound.all():
            break
        jumpers, reached = jumpers[sound], reached[np.ix_(sound, sound)]
        before, after = before[sound], after[sound]
        if len(jumpers) < 2:
            return {}
    way = np.hypot(*(after[:, np.newaxis, :2] - before[np.newaxis, :, :2]).transpose(2, 0, 1))
    here, there = linear_sum_assignment(np.where(reached, way, 1e6))
    if not reached[here, there].all():
        return {}
    return {int(jumpers[i]): int(jumpers[j]) for i, j in zip(here, there, strict=True)}


def by_robot(poses: Floats, names: Integers) -> Floats:
    """Return each robot's own poses, under whatever name they are written.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses as written.
    names : (T, N) integer array
        Column in which the pose of each robot stands.

    Returns
    -------
    (T, 3, N) array
        The same poses, each in its robot's column.
    """
    own: Floats = np.take_along_axis(poses, names[:, np.newaxis], axis=2)
    return own


def undone(run: Run, names: Integers, exchanges: tuple[Exchange, ...]) -> Run:
    """Return a run with each pose under its own robot's name, and say so.

    Parameters
    ----------
    run : Run
        As written. Its commands stay where they are: they were sent to robots, not to poses.
    names : (T, N) integer array
        Column in which the pose of each robot stands.
    exchanges : tuple of Exchange
        When this changed.
    """
    if not exchanges:
        return run.noted("no robots are taken for each other: nothing to undo (--fix-swaps)")
    told = "; ".join(map(str, exchanges))
    return replace(run, poses=by_robot(run.poses, names)).noted(f"undone, as asked: {told}")
