"""From command to answer: safe commands pass, others are projected, hopeless ones meet a policy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import get_args

import numpy as np

from barrier_certificates import checks, solvers
from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate_errors import NotFiniteError, ParameterError, ShapeError
from barrier_certificates.projection.infeasible import (
    Policy,
    furthest_first,
    furthest_from_holding,
    least_broken,
)
from barrier_certificates.projection.projection_info import NO_ROWS, ProjectionInfo, Status
from barrier_certificates.projection.scaled_program import TOLERANCE, QuadraticProgram
from barrier_certificates.projection.working_set import WorkingSet
from barrier_certificates.rows.row_set import Rows


class Projector:
    """Projects one command after another, starting each from the rows that bound last time.

    Parameters
    ----------
    solver : str
        ``"auto"`` guesses the binding rows first and picks the exact solver by size and by what is
        installed. A name out of `barrier_certificates.solvers.NAMES` uses that solver alone.
    on_infeasible : {"relax", "stop", "raise"}
        What to do when no velocity satisfies all rows, see
        `barrier_certificates.projection.infeasible`.
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
        self.on_infeasible = on_infeasible
        self._search = WorkingSet(solver, dict(options or {}))

    def reset(self) -> None:
        """Forget which rows bound last time."""
        self._search.forget()

    def project(
        self, desired: FloatArray, rows: Rows, top_speed: float = math.inf
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the nearest velocities that satisfy all rows, and what was done.

        Parameters
        ----------
        desired : (2, N) array
            The commands, m/s; left as they are.
        rows : Rows
            What must hold.
        top_speed : float
            No robot can be faster, m/s: when rows must be relaxed, none is asked for more, and
            commands beyond 100,000 times as much are first shortened to that.

        Returns
        -------
        velocity : (2, N) array
            The velocities, m/s.
        info : ProjectionInfo
            What was done.

        Raises
        ------
        InfeasibleError
            If no velocity satisfies all rows and the policy is ``"raise"``.
        NotFiniteError
            If the command or the rows hold NaN or infinity and the policy is ``"raise"``.
        ShapeError
            If the command is for another number of robots than the rows.
        """
        if desired.shape != (2, rows.size // 2):
            raise ShapeError(
                f"commands have shape {desired.shape}, but the rows are for (2, {rows.size // 2})"
            )
        if not checks.finite(desired):
            return self.refuse(desired)
        program = QuadraticProgram.of(desired.T.reshape(-1), rows, top_speed)
        if not math.isfinite(program.worst):
            return self.refuse(desired)
        if program.worst <= TOLERANCE:
            self._search.forget()
            return desired.copy(), ProjectionInfo(
                Status.TRIVIAL, max(program.worst, 0.0), rows=rows
            )
        info = ProjectionInfo(Status.OPTIMAL, rows=rows)
        program = program.scaled()
        velocity = self._answer(program, info).reshape(-1, 2).T.copy()
        if program.unit != 1.0:
            velocity *= program.unit
            info.violation *= program.unit
        info.intervention = largest_speed(velocity - desired)
        return velocity, info

    def _answer(self, program: QuadraticProgram, info: ProjectionInfo) -> FloatArray:
        """Return the optimum (2N,), or what the policy says where there is none."""
        point = self._search.optimum(program, info)
        if point is not None:
            return point
        self._search.forget()
        if self.on_infeasible == "raise":
            raise furthest_from_holding(program)
        if self.on_infeasible == "relax":
            point = least_broken(program, self._search, info)
        if point is None:
            point = np.zeros_like(program.target)
            info.status, info.solver, info.binding = Status.FAILED, "", NO_ROWS
        else:
            info.status = Status.RELAXED
        excess = program.rows.excess(point)
        order = furthest_first(excess)
        info.broken = order[excess[order] > TOLERANCE]
        info.violation = max(float(excess.max()), 0.0)
        return point

    def refuse(self, desired: FloatArray) -> tuple[FloatArray, ProjectionInfo]:
        """Stop everybody: a command or pose that is not a number says nothing about safety.

        Parameters
        ----------
        desired : (2, N) array
            The command, of which only the shape is used.

        Returns
        -------
        velocity : (2, N) array
            Zeros.
        info : ProjectionInfo
            Status ``"failed"``; its numbers are NaN.

        Raises
        ------
        NotFiniteError
            If the policy is ``"raise"``.
        """
        self._search.forget()
        if self.on_infeasible == "raise":
            raise NotFiniteError("poses or commands hold NaN or infinity; expected finite numbers")
        unknown = ProjectionInfo(Status.FAILED, math.nan, intervention=math.nan)
        unknown.smallest_h = unknown.clearance = math.nan
        return np.zeros_like(desired), unknown


def largest_speed(velocity: FloatArray) -> float:
    """Return the largest speed among velocities.

    Parameters
    ----------
    velocity : (2, N) array
        Velocities; the speed has their unit.
    """
    speed = np.hypot(velocity[0], velocity[1])  # which large numbers do not overflow
    return float(speed[speed.argmax()])
