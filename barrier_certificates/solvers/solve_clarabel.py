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

_DEFAULTS = {"tol_feas": 1e-10, "tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11}
_ENOUGH = ("Solved", "AlmostSolved")


def solve(
    rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
) -> FloatArray | None:
    """Return the nearest point to the target that satisfies the chosen rows.

    Parameters
    ----------
    rows : Rows
        All rows.
    which : (k,) integer array
        Indices of the rows to satisfy.
    target : (size,) array
        The point to be projected, m/s.
    options : mapping
        Settings of Clarabel, such as ``max_iter``.

    Returns
    -------
    (size,) array or None
        The nearest point, m/s; None if there is none.
    """
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
