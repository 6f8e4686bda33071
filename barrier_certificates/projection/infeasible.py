"""What is done where no velocity satisfies all rows: robots overlap, or stand far outside a wall.

Three policies:

``"relax"``
    What the motors can do stays a hard limit; pairs, obstacles and walls are satisfied as well as
    possible (a quadratic price on each row's excess), so robots part and come back inside.
``"stop"``
    All robots stop.
``"raise"``
    `InfeasibleError`, naming the rows that are furthest from holding.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import InfeasibleError
from barrier_certificates.projection.projection_info import ProjectionInfo
from barrier_certificates.projection.scaled_program import TOLERANCE, QuadraticProgram
from barrier_certificates.projection.working_set import BINDS, ROUNDS, WorkingSet
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.ties import TIE

Policy = Literal["relax", "stop", "raise"]


def least_broken(
    program: QuadraticProgram, search: WorkingSet, info: ProjectionInfo
) -> FloatArray | None:
    """Return the velocities that break the rows least, hard limits kept.

    Parameters
    ----------
    program : QuadraticProgram
        The program that has no solution; no robot is asked for more than its top speed.
    search : WorkingSet
        Who solves.
    info : ProjectionInfo
        Told who solved and which rows bind.

    Returns
    -------
    (2N,) array or None
        None if the hard limits alone cannot be satisfied, or nobody finds the answer.
    """
    # A pair cannot part faster than this: asking for more only spoils the conditioning.
    reachable = np.maximum(program.rows.bound, -math.sqrt(2.0) * program.top_speed)
    rows = program.rows.with_bound(reachable)
    tolerance = _tolerance(rows)
    working = rows.excess(program.target) > TOLERANCE
    for _ in range(ROUNDS):
        which = working.nonzero()[0]
        # The rows left out get no slack: they hold, or are taken up in the next round.
        softened = rows.take(which).softened()
        start = np.zeros(softened.size)
        start[: rows.size] = program.target
        point = search.solve(start, softened, np.ones(which.shape[0], dtype=bool), info, tolerance)
        if point is None:
            return None
        broken = rows.excess(point[: rows.size]) > tolerance
        broken[which] = False
        if not broken.any():
            info.binding = which[softened.excess(point) > -BINDS]
            return _within_hard_limits(point[: rows.size], rows)
        working |= broken
    return None


def _tolerance(rows: Rows) -> float:
    """Return how far rows of the softened program may be broken: its unknowns are large numbers.

    A slack is as large as the root of its weight times the excess that it stands for.
    """
    soft = rows.weight[np.isfinite(rows.weight)]
    return TOLERANCE * max(1.0, math.sqrt(float(soft.max()))) if soft.shape[0] else TOLERANCE


def _within_hard_limits(velocity: FloatArray, rows: Rows) -> FloatArray | None:
    """Shorten the velocities that break a hard limit by rounding; None if that is not enough.

    Robots may always stop, so a shorter velocity in the same direction keeps every limit.
    """
    hard = np.isinf(rows.weight).nonzero()[0]
    if not hard.shape[0]:
        return velocity
    excess, bound = rows.excess(velocity)[hard], rows.bound[hard]
    over = (excess > 0.0).nonzero()[0]
    if over.shape[0]:
        part = np.ones(rows.size // 2)
        robot = rows.index[0, hard[over]] // 2
        np.minimum.at(part, robot, np.maximum(bound[over], 0.0) / (excess[over] + bound[over]))
        velocity = velocity * np.repeat(part, 2)
        excess = rows.excess(velocity)[hard]
    return velocity if float(excess.max()) <= TOLERANCE else None


def furthest_first(excess: FloatArray) -> IntArray:
    """Return the rows by how far they are from holding; equal ones keep their order.

    Parameters
    ----------
    excess : (m,) array
        By how much each row is broken, in the unit of the program.

    Returns
    -------
    (m,) integer array
        Row numbers, the furthest from holding first.
    """
    return np.argsort(-np.round(excess / TIE), kind="stable")


def furthest_from_holding(program: QuadraticProgram) -> InfeasibleError:
    """Return the error that names the rows that the command breaks most.

    Parameters
    ----------
    program : QuadraticProgram
        The program that has no solution.

    Returns
    -------
    InfeasibleError
        To be raised; it names three rows at most.
    """
    rows, excess = program.rows, program.excess
    furthest = [int(k) for k in furthest_first(excess)[:3] if excess[k] > TOLERANCE]
    named = "; ".join(f"{rows.label(k)} ({excess[k] * program.unit:.3g} m/s)" for k in furthest)
    return InfeasibleError(
        f"no velocity satisfies all {len(rows)} rows; the command breaks most: {named}. "
        "Part the robots, bring them inside the walls, or use on_infeasible='relax'"
    )
