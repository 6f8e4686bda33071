"""A set of rows in arrays: what the solvers get.

A row touches one robot or two, so at most four of the 2N unknowns. The rows of a team are therefore
kept as four indices and four coefficients each, never as a dense matrix alone; the unknown after
the last is the *world*, which always stands still and is the partner of walls, limits and
obstacles.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse

from barrier_certificates.array_types import FloatArray, IntArray


class Rows:
    """A set of rows ``a·x ≤ b`` over ``size`` unknowns, each touching at most K of them.

    Parameters
    ----------
    index : (K, m) integer array
        Which unknowns each row touches; the value ``size`` stands for the world.
    coefficient : (K, m) array
        Their coefficients; the world's are zero.
    bound : (m,) array
        Right-hand sides, m/s.
    size : int
        Number of unknowns: 2N, robot by robot (x₁, y₁, x₂, y₂, …), plus slacks if there are any.
    weight : (m,) array
        What a unit of slack costs when no point satisfies all rows; infinite means never given up.
    label : callable
        ``label(row)`` says what the row stands for.
    key : (m,) integer array, optional
        Names that stay with a row from step to step while rows come and go; its index by default.
    """

    __slots__ = (
        "_flat",
        "_matrix",
        "_padded",
        "_place",
        "bound",
        "coefficient",
        "index",
        "key",
        "label",
        "size",
        "weight",
    )

    def __init__(
        self,
        index: IntArray,
        coefficient: FloatArray,
        bound: FloatArray,
        size: int,
        weight: FloatArray,
        label: Callable[[int], str],
        key: IntArray | None = None,
    ) -> None:
        self.index = index
        self.coefficient = coefficient
        self.bound = bound
        self.size = size
        self.weight = weight
        self.label = label
        self.key = key
        self._padded = np.zeros(size + 1)  # the world, which is last, stands still
        self._flat: FloatArray | None = None

    def __len__(self) -> int:
        return int(self.bound.shape[0])

    def keep_dense(self) -> None:
        """Keep a dense matrix besides, which is faster while it fits the processor's cache.

        `refresh` has to follow every change of the coefficients.
        """
        self._flat, self._place = _flat_matrix(self.index, self.size)
        self._matrix = self._flat[:-1].reshape(-1, self.size)
        self.refresh()

    def refresh(self) -> None:
        """Bring the dense matrix up to date, if there is one."""
        if self._flat is not None:
            self._flat[self._place] = self.coefficient

    def excess(self, x: FloatArray) -> FloatArray:
        """Return how far each row is broken.

        Parameters
        ----------
        x : (size,) array
            The velocities, x and y of all robots, m/s.

        Returns
        -------
        (m,) array
            Excess, m/s; negative where a row holds.
        """
        total: FloatArray
        if self._flat is not None:
            total = self._matrix.dot(x)  # half of what `@` costs on small arrays
            total -= self.bound
            return total
        self._padded[:-1] = x
        product = self._padded.take(self.index)
        product *= self.coefficient
        total = np.add.reduce(product, axis=0)
        total -= self.bound
        return total

    def dense(self, which: IntArray) -> FloatArray:
        """Return the chosen rows as a matrix.

        Parameters
        ----------
        which : (k,) integer array
            Indices of the rows.

        Returns
        -------
        (k, size) array
            Coefficients a: a row for each, a column for each unknown.
        """
        if self._flat is not None:
            return self._matrix.take(which, axis=0)
        flat, place = _flat_matrix(self.index.take(which, axis=1), self.size)
        flat[place] = self.coefficient.take(which, axis=1)
        return flat[:-1].reshape(-1, self.size)

    def sparse(self, which: IntArray) -> sparse.csr_matrix:
        """Return the chosen rows as a sparse matrix.

        Parameters
        ----------
        which : (k,) integer array
            Indices of the rows.

        Returns
        -------
        (k, size) sparse array
            Coefficients a, in compressed rows.
        """
        index = self.index.take(which, axis=1).T
        here = index < self.size
        ends = np.zeros(which.shape[0] + 1, dtype=np.intp)
        np.count_nonzero(here, axis=1).cumsum(out=ends[1:])
        coefficient = self.coefficient.take(which, axis=1).T
        data = (coefficient[here], index[here], ends)
        return sparse.csr_matrix(data, shape=(which.shape[0], self.size))

    def take(self, which: IntArray) -> Rows:
        """Return the chosen rows as a set of their own.

        Parameters
        ----------
        which : (k,) integer array
            Indices of the rows.
        """
        return Rows(
            self.index[:, which],
            self.coefficient[:, which],
            self.bound[which],
            self.size,
            self.weight[which],
            lambda row: self.label(int(which[row])),
        )

    def with_bound(self, bound: FloatArray) -> Rows:
        """Return the same rows with other right-hand sides; all other arrays are shared.

        Parameters
        ----------
        bound : (m,) array
            The right-hand sides, m/s.
        """
        rows = Rows(
            self.index,
            self.coefficient,
            bound,
            self.size,
            self.weight,
            self.label,
            self.key,
        )
        if self._flat is not None:
            rows._flat, rows._matrix, rows._place = self._flat, self._matrix, self._place
        return rows

    def softened(self) -> Rows:
        """Return the rows with a slack unknown for each row that may be given up.

        Slacks are scaled by the root of their weight, so that the sum of squares of all unknowns
        is the objective and every solver of the plain problem solves this one too.
        """
        soft = np.flatnonzero(np.isfinite(self.weight))
        size = self.size + soft.shape[0]
        index = np.full((self.index.shape[0] + 1, len(self)), size)
        index[:-1] = np.where(self.index == self.size, size, self.index)
        index[-1, soft] = self.size + np.arange(soft.shape[0])
        coefficient = np.zeros(index.shape)
        coefficient[:-1] = self.coefficient
        coefficient[-1, soft] = -1.0 / np.sqrt(self.weight[soft])
        return Rows(index, coefficient, self.bound, size, self.weight, self.label, self.key)


def _flat_matrix(index: IntArray, size: int) -> tuple[FloatArray, IntArray]:
    """Return a matrix of zeros, row after row, and where in it coefficients (K, m) belong.

    Behind its last row is a place for those of the world, which has no column.
    """
    total = index.shape[1] * size
    place = index + np.arange(0, total, size)
    place[index == size] = total
    return np.zeros(total + 1), place
