"""A sparse interior-point method: the default for large teams.

`Clarabel <https://clarabel.org>`_ (Goulart and Chen, 2024). An interior point is near the optimum
but never on the rows; `barrier_certificates.solvers.active_set.polish` puts it there.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.active_set import polish
from barrier_certificates.solvers.qp_solver import QpSolver

_DEFAULTS = {"tol_feas": 1e-10, "tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11}
_ENOUGH = ("Solved", "AlmostSolved")


class Clarabel(QpSolver):
    """Asks Clarabel; options are its settings, such as ``max_iter``."""

    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
        import clarabel

        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.max_threads = 1
        for name, value in {**_DEFAULTS, **options}.items():
            setattr(settings, name, value)
        matrix = rows.sparse(which).tocsc()
        solver = clarabel.DefaultSolver(
            sparse.identity(rows.size, format="csc"),
            -target,
            matrix,
            rows.bound.take(which),
            [clarabel.NonnegativeConeT(which.shape[0])],
            settings,
        )
        solution = solver.solve()
        if str(solution.status) not in _ENOUGH:
            return None
        return polish(rows, which, target, np.asarray(solution.x), np.asarray(solution.z))
