r"""Rows for what may be too close already: nothing approaches, whatever the errors are.

A row of a pair that is clear needs no more than what `late_margins` adds to its radius. One whose
stop points are *seen* at less than that radius may lose a little with every step: its direction is
known to an angle β only, velocities turn by some degrees and are driven by some part. So such a
pair gets rows that hold for all of it: for robot i, its velocity q counts with any vector a out of

    { g n(φ) :  |φ| ≤ Ψ,  weakest ≤ g ≤ strongest },    n(φ): the direction apart, turned by φ,

which lies within the four corners n(±Ψ)·weakest and n(±Ψ)·strongest/cos Ψ. Rows at all corners,
4 × 4 for a pair and 4 for a wall or obstacle, hold for all a: −a·qᵢ + b·qⱼ ≤ −(what noise may do).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.late.late_margins import LateMargins
from barrier_certificates.per_robot import PerRobot, as_numbers, largest
from barrier_certificates.rows import ObstacleRows, Rows, Scene, WallRows
from barrier_certificates.rows.pairs import COINCIDENT
from barrier_certificates.rows.row_family import WORLD

__all__ = ["CautiousRows"]

_WIDEST = math.radians(80.0)
_WEIGHT = 1e6


class _Close(NamedTuple):
    """What is seen too close."""

    partners: IntArray
    """(2, m) robots, or a robot and the world."""
    normals: FloatArray
    """(2, m) directions away from the second."""
    closing: FloatArray
    """(m,) how fast the second comes nearer on its own, m/s."""
    doubt: FloatArray
    """(m,) how far the direction may be off, rad."""


class CautiousRows:
    """Adds rows for what is seen too close.

    Parameters
    ----------
    margins : LateMargins
        What robots may do beside what they are told.
    radius : float or (N,) array-like
        What is kept between two stop points, m; of unequal robots half of the one's and half of the
        other's.

    Attributes
    ----------
    number : int
        How many rows were added at last.
    """

    def __init__(self, margins: LateMargins, radius: PerRobot) -> None:
        self._margins = margins
        self._widest = largest(radius)
        self._half = 0.5 * as_numbers(radius)
        self.number = 0

    def added(
        self,
        rows: Rows,
        scene: Scene,
        pair_rows: bool,
        walls: WallRows | None,
        obstacles: ObstacleRows,
    ) -> Rows:
        """Return the rows with those for what is too close; the same rows where nothing is.

        Parameters
        ----------
        rows : Rows
            The rows of the row book.
        scene : Scene
            Where the stop points are.
        pair_rows : bool
            Whether robots are kept apart from each other.
        walls : WallRows, optional
            What keeps them inside.
        obstacles : ObstacleRows
            What keeps them off obstacles.
        """
        found = [self._pairs(scene)] if pair_rows else []
        if walls is not None:
            found.append(self._walls(scene, walls))
        if obstacles.names:
            found.append(self._obstacles(scene, obstacles))
        close = [few for few in found if few.doubt.shape[0]]
        self.number = 0
        if not close:
            return rows
        every = _Close(*(np.concatenate(part, axis=-1) for part in zip(*close, strict=True)))
        more = self._with(rows, every)
        self.number = len(more) - len(rows)
        return more

    def _pairs(self, scene: Scene) -> _Close:
        """Return the pairs seen too close."""
        points = scene.positions
        close: IntArray = np.zeros((2, 0), dtype=np.intp)
        if points.shape[1] > 1:
            found = cKDTree(points.T).query_pairs(self._widest, output_type="ndarray")
            close = found.T[:, np.lexsort(found.T[::-1])]
        offset = points[:, close[0]] - points[:, close[1]]
        distance = np.maximum(np.hypot(offset[0], offset[1]), COINCIDENT)
        if isinstance(self._half, np.ndarray):  # which of them are closer than these two may be
            kept = distance <= self._half[close[0]] + self._half[close[1]]
            close, offset, distance = close[:, kept], offset[:, kept], distance[kept]
        doubt = np.arcsin(np.minimum(1.0, 2.0 * self._margins.stop_error / distance))
        return _Close(close, offset / distance, np.zeros(doubt.shape), doubt)

    def _walls(self, scene: Scene, walls: WallRows) -> _Close:
        """Return the robots seen too close to a wall; of its direction there is no doubt."""
        gap, _ = walls.measure(scene)
        close = np.flatnonzero(gap < 0.0)
        wall, robot = np.divmod(close, scene.positions.shape[1])
        partners = np.stack([robot, np.full(close.shape, WORLD)])
        still = np.zeros(close.shape)
        return _Close(partners, -walls.normals[:, wall], still, still)

    def _obstacles(self, scene: Scene, obstacles: ObstacleRows) -> _Close:
        """Return the robots seen too close to an obstacle."""
        offset, velocity, clearance = obstacles.apart(scene)
        close = np.flatnonzero(clearance < 0.0)
        partners = np.stack([close % scene.positions.shape[1], np.full(close.shape, WORLD)])
        offset, velocity = offset[:, close], velocity[:, close]
        distance = np.maximum(np.hypot(offset[0], offset[1]), COINCIDENT)
        normals = offset / distance
        doubt = np.arcsin(np.minimum(1.0, self._margins.stop_error / distance))
        towards = (normals * velocity).sum(axis=0) + doubt * np.hypot(velocity[0], velocity[1])
        return _Close(partners, normals, towards, doubt)

    def _with(self, rows: Rows, close: _Close) -> Rows:
        """Return the rows with those at all corners."""
        margins, (partners, normals, closing, doubt) = self._margins, close
        angle = np.minimum(doubt + margins.skew, _WIDEST)
        corners = []
        for turn in (-angle, angle):
            cos, sin = np.cos(turn), np.sin(turn)
            turned = np.stack(
                [cos * normals[0] - sin * normals[1], sin * normals[0] + cos * normals[1]]
            )
            corners += [turned * margins.weakest, turned * margins.strongest / np.cos(angle)]
        world = partners[1] == WORLD
        both = np.where(world, 1.0, 2.0)
        coefficient, bound, who = [], [], []
        for first in corners:
            for place, second in enumerate(corners):
                which = np.flatnonzero(~world if place else np.ones_like(world))
                other = np.where(world, 0.0, second)[:, which]
                block = np.concatenate([-first[:, which], other])
                length = np.sqrt((block * block).sum(axis=0))
                coefficient.append(block / length)
                bound.append(-(closing + both * margins.drift)[which] / length)
                who.append(partners[:, which])
        joined = np.concatenate(who, axis=1)
        return _joined(rows, joined, np.concatenate(coefficient, axis=1), np.concatenate(bound))


def _joined(rows: Rows, partners: IntArray, coefficient: FloatArray, bound: FloatArray) -> Rows:
    """Return rows with more of them at the end."""
    first, second = partners
    world = second == WORLD
    index = np.stack(
        [
            2 * first,
            2 * first + 1,
            np.where(world, rows.size, 2 * second),
            np.where(world, rows.size, 2 * second + 1),
        ]
    )
    number, before = bound.shape[0], len(rows)
    known = np.arange(before) if rows.key is None else rows.key
    named = rows.label

    def label(row: int) -> str:
        if row < before:
            return named(row)
        one, other = partners[:, row - before]
        who = (
            f"robot {one} and what is too close" if other == WORLD else f"robots {one} and {other}"
        )
        return who

    return Rows(
        np.concatenate([rows.index, index], axis=1),
        np.concatenate([rows.coefficient, coefficient], axis=1),
        np.concatenate([rows.bound, bound]),
        rows.size,
        np.concatenate([rows.weight, np.full(number, _WEIGHT)]),
        label,
        np.concatenate([known, int(known.max(initial=0)) + 1 + np.arange(number)]),
    )
