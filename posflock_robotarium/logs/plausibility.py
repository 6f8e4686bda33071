"""Where a log's poses are really those of the robot: no teleports, no placeholders, no other robot.

A tracker that loses a robot writes its last pose, zeros or -9999, and one that mistakes robots for
each other writes the other's pose.  All of these are jumps that no wheels can drive.  Jumps cut a
robot's rows into stretches, and a stretch is believed unless

- it stands perfectly still next to a jump: a placeholder, since a tracker's poses always jitter;
- it begins out of reach of where the robot was last believed, and a later one does not: for a while
  the tracker took something else for this robot;
- it begins where another robot was, and nobody comes back: the two are mistaken for good.

A robot that really was carried somewhere is believed again from there.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.logs.run import Run
from rps_compat.kinematics import wrap
from rps_compat.testbed import RobotModel

Floats = NDArray[np.float64]
#: Faster than wheels turn by this factor, and farther than these, m and rad, is a jump.
_FACTOR, _NEAR, _ASKEW = 1.5, 0.01, 0.2
#: What a robot may have moved unseen beyond the way at full speed, m.
_REACH = 0.03
#: Share of the increments that may be jumps before the times or the units are to blame.
TOO_MANY_JUMPS = 0.2
#: As far as a robot drives in a stall, m.
_STALLED = 1.0
#: How many jumps a sentence names.
_NAMED = 6
#: Equal rows from which on a pose is taken for a placeholder.
_EQUAL_ROWS = 3


class Why(Enum):
    """Why rows of a robot are not believed."""

    UNSEEN = "not tracked"
    ELSEWHERE = "taken for something else"


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
        Stretches that are left out.
    stalls : (K,) boolean array
        Rows in which most robots at once went too far for a nominal step: no teleports, but stalls
        of the loop that the log's times hide.
    spikes : (K, N) boolean array
        Increments that no noise explains; none before there is a fit.
    """

    known: NDArray[np.bool_]
    jumps: NDArray[np.bool_]
    unbelieved: tuple[Unbelieved, ...]
    stalls: NDArray[np.bool_]
    spikes: NDArray[np.bool_]


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
    poses, robot = log.poses, log.robot
    jumps = _jumps(poses, np.diff(t), robot)
    stalls = _together(poses, jumps) & counted
    jumps = jumps & ~stalls[:, None]
    if jumps.mean() > TOO_MANY_JUMPS:  # no robot's poses, in these units and at these times
        return Sightings(~jumps, jumps, (), stalls, jumps & False)
    own = np.ones((len(t), log.robots), dtype=bool)
    unbelieved: list[Unbelieved] = []
    for n in range(log.robots):
        for rows, why in _strange(poses, t, n, np.flatnonzero(jumps[:, n]) + 1, robot):
            own[rows, n] = False
            start, end = float(t[rows.start]), float(t[rows.stop - 1])
            unbelieved.append(Unbelieved(n, start, end, rows.stop - rows.start, why))
    return Sightings(~jumps & own[1:] & own[:-1], jumps, tuple(unbelieved), stalls, jumps & False)


def fastest(robot: RobotModel) -> tuple[float, float]:
    """Return the largest speed, m/s, and turn rate, rad/s, that a robot's wheels allow.

    Parameters
    ----------
    robot : RobotModel
        Whose wheels.
    """
    rim = robot.wheel_radius * robot.max_wheel_velocity
    return rim, 2 * rim / robot.base_length


def _jumps(poses: Floats, steps: Floats, robot: RobotModel) -> NDArray[np.bool_]:
    """Return where robots moved or turned faster than their wheels can, (K, N)."""
    speed, rate = fastest(robot)
    # A row that comes early shows a camera frame's worth of motion all the same.
    time = np.maximum(steps, np.median(steps))[:, None]
    moved = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1)
    turned = np.abs(wrap(np.diff(poses[:, 2], axis=0)))
    near = moved <= _FACTOR * speed * time + _NEAR
    straight = turned <= np.minimum(_FACTOR * rate * time + _ASKEW, np.pi)
    jumps: NDArray[np.bool_] = ~(near & straight)  # a NaN is a jump, too
    return jumps


def _together(poses: Floats, jumps: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return rows (K,) in which most robots jump, a little and to no placeholders."""
    most = jumps.sum(axis=1) > max(1.0, jumps.shape[1] / 2)
    moved = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1)
    still = (np.diff(poses, axis=0) == 0).all(axis=1)
    lost = jumps & np.concatenate([still[1:], still[:1] & False])
    together: NDArray[np.bool_] = most & ~lost.any(axis=1) & (moved < _STALLED).all(axis=1)
    return together


def _strange(
    poses: Floats, t: Floats, n: int, edges: NDArray[np.intp], robot: RobotModel
) -> list[tuple[slice, Why]]:
    """Return the stretches of one robot's rows that are not its own."""
    speed, _ = fastest(robot)
    stretches = [slice(a, b) for a, b in pairwise([0, *edges.tolist(), len(t)])]
    strange: list[tuple[slice, Why]] = []
    own: list[slice] = []
    for stretch in stretches if len(stretches) > 1 else []:
        kept, placeholders = _without_placeholders(poses[:, :, n], stretch, len(t))
        strange += [(rows, Why.UNSEEN) for rows in placeholders]
        if kept is not None:
            own.append(kept)

    starts = np.array([stretch.start for stretch in own], dtype=int)
    last: int | None = None
    for number, stretch in enumerate(own):
        if last is not None:
            later = starts[number:]
            way = np.linalg.norm(poses[later, :2, n] - poses[last, :2, n], axis=1)
            in_reach = way <= speed * (t[later] - t[last]) + _REACH
            comes_back = bool(in_reach.any())
            if not in_reach[0] and (comes_back or _where_another_was(poses, stretch.start, n)):
                strange.append((stretch, Why.ELSEWHERE))
                continue
        last = stretch.stop - 1
    return sorted(strange, key=lambda entry: entry[0].start)


def _without_placeholders(
    poses: Floats, stretch: slice, rows: int
) -> tuple[slice | None, list[slice]]:
    """Cut rows that stand perfectly still off those ends of a stretch at which there is a jump."""
    first, last = stretch.start, stretch.stop
    if not np.isfinite(poses[first]).all():
        return None, [stretch]
    changes = np.flatnonzero((np.diff(poses[stretch], axis=0) != 0).any(axis=1)) + 1
    still_until = first + (int(changes[0]) if changes.size else last - first)
    still_from = first + (int(changes[-1]) if changes.size else 0)
    cut = []
    if first > 0 and still_until - first >= _EQUAL_ROWS:
        cut.append(slice(first, still_until))
        first = still_until
    if last < rows and last - max(still_from, first) >= _EQUAL_ROWS:
        cut.append(slice(max(still_from, first), last))
        last = max(still_from, first)
    return (slice(first, last) if last > first else None), cut


def _where_another_was(poses: Floats, row: int, n: int) -> bool:
    """Whether robot n is, after its jump, where another one was seen just before."""
    apart = np.linalg.norm(poses[row - 1, :2] - poses[row, :2, n, None], axis=0)
    apart[n] = np.inf
    return bool(np.nanmin(apart, initial=np.inf) < _REACH)


def told(log: Run) -> tuple[str, str] | None:
    """Say where a log's poses cannot be those of its robots; None where all can.

    Parameters
    ----------
    log : Run
        Poses as tracked.

    Returns
    -------
    answer : str
        Whether its poses can be believed, in a few words.
    because : str
        Which robots, and when.
    """
    found = sightings_of(log, log.t, counted=not log.timed)
    share = float(found.jumps.mean())
    if share == 0:
        return None
    speed, rate = fastest(log.robot)
    limits = f"faster than wheels turn ({speed:.2g} m/s, {rate:.2g} rad/s)"
    if share > TOO_MANY_JUMPS:
        because = f"{share:.0%} of all motion is {limits}: other robots, times or units?"
        return "Not at all: no such robot moves like that.", because
    named = [str(entry) for entry in found.unbelieved]
    rows, robots = np.nonzero(found.jumps)
    jumps = [f"robot {n} at {log.t[k + 1]:.1f} s" for k, n in zip(rows, robots, strict=True)]
    because = (
        f"{len(jumps)} jump{'s' if len(jumps) > 1 else ''} {limits}: {_some(jumps)}. "
        + (f"Not believed: {_some(named)}. " if named else "")
        + "The other answers still rest on these poses."
    )
    return "Not everywhere: poses jump, as no wheels can.", because


def _some(words: list[str]) -> str:
    """Return the first of many, and how many more there are."""
    more = f" and {len(words) - _NAMED} more" if len(words) > _NAMED else ""
    return "; ".join(words[:_NAMED]) + more
