"""The flocking law on wheels for many teams: poses in, unicycle commands out, once a step.

The steps are those that `flocking.flock` numbers, in the same order. What is done robot by robot
(filter, headings, commands) is done on all robots of all teams as on one large team, since no robot
asks another there; law, neighbours and limits take the axis of teams.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.batch import STATUSES, BatchCertificate, BatchInfo, Engine
from barrier_certificates.per_robot import largest
from posflock_robotarium.batch.batch_steering import BatchSteering
from posflock_robotarium.batch.team_laws import law_of_teams
from posflock_robotarium.flocking.drive_limits import limits_of, within_limits
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.law import LawParameters, displacements, saturate
from posflock_robotarium.flocking.neighbour_memory import NeighbourMemory
from posflock_robotarium.flocking.pose_filter import PoseFilter

__all__ = ["BatchFlock", "BatchFlockStep"]

Floats = NDArray[np.float64]

#: What a log calls each of the certificate's codes.
WORDS = np.array([str(STATUSES[code]) for code in range(len(STATUSES))])


@dataclass(frozen=True, eq=False)
class BatchFlockStep:
    """What B flocks decided at one step; see `FlockStep` for one.

    Attributes
    ----------
    command : (B, 2, N) array
        v in m/s and ω in rad/s.
    status : (B,) integer array
        What the certificate said: keys of `barrier_certificates.batch.STATUSES`.
    intervention : (B,) array
        How far it changed a robot's velocity at most, m/s.
    clearance : (B,) array
        How far each team is from being unsafe, m.
    turning : (B,) array
        By how much arena steering turned the common velocity in this step, rad.
    """

    command: Floats
    status: NDArray[np.intp]
    intervention: Floats
    clearance: Floats
    turning: Floats


class BatchFlock:
    """The controller of B flocks that start differently, and may follow laws of their own.

    Each team is told what a `Flock` of its own would tell it: the same numbers with numpy; compiled
    certificates differ by the rounding of sines and cosines.

    Parameters
    ----------
    flock : Flock
        What all follow: law, model, walls, certificate, filter, steering. Its state is not used.
    teams : int
        How many, B.
    engine : {"auto", "numba", "numpy"}
        Who computes the certificate; ``"auto"`` is compiled where numba is installed.
    threads : int, optional
        How many parts of the teams the certificate computes side by side at most; one for each
        processor if None.
    laws : sequence of B LawParameters, optional
        What each team follows in the place of the flock's law.

    Raises
    ------
    ParameterError
        Where there are no teams, or not as many laws; the flock is local, or a law's radius not
        more than the flock's hysteresis; or the engine cannot do what the certificate asks for.
    EngineNotInstalledError
        If numba is asked for but not installed.

    Warns
    -----
    UserWarning
        At the first step, where teams start closer than the certificate keeps them.

    Examples
    --------
    >>> import numpy as np
    >>> one = np.array([[0.0, 0.4], [0.0, 0.0], [0.0, np.pi / 2]])
    >>> flocks = BatchFlock(Flock(), teams=3, engine="numpy")
    >>> flocks.step(np.stack([one, one, one])).command.shape
    (3, 2, 2)
    """

    def __init__(
        self,
        flock: Flock,
        teams: int,
        *,
        engine: Engine = "auto",
        threads: int | None = None,
        laws: Sequence[LawParameters] | None = None,
    ) -> None:
        if teams < 1:
            raise ParameterError(f"teams: expected one at least, got {teams!r}")
        if flock.local:
            raise ParameterError(
                "flock: it is local, each robot with estimates of its own; expected one that is"
                " steered by its mean, or fly local flocks one at a time, by simulate"
            )
        if laws is not None and len(laws) != teams:
            raise ParameterError(f"laws: expected {teams}, one for each team, got {len(laws)}")
        self.law = flock.law if laws is None else law_of_teams(laws)
        self.model, self.walls = flock.model, flock.walls
        self.time_step, self.teams = flock.time_step, teams
        self._one = replace(flock.certificate)
        self.certificate = BatchCertificate(self._one, engine=engine, threads=threads)
        self._limits = limits_of(self._one)
        self._all_rows = replace(self._one, pair_rows=True, connectivity=None)
        self._arena, self._steering_parameters = flock.arena, flock.steering
        self._hysteresis = flock.hysteresis
        self._filtering = flock.filter.parameters
        self.reset()

    def reset(self) -> None:
        """Forget the imprints and every velocity: the next step is the first."""
        margin = self._one.wall_margin
        assert margin is not None  # or there were no flock
        self._steps = 0
        self._imprint: Floats | None = None
        self._velocity: Floats | None = None
        self._neighbours = NeighbourMemory(self.law.radius, self._hysteresis)
        self._filter = PoseFilter(self._filtering, self.time_step)
        self._steering = BatchSteering(
            self._steering_parameters, self._arena, largest(margin), self.time_step, self.teams
        )
        self.certificate.reset()

    def step(self, poses: ArrayLike) -> BatchFlockStep:
        """Decide the next commands of all teams from the poses just read.

        Parameters
        ----------
        poses : (B, 3, N) array
            x, y in metres and θ in radians; N from 2, the same at every step.

        Raises
        ------
        ParameterError
            Where the poses have another shape or a value that is not finite, or the law is for
            another number of robots.
        """
        seen = self._checked(poses)
        x = self._filter.update(_side_by_side(seen))
        ahead = np.stack([np.cos(x[2]), np.sin(x[2])])
        points = self._apart(x[:2] + self._one.projection_distance * ahead)
        if self._imprint is None or self._velocity is None:
            self.law.agents_must_be(points.shape[-1])
            self._imprint = displacements(points)
            self._velocity = np.zeros_like(points)
        self._steps += 1
        w, turning = self._intended(points, self._velocity, self._imprint)

        certified = self._apart(x)
        if self.certificate.answers_late:  # by what is seen, not by what is filtered
            certified = self.certificate.stops(seen)
            heading = _side_by_side(certified)[2]
            ahead = np.stack([np.cos(heading), np.sin(heading)])
        possible = within_limits(w, self._apart(ahead), self._limits)
        applied, info = self.certificate.project(possible, certified)
        self._warn_of_unsafe_starts(info)
        self._velocity = applied
        columns = self._one.commands(_side_by_side(applied), _side_by_side(certified))
        command = self._apart(columns)
        self.certificate.sent(command)
        self._filter.moved(columns)
        clearance = info.clearance if self._one.pair_rows else self._clearances(certified)
        return BatchFlockStep(command, info.status, info.intervention, clearance, turning)

    def _intended(self, points: Floats, w: Floats, imprint: Floats) -> tuple[Floats, Floats]:
        """Return the velocities (B, 2, N) that law and steering want, and how far teams turned."""
        time = self._steps * self.time_step
        turning: Floats = np.zeros(self.teams)
        linked = self._neighbours.update(points)
        law = self.model.input(points, w, imprint, time, self.law, linked)
        u = saturate(law, self.law.input_limit)
        if self.walls == "steer":
            u, w, turning = self._steering.steer(time, points, u, w)
        return saturate(w + self.time_step * u, self.law.speed_limit), turning

    def _warn_of_unsafe_starts(self, info: BatchInfo) -> None:
        if not info.unsafe_start.any():
            return
        teams = np.flatnonzero(info.unsafe_start)
        closest = 1e3 * -float(info.clearance[teams].min())
        warnings.warn(
            f"{teams.size} of {self.teams} teams, the first of them {teams[0]}, start closer than"
            f" the certificate keeps them, by up to {closest:.3g} mm: it guarantees nothing to a"
            " team until it is apart",
            stacklevel=3,
        )

    def _clearances(self, poses: Floats) -> Floats:
        """Return the clearances of teams that nobody keeps apart."""
        within = self._arena[1] - self._arena[0]  # something is nearer than the arena is wide
        return np.array([self._all_rows.margins(one, within=within)[0].clearance for one in poses])

    def _checked(self, poses: ArrayLike) -> Floats:
        x = np.ascontiguousarray(poses, dtype=float)
        robots = None if self._velocity is None else self._velocity.shape[2]
        if x.ndim != 3 or x.shape[:2] != (self.teams, 3) or x.shape[2] < 2:
            raise ParameterError(
                f"poses: expected shape ({self.teams}, 3, N), x, y and θ of at least two robots a"
                f" team; got {x.shape}"
            )
        if robots not in (None, x.shape[2]):
            raise ParameterError(
                f"poses: expected {robots} robots a team as at the first step, got {x.shape[2]};"
                " call reset() to begin other runs"
            )
        if not np.isfinite(x).all():
            team, row, robot = np.argwhere(~np.isfinite(x))[0]
            raise ParameterError(
                f"poses: expected finite numbers, got {'xyθ'[row]} = {x[team, row, robot]}"
                f" of robot {robot} in team {team}"
            )
        return x

    def _apart(self, columns: Floats) -> Floats:
        """Return columns (d, B N) of one large team as arrays (B, d, N)."""
        split = columns.reshape(columns.shape[0], self.teams, -1)
        return np.ascontiguousarray(split.swapaxes(0, 1))


def _side_by_side(arrays: Floats) -> Floats:
    """Return arrays (B, d, N) as the columns (d, B N) of one large team."""
    return np.ascontiguousarray(arrays.swapaxes(0, 1)).reshape(arrays.shape[1], -1)
