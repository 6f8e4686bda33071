"""The optimum from a handful of the rows: a *lazy working set*.

Solve with the rows that the command breaks and those that bound last time, add what the solution
breaks, repeat until nothing is broken. The optimum of a subset of rows that satisfies all rows is
the optimum, so leaving rows out costs nothing in exactness, and most steps need a handful of
several hundred rows.

Each round first guesses the binding rows (`barrier_certificates.solvers.active_set`, a proof comes
with the answer) and asks the chosen solver only where that does not settle.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from barrier_certificates import solvers
from barrier_certificates.array_types import BoolArray, FloatArray, IntArray
from barrier_certificates.projection.projection_info import NO_ROWS, ProjectionInfo
from barrier_certificates.projection.scaled_program import TOLERANCE, QuadraticProgram
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.active_set import guess

_GUESSES = 8
ROUNDS = 50
BINDS = 1e-7
"""A row this close to its bound is reported as binding, in the unit of the program."""


class WorkingSet:
    """Finds one optimum after another, starting each from the rows that bound last time.

    Parameters
    ----------
    solver : str
        ``"auto"``, or a name out of `barrier_certificates.solvers.NAMES`.
    options : mapping
        For the solver named.
    """

    def __init__(self, solver: str, options: Mapping[str, float]) -> None:
        self.solver = solver
        self.options = options
        self.forget()

    def forget(self) -> None:
        """Forget which rows bound last time."""
        self._bound: IntArray = NO_ROWS
        self._bound_in = (0, 0)

    def optimum(self, program: QuadraticProgram, info: ProjectionInfo) -> FloatArray | None:
        """Return the point nearest to the target that satisfies all rows, None if there is none.

        `info` is told who solved, how often, which rows bind, and how far they are broken.

        Parameters
        ----------
        program : QuadraticProgram
            Target and rows.
        info : ProjectionInfo
            Is told who solved, how often, which rows bind, and how far they are broken.

        Returns
        -------
        (size,) array or None
            The point, in the program's unit of speed.
        """
        target, rows, excess = program.target, program.rows, program.excess
        warm = self._recall(rows)
        point = None
        if self.solver == "auto":
            point, info.binding, violation, info.iterations = guess(
                rows, target, excess, warm, TOLERANCE, _GUESSES
            )
            info.solver = "active set"
        if point is None:
            if program.is_out_of_reach():
                return None
            working = excess > TOLERANCE
            working[warm] = True
            point = self.solve(target, rows, working, info)
            if point is None:
                return None
            gap = rows.excess(point)
            violation = float(gap[gap.argmax()])
            info.binding = (working & (gap > -BINDS)).nonzero()[0]
        info.violation = max(violation, 0.0)
        self._bound = info.binding if rows.key is None else rows.key[info.binding]
        self._bound_in = _team(rows)
        return point

    def solve(
        self,
        target: FloatArray,
        rows: Rows,
        working: BoolArray,
        info: ProjectionInfo,
        tolerance: float = TOLERANCE,
    ) -> FloatArray | None:
        """Solve for the working rows, add those that are broken, until none is.

        A solver that finds no point, or one that breaks the rows it was given, may be mistaken or
        out of iterations: another one has to agree.

        Parameters
        ----------
        target : (size,) array
            The point to be projected.
        rows : Rows
            All rows.
        working : (m,) boolean array
            The rows to begin with; those that are added are marked here.
        info : ProjectionInfo
            Is told who solved, and how often.
        tolerance : float
            A row is broken when its excess is above this, in the rows' unit.

        Returns
        -------
        (size,) array or None
            The point, or None where the solvers agree that there is none.
        """
        name = solvers.choose(self.solver, rows.size)
        asked = [name]
        for _ in range(ROUNDS):
            which = working.nonzero()[0]
            info.iterations += 1
            info.solver = name
            options = self.options if name == self.solver else {}
            point = solvers.solve(name, rows, which, target, options)
            broken = None if point is None else rows.excess(point) > tolerance
            if broken is None or broken[which].any():
                second = solvers.confirm(asked, rows.size)
                if second is None:
                    return None
                asked.append(second)
                name = second
                continue
            if not broken.any():
                return point
            working |= broken
        return None

    def _recall(self, rows: Rows) -> IntArray:
        """Find last time's binding rows among the present ones."""
        if not self._bound.shape[0] or self._bound_in != _team(rows):
            return NO_ROWS
        if rows.key is None:
            return self._bound
        bound = np.zeros(max(rows.key.max(), self._bound.max()) + 1, dtype=bool)
        bound[self._bound] = True
        return bound.take(rows.key).nonzero()[0]


def _team(rows: Rows) -> tuple[int, int]:
    """Tell apart row sets in which the same row means different things."""
    return rows.size, len(rows) if rows.key is None else -1
