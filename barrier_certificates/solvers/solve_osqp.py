"""A first-order method: widely known, and the least exact here.

`OSQP <https://osqp.org>`_ (Stellato, Banjac, Goulart, Bemporad and Boyd, 2020). Only "solved" is
accepted, the point is polished, and like every answer it is checked on every row: on hard packings
it stops unsolved, which counts as no answer.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.active_set import polish
from barrier_certificates.solvers.qp_solver import QpSolver

_DEFAULTS = {"eps_abs": 1e-7, "eps_rel": 1e-7, "max_iter": 20000, "polishing": True}


class Osqp(QpSolver):
    """Asks OSQP; options are its settings, such as ``max_iter``."""

    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
        import osqp

        settings = {**_DEFAULTS, **options}
        if int(osqp.__version__.split(".")[0]) < 1:
            settings["polish"] = settings.pop("polishing")
        solver = osqp.OSQP()
        solver.setup(
            P=sparse.identity(rows.size, format="csc"),
            q=-target,
            A=rows.sparse(which).tocsc(),
            l=np.full(which.shape[0], -np.inf),
            u=rows.bound.take(which),
            verbose=False,
            **settings,
        )
        result = solver.solve()
        if result.info.status != "solved":
            return None
        return polish(rows, which, target, np.asarray(result.x), np.asarray(result.y))
