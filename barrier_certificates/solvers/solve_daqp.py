"""A dual active-set method in C: the fastest for small teams (extra ``fast``).

`daqp <https://github.com/darnstrom/daqp>`_ (Arnström, Bemporad and Axehill, 2022).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.qp_solver import QpSolver

_DEFAULTS = {"primal_tol": 1e-11, "dual_tol": 1e-12}


class Daqp(QpSolver):
    """Asks daqp; options are its settings, such as ``iter_limit``."""

    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
        import daqp

        bound = rows.bound.take(which)
        point, _, flag, _ = daqp.solve(
            _identity(rows.size),
            -target,
            np.ascontiguousarray(rows.dense(which)),
            bound,
            np.full(bound.shape[0], -1e30),
            np.zeros(bound.shape[0], dtype=np.intc),
            **{**_DEFAULTS, **options},
        )
        return np.asarray(point) if flag == 1 else None


@lru_cache(maxsize=8)
def _identity(size: int) -> FloatArray:
    return np.eye(size)
