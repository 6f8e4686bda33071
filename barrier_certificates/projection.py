"""The safe velocity nearest to the desired one, exactly, and what to do when there is none.

`Projector` solves ``min ‖v − v̂‖²`` over the rows of `barrier_certificates.rows` with a *lazy
working set*: solve with the rows that ``v̂`` breaks and those that bound last time, add what the
solution breaks, repeat until nothing is broken. The optimum of a subset of rows that satisfies all
rows is the optimum, so leaving rows out costs nothing in exactness, and most steps need a handful
of several hundred rows, or none.

Each round first guesses the binding rows (`barrier_certificates.active_set`, a proof comes with the
answer) and asks the chosen solver only where that does not settle. Whoever answered, every row is
checked before an answer is returned.

Some states have no safe velocity: robots that already overlap, or stand far outside a wall. What
happens then is a *policy*:

``"relax"``
    What the motors can do stays a hard limit; pairs, obstacles and walls are satisfied as well as
    possible (a quadratic price on each row's excess), so robots part and come back inside.
``"stop"``
    All robots stop.
``"raise"``
    `InfeasibleError`, naming the rows that are furthest from holding.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from barrier_certificates import checks, solvers
from barrier_certificates.active_set import guess
from barrier_certificates.certificate_errors import (
    InfeasibleError,
    NotFiniteError,
    ParameterError,
    ShapeError,
)
from barrier_certificates.rows import BoolArray, FloatArray, IntArray, Rows
from barrier_certificates.ties import rank

Policy = Literal["relax", "stop", "raise"]
Status = Literal["trivial", "optimal", "relaxed", "failed"]

TOLERANCE = 1e-9
"""A row holds when it is broken by no more than this, m/s."""

_ROUNDING = 1e-14
"""Rounding of rows, relative: where nothing limits speeds, overlaps can ask for 100 km/s."""

_FAR = 1e5
"""Beyond this many times the top speed a command says no more than its direction."""

_NO_ROWS: IntArray = np.zeros(0, dtype=np.intp)
_GUESSES = 8
_ROUNDS = 50
_BINDS = 1e-7  # m/s; a row this close to its bound is reported as binding


@dataclass(slots=True)
class ProjectionInfo:
    """What a projection did.

    Attributes
    ----------
    status : str
        ``"trivial"``: the command was safe and is returned as it was. ``"optimal"``: the nearest
        safe velocity. ``"relaxed"``: no safe velocity exists, this one breaks the rows least.
        ``"failed"``: the robots were stopped (policy ``"stop"``, or NaN in poses or command, which
        leaves the other numbers NaN).
    violation : float
        Largest excess over all rows at the velocity returned, m/s; zero if all hold.
    iterations : int
        Small problems solved.
    solver : str
        Who gave the answer; empty for a trivial one.
    moved : float
        How far the command was moved, the largest over the robots, m/s.
    smallest_h : float
        Smallest barrier at the present positions: ‖D‖² − r² in m² for pairs and obstacles, the
        distance less the margin in m for walls. Negative exactly when something is unsafe.
    clearance : float
        The same in metres throughout: distance less radius, distance to the wall less margin.
    binding : integer array
        Indices of the rows that bind.
    stuck : integer array
        Robots that have been told to move but held back for some time, where a certificate watches
        for it (its ``deadlock`` parameters).
    """

    status: Status
    violation: float = 0.0
    iterations: int = 0
    solver: str = ""
    moved: float = 0.0
    smallest_h: float = math.inf
    clearance: float = math.inf
    binding: IntArray = field(default_factory=lambda: _NO_ROWS, repr=False)
    stuck: IntArray = field(default_factory=lambda: _NO_ROWS)
    rows: Rows | None = field(default=None, repr=False)

    @property
    def deadlocked(self) -> bool:
        """Whether any robot is stuck."""
        return bool(self.stuck.shape[0])

    @property
    def active(self) -> tuple[str, ...]:
        """What the binding rows stand for: ``"robots 3 and 7"``, ``"robot 0 and wall +x"``."""
        if self.rows is None:
            return ()
        return tuple(self.rows.label(int(row)) for row in self.binding)


class Projector:
    """Projects one command after another, starting each from the rows that bound last time.

    Parameters
    ----------
    solver : str
        ``"auto"`` guesses the binding rows first and picks the exact solver by size and by what is
        installed. A name out of `barrier_certificates.solvers.NAMES` uses that solver alone.
    on_infeasible : {"relax", "stop", "raise"}
        What to do when no velocity satisfies all rows.
    options : mapping, optional
        Options for the solver named, passed with each call and never set globally.

    Raises
    ------
    ParameterError
        If there is no such policy or solver, or options come without the name of a solver.
    SolverNotInstalledError
        If the solver is not installed; the message says what brings it.
    """

    def __init__(
        self,
        solver: str = "auto",
        on_infeasible: Policy = "relax",
        options: Mapping[str, float] | None = None,
    ) -> None:
        if on_infeasible not in get_args(Policy):
            raise ParameterError(
                f"on_infeasible is {on_infeasible!r}; expected one of {', '.join(get_args(Policy))}"
            )
        solvers.check(solver)
        if options and solver == "auto":
            raise ParameterError(
                f"options {dict(options)} are for no solver in particular; expected its name too, "
                f"solver= one of {', '.join(solvers.NAMES)}"
            )
        self.solver = solver
        self.on_infeasible = on_infeasible
        self.options: Mapping[str, float] = dict(options or {})
        self._warm: IntArray = _NO_ROWS
        self._warm_for = (0, 0)
        self._tolerance = TOLERANCE

    def reset(self) -> None:
        """Forget which rows bound last time."""
        self._warm = _NO_ROWS

    def project(
        self, desired: FloatArray, rows: Rows, top_speed: float = math.inf
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the nearest velocities (2, N) in m/s that satisfy all rows, and what was done.

        Parameters
        ----------
        desired : (2, N) array
            The commands, m/s; left as they are.
        rows : Rows
            What must hold.
        top_speed : float
            No robot can be faster, m/s: when rows must be relaxed, none is asked for more, and
            commands beyond 100,000 times as much are first shortened to that.

        Raises
        ------
        InfeasibleError
            If no velocity satisfies all rows and the policy is ``"raise"``.
        NotFiniteError
            If the command or the rows hold NaN or infinity and the policy is ``"raise"``.
        """
        if desired.shape != (2, rows.size // 2):
            raise ShapeError(
                f"commands have shape {desired.shape}, but the rows are for (2, {rows.size // 2})"
            )
        if not checks.finite(desired):
            return self.refuse(desired)
        target = desired.T.reshape(-1)
        excess = rows.excess(target)
        worst = float(excess[excess.argmax()]) if excess.shape[0] else 0.0
        if not math.isfinite(worst):
            return self.refuse(desired)
        if worst <= TOLERANCE:
            self._warm = _NO_ROWS
            return desired.copy(), ProjectionInfo("trivial", max(worst, 0.0), rows=rows)
        info = ProjectionInfo("optimal", rows=rows)
        self._tolerance = max(TOLERANCE, _ROUNDING * worst)
        if self._tolerance > TOLERANCE and math.isfinite(top_speed):
            # Rounding of such numbers would hide what robots that have a top speed can do.
            self._tolerance = TOLERANCE
            target = _brought_near(desired, _FAR * top_speed).T.reshape(-1)
            excess = rows.excess(target)
        point = self._nearest(target, rows, excess, info)
        if point is None:
            point = self._without_solution(target, rows, excess, top_speed, info)
        velocity = point.reshape(-1, 2).T.copy()
        info.moved = (
            largest_shift(point, target)
            if worst < _FAR  # squares of more can overflow
            else float(np.hypot(*(velocity - desired)).max())
        )
        return velocity, info

    def _nearest(
        self, target: FloatArray, rows: Rows, excess: FloatArray, info: ProjectionInfo
    ) -> FloatArray | None:
        """Return the optimum, or None where no point satisfies all rows."""
        warm = self._recall(rows)
        if self.solver == "auto":
            point, info.binding, violation, info.iterations = guess(
                rows, target, excess, warm, self._tolerance, _GUESSES
            )
            info.solver = "active set"
        else:
            point = None
        if point is None:
            working = excess > self._tolerance
            working[warm] = True
            point, info.solver = self._exact(rows, target, working, info)
            if point is None:
                return None
            gap = rows.excess(point)
            violation = float(gap[gap.argmax()])
            info.binding = (working & (gap > -_BINDS)).nonzero()[0]
        info.violation = max(violation, 0.0)
        self._warm = info.binding if rows.key is None else rows.key[info.binding]
        self._warm_for = _team(rows)
        return point

    def _exact(
        self,
        rows: Rows,
        target: FloatArray,
        working: BoolArray,
        info: ProjectionInfo,
    ) -> tuple[FloatArray | None, str]:
        """Solve for the working rows, add those that are broken, until none is; and by whom.

        A solver that finds no point, or one that breaks the rows it was given, may be mistaken or
        out of iterations: another one has to agree.
        """
        name = solvers.choose(self.solver, rows.size)
        asked = [name]
        for _ in range(_ROUNDS):
            which = working.nonzero()[0]
            info.iterations += 1
            point = solvers.solve(name, rows, which, target, self._options_of(name))
            broken = None if point is None else rows.excess(point) > self._tolerance
            if broken is None or broken[which].any():
                second = solvers.confirm(name, rows.size)
                if second in asked:
                    return None, name
                asked.append(second)
                name = second
                continue
            if not broken.any():
                return point, name
            working |= broken
        return None, name

    def _options_of(self, name: str) -> Mapping[str, float]:
        """Return the options if they are meant for this solver."""
        return self.options if name == self.solver else {}

    def _recall(self, rows: Rows) -> IntArray:
        """Find last time's binding rows among the present ones."""
        if not self._warm.shape[0] or self._warm_for != _team(rows):
            return _NO_ROWS
        if rows.key is None:
            return self._warm
        return np.flatnonzero(np.isin(rows.key, self._warm))

    def _without_solution(
        self,
        target: FloatArray,
        rows: Rows,
        excess: FloatArray,
        top_speed: float,
        info: ProjectionInfo,
    ) -> FloatArray:
        """Do what the policy says where no velocity satisfies all rows."""
        self._warm = _NO_ROWS
        if self.on_infeasible == "raise":
            furthest = np.argsort([-rank(e) for e in excess], kind="stable")[:3]
            named = "; ".join(
                f"{rows.label(int(k))} ({excess[k]:.3g} m/s)"
                for k in furthest
                if excess[k] > TOLERANCE
            )
            raise InfeasibleError(
                f"no velocity satisfies all {len(rows)} rows; the command breaks most: {named}. "
                "Part the robots, bring them inside the walls, or use on_infeasible='relax'"
            )
        if self.on_infeasible == "relax":
            point = self._relaxed(target, rows, top_speed, info)
            if point is not None:
                info.status = "relaxed"
                return point
        point = np.zeros_like(target)
        info.status, info.solver, info.binding = "failed", "", _NO_ROWS
        info.violation = max(float(rows.excess(point).max()), 0.0)
        return point

    def _relaxed(
        self, target: FloatArray, rows: Rows, top_speed: float, info: ProjectionInfo
    ) -> FloatArray | None:
        """Return the velocity that breaks the rows least, hard limits kept."""
        softened = rows.softened()
        # A pair cannot part faster than this: asking for more only spoils the conditioning.
        softened.bound = np.maximum(rows.bound, -math.sqrt(2.0) * top_speed)
        start = np.zeros(softened.size)
        start[: rows.size] = target
        working = softened.excess(start) > self._tolerance
        point, info.solver = self._exact(softened, start, working, info)
        if point is None:
            return None
        velocity = point[: rows.size]
        excess = rows.excess(velocity)
        hard = np.isinf(rows.weight)
        if hard.any() and not float(excess[hard].max()) <= TOLERANCE:
            return None
        info.violation = max(float(excess.max()), 0.0)
        info.binding = (working & (softened.excess(point) > -_BINDS)).nonzero()[0]
        return velocity

    def refuse(self, desired: FloatArray) -> tuple[FloatArray, ProjectionInfo]:
        """Stop everybody: a command or pose that is not a number says nothing about safety.

        Raises
        ------
        NotFiniteError
            If the policy is ``"raise"``.
        """
        self._warm = _NO_ROWS
        if self.on_infeasible == "raise":
            raise NotFiniteError("poses or commands hold NaN or infinity; expected finite numbers")
        unknown = ProjectionInfo("failed", math.nan, moved=math.nan)
        unknown.smallest_h = unknown.clearance = math.nan
        return np.zeros_like(desired), unknown


def largest_shift(point: FloatArray, target: FloatArray) -> float:
    """Return the longest of the robots' ways from target to point, both (2N,) robot by robot."""
    shift = point - target
    shift *= shift
    square = shift[::2] + shift[1::2]
    return math.sqrt(square[square.argmax()])


def _brought_near(desired: FloatArray, limit: float) -> FloatArray:
    """Return commands (2, N) with those longer than the limit shortened to it, m/s."""
    shorter: FloatArray = desired * (limit / np.maximum(np.hypot(*desired), limit))
    return shorter


def _team(rows: Rows) -> tuple[int, int]:
    """Tell apart row sets in which the same row means different things."""
    return rows.size, len(rows) if rows.key is None else -1


def project(
    desired: FloatArray,
    rows: Rows,
    solver: str = "auto",
    on_infeasible: Policy = "relax",
    options: Mapping[str, float] | None = None,
) -> tuple[FloatArray, ProjectionInfo]:
    """Project one command on the rows: `Projector` without memory, see there."""
    return Projector(solver, on_infeasible, options).project(np.asarray(desired, float), rows)
