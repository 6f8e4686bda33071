"""Where one robot's poses are none of its own: jumps no wheels can drive, and what lies between.

Jumps cut a robot's rows into stretches.  A stretch is no place of that robot where

- it stands perfectly still next to a jump, or has the same numbers each time: a placeholder, since
  a tracker's poses always jitter;
- it begins out of reach of where the robot was last believed, and a later one does not: for a while
  the tracker took something else for this robot.

A robot that really was carried somewhere is believed again from there.
"""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rps_compat.kinematics import wrap
from rps_compat.testbed import RobotModel

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.intp]

#: Faster than wheels turn by this factor, and farther than these, m and rad, is a jump.
_FACTOR, _NEAR, _ASKEW = 1.5, 0.01, 0.2
#: What a robot may have moved unseen beyond the way at full speed, m.
REACH = 0.03
#: Equal rows from which on a pose is taken for a placeholder.
_EQUAL_ROWS = 3
#: Half widths of the arena from its middle at which a robot that never moves is none.
_FAR_OUTSIDE = 3.0


def fastest(robot: RobotModel) -> tuple[float, float]:
    """Return the largest speed, m/s, and turn rate, rad/s, that a robot's wheels allow.

    Parameters
    ----------
    robot : RobotModel
        Whose wheels.
    """
    rim = robot.wheel_radius * robot.max_wheel_velocity
    return rim, 2 * rim / robot.base_length


def in_reach(before: Floats, after: Floats, elapsed: Floats, robot: RobotModel) -> Booleans:
    """Tell whether a robot can drive from one pose to another.

    Parameters
    ----------
    before, after : (..., 3) array
        Poses, m and rad; a heading that is NaN is not asked.
    elapsed : (...) array
        Seconds in between.
    robot : RobotModel
        Whose wheels.

    Returns
    -------
    (...) boolean array
        False, too, where a position is NaN.
    """
    speed, rate = fastest(robot)
    moved = np.hypot(after[..., 0] - before[..., 0], after[..., 1] - before[..., 1])
    turned = np.abs(wrap(after[..., 2] - before[..., 2]))
    straight = turned <= np.minimum(_FACTOR * rate * elapsed + _ASKEW, np.pi)
    near = moved <= _FACTOR * speed * elapsed + _NEAR
    reached: Booleans = near & (straight | np.isnan(turned))
    return reached


def jumps_of(poses: Floats, t: Floats, known: Booleans, robot: RobotModel) -> Booleans:
    """Tell at which rows each robot has come faster than its wheels can.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses, m and rad.
    t : (T,) array
        Seconds.
    known : (T, N) boolean array
        Which poses are looked at: a robot's way goes from one of them to its next.
    robot : RobotModel
        Whose wheels.

    Returns
    -------
    (T, N) boolean array
        Whether a robot arrives at a row by a jump; never at its first.
    """
    usual = float(np.median(np.diff(t)))
    jumps = np.zeros(known.shape, dtype=bool)
    for n in range(known.shape[1]):
        rows = np.flatnonzero(known[:, n])
        states = poses[rows, :, n]
        # A row that comes early shows a camera frame's worth of motion all the same.
        elapsed = np.maximum(np.diff(t[rows]), usual)
        jumps[rows[1:], n] = ~in_reach(states[:-1], states[1:], elapsed, robot)
    return jumps


def placeholders_of(poses: Floats, known: Booleans, jumps: Booleans, robot: RobotModel) -> Booleans:
    """Tell which poses are numbers that a tracker writes where it sees no robot.

    Parameters
    ----------
    poses : (T, 3, N) array
        Poses, m and rad.
    known, jumps : (T, N) boolean array
        Which poses are looked at, and which of them are arrived at by a jump.
    robot : RobotModel
        Whose arena.

    Returns
    -------
    (T, N) boolean array
        Whether a pose is a placeholder.
    """
    none = np.zeros(known.shape, dtype=bool)
    far = _FAR_OUTSIDE * max(map(abs, robot.boundaries))
    with np.errstate(invalid="ignore"):
        moves = known & (poses != poses[known.argmax(axis=0), :, np.arange(known.shape[1])].T).any(
            1
        )
    stand = set(np.flatnonzero(~moves.any(axis=0)).tolist())
    for n in range(known.shape[1]):
        rows = np.flatnonzero(known[:, n])
        if not len(rows):
            continue
        edges = np.flatnonzero(jumps[rows, n])
        if len(edges):
            none[rows, n] = _placeholders(poses[rows, :, n], edges)
        elif len(rows) >= _EQUAL_ROWS and n in stand and len(stand) < known.shape[1]:
            x, y, heading = np.nan_to_num(poses[rows[0], :, n]).tolist()
            none[rows, n] = max(abs(x), abs(y)) > far or (x == y and heading in (x, 0.0))
    # Several robots at exactly one place, which is that of zeros, are none; but for a team of none.
    zero = known & (poses == 0).all(axis=1)
    if not zero[known].all():
        none |= zero & (zero.sum(axis=1, keepdims=True) > 1)
    return none


def _placeholders(states: Floats, edges: Integers) -> Booleans:
    """Return which of a robot's states (T, 3) stand perfectly still next to a jump."""
    none = np.zeros(len(states), dtype=bool)
    stretches = [slice(a, b) for a, b in pairwise([0, *edges.tolist(), len(states)])]
    starts = states[[stretch.start for stretch in stretches], :2]
    numbers = np.nan_to_num(states)  # a heading that is NaN differs from itself
    still: list[tuple[slice, tuple[float, ...]]] = []
    alike: Counter[tuple[float, ...]] = Counter()
    for number, stretch in enumerate(stretches):
        changes = np.flatnonzero((np.diff(numbers[stretch], axis=0) != 0).any(axis=1)) + 1
        if not changes.size:
            still.append((stretch, tuple(numbers[stretch.start].tolist())))
            alike[still[-1][1]] += stretch.stop - stretch.start
            continue
        first, last = stretch.start + int(changes[0]), stretch.start + int(changes[-1])
        for rows, jump in ((slice(stretch.start, first), number), (slice(last, stretch.stop), -1)):
            beside = rows.start > 0 if jump >= 0 else rows.stop < len(states)
            if beside and rows.stop - rows.start >= _EQUAL_ROWS:
                # A robot that is seen again where it stood did stand there.
                away = np.hypot(*(np.delete(starts, number, axis=0) - states[rows.start, :2]).T)
                none[rows] = not (away < REACH).any()
    for stretch, value in still:
        x, y, heading = value
        written = x == y and heading in (x, 0.0)
        lasting = stretch.stop - stretch.start >= _EQUAL_ROWS or alike[value] > 1
        none[stretch] = written or (lasting and alike[value] <= len(states) / 2)
    return none


def elsewhere(
    states: Floats, t: Floats, rows: Integers, edges: Integers, robot: RobotModel
) -> list[NDArray[np.intp]]:
    """Return the rows in which something else was taken for one robot.

    Parameters
    ----------
    states : (T, 3) array
        Its poses, m and rad.
    t : (T,) array
        Seconds.
    rows : (k,) integer array
        The rows that are looked at.
    edges : (j,) integer array
        Places in `rows` at which the robot arrives by a jump.
    robot : RobotModel
        Whose wheels.

    Returns
    -------
    list of (m,) integer array
        Rows of each stretch.
    """
    speed, _ = fastest(robot)
    stretches = [rows[a:b] for a, b in pairwise([0, *edges.tolist(), len(rows)]) if b > a]
    starts = np.array([stretch[0] for stretch in stretches], dtype=int)
    first = _first_believed(states, t, stretches, robot)
    strange = stretches[:first]
    last = stretches[first][-1]
    for number in range(first + 1, len(stretches)):
        later = starts[number:]
        way = np.hypot(*(states[later, :2] - states[last, :2]).T)
        elapsed = t[later] - t[last]
        turnable = in_reach(
            np.stack([later * 0.0, later * 0.0, np.full(len(later), states[last, 2])], axis=1),
            np.stack([later * 0.0, later * 0.0, states[later, 2]], axis=1),
            elapsed,
            robot,
        )
        reached = (way <= speed * elapsed + REACH) & turnable
        if not reached[0] and reached.any():
            strange.append(stretches[number])
            continue
        last = stretches[number][-1]
    return strange


def _first_believed(
    states: Floats, t: Floats, stretches: list[NDArray[np.intp]], robot: RobotModel
) -> int:
    """Return with which stretch a robot's own poses begin: not a short one that nothing goes on."""
    speed, _ = fastest(robot)
    for number, stretch in enumerate(stretches[:-1]):
        rest = stretches[number + 1 :]
        starts = np.array([later[0] for later in rest])
        way = np.hypot(*(states[starts, :2] - states[stretch[-1], :2]).T)
        goes_on = bool((way <= speed * (t[starts] - t[stretch[-1]]) + REACH).any())
        if goes_on or len(stretch) >= max(len(later) for later in rest):
            return number
        if len(stretch) > len(states) // 10:
            return number
    return len(stretches) - 1
