"""Rows that bind, taken as equations: the point nearest to a target that is on all of them.

If the rows A bind, that point is one small linear system: ``x = x̂ − Aᵀλ`` with ``A Aᵀ λ = A x̂ −
b``. Up to a hundred rows it is dense. Beyond, it is sparse: rows that share no robot do not meet in
A Aᵀ, and a robot has a handful of neighbours at most. Numbered from neighbour to neighbour (reverse
Cuthill-McKee), the rows of a thousand robots that press together make a band of some seventy
diagonals, and Cholesky's factors fill no more than the band.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg import lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows

# Binding rows; with more, OpenBLAS takes several threads, which on a busy machine wait for each
# other for longer than the sparse factorisation takes.
_DENSE_UP_TO = 100


class BandedSystem:
    """The system A Aᵀ λ = r of sparse rows, factorised once and solved for many r.

    Parameters
    ----------
    rows : (k, size) sparse array
        The rows A.

    Attributes
    ----------
    rows : (k, size) sparse array
        The rows A.
    dependent : bool
        Whether rows depend on each other, to within rounding: there is nothing to be solved then.
    """

    def __init__(self, rows: sparse.csr_matrix) -> None:
        self.rows = rows
        product = (rows @ rows.T).tocsr()
        self._order = reverse_cuthill_mckee(product, symmetric_mode=True)
        self._place = np.empty_like(self._order)
        self._place[self._order] = np.arange(self._order.shape[0])
        entries = product.tocoo()
        row, column = self._place[entries.row], self._place[entries.col]
        lower = row >= column
        diagonal, column = row[lower] - column[lower], column[lower]
        band = np.zeros((int(diagonal.max()) + 1, rows.shape[0]), order="F")
        band[diagonal, column] = entries.data[lower]
        self._factor, failed = lapack.dpbtrf(band, lower=1, overwrite_ab=1)
        self.dependent = failed != 0

    def solve(self, right: FloatArray) -> FloatArray:
        """Return λ.

        Parameters
        ----------
        right : (k,) array
            The right-hand side r.
        """
        ordered, _ = lapack.dpbtrs(self._factor, right[self._order], lower=1, overwrite_b=1)
        solution: FloatArray = ordered[self._place]
        return solution


class Intersection(NamedTuple):
    """The nearest point on rows taken as equations.

    Attributes
    ----------
    point : (size,) array
        The point.
    multiplier : (k,) array
        How hard each row pushes; negative where it pulls.
    binding : (k,) integer array
        The rows, those left out that depend on others.
    system : BandedSystem or None
        What was factorised, where that was sparse.
    """

    point: FloatArray
    multiplier: FloatArray
    binding: IntArray
    system: BandedSystem | None = None


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
        system = BandedSystem(rows.sparse(binding))
        if system.dependent:
            return None
        multiplier = system.solve(excess.take(binding))
        return Intersection(target - system.rows.T @ multiplier, multiplier, binding, system)
    matrix = rows.dense(binding)
    while True:
        _, multiplier, dependent = lapack.dposv(matrix @ matrix.T, excess.take(binding))
        if dependent == 0:
            return Intersection(target - multiplier @ matrix, multiplier, binding)
        if dependent < 0 or binding.shape[0] == 1:
            return None
        kept = np.arange(binding.shape[0]) != dependent - 1
        matrix, binding = matrix[kept], binding[kept]
