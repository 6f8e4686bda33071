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
from barrier_certificates.solvers.qp_solver import QpSolver

_TOLERANCES = ((1e-15, 1e-12), (1e-13, 1e-11), (1e-11, 1e-10))  # gap, rows: the finest that works


class Cvxpy(QpSolver):
    """Writes a model in cvxpy; options are settings of Clarabel, which solves it."""

    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
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
                    # "may be inaccurate": then the next is tried
                    warnings.simplefilter("ignore", UserWarning)
                    problem.solve(solver=cvxpy.CLARABEL, **settings)
            except cvxpy.SolverError:
                continue
            if problem.status == cvxpy.OPTIMAL:
                return np.asarray(velocity.value)
        return None
