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

from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate_errors import InfeasibleError
from barrier_certificates.projection.projection_info import ProjectionInfo
from barrier_certificates.projection.scaled_program import TOLERANCE, Program
from barrier_certificates.projection.working_set import BINDS, WorkingSet

Policy = Literal["relax", "stop", "raise"]


def least_broken(program: Program, search: WorkingSet, info: ProjectionInfo) -> FloatArray | None:
    """Return the velocities that break the rows least, hard limits kept.

    Parameters
    ----------
    program : Program
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
    rows = program.rows
    softened = rows.softened()
    # A pair cannot part faster than this: asking for more only spoils the conditioning.
    softened.bound = np.maximum(rows.bound, -math.sqrt(2.0) * program.top_speed)
    start = np.zeros(softened.size)
    start[: rows.size] = program.target
    working = softened.excess(start) > TOLERANCE
    point = search.solve(start, softened, working, info)
    if point is None:
        return None
    velocity = point[: rows.size]
    hard = np.isinf(rows.weight)
    if hard.any() and not float(rows.excess(velocity)[hard].max()) <= TOLERANCE:
        return None
    info.binding = (working & (softened.excess(point) > -BINDS)).nonzero()[0]
    return velocity


def furthest_from_holding(program: Program) -> InfeasibleError:
    """Return the error that names the rows that the command breaks most."""
    rows, excess = program.rows, program.excess
    furthest = [k for k in np.argsort(-excess)[:3] if excess[k] > TOLERANCE]
    named = "; ".join(
        f"{rows.label(int(k))} ({excess[k] * program.unit:.3g} m/s)" for k in furthest
    )
    return InfeasibleError(
        f"no velocity satisfies all {len(rows)} rows; the command breaks most: {named}. "
        "Part the robots, bring them inside the walls, or use on_infeasible='relax'"
    )
