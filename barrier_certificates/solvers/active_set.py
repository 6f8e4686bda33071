"""Guess which rows bind, solve for that guess, and prove it right: the solver for the easy steps.

Of the hundreds of rows of a team only a handful bind, and from one step to the next they are mostly
the same. If the binding rows A were known, the projection would be one small linear system: ``x =
x̂ − Aᵀλ`` with ``A Aᵀ λ = A x̂ − b``. The primal-dual active set method (Hintermüller, Ito and
Kunisch, 2002) guesses them: start with the rows that are broken at the target, solve, drop rows
that would pull (λ < 0), add rows that are now broken, repeat. When nothing changes, all conditions
of optimality hold and the point is *the* optimum, proved, not assumed. Started from the rows that
bound in the previous step, nine guesses in ten are right at once.

The method can cycle, or meet rows that depend on each other. It then says so (``None``), and an
exact solver takes over from the rows seen so far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows

# Binding rows; with more, OpenBLAS takes several threads, which on a busy machine wait for each
# other for longer than the sparse factorisation takes.
_DENSE_UP_TO = 100
_POLISHES = 6
_TIGHT = 1e-12  # binding rows hold as equations to within rounding, relative to the largest excess


class Guess(NamedTuple):
    """What guessing came to.

    Attributes
    ----------
    point : (size,) array or None
        The optimum, or None where the guesses did not settle.
    binding : (k,) integer array
        The rows that bind.
    violation : float
        Largest excess over all rows at the point, m/s.
    solved : int
        Linear systems solved.
    """

    point: FloatArray | None
    binding: IntArray
    violation: float
    solved: int


def guess(
    rows: Rows, target: FloatArray, excess: FloatArray, warm: IntArray, tolerance: float, tries: int
) -> Guess:
    """Find the nearest point by guessing which rows bind.

    Parameters
    ----------
    rows : Rows
        All rows.
    target : (size,) array
        The point to be projected.
    excess : (m,) array
        ``rows.excess(target)``.
    warm : (k,) integer array
        Rows that bound last time.
    tolerance : float
        A row is broken when its excess is above this, m/s.
    tries : int
        Give up after so many guesses.
    """
    binding = warm
    for count in range(1, tries + 1):
        if not binding.shape[0]:  # nothing remembered, or all of it pulls and hides no broken row
            binding = _worst_of_each_robot(rows, excess, tolerance)
        if binding.shape[0] > rows.size:
            break
        solved = _solve(rows, target, excess, binding)
        if solved is None:
            break
        point, multiplier, binding = solved
        gap = rows.excess(point)
        worst = gap[gap.argmax()]
        pulling = multiplier[multiplier.argmin()] < 0.0
        if not pulling and worst <= tolerance:
            slack = gap.take(binding)
            if -slack[slack.argmin()] > _TIGHT * max(1.0, excess[excess.argmax()]):
                break  # too ill-conditioned to prove anything
            return Guess(point, binding, float(worst), count)
        if pulling:
            binding = binding[multiplier >= 0.0]
        broken = gap > tolerance
        broken[binding] = True
        binding = broken.nonzero()[0]
    return Guess(None, binding, np.inf, count)


def _worst_of_each_robot(rows: Rows, excess: FloatArray, tolerance: float) -> IntArray:
    """Pick the row that each robot's command breaks most; these seldom depend on each other."""
    broken = (excess > tolerance).nonzero()[0]
    worst_first = broken[np.argsort(-excess[broken], kind="stable")]
    _, first = np.unique(rows.index[0, worst_first], return_index=True)
    return np.sort(worst_first[first])


def _solve(
    rows: Rows, target: FloatArray, excess: FloatArray, binding: IntArray
) -> tuple[FloatArray, FloatArray, IntArray] | None:
    """Project on the intersection of the binding rows as equations.

    Rows that depend on others are left out: returns point, multipliers and the rows kept.
    """
    if binding.shape[0] > _DENSE_UP_TO:
        return _solve_sparse(rows, target, excess, binding)
    matrix = rows.dense(binding)
    while True:
        _, multiplier, dependent = lapack.dposv(matrix @ matrix.T, excess.take(binding))
        if dependent == 0:
            return target - multiplier @ matrix, multiplier, binding
        if dependent < 0 or binding.shape[0] == 1:
            return None
        kept = np.arange(binding.shape[0]) != dependent - 1
        matrix, binding = matrix[kept], binding[kept]


def _solve_sparse(
    rows: Rows, target: FloatArray, excess: FloatArray, binding: IntArray
) -> tuple[FloatArray, FloatArray, IntArray] | None:
    """Do the same with a sparse factorisation; None where rows depend on each other."""
    thin = rows.sparse(binding)
    try:
        factors = splu(
            (thin @ thin.T).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # exactly singular
        return None
    multiplier = factors.solve(excess.take(binding))
    return target - thin.T @ multiplier, multiplier, binding


def polish(
    rows: Rows, which: IntArray, target: FloatArray, near: FloatArray, multipliers: FloatArray
) -> FloatArray:
    """Turn an approximate optimum into the exact one, if its binding rows can be told.

    Parameters
    ----------
    rows : Rows
        All rows.
    which : (k,) integer array
        Indices of the rows to satisfy.
    target : (size,) array
        The point to be projected, m/s.
    near : (size,) array
        A point near the optimum.
    multipliers : (k,) array
        Its multipliers: those of the binding rows are far above the others.

    Returns
    -------
    (size,) array
        The optimum over the chosen rows, or ``near`` where the binding rows stay in doubt.
    """
    chosen = rows.take(which)
    gap = -chosen.excess(near)
    binding = (multipliers > gap).nonzero()[0]
    if not binding.shape[0]:
        return near
    excess = chosen.excess(target)
    point = guess(chosen, target, excess, binding, 1e-11, _POLISHES).point
    return near if point is None else point
