"""The nearest point of many small programs at once: one point in the plane for each robot.

In the plane the nearest point that satisfies a set of rows is decided by two of them at most. So a
robot's answer is found by *basis exchange*: begin with the command; take the row that the point
breaks most; the new point lies on it, and is either the nearest one there or where it crosses one
of the two rows that decided before; repeat until no row is broken. Each point is farther from the
command than the last, so that no two rows decide twice; two or three rounds are usual, and each is
a handful of array operations for all robots together.

Where the three rows have no point in common, the robot's program has no solution (Helly). This and
everything that rounding leaves open is not decided here: such robots stay open.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import BoolArray, FloatArray, IntArray
from barrier_certificates.projection.scaled_program import TOLERANCE

BROKEN = 0.5 * TOLERANCE
"""A row is broken by more than this: two shares that hold make a row that holds."""
_ROUNDS = 50
_PARALLEL = 1e-9
"""Two unit normals with a smaller sine between them do not cross."""
_NOBODY = -1


class PlaneRows(NamedTuple):
    """Rows of N programs of two unknowns each, K a program.

    Attributes
    ----------
    normals : (2, K, N) array
        Unit normals.
    bounds : (K, N) array
        Right-hand sides, m/s; infinite where a program has fewer rows than others.
    """

    normals: FloatArray
    bounds: FloatArray

    def excess(self, points: FloatArray) -> FloatArray:
        """Return how far each row is broken.

        Parameters
        ----------
        points : (2, N) array
            A point for each program, m/s.

        Returns
        -------
        (K, N) array
            Excess, m/s; negative where a row holds.
        """
        excess: FloatArray = self.normals[0] * points[0]
        excess += self.normals[1] * points[1]
        excess -= self.bounds
        return excess


class PlanePoints(NamedTuple):
    """What was found.

    Attributes
    ----------
    points : (2, N) array
        The nearest points, m/s, where they are settled.
    settled : (N,) boolean array
        Whose point is the nearest one, all rows checked.
    basis : (2, N) integer array
        The rows that decide, -1 for none.
    rounds : int
        Rounds of exchange.
    """

    points: FloatArray
    settled: BoolArray
    basis: IntArray
    rounds: int


def nearest_points(targets: FloatArray, rows: PlaneRows) -> PlanePoints:
    """Return, for each program, the point nearest to its target that satisfies its rows.

    Parameters
    ----------
    targets : (2, N) array
        The commands, m/s.
    rows : PlaneRows
        What must hold; finite.

    Returns
    -------
    PlanePoints
        The points, and for which programs they are the answer.
    """
    number = targets.shape[1]
    points, basis = targets.copy(), np.full((2, number), _NOBODY)
    lost = np.zeros(number, dtype=bool)
    excess = rows.excess(points)
    for rounds in range(_ROUNDS):
        worst = excess.argmax(axis=0)
        broken = excess[worst, np.arange(number)] > BROKEN
        todo = (broken & ~lost).nonzero()[0]
        if not todo.shape[0]:
            return PlanePoints(points, ~lost, basis, rounds)
        found = _exchanged(targets[:, todo], worst[todo], basis[:, todo], rows, todo)
        points[:, todo], basis[:, todo], lost[todo] = found
        excess[:, todo] = PlaneRows(rows.normals[:, :, todo], rows.bounds[:, todo]).excess(
            points[:, todo]
        )
    return PlanePoints(points, ~(lost | broken), basis, _ROUNDS)


def _exchanged(
    target: FloatArray, new: IntArray, basis: IntArray, rows: PlaneRows, which: IntArray
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Return the nearest points on new rows that satisfy those of the basis, and who has none."""
    (first, a, p) = _taken(rows, new, which)
    others = [_taken(rows, row, which) for row in basis]
    along = a[0] * target[0] + a[1] * target[1] - p
    candidates = [target - along * a]
    admitted = [_holds(candidates[0], *others[0][1:]) & _holds(candidates[0], *others[1][1:])]
    for (_, b, q), (_, c, r) in (others, others[::-1]):
        sine = a[0] * b[1] - a[1] * b[0]
        crossing = np.abs(sine) > _PARALLEL
        sine, q = np.where(crossing, sine, 1.0), np.where(crossing, q, 0.0)
        corner = np.stack([p * b[1] - q * a[1], q * a[0] - p * b[0]]) / sine
        candidates.append(corner)
        admitted.append(crossing & _holds(corner, c, r))
    places = np.stack(candidates)
    distance = np.square(places - target).sum(axis=1)
    distance[~np.stack(admitted)] = np.inf
    chosen = distance.argmin(axis=0)
    robots = np.arange(which.shape[0])
    point = places[chosen, :, robots].T
    decides = np.stack([first, np.choose(chosen, [np.full_like(first, _NOBODY), *basis])])
    return point, decides, np.isinf(distance[chosen, robots])


def _taken(
    rows: PlaneRows, row: IntArray, which: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return one row of each chosen program: its number, normal and bound; of none, no limit."""
    there = row != _NOBODY
    normal = np.where(there, rows.normals[:, row, which], 0.0)
    return row, normal, np.where(there, rows.bounds[row, which], np.inf)


def _holds(point: FloatArray, normal: FloatArray, bound: FloatArray) -> BoolArray:
    held: BoolArray = normal[0] * point[0] + normal[1] * point[1] <= bound + 0.1 * TOLERANCE
    return held
