"""Least-distance programming by non-negative least squares: the solver that scipy alone provides.

The point nearest to ``x̂`` with ``G x ≤ h`` follows from one non-negative least-squares problem
(Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23): with ``z = x − x̂`` and ``r =
G x̂ − h``, minimise ``‖E u − f‖`` over ``u ≥ 0`` where ``E = [−Gᵀ; rᵀ]`` and ``f`` is the last unit
vector. The residual ``E u − f = (p, q)`` gives ``z = −p/q``; if it vanishes, no point satisfies the
rows. It is finite and exact to rounding, and asks for nothing beyond scipy.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.optimize import nnls

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.qp_solver import QpSolver

_NO_RESIDUAL = 1e-9
_BROKEN = 1e-10  # m/s
_APART = 1e-7  # of the largest excess; how far a point may be from the nearest one
_ROUNDING = 1e-12  # of unknowns that are large numbers, as slacks are
# Where rows depend on each other, scipy's routine can stop short of the optimum, silently and by a
# lot. The last row of E can be scaled at will (z then comes out scaled), and another scale takes
# another path; whether the rows hold, and those that decide bind, tells. In units of the largest
# excess.
_SCALES = (1.0, 10.0, 0.3, 100.0)


class Nnls(QpSolver):
    """Solves by `scipy.optimize.nnls`; the one option is its ``maxiter``."""

    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
        """Return the nearest point; see `QpSolver.solve`.

        Raises
        ------
        TypeError
            If there is another option.
        """
        matrix, bound = rows.dense(which), rows.bound.take(which)
        system = np.empty((rows.size + 1, which.shape[0]))
        np.negative(matrix.T, out=system[:-1])
        excess = matrix @ target - bound
        aim = np.zeros(rows.size + 1)
        aim[-1] = 1.0
        if options.keys() - {"maxiter"}:
            raise TypeError(f"got {sorted(options)}, where nnls has maxiter alone")
        maxiter = options.get("maxiter")
        point: FloatArray | None = None
        worst = float(excess.max())
        if worst <= 0.0:
            return target
        for scale in _SCALES:
            scale *= worst
            np.divide(excess, scale, out=system[-1])
            try:
                weights, _ = nnls(system, aim, maxiter=None if maxiter is None else int(maxiter))
            except RuntimeError:  # out of iterations
                continue
            residual = system @ weights - aim
            if math.sqrt(residual @ residual) < _NO_RESIDUAL or residual[-1] == 0.0:
                return None
            point = target - residual[:-1] * (scale / residual[-1])
            room = bound - matrix @ point
            broken = -float(room.min())
            held = max(_BROKEN, 1e-14 * worst, _ROUNDING * np.abs(point).max())
            if broken <= held and _is_nearest(weights * (scale / residual[-1]), room - held, worst):
                return point
        np.divide(excess, worst, out=system[-1])
        residual = system @ _bounded(system, aim) - aim
        if math.sqrt(residual @ residual) < _NO_RESIDUAL or residual[-1] == 0.0:
            return None
        last: FloatArray = target - residual[:-1] * (worst / residual[-1])
        if point is None or (matrix @ last - bound).max() <= max(broken, held):
            return last
        return point


def _is_nearest(multipliers: FloatArray, room: FloatArray, worst: float) -> bool:
    """Tell whether rows that decide bind: the gap of duality bounds the way to the optimum.

    Its root makes 1e-8 of a rounding error, so `room` is what rows have beyond rounding.
    """
    gap = float(np.abs(multipliers) @ np.maximum(room, 0.0))
    return math.sqrt(2.0 * gap) <= _APART * max(worst, 1.0)


def _bounded(system: FloatArray, aim: FloatArray) -> FloatArray:
    """Solve the same problem by bounded least squares: slower, and at ease with dependent rows.

    scipy's non-negative least squares before 1.16 goes astray where more rows bind than there
    are velocities, as in a corner of the arena.
    """
    from scipy.optimize import lsq_linear

    weights: FloatArray = lsq_linear(
        system, aim, bounds=(0.0, np.inf), method="bvls", tol=1e-15, max_iter=10 * system.shape[1]
    ).x
    return weights
