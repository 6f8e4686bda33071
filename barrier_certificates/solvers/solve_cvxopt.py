"""An interior-point method in C: what the testbed has besides scipy.

`CVXOPT <https://cvxopt.org>`_ (Andersen, Dahl and Vandenberghe). Its options are given with the
call: the global ones, which other code may rely on, are left alone. It is licensed under the GPL,
so it is an extra and never installed by default.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.active_set import polish
from barrier_certificates.solvers.qp_solver import QpSolver

_DEFAULTS = {"abstol": 1e-10, "reltol": 1e-10, "feastol": 1e-10, "maxiters": 100}
_NAMES = {*_DEFAULTS, "refinement", "kktreg", "show_progress"}
_NEAR = 1e-10  # duality gap, m²/s²: at most 15 µm/s from the optimum


class Cvxopt(QpSolver):
    """Asks cvxopt; options are those of `cvxopt.solvers.qp`, such as ``maxiters``."""

    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
        """Return the nearest point; see `QpSolver.solve`.

        Raises
        ------
        TypeError
            If cvxopt has no such option, or one is no number.
        """
        from cvxopt import matrix, solvers, spmatrix

        # cvxopt ignores names it does not know, and its ValueError for values means many things.
        if unknown := options.keys() - _NAMES:
            raise TypeError(f"cvxopt has no option {sorted(unknown)}, only {sorted(_NAMES)}")
        if not all(isinstance(value, (int, float)) for value in options.values()):
            raise TypeError(f"cvxopt takes numbers, not {dict(options)}")
        sparse = rows.sparse(which).tocoo()
        count = rows.size
        try:
            solution = solvers.qp(
                spmatrix(1.0, range(count), range(count)),
                matrix(-target),
                spmatrix(sparse.data, sparse.row.astype(int), sparse.col.astype(int), sparse.shape),
                matrix(rows.bound.take(which)),
                options={"show_progress": False, **_DEFAULTS, **options},
            )
        except (ArithmeticError, ValueError):  # a singular step: no answer
            return None
        # "unknown" is out of iterations: near the optimum, where the polish ends, or far from any.
        if solution["status"] != "optimal" and not (solution["gap"] or np.inf) < _NEAR:
            return None
        point, multipliers = (np.array(solution[part]).reshape(-1) for part in ("x", "z"))
        return polish(rows, which, target, point, multipliers)
