"""All rows of a team in one set, in arrays that live from step to step.

The number of rows depends on the number of robots alone, so their indices are written once, and a
step only fills in what changed. In large teams most pairs are too far apart to matter: at the top
speed s of the robots, a pair whose γ h³ is at least 2‖D‖·2s cannot break its row. Such pairs are
not even looked at; a k-d tree finds the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from barrier_certificates import ties
from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.pairs import PairRows
from barrier_certificates.rows.row_family import NOTHING_NEAR, WORLD, Barrier, RowFamily, Scene
from barrier_certificates.rows.row_set import Rows

_DENSE_UP_TO = 20_000  # entries; beyond, a dense matrix besides costs more than it saves


class Margin(NamedTuple):
    """How far something is from being unsafe.

    Attributes
    ----------
    what : str
        ``"robots 3 and 7"``, ``"robot 0 and wall +x"``, …
    h : float
        Its barrier: m² for pairs and obstacles, m for walls.
    clearance : float
        The same in metres.
    """

    what: str
    h: float
    clearance: float


class RowBook:
    """The rows of a team, family after family, written into arrays that live from step to step.

    Parameters
    ----------
    families : sequence of RowFamily
        Walls, obstacles and limits.
    pairs : PairRows, optional
        The pairs; they come last, since their number may change from step to step.
    top_speed : float
        No robot can be faster (m/s, ``inf`` if unknown): far pairs that cannot break their row at
        this speed are left out of large teams.
    prune_from : int
        From this number of robots on, near pairs are looked for in a k-d tree.
    """

    def __init__(
        self,
        families: Sequence[RowFamily],
        pairs: PairRows | None,
        top_speed: float = np.inf,
        prune_from: int = 40,
    ) -> None:
        self.families = tuple(families)
        self.pairs = pairs
        self.top_speed = top_speed
        self.prune_from = prune_from
        self._number = -1
        self._reach = np.inf if pairs is None else pairs.reach(top_speed)

    def write(self, scene: Scene) -> tuple[Rows, Barrier]:
        """Return the rows for a scene, and the barrier of least clearance in it.

        The arrays inside are written again by the next call.

        Parameters
        ----------
        scene : Scene
            Where the team is.

        Returns
        -------
        rows : Rows
            All rows, m/s.
        nearest : Barrier
            The one of least clearance.
        """
        number = scene.positions.shape[1]
        if number != self._number:
            self._lay_out(number)
        nearest = NOTHING_NEAR
        for family, start, coefficient, bound in self._sections:
            nearest = _nearer(nearest, family.update(scene, coefficient, bound), start)
        if self.pairs is not None and number > 1:
            if self._all_pairs is None:
                return self._write_near(scene, nearest)
            barrier = self.pairs.write(
                scene, self._all_pairs, self._pair_coefficient, self._pair_bound
            )
            nearest = _nearer(nearest, barrier, self._fixed)
        self._rows.refresh()
        return self._rows, nearest

    def forget(self) -> None:
        """Lay the rows out anew at the next scene: some family has more or fewer of them."""
        self._number = -1

    def margins(self, scene: Scene, within: float) -> list[Margin]:
        """Return what is near to being unsafe, the closest first.

        Parameters
        ----------
        scene : Scene
            Where the team is.
        within : float
            Leave out what is clear by more than this, m.
        """
        number = scene.positions.shape[1]
        found: list[Margin] = []

        def collect(label: Callable[[int], str], h: FloatArray, clearance: FloatArray) -> None:
            for row in np.flatnonzero(ties.within(clearance, within)):
                found.append(Margin(label(int(row)), float(h[row]), float(clearance[row])))

        for family in self.families:
            collect(partial(family.label, number), *family.measure(scene))
        if self.pairs is not None and number > 1:
            tree = cKDTree(scene.positions.T)
            # The tree rounds otherwise than `measure`, which decides, and has an order of its own.
            reach = self.pairs.radius + within + 2 * ties.TIE
            pairs = tree.query_pairs(reach, output_type="ndarray").T
            pairs = pairs[:, np.lexsort(pairs[::-1])]
            collect(_labeller(str, 0, pairs), *self.pairs.measure(scene, pairs))
        return sorted(found, key=lambda margin: ties.rank(margin.clearance))

    def _lay_out(self, number: int) -> None:
        """Allocate for this number of robots, and write what does not change."""
        self._number = number
        partners = [family.partners(number) for family in self.families]
        self._fixed = sum(p.shape[1] for p in partners)
        prune = number >= self.prune_from and np.isfinite(self._reach)
        self._all_pairs: IntArray | None = None
        if self.pairs is not None and number > 1 and not prune:
            self._all_pairs = np.array(list(combinations(range(number), 2))).T
            partners.append(self._all_pairs)
        joined = np.concatenate(partners, axis=1) if partners else np.zeros((2, 0), dtype=np.intp)
        total = joined.shape[1]
        coefficient, bound = np.zeros((4, total)), np.zeros(total)
        weight = np.empty(total)
        self._sections = []
        start = 0
        for family, block in zip(self.families, partners, strict=False):
            stop = start + block.shape[1]
            weight[start:stop] = family.weight
            section = (coefficient[:, start:stop], bound[start:stop])
            family.prepare(number, *section)
            if stop > start:
                self._sections.append((family, start, *section))
            start = stop
        if self.pairs is not None:
            weight[start:] = self.pairs.weight
        self._pair_coefficient, self._pair_bound = coefficient[:, start:], bound[start:]
        fixed_labels, every = self._fixed_label(number), self._all_pairs
        self._rows = Rows(
            _unknowns(joined, number),
            coefficient,
            bound,
            2 * number,
            weight,
            _labeller(fixed_labels, self._fixed, every),
        )
        self._label_fixed = fixed_labels
        if not prune and total * 2 * number <= _DENSE_UP_TO:
            self._rows.keep_dense()

    def _fixed_label(self, number: int) -> Callable[[int], str]:
        families = self.families  # of these rows, whatever is laid out later
        starts = np.cumsum([0] + [family.partners(number).shape[1] for family in families])

        def label(row: int) -> str:
            place = int(np.searchsorted(starts, row, side="right")) - 1
            return families[place].label(number, row - int(starts[place]))

        return label

    def _write_near(self, scene: Scene, nearest: Barrier) -> tuple[Rows, Barrier]:
        """Write the rows of a large team: only pairs that can break their row at top speed."""
        assert self.pairs is not None
        number, fixed = self._number, self._rows
        tree = cKDTree(scene.positions.T)
        near = self.pairs.near(tree, self._reach)
        coefficient, bound = np.empty((4, near.shape[1])), np.empty(near.shape[1])
        closest = self.pairs.write(scene, near, coefficient, bound)
        rows = Rows(
            np.concatenate([fixed.index, _unknowns(near, number)], axis=1),
            np.concatenate([fixed.coefficient, coefficient], axis=1),
            np.concatenate([fixed.bound, bound]),
            fixed.size,
            np.concatenate([fixed.weight, np.full(near.shape[1], self.pairs.weight)]),
            _labeller(self._label_fixed, self._fixed, near),
            np.concatenate([np.arange(self._fixed), self._fixed + near[0] * number + near[1]]),
        )
        return rows, _nearer(nearest, closest, self._fixed)


def _nearer(nearest: Barrier, found: Barrier, start: int) -> Barrier:
    """Return which barrier has less clearance; the rows of the one found begin at ``start``."""
    if ties.short_of(found.clearance, nearest.clearance):  # of equally near, the first is told
        return Barrier(found.h, found.clearance, start + found.row)
    return nearest


def _unknowns(partners: IntArray, number: int) -> IntArray:
    """Which unknowns rows between these partners (2, m) touch, shape (4, m)."""
    first, second = partners
    world = second == WORLD
    at_world = 2 * number
    return np.stack(
        [
            2 * first,
            2 * first + 1,
            np.where(world, at_world, 2 * second),
            np.where(world, at_world, 2 * second + 1),
        ]
    )


def _labeller(
    fixed: Callable[[int], str], count: int, pairs: IntArray | None
) -> Callable[[int], str]:
    """Say what a row stands for: the first ``count`` are labelled, the rest are pairs."""

    def label(row: int) -> str:
        if row < count or pairs is None:
            return fixed(row)
        first, second = pairs[:, row - count]
        return f"robots {first} and {second}"

    return label
