"""Each robot its own small program: half of every pair's row, and it needs nobody's velocity.

The row of a pair, a·vᵢ + b·vⱼ ≤ c, is one condition on two robots, and only who knows what both are
told can solve the team's program. But where robot i keeps a·vᵢ ≤ c·sᵢ/(sᵢ + sⱼ) and robot j the
rest, the row holds whatever both do (Wang, Ames and Egerstedt, 2017, who take for the share sᵢ how
strong a robot is). So each robot has a program of two unknowns, from where it sees its neighbours
alone, and the velocities of all satisfy the team's rows. The price is room: what one robot does not
use of its share, the other may not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ShapeError
from barrier_certificates.projection.infeasible import Policy, furthest_first
from barrier_certificates.projection.plane_points import BROKEN, PlaneRows, nearest_points
from barrier_certificates.projection.projection_info import ProjectionInfo, Status
from barrier_certificates.projection.projector import Projector, largest_speed
from barrier_certificates.projection.scaled_program import TOLERANCE
from barrier_certificates.rows.row_set import Rows

_FAST = 10.0  # m/s; larger numbers want a unit of their own, which `Projector` finds
_WORST_FIRST = (Status.FAILED, Status.RELAXED, Status.OPTIMAL, Status.TRIVIAL)


class DecentralisedProjector(Projector):
    """Projects each robot's command onto its own rows and its shares of those of its pairs.

    Robots without a safe velocity meet the policy one by one: ``"stop"`` stops that robot.

    Parameters
    ----------
    solver, on_infeasible, options
        See `barrier_certificates.projection.Projector`: for robots whose rows have no solution, or
        numbers out of all measure.
    shares : sequence of float, optional
        A number for each robot; of a pair's bound each takes its part of the sum. Half if None.
    """

    def __init__(
        self,
        solver: str = "auto",
        on_infeasible: Policy = "relax",
        options: Mapping[str, float] | None = None,
        shares: Sequence[float] | None = None,
    ) -> None:
        super().__init__(solver, on_infeasible, options)
        self.shares = None if shares is None else np.asarray(shares, dtype=float)
        self._alone = Projector(solver, on_infeasible, options)
        self._index: IntArray | None = None

    def project(
        self, desired: FloatArray, rows: Rows, top_speed: float = math.inf
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the nearest velocities that satisfy each robot's rows, and what was done.

        Violations are those of the shares; a team's row is broken by √2 times as much at most.
        """
        number = rows.size // 2
        if desired.shape != (2, number):
            raise ShapeError(
                f"commands have shape {desired.shape}, but the rows are for (2, {number})"
            )
        plane = self._split(rows)
        excess = plane.excess(desired)
        worst = excess.max(axis=0, initial=-np.inf)
        if not (np.isfinite(desired).all() and (worst < np.inf).all()):
            return self.refuse(desired)
        if not (worst > BROKEN).any():  # nobody's command breaks a row
            violation = max(float(worst.max(initial=0.0)), 0.0)
            return desired.copy(), ProjectionInfo(Status.TRIVIAL, violation, rows=rows)
        fast = worst > _FAST
        found = nearest_points(np.where(fast, 0.0, desired), plane)
        info = ProjectionInfo(Status.OPTIMAL, rows=rows, iterations=found.rounds)
        info.solver = "basis exchange"
        decides = (found.basis >= 0) & found.settled & ~fast
        info.binding = self._row[found.basis, np.arange(number)][decides]
        velocity = found.points
        for robot in (~found.settled | fast).nonzero()[0]:
            velocity[:, robot] = self._answer_one(int(robot), desired, plane, rows, top_speed, info)
        info.binding = np.unique(info.binding)
        info.intervention = largest_speed(velocity - desired)
        excess = plane.excess(velocity)
        info.violation = max(float(excess.max()), 0.0)
        if info.status is not Status.OPTIMAL:
            excess, row = excess.reshape(-1), self._row.reshape(-1)
            order = furthest_first(np.maximum(excess, -1.0))
            info.broken = np.array(list(dict.fromkeys(row[order[excess[order] > TOLERANCE]])))
        return velocity, info

    def _answer_one(
        self,
        robot: int,
        desired: FloatArray,
        plane: PlaneRows,
        rows: Rows,
        top_speed: float,
        info: ProjectionInfo,
    ) -> FloatArray:
        """Return the velocity of one robot, by the policy where its rows have no solution."""
        there = (self._row[:, robot] >= 0).nonzero()[0]
        which = self._row[there, robot]
        own = Rows(
            np.repeat([[0], [1]], there.shape[0], axis=1),
            plane.normals[:, there, robot],
            plane.bounds[there, robot],
            2,
            rows.weight[which],
            lambda row: rows.label(int(which[row])),
        )
        self._alone.reset()
        velocity, told = self._alone.project(desired[:, robot : robot + 1], own, top_speed)
        info.status = min(info.status, told.status, key=_WORST_FIRST.index)
        info.iterations += told.iterations
        info.binding = np.append(info.binding, which[told.binding])
        return velocity[:, 0]

    def _split(self, rows: Rows) -> PlaneRows:
        """Return each robot's own rows and its shares of pairs', normals made unit vectors."""
        if self._index is not rows.index:
            self._lay_out(rows)
        total = len(rows)
        flat = rows.coefficient.reshape(-1)
        normals = np.stack([flat.take(self._place), flat.take(self._place + total)])
        length = np.hypot(normals[0], normals[1])
        length[length == 0.0] = 1.0
        normals /= length
        bounds = rows.bound.take(self._row) * self._part / length
        normals[:, self._padding] = 0.0
        bounds[self._padding] = np.inf
        return PlaneRows(normals, bounds)

    def _lay_out(self, rows: Rows) -> None:
        """Say where each robot's rows lie in the team's, a column a robot."""
        number, total = rows.size // 2, len(rows)
        robots = rows.index[::2] // 2  # of both ends of each row; the world is no robot
        end, row = (robots < number).nonzero()
        robot = robots[end, row]
        order = np.argsort(robot, kind="stable")
        end, row, robot = end[order], row[order], robot[order]
        starts = np.searchsorted(robot, np.arange(number))
        slot = np.arange(robot.shape[0]) - starts[robot]
        shape = (int(slot.max(initial=-1)) + 1, number)
        self._row, self._place = np.full(shape, -1), np.zeros(shape, dtype=np.intp)
        self._part = np.ones(shape)
        self._row[slot, robot] = row
        self._place[slot, robot] = 2 * end * total + row
        self._part[slot, robot] = self._parts(robot, robots[1 - end, row], number)
        self._padding = self._row < 0
        self._index = rows.index

    def _parts(self, robot: IntArray, other: IntArray, number: int) -> FloatArray:
        """Return which part of each row's bound is a robot's: all, where there is no other."""
        shares = np.ones(number) if self.shares is None else self.shares
        if shares.shape[0] != number:
            raise ShapeError(f"shares are for {shares.shape[0]} robots, but the team has {number}")
        with_world = np.append(shares, 0.0)
        mine = shares[robot]
        part: FloatArray = mine / (mine + with_world[other])
        return part
