"""The problem as one would write it on a blackboard: the reference that the others are held to.

Readable first: the model is built anew with each call, which takes milliseconds.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows

_TOLERANCES = ((1e-15, 1e-12), (1e-13, 1e-11), (1e-11, 1e-10))  # gap, rows: the finest that works


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
        Settings of Clarabel, which solves the model.

    Returns
    -------
    (size,) array or None
        The nearest point, m/s; None if there is none.
    """
    cvxpy: Any = import_module("cvxpy")
    velocity = cvxpy.Variable(rows.size)
    problem = cvxpy.Problem(
        cvxpy.Minimize(cvxpy.sum_squares(velocity - target)),
        [rows.sparse(which) @ velocity <= rows.bound.take(which)],
    )
    for gap, feasible in _TOLERANCES:
        settings = {"tol_feas": feasible, "tol_gap_abs": gap, "tol_gap_rel": gap, **options}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # "may be inaccurate": try the next
                problem.solve(solver=cvxpy.CLARABEL, **settings)
        except cvxpy.SolverError:
            continue
        if problem.status == cvxpy.OPTIMAL:
            return np.asarray(velocity.value)
    return None
