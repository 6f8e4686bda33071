"""Rows that keep every two robots of a team apart whose sizes and gains differ.

Each robot is a disc of its own *safety diameter* sᵢ, and two discs must not overlap: a pair keeps
(sᵢ + sⱼ)/2, which is s where all are alike. Of two gains the more cautious counts: the smaller γ
lets a pair close in more slowly, and of pairs that are too close already the larger one has them
part sooner.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.per_robot import PerRobot
from barrier_certificates.rows.disturbance import WheelDisturbance
from barrier_certificates.rows.pairs import COINCIDENT, PairRows, part_coincident
from barrier_certificates.rows.row_family import NOTHING_NEAR, Barrier, Scene


class _PairNumbers(NamedTuple):
    """What counts for each of some pairs, (m,) arrays."""

    radius: FloatArray
    square: FloatArray
    half_gain: FloatArray
    half_unsafe_gain: FloatArray


class UnequalPairRows(PairRows):
    """Every two robots stay (sᵢ + sⱼ)/2 apart, by the more cautious of their gains.

    Parameters
    ----------
    radius : float or (N,) array-like
        s, what each robot keeps from one of its own size, m.
    gain : float or (N,) array-like
        γ, in 1/(m⁴ s); of two the smaller counts.
    unsafe_gain : float or (N,) array-like, optional
        γ for pairs that are already too close; of two the larger counts. Default: that of ``gain``.
    disturbance : WheelDisturbance, optional
        What the wheels may do on their own; rows then hold for the worst of it.
    weight : float
        Cost of giving a row up when no velocity satisfies all rows.

    Attributes
    ----------
    radius, gain : float
        The largest distance and the smallest gain of all pairs: `reach` is a bound for all.
    number : int
        For how many robots they are, N.

    Raises
    ------
    ParameterError
        If the numbers are not for one team.
    """

    def __init__(
        self,
        radius: PerRobot,
        gain: PerRobot,
        unsafe_gain: PerRobot | None = None,
        disturbance: WheelDisturbance | None = None,
        weight: float = 1e6,
    ) -> None:
        given = [radius, gain, gain if unsafe_gain is None else unsafe_gain]
        try:
            sizes, gains, unsafe = np.broadcast_arrays(*(np.asarray(g, dtype=float) for g in given))
        except ValueError:
            shapes = [np.shape(g) for g in given]
            raise ParameterError(
                f"radius and gains have shapes {shapes}; expected (N,), or one number for all"
            ) from None
        if sizes.ndim != 1:
            raise ParameterError(f"radius and gains have shape {sizes.shape}; expected (N,)")
        largest = np.sort(sizes)[-2:].mean()  # of a single robot: its own
        super().__init__(float(largest), float(gains.min()), None, disturbance, weight)
        self.number = sizes.shape[0]
        self._half, self._gains = 0.5 * sizes, gains
        self._unsafe = None if unsafe_gain is None else unsafe
        self._known: tuple[IntArray, _PairNumbers] | None = None

    def check_number(self, number: int) -> None:
        """Refuse a team for which there are no numbers.

        Parameters
        ----------
        number : int
            Number of robots of the team.

        Raises
        ------
        ShapeError
            If it is not `number`.
        """
        if number != self.number:
            raise ShapeError(
                f"radii and gains are for {self.number} robots, but the team has {number}"
            )

    def write(
        self, scene: Scene, pairs: IntArray, coefficient: FloatArray, bound: FloatArray
    ) -> Barrier:
        """Write the rows of the given pairs for the present positions."""
        self.check_number(scene.positions.shape[1])
        offset, square = self._apart(scene, pairs)
        if not square.shape[0]:
            return NOTHING_NEAR
        kept = self._numbers(pairs)
        clearance = np.sqrt(square) - kept.radius
        row = int(clearance.argmin())
        nearest = Barrier(square.item(row) - kept.square.item(row), clearance.item(row), row)
        if square.item(square.argmin()) < COINCIDENT**2:
            square = part_coincident(offset, square, pairs)
        h = square - kept.square
        scale = self._write_normals(offset, square, coefficient)
        if nearest.clearance < 0.0 and self._unsafe is not None:
            scale *= np.where(h < 0.0, kept.half_unsafe_gain, kept.half_gain)
        else:
            scale *= kept.half_gain
        self._write_bounds(scene, pairs, h, scale, coefficient, bound)
        return nearest

    def measure(self, scene: Scene, pairs: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return how far the robots of the given pairs are apart, beyond what each pair keeps."""
        self.check_number(scene.positions.shape[1])
        _, square = self._apart(scene, pairs)
        kept = self._numbers(pairs)
        return square - kept.square, np.sqrt(square) - kept.radius

    def near(self, tree: cKDTree, reach: float) -> IntArray:
        """Return the pairs within reach, and any other that is nearer to being unsafe."""
        found = super().near(tree, reach)
        points = tree.data
        apart = np.linalg.norm(points[found[0]] - points[found[1]], axis=1)
        clearance = float((apart - self._numbers(found).radius).min())
        if clearance <= reach - self.radius:  # pairs beyond are clear by more
            return found
        return super().near(tree, clearance + self.radius)

    def _numbers(self, pairs: IntArray) -> _PairNumbers:
        """Return what counts for each pair; of a team whose pairs stay the same, computed once."""
        if self._known is not None and self._known[0] is pairs:
            return self._known[1]
        first, second = pairs
        radius = self._half[first] + self._half[second]
        half = 0.5 * np.minimum(self._gains[first], self._gains[second])
        unsafe = half
        if self._unsafe is not None:
            unsafe = 0.5 * np.maximum(self._unsafe[first], self._unsafe[second])
        numbers = _PairNumbers(radius, radius**2, half, unsafe)
        self._known = pairs, numbers
        return numbers


def pair_rows(
    radius: PerRobot,
    gain: PerRobot,
    unsafe_gain: PerRobot | None = None,
    disturbance: WheelDisturbance | None = None,
) -> PairRows:
    """Return the rows of pairs, of equal robots or of unequal ones.

    Parameters
    ----------
    radius : float or (N,) array-like
        What two robots keep, m, or what each keeps from one of its own size.
    gain : float or (N,) array-like
        γ, in 1/(m⁴ s).
    unsafe_gain : float or (N,) array-like, optional
        γ for pairs that are already too close. Default: ``gain``.
    disturbance : WheelDisturbance, optional
        What the wheels may do on their own.
    """
    if any(isinstance(given, tuple) for given in (radius, gain, unsafe_gain)):
        return UnequalPairRows(radius, gain, unsafe_gain, disturbance)
    return PairRows(radius, gain, unsafe_gain, disturbance)  # type: ignore[arg-type]
