"""What robots can do, as convex polygons of velocities around zero.

A limit that is a polygon is a handful of linear rows for each robot, so it can stand in the same
quadratic program as the safety rows. That is where limits belong: clipping a certified velocity
afterwards changes its direction against the other robots' and voids the certificate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.rows.row_family import NOTHING_NEAR, Barrier, RowFamily, Scene, with_world


class LimitRows(RowFamily):
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
    top_speed : float
        No velocity in the polygon is faster, m/s.
    """

    weight = np.inf  # what the motors cannot do is never asked of them

    def __init__(
        self,
        normals: FloatArray,
        bounds: FloatArray,
        names: Sequence[str],
        turning: bool = False,
        top_speed: float = np.inf,
    ) -> None:
        self.normals = normals
        self.bounds = bounds
        self.names = tuple(names)
        self.turning = turning
        self.top_speed = top_speed
        along, across = normals
        # These times (cos, sin) of the heading are the turned normals' x, then their y.
        self._turned = np.array([[*along, *across], [*-across, *along]]).T

    def partners(self, number: int) -> IntArray:
        """Return which robots each row joins: side by side, every robot with the world."""
        return with_world(len(self.names), number)

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write what does not turn."""
        coefficient[:2] = np.repeat(self.normals, number, axis=1)
        bound[:] = np.repeat(self.bounds, number)

    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Turn the polygon with the headings; nothing is near, since limits have no barrier.

        Raises
        ------
        ParameterError
            If the polygon turns with the robots, but they have no headings.
        """
        if self.turning:
            if scene.headings is None:
                raise ParameterError("limits fixed to the body need the headings of the robots")
            self._turn(scene.headings, coefficient)
        return NOTHING_NEAR

    def _turn(self, headings: FloatArray, coefficient: FloatArray) -> None:
        """Write each normal, turned by the heading of its robot."""
        coefficient[:2] = self._turned.dot(headings).reshape(2, -1)

    def measure(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return nothing: limits have no barrier."""
        return np.zeros(0), np.zeros(0)

    def label(self, number: int, row: int) -> str:
        """Say which robot and which limit."""
        return f"robot {row % number}: {self.names[row // number]}"


@dataclass(frozen=True, eq=False)
class VelocityPolygon:
    """Velocities v with n·v ≤ b for every side; zero is one of them.

    Parameters
    ----------
    normals : (2, K) array
        Outward normals n, made unit vectors.
    bounds : (K,) array
        Bounds b, m/s.
    names : tuple of str
        What `info.active` calls each side, K names.

    Raises
    ------
    ParameterError
        If a bound is negative: zero velocity must be allowed, or robots could not stop.
    """

    normals: FloatArray
    bounds: FloatArray
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        bounds = np.asarray(self.bounds, dtype=float)
        lengths = np.hypot(*np.asarray(self.normals, dtype=float))
        if not (np.all(np.isfinite(bounds)) and np.all(bounds >= 0.0) and np.all(lengths > 0.0)):
            raise ParameterError(f"limits are {bounds} m/s; expected finite numbers, none negative")
        object.__setattr__(self, "normals", np.asarray(self.normals, dtype=float) / lengths)
        object.__setattr__(self, "bounds", bounds / lengths)

    @classmethod
    def octagon(cls, limit: float) -> VelocityPolygon:
        """Return the octagon with its vertices on a circle.

        Parameters
        ----------
        limit : float
            Radius of the circle, m/s.
        """
        angles = np.arange(8) * np.pi / 4.0
        normals = np.stack([np.cos(angles), np.sin(angles)])
        return cls(normals, np.full(8, limit * np.cos(np.pi / 8.0)), ("speed limit",) * 8)

    @classmethod
    def box(cls, limit: float) -> VelocityPolygon:
        """Return the box |v_x|, |v_y| ≤ limit.

        Parameters
        ----------
        limit : float
            The limit, m/s.
        """
        normals = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
        return cls(normals, np.full(4, limit), ("speed limit",) * 4)

    def top_speed(self) -> float:
        """Largest speed the polygon allows, m/s; infinite if it is open."""
        vertices = self._vertices()
        return float(np.hypot(*vertices).max()) if self._closed() else np.inf

    def without_idle_sides(self) -> VelocityPolygon:
        """Leave out the sides that the others imply, and repeated ones."""
        return self.with_sides(self.needed_sides()) if self._encloses() else self

    def with_sides(self, kept: Sequence[int]) -> VelocityPolygon:
        """Return the polygon of some sides alone.

        Parameters
        ----------
        kept : sequence of int
            Which of them, in the order that is wanted.
        """
        names = tuple(self.names[side] for side in kept)
        return VelocityPolygon(self.normals[:, kept], self.bounds[kept], names)

    def needed_sides(self) -> list[int]:
        """Return the sides that others do not imply, each once; all, where it is open or a line."""
        if not self._encloses():
            return list(range(len(self.names)))
        vertices = self._vertices()
        touch = np.abs(self.normals.T @ vertices - self.bounds[:, None]) < 1e-12
        # A side belongs to the polygon when two different vertices lie on it.
        kept: list[int] = []
        for side in range(len(self.names)):
            ends = vertices[:, touch[side]]
            spread = np.ptp(ends, axis=1).max() if ends.shape[1] else 0.0
            repeated = any(
                np.allclose(self.normals[:, side], self.normals[:, other], atol=1e-12)
                for other in kept
            )
            if spread > 1e-12 and not repeated:
                kept.append(side)
        return kept

    def rows(self, turning: bool = False) -> LimitRows:
        """Return the rows of the polygon.

        Parameters
        ----------
        turning : bool
            Whether it turns with the headings, or is fixed in the plane.
        """
        return LimitRows(self.normals, self.bounds, self.names, turning, self.top_speed())

    def _encloses(self) -> bool:
        """Whether it has an inside, and no way out."""
        return self._closed() and bool(np.all(self.bounds > 0.0))

    def _closed(self) -> bool:
        """Whether the normals leave no half-plane uncovered."""
        angles = np.sort(np.arctan2(self.normals[1], self.normals[0]))
        gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
        return bool(gaps.max() < np.pi - 1e-9)

    def _vertices(self) -> FloatArray:
        """Corners of the polygon, shape (2, M), corners of three sides repeated."""
        first, second = np.triu_indices(len(self.names), 1)
        a, b = self.normals[:, first], self.normals[:, second]
        determinant = a[0] * b[1] - a[1] * b[0]
        crossing = np.abs(determinant) > 1e-12
        a, b, determinant = a[:, crossing], b[:, crossing], determinant[crossing]
        p, q = self.bounds[first[crossing]], self.bounds[second[crossing]]
        points = np.stack([p * b[1] - q * a[1], q * a[0] - p * b[0]]) / determinant
        inside = np.all(self.normals.T @ points <= self.bounds[:, None] + 1e-12, axis=0)
        return np.asarray(points[:, inside])
