"""A proximal interior-point method, sparse and quick on large teams (extra ``fast``).

`PIQP <https://predict-epfl.github.io/piqp>`_ (Schwan, Jiang, Kuhn and Jones, 2023).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.active_set import polish
from barrier_certificates.solvers.qp_solver import QpSolver

_DEFAULTS = {"eps_abs": 1e-10, "eps_rel": 1e-10}


class Piqp(QpSolver):
    """Asks PIQP; options are its settings, such as ``max_iter``."""

    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
        import piqp

        solver = piqp.SparseSolver()
        for name, value in {**_DEFAULTS, **options}.items():
            setattr(solver.settings, name, value)
        solver.setup(
            sparse.identity(rows.size, format="csc"),
            -target,
            G=rows.sparse(which).tocsc(),
            h_u=rows.bound.take(which),
        )
        if solver.solve() != piqp.PIQP_SOLVED:
            return None
        point, multipliers = np.asarray(solver.result.x), np.asarray(solver.result.z_u)
        return polish(rows, which, target, point, multipliers)
