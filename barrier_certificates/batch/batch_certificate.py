"""One certificate for many teams at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from barrier_certificates import checks
from barrier_certificates.array_types import BoolArray, FloatArray
from barrier_certificates.batch.batch_info import BatchInfo, numbers_of
from barrier_certificates.batch.certify import UNANSWERED, Answers, DriveModel, certify_teams
from barrier_certificates.batch.compiling import Engine, is_compiled, over_teams
from barrier_certificates.batch.layout import Recipe, TeamRows, recipe_of, rows_of
from barrier_certificates.certificate import Certificate, RowFamilies
from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.stop_prediction import StopPrediction
from barrier_certificates.projection import ProjectionInfo
from barrier_certificates.rows import Obstacle, ObstacleRows
from barrier_certificates.rows.obstacles import listed, moved
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

__all__ = ["BatchCertificate"]

_NO_ROWS = RowFamilies(None, None, ObstacleRows((), 0.0, 0.0), None)

_One = Callable[[Certificate, FloatArray, FloatArray, Any], tuple[FloatArray, ProjectionInfo]]


class BatchCertificate:
    """The answers of one certificate for B teams of N robots, as arrays.

    Each team is answered as it would be alone: the optimum of its program, all rows checked. With
    numba one compiled loop goes over the teams. What it does not solve it hands to a single
    certificate: states without a safe velocity, points that coincide, numbers out of all measure.
    Without numba, a single certificate a team does it all.

    Parameters
    ----------
    certificate : SingleIntegratorCertificate, UnicycleCertificate or LateCertificate
        What is kept apart, and how firmly.
    engine : {"auto", "numba", "numpy"}
        Who computes; ``"auto"`` is compiled where numba is installed and the certificate has
        neither a solver of its own nor an eye on deadlocks or links, is not decentralised, and has
        no numbers of single robots.
    threads : int, optional
        How many parts of the teams are computed side by side at most; one for each processor if
        None.

    Attributes
    ----------
    distance : float or (N,) array
        How far ahead of the axle the projection points lie, m; 0 for robots without headings.

    Raises
    ------
    ParameterError
        If there is no such engine, or it cannot do what the certificate asks for.
    EngineNotInstalledError
        If numba is asked for but not installed.

    Examples
    --------
    >>> import numpy as np
    >>> from barrier_certificates.unicycle import UnicycleCertificate
    >>> certificate = UnicycleCertificate(safety_radius=0.27, speed_limit=0.15)
    >>> batch = BatchCertificate(certificate, engine="numpy")  # "auto" is compiled with numba
    >>> apart = np.array([[-0.4, 0.4], [0.0, 0.0], [0.0, np.pi]])
    >>> near = np.array([[-0.2, 0.2], [0.0, 0.0], [0.0, np.pi]])  # face to face
    >>> commands, info = batch(np.full((2, 2, 2), [[0.15], [0.0]]), np.stack([apart, near]))
    >>> [str(status) for status in info.statuses()]
    ['trivial', 'optimal']
    """

    def __init__(
        self, certificate: Certificate, *, engine: Engine = "auto", threads: int | None = None
    ) -> None:
        self.certificate = certificate
        self.threads = threads
        self.compiled = is_compiled(engine) and _can_be_compiled(certificate, engine)
        self._alone = replace(certificate)
        self._late = certificate if isinstance(certificate, LateCertificate) else None
        unicycles = isinstance(certificate, UnicycleCertificate)
        self.distance = getattr(certificate, "look_ahead", 0.0)
        step = getattr(certificate, "time_step", 0.0)
        # Compiled code knows one number for all robots, and is not asked where there are others.
        equal = certificate.team_size is None
        distance = self.distance if equal else 0.0
        self._drive = DriveModel(distance, step, unicycles)
        families = self._alone.row_families() if equal else _NO_ROWS
        self._recipe = recipe_of(*families, cautious=self._late is not None)
        self._teams = (0, 0)
        self._lay_out()
        self.reset()

    def reset(self) -> None:
        """Forget the steps so far, of all teams: which rows bound, what was sent."""
        self._each: list[Certificate] = []
        self._prediction = None
        if self._late is not None:
            self._prediction = StopPrediction(self._late.robots, self._late.time_step)
        self._answers.bound.fill(0)
        self._fresh: BoolArray = np.ones(self._teams[0], dtype=bool)
        self._all_met = False

    def __call__(
        self, desired: Any, states: Any, obstacles: Sequence[Obstacle] | None = None
    ) -> tuple[FloatArray, BatchInfo]:
        """Return the safe commands nearest to the desired ones.

        Parameters
        ----------
        desired : (B, 2, N) array
            Velocities, m/s, or unicycle commands, m/s and rad/s.
        states : (B, 2, N) or (B, 3, N) array
            Positions, m, or poses, m and rad; of late robots as tracked.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, alike for all teams, instead of those of the certificate.

        Returns
        -------
        commands : (B, 2, N) array
            Safe velocities, or commands, which count as sent.
        info : BatchInfo
            What was done.

        Raises
        ------
        ShapeError
            If the shapes do not fit.
        InfeasibleError, NotFiniteError
            Under the policy ``"raise"``.
        """
        desired, states = self._checked(desired, states)
        if self._late is None or not self.compiled:
            one = _call_late if self._late is not None else _call
            return self._answer(desired, states, obstacles, self._drive, one)
        commands, info = self._answer(desired, self.stops(states), obstacles, self._drive, _call)
        self.sent(commands)
        return commands, info

    def project(
        self, desired: Any, poses: Any, obstacles: Sequence[Obstacle] | None = None
    ) -> tuple[FloatArray, BatchInfo]:
        """Return the safe velocities of projection points nearest to the desired ones.

        Parameters
        ----------
        desired : (B, 2, N) array
            Velocities of the projection points, m/s.
        poses : (B, 3, N) array
            Poses of the robots, m and rad; of late ones those at rest, see `stops`.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, alike for all teams, instead of those of the certificate.

        Returns
        -------
        velocity : (B, 2, N) array
            Safe velocities of the projection points, m/s.
        info : BatchInfo
            What was done.

        Raises
        ------
        ShapeError
            If the shapes do not fit.
        InfeasibleError, NotFiniteError
            Under the policy ``"raise"``.
        """
        desired, poses = self._checked(desired, poses)
        drive = self._drive._replace(commands=False)
        return self._answer(desired, poses, obstacles, drive, _project)

    def stops(self, poses: FloatArray, elapsed: float | None = None) -> FloatArray:
        """Return the poses that the certificate is about: where late robots would come to rest.

        Parameters
        ----------
        poses : (B, 3, N) array
            Poses as tracked, m and rad.
        elapsed : float, optional
            Time since the last commands were sent, s; the time step if None.

        Returns
        -------
        (B, 3, N) array
            Poses, m and rad; the same for robots that obey at once.
        """
        if self._prediction is None:
            return poses
        if elapsed is not None:
            checks.positive("elapsed", elapsed, "of seconds")
            self._prediction.elapsed(elapsed)
        return _apart(self._prediction.stops(_together(poses)), poses.shape[0])

    def sent(self, commands: FloatArray) -> None:
        """Take note of the commands that robots are sent.

        Parameters
        ----------
        commands : (B, 2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """
        if self._prediction is not None:
            self._prediction.sent(_together(commands))

    @property
    def answers_late(self) -> bool:
        """Whether robots are late, so that commands are remembered from step to step."""
        return self._late is not None

    def prepared(self, poses: FloatArray) -> tuple[Recipe, DriveModel, TeamRows, Answers]:
        """Return what compiled rollouts take; the answers are those of this certificate.

        Parameters
        ----------
        poses : (B, 3, N) array
            Poses of the robots, m and rad.
        """
        self._meet(poses.shape[0], poses.shape[2])
        return self._placed(None), self._drive, self._pattern, self._answers

    def answer_alone(
        self, team: int, poses: FloatArray, answers: Answers
    ) -> tuple[int, FloatArray]:
        """Let a single certificate answer for a team.

        Parameters
        ----------
        team : int
            Which team.
        poses : (3, N) array
            Its poses, m and rad.
        answers : Answers
            Its velocities are the desired commands, and become the safe ones.

        Returns
        -------
        status : int
            A key of `STATUSES`.
        numbers : (4,) array
            Violation and intervention, m/s; clearance, m; smallest h.
        """
        self._alone.reset()
        answers.velocity[team], info = _call(
            self._alone, answers.velocity[team].copy(), poses, None
        )
        return numbers_of(info)

    def _checked(self, desired: Any, states: Any) -> tuple[FloatArray, FloatArray]:
        first = np.ascontiguousarray(desired, dtype=float)
        second = np.ascontiguousarray(states, dtype=float)
        rows = 2 if isinstance(self.certificate, SingleIntegratorCertificate) else 3
        teams, robots = (first.shape[0], first.shape[-1]) if first.ndim == 3 else (0, 0)
        if first.shape != (teams, 2, robots) or second.shape != (teams, rows, robots) or not robots:
            raise ShapeError(
                f"commands have shape {first.shape} and states {second.shape}; expected (B, 2, N)"
                f" and (B, {rows}, N), for B teams of N robots"
            )
        self._meet(teams, robots)
        return first, second

    def _meet(self, teams: int, robots: int) -> None:
        """Begin anew where there are other teams than before."""
        if (teams, robots) != self._teams:
            self._teams = (teams, robots)
            self._lay_out()
            self.reset()

    def _lay_out(self) -> None:
        """Make room for the rows and the answers of all teams."""
        teams, robots = self._teams
        most = 2 * robots + 1
        self._pattern = rows_of(self._recipe, robots)
        self._answers = Answers(
            np.zeros((teams, 2, robots)),
            np.zeros(teams, dtype=np.intp),
            np.zeros((4, teams)),
            np.zeros((teams, most), dtype=np.intp),
            np.zeros(teams, dtype=np.intp),
        )

    def _answer(
        self,
        desired: FloatArray,
        states: FloatArray,
        obstacles: Sequence[Obstacle] | None,
        drive: DriveModel,
        one: _One,
    ) -> tuple[FloatArray, BatchInfo]:
        teams = desired.shape[0]
        velocity, status, numbers = (
            np.empty(desired.shape),
            np.empty(teams, np.intp),
            np.empty((4, teams)),
        )
        status[:] = UNANSWERED
        unanswered = teams
        if self.compiled:
            recipe = self._placed(obstacles)
            written = (velocity, status, numbers, self._answers.binding, self._answers.bound)
            program = (tuple(recipe), tuple(drive), tuple(self._pattern))
            arguments = (*program, desired, states, written)
            unanswered = sum(over_teams(certify_teams, teams, self.threads, *arguments))
        elif not self._each:
            self._each = [replace(self.certificate) for _ in range(teams)]
        left = np.flatnonzero(status == UNANSWERED).tolist() if unanswered else []
        for team in left:
            alone = self._each[team] if self._each else self._alone
            if not self._each:
                alone.reset()
            velocity[team], info = one(alone, desired[team], states[team], obstacles)
            status[team], numbers[:, team] = numbers_of(info)
        unsafe = self._unsafe_starts(numbers[2])
        return velocity, BatchInfo(
            status, numbers[0], numbers[1], numbers[2], numbers[3], unsafe, len(left)
        )

    def _unsafe_starts(self, clearance: FloatArray) -> BoolArray:
        """Return which teams were met for the first time, and unsafe already."""
        if self._all_met:
            return np.zeros(clearance.shape, dtype=bool)
        unsafe = self._fresh & (clearance < 0.0)
        self._fresh &= np.isnan(clearance)
        self._all_met = not self._fresh.any()
        return unsafe

    def _placed(self, obstacles: Sequence[Obstacle] | None) -> Recipe:
        """Return what rows are made from, with obstacles where they are now."""
        now = self.certificate.obstacles if obstacles is None else listed(obstacles)
        if not now and not self._recipe.obstacles.shape[1]:
            return self._recipe
        if self._late is not None:
            now = moved(now, self._late.late_margins.delay)
        rows = self._alone.row_families().obstacles
        rows.move(now)
        table, before = rows.table(), self._recipe.obstacles.shape[1]
        self._recipe = self._recipe._replace(obstacles=np.ascontiguousarray(table))
        if table.shape[1] != before:
            self._alone = replace(self.certificate)
            self._lay_out()
        return self._recipe


def _can_be_compiled(certificate: Certificate, engine: Engine) -> bool:
    """Whether compiled code does all that a certificate asks for; refuse it if it was asked for."""
    single = certificate.solver == "auto" and certificate.deadlock is None and not certificate.tilt
    single = single and not certificate.decentralised and certificate.connectivity is None
    single = single and certificate.team_size is None
    known = (SingleIntegratorCertificate, UnicycleCertificate)
    if single and certificate.checked and isinstance(certificate, known):
        return True
    if engine == "numba":
        raise ParameterError(
            f"engine is 'numba' for {certificate!r}; expected a checked certificate with solver"
            " 'auto', for the whole team, without deadlock, tilt and connectivity, and one number"
            " for all robots in place of one for each; engine 'auto' or 'numpy' takes any"
        )
    return False


def _together(arrays: FloatArray) -> FloatArray:
    """Return arrays (B, d, N) as those (d, B N) of one large team."""
    return np.ascontiguousarray(arrays.swapaxes(0, 1)).reshape(arrays.shape[1], -1)


def _apart(array: FloatArray, teams: int) -> FloatArray:
    """Return the array (d, B N) of one large team as those (B, d, N) of many."""
    return np.ascontiguousarray(array.reshape(array.shape[0], teams, -1).swapaxes(0, 1))


def _call(
    certificate: Certificate, desired: FloatArray, states: FloatArray, obstacles: Any
) -> tuple[FloatArray, ProjectionInfo]:
    if isinstance(certificate, UnicycleCertificate):
        # Not that of late robots: their states are those at rest already.
        return UnicycleCertificate.__call__(certificate, desired, states, obstacles)
    assert isinstance(certificate, SingleIntegratorCertificate)
    return certificate(desired, states, obstacles)


def _call_late(
    certificate: Certificate, desired: FloatArray, states: FloatArray, obstacles: Any
) -> tuple[FloatArray, ProjectionInfo]:
    assert isinstance(certificate, LateCertificate)
    return certificate(desired, states, obstacles)


def _project(
    certificate: Certificate, desired: FloatArray, states: FloatArray, obstacles: Any
) -> tuple[FloatArray, ProjectionInfo]:
    assert isinstance(certificate, UnicycleCertificate)
    return certificate.project(desired, states, obstacles)
