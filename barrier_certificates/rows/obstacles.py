"""Rows that keep every robot away from discs and segments, standing or moving.

Each obstacle is a capsule: the points within a radius of a segment, and a disc is one whose segment
is a point. The nearest point of the segment is the partner in the row; its velocity is known, not
an unknown, so obstacles never give way. (If an obstacle moves towards a robot faster than the robot
can retreat, no velocity is safe, and the policy for infeasible states decides.)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from barrier_certificates import checks
from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.rows.disturbance import WheelDisturbance
from barrier_certificates.rows.pairs import COINCIDENT
from barrier_certificates.rows.row_family import Barrier, RowFamily, Scene, with_world

Point = tuple[float, float]


@dataclass(frozen=True)
class Disc:
    """A disc that robots keep clear of, standing or moving.

    Parameters
    ----------
    centre : (x, y)
        Where it is now, m.
    radius : float
        Its radius, m.
    velocity : (v_x, v_y)
        How it moves, m/s.
    name : str
        What messages call it; by default its number.

    Raises
    ------
    ParameterError
        If a number is not finite or the radius is negative.
    """

    centre: Point
    radius: float
    velocity: Point = (0.0, 0.0)
    name: str = ""

    def __post_init__(self) -> None:
        _settle(self, "centre", "velocity")

    @property
    def ends(self) -> tuple[Point, Point]:
        """The two ends of the segment inside: both the centre."""
        return self.centre, self.centre


@dataclass(frozen=True)
class Segment:
    """A wall or bar that robots keep clear of, standing or moving.

    Parameters
    ----------
    start : (x, y)
        One end, m.
    end : (x, y)
        The other end, m.
    radius : float
        Thickness to each side, m.
    velocity : (v_x, v_y)
        How it moves, m/s.
    name : str
        What messages call it; by default its number.

    Raises
    ------
    ParameterError
        If a number is not finite or the radius is negative.
    """

    start: Point
    end: Point
    radius: float = 0.0
    velocity: Point = (0.0, 0.0)
    name: str = ""

    def __post_init__(self) -> None:
        _settle(self, "start", "end", "velocity")

    @property
    def ends(self) -> tuple[Point, Point]:
        """The two ends of the segment."""
        return self.start, self.end


Obstacle = Disc | Segment


def _settle(obstacle: Obstacle, *points: str) -> None:
    """Turn the points of an obstacle into pairs of floats, refusing what is none."""
    for name in points:
        given = getattr(obstacle, name)
        try:
            point = np.asarray(given, dtype=float)
        except (TypeError, ValueError):
            point = np.array(np.nan)
        if point.shape != (2,) or not np.all(np.isfinite(point)):
            raise ParameterError(
                f"{name} of an obstacle is {given!r}; expected a pair of finite numbers"
            )
        object.__setattr__(obstacle, name, (point.item(0), point.item(1)))
    checks.not_negative("radius of an obstacle", obstacle.radius, "of metres")


def listed(obstacles: Any) -> tuple[Obstacle, ...]:
    """Return obstacles as a tuple, refusing what is none.

    Parameters
    ----------
    obstacles : sequence of Disc or Segment
        What was given.

    Raises
    ------
    ParameterError
        If they are not a sequence of `Disc` and `Segment`.
    """
    if isinstance(obstacles, Iterable):
        found = tuple(obstacles)
        if all(isinstance(obstacle, (Disc, Segment)) for obstacle in found):
            return found
    raise ParameterError(f"obstacles are {obstacles!r}; expected a sequence of Disc and Segment")


def moved(obstacles: Sequence[Obstacle], seconds: float) -> tuple[Obstacle, ...]:
    """Return obstacles where they will be, as their velocities say.

    Parameters
    ----------
    obstacles : sequence of Disc or Segment
        Where they are now.
    seconds : float
        When, from now, s.
    """
    out: list[Obstacle] = []
    for obstacle in obstacles:
        x, y = obstacle.velocity
        ends = [(a + seconds * x, b + seconds * y) for a, b in obstacle.ends]
        if isinstance(obstacle, Disc):
            out.append(replace(obstacle, centre=ends[0]))
        else:
            out.append(replace(obstacle, start=ends[0], end=ends[1]))
    return tuple(out)


class ObstacleRows(RowFamily):
    """Every robot stays away from every obstacle: −2D·vᵢ + 2D·ċ ≤ γ h³, h = ‖D‖² − R².

    Parameters
    ----------
    obstacles : sequence of Disc or Segment
        What to stay away from.
    margin : float or (N,) array
        Smallest distance between a position and the surface of an obstacle, m: all robots alike, or
        each.
    gain : float or (N,) array
        γ, in 1/(m⁴ s).
    disturbance : WheelDisturbance, optional
        What the wheels may do on their own; rows then hold for the worst of it.
    unsafe_gain : float, optional
        γ for robots that are too close already (h < 0). Default: ``gain``.
    weight : float
        Cost of giving a row up when no velocity satisfies all rows.
    """

    def __init__(
        self,
        obstacles: Sequence[Obstacle],
        margin: float | FloatArray,
        gain: float | FloatArray,
        disturbance: WheelDisturbance | None = None,
        unsafe_gain: float | None = None,
        weight: float = 1e6,
    ) -> None:
        self.gain = gain
        self.disturbance = disturbance
        self.unsafe_gain = gain if unsafe_gain is None else unsafe_gain
        self.weight = weight
        self._margin = margin
        self.move(obstacles)

    def move(self, obstacles: Sequence[Obstacle]) -> None:
        """Put obstacles where they are now; tell the row book where their number changed.

        Parameters
        ----------
        obstacles : sequence of Disc or Segment
            The obstacles as they are now.
        """
        self.obstacles = obstacles
        ends = np.array([o.ends for o in obstacles], dtype=float).reshape(-1, 2, 2)
        self._start = ends[:, 0].T[:, :, None]
        self._along = (ends[:, 1] - ends[:, 0]).T[:, :, None]
        square = (self._along * self._along).sum(axis=0)
        self._inverse_square = np.divide(1.0, square, out=np.zeros_like(square), where=square > 0)
        velocities = np.array([o.velocity for o in obstacles], dtype=float).reshape(-1, 2)
        self._velocity = velocities.T[:, :, None]
        radii = np.array([o.radius for o in obstacles], dtype=float)[:, None]
        self._distance = radii + self._margin
        self.names = tuple(o.name or f"obstacle {k}" for k, o in enumerate(obstacles))

    def partners(self, number: int) -> IntArray:
        """Return which robots each row joins: obstacle by obstacle, every robot with the world."""
        return with_world(len(self.names), number)

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write nothing: all of it changes with the positions."""

    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Write the rows for the present positions."""
        offset, square = self._offsets(scene)
        if square.min() < COINCIDENT**2:
            square = self._leave(offset, square)
        h = square - self._distance**2
        distance = np.sqrt(square)
        offset /= distance
        closing = (offset * self._velocity).sum(axis=0)
        coefficient[:2] = -offset.reshape(2, -1)
        half_gain: float | FloatArray = 0.5 * self.gain
        if self.unsafe_gain is not self.gain:
            half_gain = np.where(h < 0.0, 0.5 * self.unsafe_gain, half_gain)
        bound[:] = (half_gain * h**3 / distance - closing).reshape(-1)
        if self.disturbance is not None:
            robots = np.tile(np.arange(scene.positions.shape[1]), len(self.names))
            bound -= self.disturbance.worst(scene, robots, coefficient[:2])
        clearance = distance - self._distance
        row = int(clearance.argmin())
        return Barrier(h.item(row), clearance.item(row), row)

    def measure(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return how far every robot is from every obstacle."""
        _, square = self._offsets(scene)
        h, clearance = square - self._distance**2, np.sqrt(square) - self._distance
        return h.reshape(-1), clearance.reshape(-1)

    def apart(self, scene: Scene) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return how every robot lies to every obstacle, row by row.

        Parameters
        ----------
        scene : Scene
            Where the team is.

        Returns
        -------
        offset : (2, m) array
            From the nearest points of the obstacles to the robots, m.
        velocity : (2, m) array
            Velocities of the obstacles, m/s.
        clearance : (m,) array
            Distance less radius and margin, m.
        """
        offset, square = self._offsets(scene)
        velocity = np.broadcast_to(self._velocity, offset.shape)
        clearance = np.sqrt(square) - self._distance
        return offset.reshape(2, -1), velocity.reshape(2, -1), clearance.reshape(-1)

    def table(self) -> FloatArray:
        """Return what rows are made from, for code that is compiled.

        Returns
        -------
        (8, M) array
            Start of each segment, vector to its end, the inverse of its squared length (0 for a
            disc), velocity, and the distance that is kept from the segment.
        """
        columns = (self._start, self._along, self._inverse_square[None], self._velocity)
        return np.concatenate([*(c[:, :, 0] for c in columns), self._distance.T])

    def _offsets(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return D from the nearest points to the robots, (2, M, N), and ‖D‖², (M, N)."""
        from_start = scene.positions[:, None, :] - self._start
        part = (from_start * self._along).sum(axis=0) * self._inverse_square
        np.clip(part, 0.0, 1.0, out=part)
        offset = from_start - part * self._along
        return offset, (offset * offset).sum(axis=0)

    def _leave(self, offset: FloatArray, square: FloatArray) -> FloatArray:
        """Give robots in the very middle of an obstacle a way out: to the side of its segment."""
        inside = square < COINCIDENT**2
        length = np.sqrt((self._along * self._along).sum(axis=0))
        aside = np.where(
            length > 0, np.stack([-self._along[1], self._along[0]]), [[[1.0]], [[0.0]]]
        )
        aside = np.broadcast_to(aside / np.where(length > 0, length, 1.0), offset.shape)
        offset[:, inside] = COINCIDENT * aside[:, inside]
        return np.where(inside, COINCIDENT**2, square)

    def label(self, number: int, row: int) -> str:
        """Say which robot and which obstacle."""
        return f"robot {row % number} and {self.names[row // number]}"
