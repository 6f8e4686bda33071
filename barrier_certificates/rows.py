r"""What must hold: linear rows :math:`a^\top v \le b` on the velocities of a team.

A *control barrier function* ``h`` is positive where a team is safe. Keeping
:math:`\dot h \ge -\gamma h^3` at every moment keeps ``h`` positive for ever, and because
:math:`\dot h` is linear in the velocities, the condition is one linear row. Three sources of rows
cover a team in an arena:

=========  ==================================================  ==================================
kind       barrier                                             row
=========  ==================================================  ==================================
pair       h = ‖xᵢ − xⱼ‖² − r²                                 −2D·vᵢ + 2D·vⱼ ≤ γ h³, D = xᵢ − xⱼ
obstacle   h = ‖xᵢ − c‖² − R², c the obstacle's nearest point  −2D·vᵢ + 2D·ċ ≤ γ h³,  D = xᵢ − c
wall       g = distance to the wall − margin                   n·vᵢ ≤ 0.4 γ g³, n out of the arena
limit      (none: what the motors can do)                      n·vᵢ ≤ b, for each side of a polygon
=========  ==================================================  ==================================

Every row is scaled to unit norm, so how far a row is broken is a speed in m/s, whatever its kind,
and one tolerance serves all.

A row touches one robot or two, so at most four of the 2N unknowns. The rows of a team are therefore
kept as four indices and four coefficients each (`Rows`), never as a dense matrix; the unknown after
the last is the *world*, which always stands still and is the partner of walls, limits and
obstacles. Families (`PairRows`, `WallRows`, `ObstacleRows`, `LimitRows`) know how to write their
rows in place, and `RowBook` keeps the arrays between steps, so that a step allocates little.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import combinations
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

WORLD = -1
"""Stands in for a robot where a row has no second one."""

_SQRT2 = float(np.sqrt(2.0))
_COINCIDENT = 1e-9  # m; below this the direction between two robots is rounding noise


class Barrier(NamedTuple):
    """The value that decides safety, in the barrier's own unit and in metres.

    ``h`` is ‖D‖² − r² in m² for pairs and obstacles, and the distance less the margin in m for
    walls; ``clearance`` is in metres for all. Both are negative exactly when something is unsafe.
    """

    h: float
    clearance: float


NOTHING_NEAR = Barrier(np.inf, np.inf)


class Scene(NamedTuple):
    """Where the team is: positions (2, N) in m and, where robots have one, headings (2, N)."""

    positions: FloatArray
    headings: FloatArray | None = None


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

    __slots__ = ("bound", "coefficient", "index", "key", "label", "size", "weight")

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

    def __len__(self) -> int:
        return int(self.bound.shape[0])

    def excess(self, x: FloatArray) -> FloatArray:
        """Return how far each row is broken at ``x``, (m,) in m/s; negative where it holds."""
        padded = np.empty(self.size + 1)
        padded[:-1] = x
        padded[-1] = 0.0
        product = padded.take(self.index)
        product *= self.coefficient
        total: FloatArray = np.add.reduce(product, axis=0)
        total -= self.bound
        return total

    def dense(self, which: IntArray) -> FloatArray:
        """Return the chosen rows as a matrix, shape (len(which), size)."""
        width = self.size + 1
        flat = np.zeros(which.shape[0] * width)
        # Only the world can occur twice in a row, and its column is cut off.
        place = self.index.take(which, axis=1)
        place += np.arange(0, flat.shape[0], width)
        flat[place] = self.coefficient.take(which, axis=1)
        return flat.reshape(-1, width)[:, : self.size]

    def sparse(self, which: IntArray) -> sparse.csr_matrix:
        """Return the chosen rows as a sparse matrix, shape (len(which), size)."""
        index = self.index[:, which]
        row = np.broadcast_to(np.arange(which.shape[0]), index.shape)
        here = index < self.size
        data = (self.coefficient[:, which][here], (row[here], index[here]))
        return sparse.csr_matrix(data, shape=(which.shape[0], self.size))

    def take(self, which: IntArray) -> Rows:
        """Return the chosen rows as a set of their own."""
        return Rows(
            self.index[:, which],
            self.coefficient[:, which],
            self.bound[which],
            self.size,
            self.weight[which],
            lambda row: self.label(int(which[row])),
        )

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


class Family(Protocol):
    """Rows of one kind whose number depends on the number of robots alone."""

    weight: float

    def partners(self, number: int) -> IntArray:
        """Which robots each row joins, shape (2, m); `WORLD` where there is no second one."""

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write what never changes into ``coefficient`` (4, m) and ``bound`` (m,)."""

    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Write what changes with the scene; return the smallest barrier of the family."""

    def label(self, number: int, row: int) -> str:
        """Say what the row stands for."""


class PairRows:
    r"""Every two robots stay a radius apart: −2D·vᵢ + 2D·vⱼ ≤ γ h³, h = ‖D‖² − r².

    Parameters
    ----------
    radius : float
        Smallest distance between two positions, m.
    gain : float
        γ, in 1/(m⁴ s): how fast a pair may close.
    unsafe_gain : float, optional
        γ for pairs that are already too close (h < 0): how fast they must part. Default: ``gain``.
    weight : float
        Cost of giving a row up when no velocity satisfies all rows.
    """

    def __init__(
        self, radius: float, gain: float, unsafe_gain: float | None = None, weight: float = 1e6
    ) -> None:
        self.radius = radius
        self.gain = gain
        self.unsafe_gain = gain if unsafe_gain is None else unsafe_gain
        self.weight = weight

    def write(
        self, positions: FloatArray, pairs: IntArray, coefficient: FloatArray, bound: FloatArray
    ) -> Barrier:
        """Write the rows of the given pairs (2, m)."""
        offset = positions.take(pairs[0], axis=1)
        offset -= positions.take(pairs[1], axis=1)
        square = offset[0] * offset[0]
        square += offset[1] * offset[1]
        # argmin costs a tenth of min on small arrays.
        nearest = float(square[square.argmin()]) if square.shape[0] else np.inf
        if nearest < _COINCIDENT**2:
            square = _part_coincident(offset, square, pairs)
        h = square - self.radius**2
        smallest = nearest - self.radius**2
        # Two unit vectors make a row of norm √2, hence √2 on both sides.
        scale = np.sqrt(square)
        np.divide(1.0 / _SQRT2, scale, out=scale)
        offset *= scale
        coefficient[2:] = offset
        np.negative(offset, out=offset)
        coefficient[:2] = offset
        scale *= 0.5 * self.gain
        np.multiply(h, h, out=bound)
        bound *= h
        bound *= scale
        if smallest < 0.0 and self.unsafe_gain != self.gain:
            bound[h < 0.0] *= self.unsafe_gain / self.gain
        return Barrier(smallest, math.sqrt(nearest) - self.radius)

    def reach(self, speed: float) -> float:
        """Distance (m) beyond which no two robots of at most ``speed`` m/s can break their row."""
        # γ h³ ≥ 2 d·2s; h grows with d, so doubling brackets the root and bisection finds it.
        low, high = self.radius, 2.0 * self.radius + 1e-3
        while self.gain * (high**2 - self.radius**2) ** 3 < 4.0 * speed * high:
            low, high = high, 2.0 * high
        for _ in range(60):
            middle = 0.5 * (low + high)
            if self.gain * (middle**2 - self.radius**2) ** 3 < 4.0 * speed * middle:
                low = middle
            else:
                high = middle
        return high


def _part_coincident(offset: FloatArray, square: FloatArray, pairs: IntArray) -> FloatArray:
    """Give robots at one point directions by their index, in place; return safe squared distances.

    Directions come from points on a circle, one a robot, so that those of several coincident
    robots agree with each other (each can move out along its own ray).
    """
    together = np.flatnonzero(square < _COINCIDENT**2)
    angle = 2.399963229728653 * pairs[:, together]  # the golden angle: no two indices share a ray
    ray = np.stack([np.cos(angle), np.sin(angle)])
    apart = ray[:, 0] - ray[:, 1]
    offset[:, together] = _COINCIDENT * apart / np.hypot(apart[0], apart[1])
    square = square.copy()
    square[together] = _COINCIDENT**2
    return square


class WallRows:
    """Every robot stays inside a convex arena: n·vᵢ ≤ 0.4 γ g³, g = distance to the wall − margin.

    Parameters
    ----------
    normals : (2, W) array
        Unit normals, pointing out of the arena.
    offsets : (W,) array
        Walls are the lines n·x = offset, m.
    names : sequence of str
        What the walls are called in reports, such as ``"wall +x"``.
    margin : float
        How far inside the wall a position has to stay, m.
    gain : float
        γ, in 1/(m² s).
    weight : float
        Cost of giving a row up when no velocity satisfies all rows.
    """

    def __init__(
        self,
        normals: FloatArray,
        offsets: FloatArray,
        names: Sequence[str],
        margin: float,
        gain: float,
        weight: float = 1e4,
    ) -> None:
        self.normals = normals
        self.names = tuple(names)
        self.gain = gain
        self.weight = weight
        self._outward = np.ascontiguousarray(normals.T)
        self._inner = (offsets - margin)[:, None]

    def partners(self, number: int) -> IntArray:
        """Which robots each row joins: wall by wall, every robot with the world."""
        return _alone(len(self.names), number)

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write the normals, which never change."""
        coefficient[:2] = np.repeat(self.normals, number, axis=1)

    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Write the bounds for the present positions."""
        gap = self._outward @ scene.positions
        np.subtract(self._inner, gap, out=gap)
        gap = gap.reshape(-1)
        np.multiply(gap, gap, out=bound)
        bound *= gap
        bound *= 0.4 * self.gain
        smallest = float(gap[gap.argmin()])
        return Barrier(smallest, smallest)

    def label(self, number: int, row: int) -> str:
        """Say which robot and which wall."""
        return f"robot {row % number} and {self.names[row // number]}"


def rectangle(
    bounds: Sequence[float] | FloatArray,
) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Return normals, offsets and names of the walls of (x_min, x_max, y_min, y_max), m."""
    x_min, x_max, y_min, y_max = (float(b) for b in bounds)
    normals = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    return (
        normals,
        np.array([x_max, -x_min, y_max, -y_min]),
        ("wall +x", "wall -x", "wall +y", "wall -y"),
    )


class LimitRows:
    """Every robot's velocity stays inside a polygon, fixed in the plane or to its heading.

    Parameters
    ----------
    normals : (2, K) array
        Unit normals of the polygon's sides.
    bounds : (K,) array
        Its distance from zero along each, m/s.
    names : sequence of str
        What the sides are called in reports, such as ``"speed limit"``.
    turning : bool
        Whether the polygon turns with the robot's heading.
    """

    weight = np.inf  # what the motors cannot do is never asked of them

    def __init__(
        self, normals: FloatArray, bounds: FloatArray, names: Sequence[str], turning: bool = False
    ) -> None:
        self.normals = normals
        self.bounds = bounds
        self.names = tuple(names)
        self.turning = turning
        along, across = normals
        # (cos, sin) of the heading times these are the turned normals' x and y.
        self._turned = np.stack([along, -across], axis=1), np.stack([across, along], axis=1)

    def partners(self, number: int) -> IntArray:
        """Which robots each row joins: side by side, every robot with the world."""
        return _alone(len(self.names), number)

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write what does not turn."""
        coefficient[:2] = np.repeat(self.normals, number, axis=1)
        bound[:] = np.repeat(self.bounds, number)

    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Turn the polygon with the headings."""
        if self.turning:
            if scene.headings is None:
                raise TypeError("limits fixed to the body need the headings of the robots")
            shape = (len(self.names), scene.headings.shape[1])
            np.matmul(self._turned[0], scene.headings, out=coefficient[0].reshape(shape))
            np.matmul(self._turned[1], scene.headings, out=coefficient[1].reshape(shape))
        return NOTHING_NEAR

    def label(self, number: int, row: int) -> str:
        """Say which robot and which limit."""
        return f"robot {row % number}: {self.names[row // number]}"


def _alone(rows_each: int, number: int) -> IntArray:
    """Partners of ``rows_each`` rows for each robot, all with the world."""
    partners = np.full((2, rows_each * number), WORLD)
    partners[0] = np.tile(np.arange(number), rows_each)
    return partners


class RowBook:
    """The rows of a team, family after family, written into arrays that live from step to step.

    Parameters
    ----------
    families : sequence of Family
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
        families: Sequence[Family],
        pairs: PairRows | None,
        top_speed: float = np.inf,
        prune_from: int = 40,
    ) -> None:
        self.families = tuple(families)
        self.pairs = pairs
        self.top_speed = top_speed
        self.prune_from = prune_from
        self._number = -1
        self._reach = pairs.reach(top_speed) if pairs and np.isfinite(top_speed) else np.inf

    def write(self, scene: Scene) -> tuple[Rows, Barrier]:
        """Return the rows for a scene, and the smallest barrier in it.

        The arrays inside are written again by the next call.
        """
        number = scene.positions.shape[1]
        if number != self._number:
            self._lay_out(number)
        h = clearance = np.inf
        for family, coefficient, bound in self._sections:
            barrier = family.update(scene, coefficient, bound)
            h, clearance = min(h, barrier.h), min(clearance, barrier.clearance)
        if self.pairs is None or number < 2:
            return self._rows, Barrier(h, clearance)
        if self._all_pairs is not None:
            barrier = self.pairs.write(
                scene.positions, self._all_pairs, self._pair_coefficient, self._pair_bound
            )
            return self._rows, Barrier(min(h, barrier.h), min(clearance, barrier.clearance))
        return self._write_near(scene, Barrier(h, clearance))

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
            section = (family, coefficient[:, start:stop], bound[start:stop])
            family.prepare(number, *section[1:])
            self._sections.append(section)
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

    def _fixed_label(self, number: int) -> Callable[[int], str]:
        starts = np.cumsum([0] + [family.partners(number).shape[1] for family in self.families])

        def label(row: int) -> str:
            place = int(np.searchsorted(starts, row, side="right")) - 1
            return self.families[place].label(number, row - int(starts[place]))

        return label

    def _write_near(self, scene: Scene, barrier: Barrier) -> tuple[Rows, Barrier]:
        """Write the rows of a large team: only pairs that can break their row at top speed."""
        assert self.pairs is not None
        number, fixed = self._number, self._rows
        tree = cKDTree(scene.positions.T)
        near = np.ascontiguousarray(tree.query_pairs(self._reach, output_type="ndarray").T)
        coefficient, bound = np.empty((4, near.shape[1])), np.empty(near.shape[1])
        closest = self.pairs.write(scene.positions, near, coefficient, bound)
        if not near.shape[1]:
            distance = float(tree.query(scene.positions.T, k=2)[0][:, 1].min())
            radius = self.pairs.radius
            closest = Barrier(distance**2 - radius**2, distance - radius)
        rows = Rows(
            np.concatenate([fixed.index, _unknowns(near, number)], axis=1),
            np.concatenate([fixed.coefficient, coefficient], axis=1),
            np.concatenate([fixed.bound, bound]),
            fixed.size,
            np.concatenate([fixed.weight, np.full(near.shape[1], self.pairs.weight)]),
            _labeller(self._label_fixed, self._fixed, near),
            np.concatenate([np.arange(self._fixed), self._fixed + near[0] * number + near[1]]),
        )
        return rows, Barrier(min(barrier.h, closest.h), min(barrier.clearance, closest.clearance))


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
