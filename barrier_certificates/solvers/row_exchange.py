"""Exchange binding rows one by one: a dual active-set method that starts from rows nearly right.

In a packed team nearly as many rows bind as there are unknowns, and changing all that are wrong at
once overshoots. Goldfarb and Idnani's method (1983) changes one at a time. It keeps a set of rows
that all push, as equations; takes in the row that their point breaks most, which pushes harder and
harder until it holds; and lets go of a row whose push has come to nothing on the way. Each set's
point is farther from the target than the last, so that no set comes twice.

From one step to the next a dozen rows change among two thousand. So the system of the first rows
is factorised once, and every change borders it with one more equation (Gill, Murray, Saunders and
Wright, A Schur-complement method for sparse quadratic programming, 1990): a row that came is an
equation more; one that went gets a force of its own, which keeps its push at zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.equations import Intersection

_DEPENDENT = 1e-10
"""A row of which less than this lies outside the span of others, squared, depends on them."""


def room(size: int) -> int:
    """Return how many rows may come or go; where it takes more, another solver is quicker.

    Parameters
    ----------
    size : int
        Number of unknowns.
    """
    return size // 12


def exchanged(
    rows: Rows, target: FloatArray, excess: FloatArray, start: Intersection, tolerance: float
) -> IntArray | None:
    """Return the rows that bind at the nearest point that satisfies all.

    Parameters
    ----------
    rows : Rows
        All rows.
    target : (size,) array
        The point to be projected.
    excess : (m,) array
        ``rows.excess(target)``.
    start : Intersection
        Rows that are nearly the answer, with their system.
    tolerance : float
        A row is broken when its excess is above this, m/s.

    Returns
    -------
    (k,) integer array or None
        The rows; None where no point satisfies all, or it takes too many changes.
    """
    try:
        return _settled(_BorderedSystem(rows, excess, start), target, tolerance)
    except np.linalg.LinAlgError:  # rows depend on each other in spite of all
        return None


def _settled(bordered: _BorderedSystem, target: FloatArray, tolerance: float) -> IntArray | None:
    """Let rows go that pull, take in those that are broken, until there are none of either."""
    push = bordered.push()
    while push[weakest := int(push.argmin())] < 0.0:
        if not bordered.has_room():
            return None
        bordered.let_go(weakest)
        push = bordered.push()
    while True:
        gap = bordered.rows.excess(target - bordered.shift(push))
        worst = int(gap.argmax())
        if gap[worst] <= tolerance:
            return bordered.binding()
        if not _takes_in(bordered, worst):
            return None
        push = bordered.push()


def _takes_in(bordered: _BorderedSystem, row: int) -> bool:
    """Let a row push until it holds, and rows go whose push comes to nothing on the way.

    False where it never holds, or there is no room for it.
    """
    new = bordered.column(row)
    while bordered.has_room():
        # For each unit that the new row pushes, the others push by their relief less.
        products = bordered.products(new)
        push, relief = bordered.push(), bordered.relief(new, products)
        outside = float(new.vector @ new.vector - products @ relief)
        enough: float = np.inf
        if outside > _DEPENDENT:
            enough = float(new.excess - products @ push) / outside
        weaker = (relief > 0.0).nonzero()[0]
        lasts = push[weaker] / relief[weaker]
        if enough <= lasts.min(initial=np.inf):
            if enough < np.inf:
                bordered.take_in(new)
            return enough < np.inf
        bordered.let_go(int(weaker[lasts.argmin()]))
    return False


class _Column(NamedTuple):
    """One more equation, as the first rows see it.

    Attributes
    ----------
    change : int
        The row that came; ``~place`` for the row in that place that went.
    vector : (size,) array
        Its coefficients; zero for one that went.
    meets : (k,) array
        Its products with the first rows.
    solved : (k,) array
        The solution of their system with these as right-hand side.
    excess : float
        Its own right-hand side.
    """

    change: int
    vector: FloatArray
    meets: FloatArray
    solved: FloatArray
    excess: float


class _BorderedSystem:
    """The equations of rows that come and go, by the factors of the first ones.

    Its unknowns are how hard rows push: the first rows, then one for each change, which is zero
    where that stands for a row that went. Products are `einsum`'s, which never starts threads.
    """

    def __init__(self, rows: Rows, excess: FloatArray, start: Intersection) -> None:
        assert start.system is not None
        self.rows, self._excess = rows, excess
        self._start, self._system = start.binding, start.system
        self._free = start.multiplier
        self._changes: list[int] = []
        count = self._free.shape[0]
        self._steps_left = most = room(rows.size)
        self._vectors, self._right = np.empty((most, rows.size)), np.empty(most)
        self._meets, self._solved = np.empty((most, count)), np.empty((most, count))
        self._corner = np.empty((most, most))

    def has_room(self) -> bool:
        """Whether another row may come or go."""
        return self._steps_left > 0

    def column(self, row: int) -> _Column:
        """Return what a row would add."""
        vector = self.rows.dense(np.array([row]))[0]
        meets = self._system.rows @ vector
        return _Column(row, vector, meets, self._system.solve(meets), float(self._excess[row]))

    def take_in(self, new: _Column) -> None:
        """Let a row come; one of the first that comes back counts as another one."""
        last = len(self._changes)
        self._steps_left -= 1
        self._changes.append(new.change)
        self._vectors[last], self._right[last] = new.vector, new.excess
        self._meets[last], self._solved[last] = new.meets, new.solved
        every = slice(0, last + 1)
        schur = np.einsum("cx,x->c", self._vectors[every], new.vector)
        schur -= np.einsum("ck,k->c", self._meets[every], new.solved)
        self._corner[last, every] = self._corner[every, last] = schur

    def let_go(self, which: int) -> None:
        """Let go of a row, by its place among the unknowns."""
        count = self._free.shape[0]
        if which >= count:
            self._undo(which - count)
            return
        nothing, meets = np.zeros(self.rows.size), np.zeros(count)
        meets[which] = 1.0
        self.take_in(_Column(~which, nothing, meets, self._system.solve(meets), 0.0))

    def push(self) -> FloatArray:
        """Return how hard rows push where all hold as equations."""
        return self._answer(self._free, self._right[: len(self._changes)])

    def products(self, new: _Column) -> FloatArray:
        """Return how far a unit of push of each row moves the point against another row."""
        vectors = self._vectors[: len(self._changes)]
        return np.append(new.meets, np.einsum("cx,x->c", vectors, new.vector))

    def relief(self, new: _Column, products: FloatArray) -> FloatArray:
        """Return by how much rows push less for each unit that another one pushes."""
        return self._answer(new.solved, products[new.meets.shape[0] :])

    def shift(self, push: FloatArray) -> FloatArray:
        """Return by how much the rows' push moves the target back, (size,) array."""
        count = self._free.shape[0]
        shift: FloatArray = self._system.columns @ push[:count]
        shift += np.einsum("c,cx->x", push[count:], self._vectors[: len(self._changes)])
        return shift

    def binding(self) -> IntArray:
        """Return the rows that hold as equations, in order."""
        gone = [~change for change in self._changes if change < 0]
        came = [change for change in self._changes if change >= 0]
        return np.sort(np.append(np.delete(self._start, gone), came).astype(np.intp))

    def _answer(self, first: FloatArray, last: FloatArray) -> FloatArray:
        """Solve for the changes (Schur's complement), then for the first rows given those."""
        changes = len(self._changes)
        meets, solved = self._meets[:changes], self._solved[:changes]
        last = last - np.einsum("ck,k->c", meets, first)
        change = np.linalg.solve(self._corner[:changes, :changes], last)
        push = np.append(first - np.einsum("c,ck->k", change, solved), change)
        for number, what in enumerate(self._changes):
            if what < 0:
                push[[~what, first.shape[0] + number]] = 0.0
        return push

    def _undo(self, number: int) -> None:
        """Take back that a row came: the last change takes its number."""
        last = len(self._changes) - 1
        self._steps_left -= 1
        self._changes[number] = self._changes[last]
        self._changes.pop()
        for array in (self._vectors, self._right, self._meets, self._solved, self._corner):
            array[number] = array[last]
        self._corner[:, number] = self._corner[:, last]
