"""What every solver does: one signature, whatever it is made of."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Protocol

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows


class QpSolver(Protocol):
    """Who solves the quadratic program: the point nearest to a target that satisfies rows."""

    @abstractmethod
    def solve(
        self, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
    ) -> FloatArray | None:
        """Return the point nearest to the target that satisfies the chosen rows.

        Parameters
        ----------
        rows : Rows
            All rows.
        which : (k,) integer array
            Indices of the rows to satisfy.
        target : (size,) array
            The point to be projected, m/s.
        options : mapping
            The solver's own, by their own names; they hold for this call.

        Returns
        -------
        (size,) array or None
            None if no point satisfies them, or none was found.
        """
