"""Guess which rows bind, solve for that guess, and prove it right: the solver for the easy steps.

Of the hundreds of rows of a team only a handful bind, and from one step to the next they are mostly
the same. If the binding rows A were known, the projection would be one small linear system: ``x =
x̂ − Aᵀλ`` with ``A Aᵀ λ = A x̂ − b``. The primal-dual active set method (Hintermüller, Ito and
Kunisch, 2002) guesses them: start with the rows that are broken at the target, solve, drop rows
that would pull (λ < 0), add rows that are now broken, repeat. When nothing changes, all conditions
of optimality hold and the point is *the* optimum, proved, not assumed. Started from the rows that
bound in the previous step, nine guesses in ten are right at once.

Where robots press together, nearly as many rows bind as there are unknowns, and changing all that
are wrong at once overshoots: a thousand are wrong next. A large team's rows that are nearly right
are then exchanged one by one (`barrier_certificates.solvers.row_exchange`), and what comes of that
is proved like any other guess.

The method can cycle, or meet rows that depend on each other. It then says so (``None``), and an
exact solver takes over from the rows seen so far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.equations import Intersection, intersection
from barrier_certificates.solvers.row_exchange import exchanged, room

_CROWDED = 0.75
"""Where more rows bind than this part of the unknowns, changing all that are wrong overshoots."""
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
    binding, best = warm, None
    for count in range(1, tries + 1):
        if not binding.shape[0]:  # nothing remembered, or all of it pulls and hides no broken row
            binding = _worst_of_each_robot(rows, excess, tolerance)
        trial = _try(rows, target, excess, binding, tolerance)
        if trial is not None and trial.is_optimal():
            slack = trial.gap.take(trial.at.binding)
            loose = -slack[slack.argmin()]
            if loose > _TIGHT and loose > _TIGHT * excess[excess.argmax()]:
                break  # too ill-conditioned to prove anything
            return Guess(trial.at.point, trial.at.binding, trial.worst, count)
        if trial is None or trial.overshoots(best):
            start = best
        elif trial.is_crowded():
            start = trial
        else:
            best = trial if trial.is_nearly_right() else None
            binding = trial.changed()
            continue
        right = None if start is None else exchanged(rows, target, excess, start.at, tolerance)
        if right is None:
            break
        binding, best = right, None
    return Guess(None, binding, np.inf, count)


class _Trial(NamedTuple):
    """A guess that was tried: the point where its rows bind, and what is wrong with it.

    Attributes
    ----------
    at : Intersection
        The point, and how hard its rows push.
    gap : (m,) array
        How far each row is broken there, m/s.
    worst : float
        The largest of it.
    pulls : bool
        Whether some row pulls.
    tolerance : float
        A row is broken when its excess is above this, m/s.
    """

    at: Intersection
    gap: FloatArray
    worst: float
    pulls: bool
    tolerance: float

    def is_optimal(self) -> bool:
        """Whether no row pulls, and none is broken."""
        return not self.pulls and self.worst <= self.tolerance

    def wrong(self) -> int:
        """Return how many rows pull or are broken."""
        pulling = np.count_nonzero(self.at.multiplier < 0.0)
        return int(pulling + np.count_nonzero(self.gap > self.tolerance))

    def overshoots(self, best: _Trial | None) -> bool:
        """Whether more than half as many rows are wrong as in the trial that was nearly right."""
        return best is not None and 2 * self.wrong() > best.wrong()

    def is_nearly_right(self) -> bool:
        """Whether its rows can be exchanged one by one."""
        size = self.at.point.shape[0]
        return self.at.system is not None and 2 * self.wrong() <= room(size)

    def is_crowded(self) -> bool:
        """Whether it is nearly right, but changing all that is wrong at once would overshoot."""
        many = self.at.binding.shape[0] > _CROWDED * self.at.point.shape[0]
        return many and self.is_nearly_right()

    def changed(self) -> IntArray:
        """Return the rows without those that pull, and with those that are broken."""
        binding = self.at.binding
        if self.pulls:
            binding = binding[self.at.multiplier >= 0.0]
        broken = self.gap > self.tolerance
        broken[binding] = True
        return broken.nonzero()[0]


def _try(
    rows: Rows, target: FloatArray, excess: FloatArray, binding: IntArray, tolerance: float
) -> _Trial | None:
    """Return what is wrong where these rows bind; None where they have no point in common."""
    if binding.shape[0] > rows.size:
        return None
    at = intersection(rows, target, excess, binding)
    if at is None:
        return None
    gap = rows.excess(at.point)
    worst = float(gap[gap.argmax()])
    return _Trial(at, gap, worst, at.multiplier[at.multiplier.argmin()] < 0.0, tolerance)


def _worst_of_each_robot(rows: Rows, excess: FloatArray, tolerance: float) -> IntArray:
    """Pick the row that each robot's command breaks most; these seldom depend on each other."""
    broken = (excess > tolerance).nonzero()[0]
    worst_first = broken[np.argsort(-excess[broken], kind="stable")]
    _, first = np.unique(rows.index[0, worst_first], return_index=True)
    return np.sort(worst_first[first])


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
