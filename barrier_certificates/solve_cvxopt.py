"""An interior-point method in C: what the testbed has besides scipy.

`CVXOPT <https://cvxopt.org>`_ (Andersen, Dahl and Vandenberghe). Its options are given with the
call: the global ones, which other code may rely on, are left alone. It is licensed under the GPL,
so it is an extra and never installed by default.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from barrier_certificates.active_set import polish
from barrier_certificates.rows import FloatArray, IntArray, Rows

_DEFAULTS = {"abstol": 1e-10, "reltol": 1e-10, "feastol": 1e-10, "maxiters": 100}


def solve(
    rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
) -> FloatArray | None:
    """Nearest point to ``target`` that satisfies the chosen rows, or None if there is none.

    Parameters
    ----------
    rows, which, target
        See `barrier_certificates.solvers`.
    options : mapping
        Options of `cvxopt.solvers.qp`, such as ``maxiters``.
    """
    from cvxopt import matrix, solvers, spmatrix

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
    if solution["status"] not in ("optimal", "unknown"):
        return None
    point, multipliers = (np.array(solution[part]).reshape(-1) for part in ("x", "z"))
    # "unknown" is out of iterations near the optimum, or far from any: the polish decides.
    return polish(rows, which, target, point, multipliers)
