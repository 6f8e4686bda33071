"""Guess which rows bind, solve for that guess, and prove it right: the solver for the easy steps.

Of the hundreds of rows of a team only a handful bind, and from one step to the next they are mostly
the same. If the binding rows A were known, the projection would be one small linear system: ``x =
x̂ − Aᵀλ`` with ``A Aᵀ λ = A x̂ − b``. The primal-dual active set method (Hintermüller, Ito and
Kunisch, 2002) guesses them: start with the rows that are broken at the target, solve, drop rows
that would pull (λ < 0), add rows that are now broken, repeat. When nothing changes, all conditions
of optimality hold and the point is *the* optimum, proved, not assumed.

The method can cycle, or meet rows that depend on each other. It then says so (``None``), and an
exact solver takes over from the rows seen so far.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from barrier_certificates.rows import FloatArray, IntArray, Rows

_DENSE_UP_TO = 150  # binding rows; above, factorising the sparse matrix is faster


def guess(
    rows: Rows, target: FloatArray, excess: FloatArray, warm: IntArray, tolerance: float, tries: int
) -> tuple[FloatArray | None, FloatArray, IntArray, int]:
    """Find the nearest point by guessing which rows bind.

    Parameters
    ----------
    rows : Rows
        All rows.
    target : (size,) array
        The point to be projected.
    excess : (m,) array
        ``rows.excess(target)``.
    warm : integer array
        Rows that bound last time.
    tolerance : float
        A row is broken when its excess is above this, m/s.
    tries : int
        Give up after so many guesses.

    Returns
    -------
    point : (size,) array or None
        The optimum, or None where the guesses did not settle.
    multipliers, rows : arrays
        Multipliers and indices of the binding rows (or, without a point, those guessed last).
    int
        Linear systems solved.
    """
    broken = excess > tolerance
    if warm.shape[0]:
        broken[warm] = True
    binding = np.flatnonzero(broken)
    multiplier = excess[:0]
    for count in range(1, tries + 1):
        if binding.shape[0] > rows.size:
            return None, multiplier, binding, count
        solved = _solve(rows, target, excess, binding)
        if solved is None:
            return None, multiplier, binding, count
        point, multiplier = solved
        pushing = multiplier >= 0.0
        broken = rows.excess(point) > tolerance
        if not pushing.all():
            kept = binding[pushing]
        elif broken.any():
            kept = binding
        else:
            return point, multiplier, binding, count
        broken[kept] = True
        binding = np.flatnonzero(broken)
    return None, multiplier, binding, tries


def _solve(
    rows: Rows, target: FloatArray, excess: FloatArray, binding: IntArray
) -> tuple[FloatArray, FloatArray] | None:
    """Project on the intersection of the binding rows as equations; None if they are dependent."""
    if binding.shape[0] <= _DENSE_UP_TO:
        matrix = rows.dense(binding)
        _, multiplier, info = lapack.dposv(matrix @ matrix.T, excess[binding])
        if info != 0:
            return None
        return target - multiplier @ matrix, multiplier
    thin = rows.sparse(binding)
    try:
        factors = splu(
            (thin @ thin.T).tocsc(), options={"SymmetricMode": True}, diag_pivot_thresh=0.0
        )
    except RuntimeError:  # exactly singular
        return None
    multiplier = factors.solve(excess[binding])
    return target - thin.T @ multiplier, multiplier
