"""Rows that keep every two robots apart."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.disturbance import WheelDisturbance
from barrier_certificates.rows.row_family import NOTHING_NEAR, Barrier, Scene

_SQRT2 = math.sqrt(2.0)
COINCIDENT = 1e-6
"""Below this distance in m the direction between two points says nothing."""


class PairRows:
    """Every two robots stay a radius apart: −2D·vᵢ + 2D·vⱼ ≤ γ h³, h = ‖D‖² − r².

    The rows of the pairs that are looked at come from `write`, since which these are may change.

    Parameters
    ----------
    radius : float
        Smallest distance between two positions, m.
    gain : float
        γ, in 1/(m⁴ s): how fast a pair may close.
    unsafe_gain : float, optional
        γ for pairs that are already too close (h < 0): how fast they must part. Default: ``gain``.
    disturbance : WheelDisturbance, optional
        What the wheels may do on their own; rows then hold for the worst of it.
    weight : float
        Cost of giving a row up when no velocity satisfies all rows.
    """

    def __init__(
        self,
        radius: float,
        gain: float,
        unsafe_gain: float | None = None,
        disturbance: WheelDisturbance | None = None,
        weight: float = 1e6,
    ) -> None:
        self.radius = radius
        self.gain = gain
        self.unsafe_gain = gain if unsafe_gain is None else unsafe_gain
        self.disturbance = disturbance
        self.weight = weight

    def write(
        self, scene: Scene, pairs: IntArray, coefficient: FloatArray, bound: FloatArray
    ) -> Barrier:
        """Write the rows of the given pairs for the present positions.

        Parameters
        ----------
        scene : Scene
            Where the team is.
        pairs : (2, m) integer array
            The two robots of each row.
        coefficient : (4, m) array
            Where the coefficients are written: x and y of the first robot, x and y of the second.
        bound : (m,) array
            Where the right-hand sides are written, m/s.

        Returns
        -------
        Barrier
            The one of least clearance.
        """
        offset, square = self._apart(scene, pairs)
        if not square.shape[0]:
            return NOTHING_NEAR
        row = int(square.argmin())  # a tenth of what min costs on small arrays
        nearest = float(square[row])
        if nearest < COINCIDENT**2:
            square = part_coincident(offset, square, pairs)
        h = square - self.radius**2
        smallest = nearest - self.radius**2
        scale = self._write_normals(offset, square, coefficient)
        if smallest < 0.0 and self.unsafe_gain != self.gain:
            scale *= np.where(h < 0.0, 0.5 * self.unsafe_gain, 0.5 * self.gain)
        else:
            scale *= 0.5 * self.gain
        self._write_bounds(scene, pairs, h, scale, coefficient, bound)
        return Barrier(smallest, math.sqrt(nearest) - self.radius, row)

    def _apart(self, scene: Scene, pairs: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return D of each pair, (2, m), and ‖D‖²."""
        offset = scene.positions.take(pairs[0], axis=1)
        offset -= scene.positions.take(pairs[1], axis=1)
        square = offset[0] * offset[0]
        square += offset[1] * offset[1]
        return offset, square

    def _write_normals(
        self, offset: FloatArray, square: FloatArray, coefficient: FloatArray
    ) -> FloatArray:
        """Write the directions of all pairs; return by what their rows are scaled."""
        # Two unit vectors make a row of norm √2, hence √2 on both sides.
        scale = np.sqrt(square)
        np.divide(1.0 / _SQRT2, scale, out=scale)
        offset *= scale
        coefficient[2:] = offset
        np.negative(offset, out=offset)
        coefficient[:2] = offset
        return scale

    def _write_bounds(
        self,
        scene: Scene,
        pairs: IntArray,
        h: FloatArray,
        scale: FloatArray,
        coefficient: FloatArray,
        bound: FloatArray,
    ) -> None:
        """Write h³ times scale, less what the wheels may do."""
        np.multiply(h, h, out=bound)
        bound *= h
        bound *= scale
        if self.disturbance is not None:
            bound -= self.disturbance.worst(scene, pairs[0], coefficient[:2])
            bound -= self.disturbance.worst(scene, pairs[1], coefficient[2:])

    def measure(self, scene: Scene, pairs: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return how far the robots of the given pairs are apart.

        Parameters
        ----------
        scene : Scene
            Where the team is.
        pairs : (2, m) integer array
            The two robots of each pair.

        Returns
        -------
        h : (m,) array
            Barriers ‖D‖² − r², m².
        clearance : (m,) array
            Distances less the radius, ‖D‖ − r, m.
        """
        offset = scene.positions[:, pairs[0]] - scene.positions[:, pairs[1]]
        square = (offset * offset).sum(axis=0)
        return square - self.radius**2, np.sqrt(square) - self.radius

    def near(self, tree: cKDTree, reach: float) -> IntArray:
        """Return the pairs within reach; where there is none, the two that are nearest.

        Parameters
        ----------
        tree : cKDTree
            The positions of a team, m.
        reach : float
            Pairs beyond cannot break their row, m.

        Returns
        -------
        (2, m) integer array
            The two robots of each pair.
        """
        found = np.ascontiguousarray(tree.query_pairs(reach, output_type="ndarray").T)
        # The row of the nearest two cannot be broken then, but their distance is reported.
        return found if found.shape[1] else _closest_pair(tree)

    def reach(self, speed: float) -> float:
        """Return the distance beyond which no two robots can break their row, m.

        Parameters
        ----------
        speed : float
            No robot is faster, m/s.
        """
        if not (self.gain > 0.0 and math.isfinite(speed)):
            return math.inf
        if self.disturbance is not None:
            speed += self.disturbance.top_speed()

        def out_of_reach(distance: float) -> bool:
            # γ h³ ≥ 2 d·2s: the largest that the left side of the row can become.
            return self.gain * (distance**2 - self.radius**2) ** 3 >= 4.0 * speed * distance

        low, high = self.radius, 2.0 * self.radius + 1e-3
        while not out_of_reach(high):
            low, high = high, 2.0 * high
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if out_of_reach(middle) else (middle, high)
        return high


def part_coincident(offset: FloatArray, square: FloatArray, pairs: IntArray) -> FloatArray:
    """Give robots at one point directions by their index, in place; return safe squared distances.

    Without this the row would be 0/0, and a row of NaN is never found broken. Directions come from
    points on a circle, one a robot, so that those of several coincident robots agree with each
    other: each can move out along its own ray.

    Parameters
    ----------
    offset : (2, m) array
        From the second robot of each pair to the first, m.
    square : (m,) array
        Its squared length, m².
    pairs : (2, m) integer array
        The two robots of each pair.

    Returns
    -------
    (m,) array
        Squared distances, none of them zero, m².
    """
    together = (square < COINCIDENT**2).nonzero()[0]
    angle = 2.399963229728653 * pairs[:, together]  # the golden angle: no two indices share a ray
    ray = np.stack([np.cos(angle), np.sin(angle)])
    apart = ray[:, 0] - ray[:, 1]
    offset[:, together] = COINCIDENT * apart / np.hypot(apart[0], apart[1])
    square = square.copy()
    square[together] = COINCIDENT**2
    return square


def _closest_pair(tree: cKDTree) -> IntArray:
    """Return the two points nearest to each other, shape (2, 1)."""
    distance, neighbour = tree.query(tree.data, k=2)
    first = int(distance[:, 1].argmin())
    other = int(neighbour[first, 1])
    return np.array([[min(first, other)], [max(first, other)]])
