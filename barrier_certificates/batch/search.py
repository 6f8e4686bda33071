"""The nearest point that satisfies all rows of one team: two active-set methods, compiled.

`guess` is that of `barrier_certificates.solvers.active_set`: solve for the rows that bound last
time, drop those that pull, add those that are broken. It answers most steps of a run at once, but
may cycle. `climb` is the dual method of Goldfarb and Idnani (A numerically stable dual method for
solving strictly convex quadratic programs, 1983): it adds the row that is broken most, one by one,
always at an optimum of the rows added so far, so it ends, at the optimum or at the proof that there
is none. Both answers are the projection on their binding rows, and are checked on every row.
"""

from __future__ import annotations

import math

from barrier_certificates.array_types import FloatArray
from barrier_certificates.batch.active_rows import (
    Space,
    append,
    copy,
    products,
    project_on,
    solve,
    subtract,
)
from barrier_certificates.batch.compiling import compiled
from barrier_certificates.batch.layout import TeamRows
from barrier_certificates.batch.write_rows import write_excess
from barrier_certificates.projection.scaled_program import TOLERANCE

_GUESSES = 8
_TIGHT = 1e-12  # binding rows hold as equations to within rounding, relative to the largest excess
_STEPS = 40  # times the unknowns; what takes longer goes round in a circle of rounding
_CLOSER = 0.1 * TOLERANCE

NOT_FOUND = -1
"""Instead of a number of binding rows: a single projector has to look."""


@compiled
def guess(rows: TeamRows, space: Space, warm: int, worst: float) -> int:
    """Find the optimum by guessing which rows bind; return how many do, or `NOT_FOUND`.

    Parameters
    ----------
    rows : TeamRows
        All rows.
    space : Space
        Target, and the rows that bound last time; point, gap and binding rows are written.
    warm : int
        How many bound last time.
    worst : float
        How far the target breaks a row, the largest known, m/s.
    """
    binding, gap, multiplier = space.binding, space.gap, space.multiplier
    size, count = 2 * space.target.shape[1], warm
    for _ in range(_GUESSES):
        if count == 0:
            count = _worst_of_each_robot(rows, space)
        kept = 0
        for a in range(count):
            if append(rows, space, binding[a], kept):
                kept += 1
        count = kept
        project_on(rows, space, count)
        most = write_excess(rows, space.point, space.least, gap)
        if _proves(space, count, most, worst):
            space.largest[0] = most
            return count
        kept = 0
        for a in range(count):
            if multiplier[a] >= 0.0:
                gap[binding[a]] = -math.inf  # it stays; not to be added again
                binding[kept] = binding[a]
                kept += 1
        count = kept
        for row in range(gap.shape[0]):
            if gap[row] > TOLERANCE:
                if count >= size:
                    return NOT_FOUND
                binding[count] = row
                count += 1
    return NOT_FOUND


@compiled
def _worst_of_each_robot(rows: TeamRows, space: Space) -> int:
    """Bind the row that each robot's command breaks most; return how many."""
    first, least, binding, excess = rows.first, space.least, space.binding, space.gap
    number, count = space.target.shape[1], 0
    write_excess(rows, space.target, least, excess)
    for robot in range(number):
        least[robot] = TOLERANCE
        binding[robot] = NOT_FOUND
    for row in range(excess.shape[0]):
        robot = first[row]
        if excess[row] > least[robot]:
            least[robot] = excess[row]
            binding[robot] = row
    for robot in range(number):
        if binding[robot] != NOT_FOUND:
            binding[count] = binding[robot]
            count += 1
    return count


@compiled
def _proves(space: Space, count: int, most: float, worst: float) -> bool:
    """Whether nothing is broken, no row pulls, and binding rows hold as equations."""
    if not most <= TOLERANCE:
        return False
    multiplier, gap, binding = space.multiplier, space.gap, space.binding
    for a in range(count):
        if not (multiplier[a] >= 0.0 and -gap[binding[a]] <= _TIGHT * max(1.0, worst)):
            return False
    return True


@compiled
def climb(rows: TeamRows, space: Space, worst: float) -> int:
    """Find the optimum from the target on, row by row; return how many bind, or `NOT_FOUND`.

    Parameters
    ----------
    rows : TeamRows
        All rows.
    space : Space
        Target; point, gap and binding rows are written.
    worst : float
        How far the target breaks a row, the largest known, m/s.
    """
    size, count = 2 * space.target.shape[1], 0
    copy(space.target, space.point)
    multiplier = space.side
    for _ in range(_STEPS * size):
        write_excess(rows, space.point, space.least, space.gap)
        row = _most_broken(space)
        if row == NOT_FOUND:
            project_on(rows, space, count)
            most = write_excess(rows, space.point, space.least, space.gap)
            for a in range(count):  # a row that binds but does not push may seem to pull
                if -_CLOSER < space.multiplier[a] < 0.0:
                    space.multiplier[a] = 0.0
            space.largest[0] = most
            return count if _proves(space, count, most, worst) else NOT_FOUND
        count = _take_up(rows, space, row, count, multiplier)
        if count == NOT_FOUND:
            return NOT_FOUND
    return NOT_FOUND


@compiled
def _most_broken(space: Space) -> int:
    gap, row, most = space.gap, NOT_FOUND, _CLOSER
    for candidate in range(gap.shape[0]):
        if gap[candidate] > most:
            row, most = candidate, gap[candidate]
    return row


@compiled
def _take_up(rows: TeamRows, space: Space, row: int, count: int, multiplier: FloatArray) -> int:
    """Move until a broken row holds, dropping rows that would begin to pull on the way."""
    binding, right, along = space.binding, space.right, space.multiplier
    step, point, broken, pushed = space.step, space.point, space.gap[row], 0.0
    while True:
        products(rows, space, row, count, right)
        solve(space, count, right, along)
        for robot in range(step.shape[1]):
            step[0, robot] = step[1, robot] = 0.0
        subtract(rows, row, 1.0, step)
        for a in range(count):
            subtract(rows, binding[a], -along[a], step)
        length = 0.0
        for robot in range(step.shape[1]):
            length += step[0, robot] * step[0, robot] + step[1, robot] * step[1, robot]
        whole = broken / length if length > 1e-12 else math.inf
        part, dropped = math.inf, NOT_FOUND
        for a in range(count):
            if along[a] > 1e-12 and multiplier[a] < part * along[a]:
                part, dropped = multiplier[a] / along[a], a
        way = min(whole, part)
        if way == math.inf:
            return NOT_FOUND  # the row contradicts those that bind
        for a in range(count):
            multiplier[a] -= way * along[a]
        pushed += way
        if whole < math.inf:
            for robot in range(step.shape[1]):
                point[0, robot] += way * step[0, robot]
                point[1, robot] += way * step[1, robot]
            broken -= way * length
        if whole <= part:
            if not append(rows, space, row, count):
                return NOT_FOUND
            multiplier[count] = pushed
            return count + 1
        kept = dropped
        for a in range(dropped + 1, count):
            multiplier[kept] = multiplier[a]
            if not append(rows, space, binding[a], kept):
                return NOT_FOUND
            kept += 1
        count = kept
