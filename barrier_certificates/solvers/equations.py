"""Rows that bind, taken as equations: the point nearest to a target that is on all of them.

If the rows A bind, that point is one small linear system: ``x = x̂ − Aᵀλ`` with ``A Aᵀ λ = A x̂ −
b``. Up to a hundred rows it is dense. Beyond, it is sparse: rows that share no robot do not meet in
A Aᵀ, and a robot has a handful of neighbours at most.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows

# Binding rows; with more, OpenBLAS takes several threads, which on a busy machine wait for each
# other for longer than the sparse factorisation takes.
_DENSE_UP_TO = 100


class SparseSystem:
    """The system A Aᵀ λ = r of sparse rows, factorised once and solved for many r.

    Parameters
    ----------
    rows : (k, size) sparse array
        The rows A.

    Attributes
    ----------
    rows, columns : sparse arrays
        A and Aᵀ.

    Raises
    ------
    RuntimeError
        If rows depend on each other, exactly.
    """

    def __init__(self, rows: sparse.csr_matrix) -> None:
        self.rows, self.columns = rows, rows.T
        self._factors = splu(
            (rows @ self.columns).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution.

        Parameters
        ----------
        right : (k,) array
            The right-hand side r.

        Returns
        -------
        (k,) array
            The solution λ.
        """
        multiplier: FloatArray = self._factors.solve(right)
        return multiplier


class Intersection(NamedTuple):
    """The nearest point on rows taken as equations.

    Attributes
    ----------
    point : (size,) array
        Where all rows hold as equations, m/s.
    multiplier : (k,) array
        How hard each row pushes; negative where it pulls.
    binding : (k,) integer array
        The rows, those left out that depend on others.
    system : SparseSystem or None
        What was factorised, where that was sparse.
    """

    point: FloatArray
    multiplier: FloatArray
    binding: IntArray
    system: SparseSystem | None = None


def intersection(
    rows: Rows, target: FloatArray, excess: FloatArray, binding: IntArray
) -> Intersection | None:
    """Return the point nearest to the target that is on all the rows given.

    Parameters
    ----------
    rows : Rows
        All rows.
    target : (size,) array
        The point to be projected.
    excess : (m,) array
        ``rows.excess(target)``.
    binding : (k,) integer array
        The rows taken as equations, one or more.

    Returns
    -------
    Intersection or None
        None where rows depend on each other, beyond what leaving some out mends.
    """
    if binding.shape[0] > _DENSE_UP_TO:
        try:
            system = SparseSystem(rows.sparse(binding))
        except RuntimeError:
            return None
        multiplier = system.solve(excess.take(binding))
        return Intersection(target - system.columns @ multiplier, multiplier, binding, system)
    matrix = rows.dense(binding)
    while True:
        # `dot` costs half of `@` on small arrays.
        _, multiplier, dependent = lapack.dposv(matrix.dot(matrix.T), excess.take(binding))
        if dependent == 0:
            return Intersection(target - multiplier.dot(matrix), multiplier, binding)
        if dependent < 0 or binding.shape[0] == 1:
            return None
        kept = np.arange(binding.shape[0]) != dependent - 1
        matrix, binding = matrix[kept], binding[kept]
