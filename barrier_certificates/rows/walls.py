"""Rows that keep every robot inside a convex arena."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.rows.disturbance import WheelDisturbance
from barrier_certificates.rows.row_family import Barrier, RowFamily, Scene, with_world
from barrier_certificates.ties import TIE


class WallRows(RowFamily):
    """Every robot stays inside: n·vᵢ ≤ 0.4 γ g³, g = distance to the wall − margin.

    Parameters
    ----------
    normals : (2, W) array
        Unit normals, pointing out of the arena.
    offsets : (W,) array
        Walls are the lines n·x = offset, m.
    names : sequence of str
        What the walls are called in reports, such as ``"wall +x"``.
    margin : float or (N,) array
        How far inside the wall a position has to stay, m: all robots alike, or each.
    gain : float or (N,) array
        γ, in 1/(m² s).
    disturbance : WheelDisturbance, optional
        What the wheels may do on their own; rows then hold for the worst of it.
    unsafe_gain : float, optional
        γ beyond a margin (g < 0): how fast robots must come back. Default: ``gain``.
    weight : float
        Cost of giving a row up when no velocity satisfies all rows.
    """

    def __init__(
        self,
        normals: FloatArray,
        offsets: FloatArray,
        names: Sequence[str],
        margin: float | FloatArray,
        gain: float | FloatArray,
        disturbance: WheelDisturbance | None = None,
        unsafe_gain: float | None = None,
        weight: float = 1e4,
    ) -> None:
        self.normals = normals
        self.names = tuple(names)
        self.gain = gain
        self.disturbance = disturbance
        self.unsafe_gain = gain if unsafe_gain is None else unsafe_gain
        self._safe = _each_row(0.4 * gain, len(self.names))
        self._unsafe = None
        if unsafe_gain is not None:
            self._unsafe = _each_row(0.4 * unsafe_gain, len(self.names))
        self.weight = weight
        self._outward = np.ascontiguousarray(normals.T)
        self._inner = offsets[:, None] - margin

    @property
    def inner(self) -> FloatArray:
        """Return how far along each normal positions may be, the margin kept, (W,) array, m."""
        return self._inner[:, 0]

    def partners(self, number: int) -> IntArray:
        """Return which robots each row joins: wall by wall, every robot with the world."""
        return with_world(len(self.names), number)

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
        if self._unsafe is None:
            bound *= self._safe
        else:
            bound *= np.where(gap < 0.0, self._unsafe, self._safe)
        if self.disturbance is not None:
            robots = np.tile(np.arange(scene.positions.shape[1]), len(self.names))
            bound -= self.disturbance.worst(scene, robots, coefficient[:2])
        row = int(gap.argmin())
        smallest = float(gap[row])
        return Barrier(smallest, smallest, row)

    def measure(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return the gap of every robot to every wall twice: it is barrier and clearance in one."""
        gap = (self._inner - self._outward @ scene.positions).reshape(-1)
        return gap, gap

    def label(self, number: int, row: int) -> str:
        """Say which robot and which wall."""
        return f"robot {row % number} and {self.names[row // number]}"


def _each_row(value: float | FloatArray, walls: int) -> float | FloatArray:
    """Return a number for each row, wall by wall, where each robot has one of its own."""
    return np.tile(value, walls) if np.size(value) > 1 else value


def rectangle(bounds: Any) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Return the walls of a rectangle.

    Parameters
    ----------
    bounds : (4,) array-like
        x_min, x_max, y_min, y_max, m.

    Returns
    -------
    normals : (2, 4) array
        Outward unit normals.
    offsets : (4,) array
        Distances of the walls from the origin, along the normals, m.
    names : tuple of str
        What messages call the walls.
    """
    x_min, x_max, y_min, y_max = (float(b) for b in np.asarray(bounds, dtype=float).reshape(-1))
    normals = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    offsets = np.array([x_max, -x_min, y_max, -y_min])
    return normals, offsets, ("wall +x", "wall -x", "wall +y", "wall -y")


def polygon(corners: Any) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Return the walls of a convex polygon.

    Parameters
    ----------
    corners : (2, W) array-like
        Corners in order, either way round, m; the first may be repeated at the end.

    Returns
    -------
    normals : (2, W) array
        Outward unit normals.
    offsets : (W,) array
        Distances of the walls from the origin, along the normals, m.
    names : tuple of str
        What messages call the walls.

    Raises
    ------
    ParameterError
        If there are fewer than three, or they are not in convex position. An arena with a corner
        that points inwards is a convex one with segment obstacles along the edges there.
    """
    points = np.asarray(corners, dtype=float)
    if points.ndim != 2 or points.shape[0] != 2 or points.shape[1] < 3:
        raise ParameterError(
            f"corners have shape {points.shape}; expected (2, W) with three corners or more"
        )
    if points.shape[1] > 3 and np.abs(points[:, 0] - points[:, -1]).max() <= TIE:
        points = points[:, :-1]
    edges = np.roll(points, -1, axis=1) - points
    following = np.roll(edges, -1, axis=1)
    turns = np.arctan2(
        edges[0] * following[1] - edges[1] * following[0], (edges * following).sum(axis=0)
    )
    # All corners turn one way, and once around only: a star turns one way too, but twice around.
    one_way = np.all(turns > TIE) or np.all(turns < -TIE)
    if not one_way or abs(turns.sum()) > 2.0 * np.pi + 1e-6:
        raise ParameterError(
            "corners are not those of a convex polygon in order; take a convex arena and put "
            "Segment obstacles where a wall points inwards"
        )
    outward = np.stack([edges[1], -edges[0]]) * np.sign(turns[0]) / np.hypot(*edges)
    names = tuple(f"wall {k}" for k in range(points.shape[1]))
    return outward, (outward * points).sum(axis=0), names
