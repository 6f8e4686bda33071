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

_DEFAULTS = {"eps_abs": 1e-10, "eps_rel": 1e-10}


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
        Settings of PIQP, such as ``max_iter``.

    Returns
    -------
    (size,) array or None
        The nearest point, m/s; None if there is none.
    """
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
    return polish(rows, which, target, np.asarray(solver.result.x), np.asarray(solver.result.z_u))
