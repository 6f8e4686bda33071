"""What the certificates have in common: parameters, memory, and the way from command to answer."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from barrier_certificates import checks
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.deadlock import DeadlockMonitor, DeadlockParameters, tilt
from barrier_certificates.disturbance import WheelDisturbance
from barrier_certificates.limits import LimitRows
from barrier_certificates.obstacles import Obstacle, ObstacleRows, listed
from barrier_certificates.pairs import PairRows
from barrier_certificates.projection import Policy, ProjectionInfo, Projector
from barrier_certificates.rowbook import Margin, RowBook
from barrier_certificates.rows import Family, FloatArray, Rows, Scene
from barrier_certificates.walls import WallRows, polygon, rectangle


@dataclass(frozen=True)
class SafetyParameters:
    """What is kept apart from what, and how firmly.

    Parameters
    ----------
    safety_radius : float
        Smallest distance between two positions, m.
    barrier_gain : float
        γ of all rows but limits: larger lets robots come closer faster. Zero: never any closer.
    unsafe_gain : float, optional
        γ of pairs that are already too close; ``barrier_gain`` if None.
    boundary : (4,) or (2, W) array-like, optional
        The arena: (x_min, x_max, y_min, y_max), or the corners of a convex polygon in order, m.
    wall_margin : float, optional
        How far inside the walls positions stay, m; half the safety radius if None.
    obstacle_margin : float, optional
        How far from the surface of obstacles positions stay, m; half the safety radius if None.
    """

    safety_radius: float = 0.15
    barrier_gain: float = 100.0
    unsafe_gain: float | None = None
    boundary: Any = None
    wall_margin: float | None = None
    obstacle_margin: float | None = None

    def __post_init__(self) -> None:
        checks.positive("safety_radius", self.safety_radius, "of metres")
        checks.not_negative("barrier_gain", self.barrier_gain)
        for name in ("unsafe_gain", "wall_margin", "obstacle_margin"):
            if getattr(self, name) is not None:
                checks.not_negative(name, getattr(self, name))
        if self.boundary is not None:
            object.__setattr__(self, "boundary", _boundary(self.boundary))
            self.walls()

    def walls(self) -> tuple[FloatArray, FloatArray, tuple[str, ...]] | None:
        """Return normals, offsets and names of the walls, if there is a boundary."""
        if self.boundary is None:
            return None
        return rectangle(self.boundary) if len(self.boundary) == 4 else polygon(self.boundary)


def _boundary(boundary: Any) -> tuple[Any, ...]:
    """Return a boundary as nested tuples of floats, so that parameters stay comparable."""
    try:
        points = np.asarray(boundary, dtype=float)
    except (TypeError, ValueError):
        points = np.array(np.nan)
    if points.shape[:1] == (2,) and points.ndim == 2 and np.all(np.isfinite(points)):
        return tuple(tuple(float(c) for c in row) for row in points)
    flat = points.reshape(-1)
    if flat.shape == (4,) and flat[0] < flat[1] and flat[2] < flat[3]:
        return tuple(float(b) for b in flat)
    raise ParameterError(
        f"boundary is {boundary!r}; expected (x_min, x_max, y_min, y_max) or the (2, W) corners of "
        "a convex polygon, in metres"
    )


Parameters = TypeVar("Parameters", bound=SafetyParameters)


class Certificate(ABC, Generic[Parameters]):
    """A certificate that remembers: rows in arrays of its own, and which of them bound last time.

    Parameters
    ----------
    parameters : SafetyParameters
        What the certificate keeps.
    obstacles : sequence of Disc or Segment
        What robots stay away from.
    solver, on_infeasible, options
        See `barrier_certificates.projection.Projector`.
    deadlock : DeadlockParameters, optional
        When a robot counts as stuck; without it nobody watches.
    tilt : float
        Turn the commands of stuck robots by this angle (rad) before they are certified, until they
        are free again; zero leaves them stuck.
    """

    def __init__(
        self,
        parameters: Parameters,
        obstacles: Sequence[Obstacle] = (),
        solver: str = "auto",
        on_infeasible: Policy = "relax",
        options: Mapping[str, float] | None = None,
        deadlock: DeadlockParameters | None = None,
        tilt: float = 0.0,
    ) -> None:
        checks.angle("tilt", tilt)
        if not (deadlock is None or isinstance(deadlock, DeadlockParameters)):
            raise ParameterError(f"deadlock is {deadlock!r}; expected DeadlockParameters or None")
        self._projector = Projector(solver, on_infeasible, options)
        self._tilt = tilt
        if tilt and deadlock is None:
            deadlock = DeadlockParameters()
        self._monitor = None if deadlock is None else DeadlockMonitor(deadlock)
        self._obstacles = listed(obstacles)
        self._parameters = parameters
        self._build()

    @property
    def parameters(self) -> Parameters:
        """What the certificate keeps; assign a changed copy (`dataclasses.replace`)."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: Parameters) -> None:
        if type(parameters) is not type(self._parameters):
            raise ParameterError(
                f"parameters are {type(parameters).__name__}; "
                f"expected {type(self._parameters).__name__}"
            )
        self._parameters = parameters
        self._build()

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """What robots stay away from; assign the obstacles of this step to move them."""
        return self._obstacles

    @obstacles.setter
    def obstacles(self, obstacles: Sequence[Obstacle]) -> None:
        moved = listed(obstacles)
        if self._obstacle_rows is not None and len(moved) == len(self._obstacles):
            self._obstacle_rows.move(moved)
            self._obstacles = moved
        else:
            self._obstacles = moved
            self._build()

    def _margins(self, scene: Scene, within: float) -> list[Margin]:
        checks.require_finite("positions", scene.positions)
        checks.not_negative("within", within, "of metres")
        return self._book.margins(scene, within)

    def reset(self) -> None:
        """Forget the steps so far: which rows bound, and for how long robots have been held."""
        self._projector.reset()
        if self._monitor is not None:
            self._monitor.reset()

    @abstractmethod
    def _limits(self) -> LimitRows | None:
        """Return the rows for what the motors can do."""

    def _disturbance(self) -> WheelDisturbance | None:
        """Return what the wheels may do on their own."""
        return None

    def _build(self) -> None:
        """Compose the rows from the parameters, and forget the steps so far."""
        p, limits, disturbance = self._parameters, self._limits(), self._disturbance()
        families: list[Family] = [] if limits is None else [limits]
        self._top_speed = math.inf if limits is None else limits.top_speed
        walls = p.walls()
        if walls is not None:
            margin = 0.5 * p.safety_radius if p.wall_margin is None else p.wall_margin
            families.append(WallRows(*walls, margin, p.barrier_gain, disturbance))
        self._obstacle_rows = None
        if self._obstacles:
            margin = 0.5 * p.safety_radius if p.obstacle_margin is None else p.obstacle_margin
            self._obstacle_rows = ObstacleRows(self._obstacles, margin, p.barrier_gain, disturbance)
            families.append(self._obstacle_rows)
        pairs = PairRows(p.safety_radius, p.barrier_gain, p.unsafe_gain, disturbance)
        self._book = RowBook(families, pairs, self._top_speed)
        self.reset()

    def _certify(self, desired: FloatArray, scene: Scene) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe velocities (2, N) nearest to the desired ones, and what was done."""
        rows, barrier = self._book.write(scene)
        if self._monitor is None:
            velocity, info = self._projector.project(desired, rows, self._top_speed)
        else:
            velocity, info = self._watch(desired, rows)
        info.smallest_h, info.clearance = barrier
        return velocity, info

    def _watch(self, desired: FloatArray, rows: Rows) -> tuple[FloatArray, ProjectionInfo]:
        """Certify with an eye on robots that are held, and tilt the commands of stuck ones."""
        assert self._monitor is not None
        command = desired
        stuck = self._monitor.stuck(desired.shape[1])
        if self._tilt and stuck.any():
            command = np.where(stuck, tilt(desired, self._tilt), desired)
        velocity, info = self._projector.project(command, rows, self._top_speed)
        if command is not desired and info.status == "trivial":
            info.status = "optimal"  # safe as it was tilted, but not what was desired
        if math.isfinite(info.moved):
            info.moved = float(np.hypot(*(velocity - desired)).max())
            self._monitor.watch(desired, command, velocity)
        info.stuck = np.flatnonzero(self._monitor.stuck(desired.shape[1]))
        return velocity, info
