"""What every certificate is given and remembers, and the way from command to answer."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from barrier_certificates import checks, given_parameters, hearing, per_robot
from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.deadlock import DeadlockMonitor, DeadlockParameters, tilt
from barrier_certificates.per_robot import PerRobot, as_numbers
from barrier_certificates.projection import Policy, ProjectionInfo, Projector, Status
from barrier_certificates.projection.decentralised import DecentralisedProjector
from barrier_certificates.projection.projector import largest_speed
from barrier_certificates.rows import (
    ConnectivityParameters,
    LimitRows,
    Margin,
    Obstacle,
    ObstacleRows,
    PairRows,
    RowBook,
    RowFamily,
    Rows,
    Scene,
    WallRows,
    WheelDisturbance,
    polygon,
    rectangle,
)
from barrier_certificates.rows.kept_links import require_connectivity
from barrier_certificates.rows.linked_book import LinkedRowBook
from barrier_certificates.rows.obstacles import listed
from barrier_certificates.rows.unequal_pairs import pair_rows
from barrier_certificates.step_memory import StepMemory

__all__ = ["Certificate"]


class RowAllowance(NamedTuple):
    """How rows differ from what is asked for, because robots are not where they seem.

    Attributes
    ----------
    pairs, walls, obstacles : float
        By how much distances between two robots, to a wall and to an obstacle are kept larger, m.
    unsafe_gain : float, optional
        γ of whatever is unsafe already, in the place of all others; None leaves them.
    """

    pairs: float = 0.0
    walls: float = 0.0
    obstacles: float = 0.0
    unsafe_gain: float | None = None


EXACT = RowAllowance()


class RowFamilies(NamedTuple):
    """What writes a certificate's rows; None where it has none of that kind.

    Attributes
    ----------
    limits, walls, obstacles, pairs : row families
        In the order in which they are written.
    """

    limits: LimitRows | None
    walls: WallRows | None
    obstacles: ObstacleRows
    pairs: PairRows | None


@dataclass(frozen=True)
class Certificate(ABC):
    """What is kept apart from what, how firmly, and how that is solved.

    A certificate is its parameters, and does not change; `dataclasses.replace` makes another one.
    Besides, it remembers which rows bound last time, which makes the next step faster but never
    changes its result, and for how long robots have been held, where it watches for that.

    Radius, gains and margins are one number for all robots, or a sequence of one for each. Unequal
    robots count as discs that must not overlap: two keep half the radius of the one and half of
    the other.

    Parameters
    ----------
    safety_radius : float or (N,) array-like
        Smallest distance between two positions, m. Of each robot: what it keeps from one of its own
        size, twice the radius of its disc.
    barrier_gain : float or (N,) array-like
        γ of pairs and obstacles, in 1/(m⁴ s): larger lets robots come closer faster. Zero: never
        any closer. Of two robots' the smaller counts.
    unsafe_gain : float or (N,) array-like, optional
        γ of pairs that are already too close; ``barrier_gain`` if None. Of two the larger counts.
    wall_gain : float or (N,) array-like, optional
        γ of walls, in 1/(m² s), a unit of its own; the number of ``barrier_gain`` if None.
    pair_rows : bool
        Whether robots are kept apart from each other. Without, a control run shows what robots do
        on their own; ``clearance`` then is of walls and obstacles alone.
    boundary : (4,) or (2, W) array-like, optional
        The arena: (x_min, x_max, y_min, y_max), or the corners of a convex polygon in order, m.
    wall_margin : float or (N,) array-like, optional
        How far inside the walls positions stay, m; half the safety radius if None.
    obstacle_margin : float or (N,) array-like, optional
        How far from the surface of obstacles positions stay, m; half the safety radius if None.
    obstacles : sequence of Disc or Segment
        What robots stay away from; a call may say where they are by then.
    limits : LimitRows, optional
        What the motors can do, as rows of your own, instead of the limits that have names.
    solver, on_infeasible, options
        See `barrier_certificates.projection.Projector`.
    connectivity : ConnectivityParameters, optional
        Which robots stay within range of each other; None lets a team fall apart.
    decentralised : bool
        Whether each robot has a program of its own, with its share of each pair's row, instead of
        one for the team; see `barrier_certificates.projection.decentralised`.
    shares : (N,) array-like, optional
        A positive number for each robot: of a pair's bound it takes its part of the sum. Half if
        None.
    deadlock : DeadlockParameters, optional
        When a robot counts as stuck; without it nobody watches.
    tilt : float
        Turn the commands of stuck robots by this angle (rad) before they are certified, until they
        are free again; zero leaves them stuck.
    checked : bool
        Whether numbers that make no sense, such as a negative gain, are refused. Only who has to
        take any number, as the Robotarium's published functions do, leaves them unchecked.

    Raises
    ------
    ParameterError
        If a parameter makes no sense, or numbers are for teams of different sizes; the message
        names it.
    SolverNotInstalledError
        If the solver asked for by name is not installed.
    """

    may_differ: ClassVar[tuple[str, ...]] = (
        "safety_radius",
        "barrier_gain",
        "unsafe_gain",
        "wall_gain",
        "wall_margin",
        "obstacle_margin",
    )
    """Which parameters may be sequences of one number for each robot."""

    safety_radius: PerRobot = 0.15
    barrier_gain: PerRobot = 100.0
    _: KW_ONLY
    unsafe_gain: PerRobot | None = None
    wall_gain: PerRobot | None = None
    pair_rows: bool = True
    boundary: Any = None
    wall_margin: PerRobot | None = None
    obstacle_margin: PerRobot | None = None
    obstacles: Sequence[Obstacle] = ()
    limits: LimitRows | None = None
    solver: str = "auto"
    on_infeasible: Policy = "relax"
    options: Mapping[str, float] | None = field(default=None, hash=False)
    connectivity: ConnectivityParameters | None = None
    decentralised: bool = False
    shares: Sequence[float] | None = None
    deadlock: DeadlockParameters | None = None
    tilt: float = 0.0
    checked: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "obstacles", listed(self.obstacles))
        if self.boundary is not None:
            points = given_parameters.boundary_points(self.boundary)
            object.__setattr__(self, "boundary", points)
        if self.shares is not None:
            object.__setattr__(self, "shares", given_parameters.shares_of(self.shares))
        per_robot.settle(self, self.may_differ, self.checked)
        if self.checked:
            self.check()
        self.reset()

    def check(self) -> None:
        """Refuse parameters that make no sense.

        Raises
        ------
        ParameterError
            If a parameter is out of its range, numbers are for teams of different sizes, or a
            boundary encloses nothing.
        """
        per_robot.check_each(checks.positive, "safety_radius", self.safety_radius, "of metres")
        per_robot.check_each(checks.not_negative, "barrier_gain", self.barrier_gain)
        for name in ("unsafe_gain", "wall_gain", "wall_margin", "obstacle_margin"):
            if getattr(self, name) is not None:
                per_robot.check_each(checks.not_negative, name, getattr(self, name))
        per_robot.team_size({name: getattr(self, name) for name in (*self.may_differ, "shares")})
        checks.angle("tilt", self.tilt)
        if self.shares is not None and not self.decentralised:
            raise ParameterError(
                f"shares are {self.shares}, but the certificate is not decentralised; expected"
                " decentralised=True with them"
            )
        if not (self.deadlock is None or isinstance(self.deadlock, DeadlockParameters)):
            raise ParameterError(
                f"deadlock is {self.deadlock!r}; expected DeadlockParameters or None"
            )
        if self.connectivity is not None:
            require_connectivity(self.connectivity, self.safety_radius if self.pair_rows else 0.0)
        if self.boundary is not None and len(self.boundary) == 4:
            x_min, x_max, y_min, y_max = self.boundary
            if not (x_min < x_max and y_min < y_max):
                raise given_parameters.no_boundary(self.boundary)

    @cached_property
    def team_size(self) -> int | None:
        """For how many robots there are numbers of their own; None where all are alike."""
        return per_robot.team_size({name: getattr(self, name) for name in self.may_differ})

    def reset(self) -> None:
        """Forget the steps so far: which rows bound, and for how long robots have been held."""
        self._memory.reset()

    def reach(self) -> float:
        """Return the distance beyond which no two robots can break their row, m.

        Infinite where nothing limits speeds, and where a tree of links is chosen, for which all
        have to be seen; of unequal robots it is for the largest distance, the smallest gain and the
        highest speed. A robot that computes its own answer (``decentralised``) need not see
        farther.
        """
        memory = self._memory
        pairs, least = memory.book.pairs, 0.5
        links = 0.0 if self.connectivity is None else self.connectivity.reach()
        if pairs is None:
            return links
        if self.shares is not None:
            least = min(self.shares) / (min(self.shares) + max(self.shares))
        return max(links, pairs.reach(memory.book.top_speed * 0.5 / least))

    def row_families(self) -> RowFamilies:
        """Return what writes the rows; a call with other obstacles moves those in here."""
        memory = self._memory
        limits = self._motor_limits() if self.limits is None else self.limits
        return RowFamilies(limits, memory.walls, memory.obstacles, memory.book.pairs)

    @abstractmethod
    def _motor_limits(self) -> LimitRows | None:
        """Return the rows for the limits that have names."""

    def _disturbance(self) -> WheelDisturbance | None:
        """Return what the wheels may do on their own."""
        return None

    def _wall_rows(self, disturbance: WheelDisturbance | None) -> WallRows | None:
        """Return the rows for the walls, if there are any."""
        if self.boundary is None:
            return None
        walls = (rectangle if len(self.boundary) == 4 else polygon)(self.boundary)
        more = self._allowance()
        margin = self._half_radius(self.wall_margin) + more.walls
        gain = as_numbers(self.barrier_gain if self.wall_gain is None else self.wall_gain)
        return WallRows(*walls, margin, gain, disturbance, more.unsafe_gain)

    def _allowance(self) -> RowAllowance:
        """Return how rows differ from what is asked for; not at all, where robots obey at once."""
        return EXACT

    def _all_rows(self, rows: Rows, scene: Scene) -> Rows:
        """Return the rows to be kept, given those of the row book for a scene."""
        return rows

    def _projector(self) -> Projector:
        """Return who finds the nearest velocities."""
        if self.decentralised:
            return DecentralisedProjector(
                self.solver, self.on_infeasible, self.options, self.shares
            )
        return Projector(self.solver, self.on_infeasible, self.options)

    def _half_radius(self, margin: PerRobot | None) -> float | FloatArray:
        """Return a margin, by default half the safety radius, m."""
        return 0.5 * as_numbers(self.safety_radius) if margin is None else as_numbers(margin)

    @cached_property
    def _memory(self) -> StepMemory:
        disturbance, more = self._disturbance(), self._allowance()
        limits = self._motor_limits() if self.limits is None else self.limits
        walls = self._wall_rows(disturbance)
        obstacles = ObstacleRows(
            self.obstacles,
            self._half_radius(self.obstacle_margin) + more.obstacles,
            as_numbers(self.barrier_gain),
            disturbance,
            more.unsafe_gain,
        )
        families = [family for family in (limits, walls, obstacles) if family is not None]
        pairs = None
        if self.pair_rows:
            radius = per_robot.widened(self.safety_radius, more.pairs)
            unsafe = self.unsafe_gain if more.unsafe_gain is None else more.unsafe_gain
            pairs = pair_rows(radius, self.barrier_gain, unsafe, disturbance)
        top_speed = math.inf if limits is None else limits.top_speed
        deadlock = self.deadlock
        if deadlock is None and self.tilt:
            deadlock = DeadlockParameters()
        return StepMemory(
            self._row_book(families, pairs, top_speed, disturbance),
            walls,
            obstacles,
            self._projector(),
            None if deadlock is None else DeadlockMonitor(deadlock),
        )

    def _row_book(
        self,
        families: Sequence[RowFamily],
        pairs: PairRows | None,
        top_speed: float,
        disturbance: WheelDisturbance | None,
    ) -> RowBook:
        """Return what writes the rows, with those of links where a team stays connected."""
        if self.connectivity is None:
            return RowBook(families, pairs, top_speed)
        held: float = getattr(self, "time_step", 0.0)
        kept = self.connectivity.barrier(held, top_speed, disturbance)
        return LinkedRowBook(families, pairs, top_speed, self.connectivity, kept)

    def _refuse(self, desired: FloatArray) -> tuple[FloatArray, ProjectionInfo]:
        """Stop everybody, since something is not a number."""
        velocity, info = self._memory.projector.refuse(desired)
        info.range_left = math.inf if self.connectivity is None else math.nan
        return velocity, info

    def _certify(
        self, desired: FloatArray, scene: Scene, obstacles: Sequence[Obstacle] | None
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe velocities (2, N) nearest to the desired ones, and what was done."""
        memory = self._memory
        memory.place(self.obstacles if obstacles is None else obstacles)
        rows, barrier = memory.book.write(scene)
        rows = self._all_rows(rows, scene)
        if memory.monitor is None:
            velocity, info = memory.projector.project(desired, rows, memory.book.top_speed)
        else:
            velocity, info = self._watch(desired, rows, memory.monitor)
        memory.tell(info, barrier)
        hearing.tell(desired, velocity, info)
        return velocity, info

    def _watch(
        self, desired: FloatArray, rows: Rows, monitor: DeadlockMonitor
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Certify with an eye on robots that are held, and tilt the commands of stuck ones."""
        command = desired
        stuck = monitor.stuck(desired.shape[1])
        if self.tilt and stuck.any():
            command = np.where(stuck, tilt(desired, self.tilt), desired)
        velocity, info = self._memory.projector.project(command, rows, self._memory.book.top_speed)
        if command is not desired and info.status is Status.TRIVIAL:
            info.status = Status.OPTIMAL  # safe as it was tilted, but not what was desired
        if math.isfinite(info.intervention):
            info.intervention = largest_speed(velocity - desired)
            monitor.watch(desired, command, velocity)
        info.stuck = np.flatnonzero(monitor.stuck(desired.shape[1]))
        return velocity, info

    def _margins(
        self, scene: Scene, within: float, obstacles: Sequence[Obstacle] | None
    ) -> list[Margin]:
        checks.require_finite("positions", scene.positions)
        checks.not_negative("within", within, "of metres")
        self._memory.place(self.obstacles if obstacles is None else obstacles)
        return self._memory.book.margins(scene, within)
