"""Runs of many teams under a certificate, many steps a call."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.batch.batch_certificate import BatchCertificate
from barrier_certificates.batch.certify import Answers
from barrier_certificates.batch.compiling import over_teams
from rps_compat.arena_guests import Array
from rps_compat.batch.batch_arena import BatchArena, require_steps
from rps_compat.batch.rollout_kernel import (
    CLEARANCE,
    INTERVENTION,
    VIOLATION,
    Progress,
    Wish,
    roll_teams,
)
from rps_compat.errors import CommandError
from rps_compat.kinematics import projection_point, unicycle_command

__all__ = ["Hold", "Rollout", "RolloutOutcome", "ToGoals", "rollout"]


@dataclass(frozen=True, eq=False)
class Hold:
    """Robots would do the same all the time.

    Attributes
    ----------
    commands : (B, 2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    """

    commands: Array

    def wish(self) -> Wish:
        """Return this for compiled code."""
        return Wish(np.ascontiguousarray(self.commands, dtype=float), 0.0, 0.0)

    def __call__(self, poses: Array, distance: float) -> Array:
        """Return what robots would do.

        Parameters
        ----------
        poses : (B, 3, N) array
            Poses, m and rad.
        distance : float
            How far ahead of the axle projection points lie, m.

        Returns
        -------
        (B, 2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """
        return self.commands


@dataclass(frozen=True, eq=False)
class ToGoals:
    """Projection points would go straight to their goals, slower where these are near.

    Attributes
    ----------
    goals : (B, 2, N) array
        Where to, m.
    gain : float
        Speed for each metre of the way, 1/s.
    speed : float
        How fast at most, m/s.
    """

    goals: Array
    gain: float = 1.0
    speed: float = 0.15

    def wish(self) -> Wish:
        """Return this for compiled code."""
        goals = np.ascontiguousarray(self.goals, dtype=float)
        return Wish(goals, float(self.gain), float(self.speed))

    def __call__(self, poses: Array, distance: float) -> Array:
        """Return what robots would do.

        Parameters
        ----------
        poses : (B, 3, N) array
            Poses, m and rad.
        distance : float
            How far ahead of the axle projection points lie, m.

        Returns
        -------
        (B, 2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """
        stacked = poses.swapaxes(0, 1)
        velocity = self.gain * (self.goals.swapaxes(0, 1) - projection_point(stacked, distance))
        length = np.sqrt((velocity * velocity).sum(axis=0))
        velocity *= np.where(length > self.speed, self.speed / np.maximum(length, self.speed), 1.0)
        return np.ascontiguousarray(unicycle_command(velocity, stacked, distance).swapaxes(0, 1))


@dataclass(frozen=True, eq=False)
class RolloutOutcome:
    """What became of each team in a rollout.

    Attributes
    ----------
    statuses : (B, 4) integer array
        Steps that ended with each status, in the order of `barrier_certificates.batch.STATUSES`.
    violation : (B,) array
        Largest excess over all rows in all steps, m/s.
    intervention : (B,) array
        Farthest that the certificate changed a velocity, m/s.
    clearance : (B,) array
        Least distance from being unsafe, m.
    handed_over : int
        Steps of a team that a single certificate answered.
    """

    statuses: NDArray[np.intp]
    violation: Array
    intervention: Array
    clearance: Array
    handed_over: int


class Rollout:
    """Teams on their way under a certificate, with what a step takes made ready once.

    A call of `rollout` does many steps; who looks at the teams between steps keeps one of these,
    and pays for a step of one team a quarter of what controller, certificate and arena cost in
    turn.

    Parameters
    ----------
    arena : BatchArena
        Where the teams are; it is moved.
    certificate : BatchCertificate
        Who certifies: of unicycles.
    wish : Hold or ToGoals
        What robots would do.

    Raises
    ------
    CommandError
        If what is wished is not for so many teams and robots.

    Examples
    --------
    >>> import numpy as np
    >>> from barrier_certificates.unicycle import UnicycleCertificate
    >>> teams = BatchArena([[[-0.5, 0.5], [0.0, 0.0], [0.0, 3.1]]])
    >>> certificate = BatchCertificate(UnicycleCertificate(0.2, speed_limit=0.15))
    >>> way = Rollout(teams, certificate, ToGoals(-teams.poses[:, :2]))
    >>> while way.outcome.clearance.min() > 0.5:
    ...     way.run()
    >>> teams.steps
    22
    """

    def __init__(
        self, arena: BatchArena, certificate: BatchCertificate, wish: Hold | ToGoals
    ) -> None:
        teams, _, robots = arena.poses.shape
        asked = wish.wish()
        if asked.target.shape != (teams, 2, robots):
            raise CommandError(
                f"the wish is of shape {asked.target.shape}; expected {(teams, 2, robots)}"
            )
        self.arena = arena
        self.certificate = certificate
        self.wish = wish
        self._wished = tuple(asked)
        self._teams = np.arange(teams)
        self._progress = Progress(
            np.zeros(teams, dtype=np.intp),
            np.zeros((teams, 4), dtype=np.intp),
            np.zeros((3, teams)),
        )
        self._progress.extremes[CLEARANCE] = np.inf
        self._steps = 0
        self._handed_over = 0
        alike = arena.compiled and certificate.compiled and arena.realism is None
        self._compiled = alike and not certificate.answers_late

    @property
    def outcome(self) -> RolloutOutcome:
        """What became of each team so far; the arrays are copies."""
        _, statuses, extremes = self._progress
        violation, intervention, clearance = extremes.copy()
        return RolloutOutcome(
            statuses.copy(), violation, intervention, clearance, self._handed_over
        )

    def run(self, steps: int = 1) -> None:
        """Go on.

        Parameters
        ----------
        steps : int
            How many steps, 0 or more.

        Raises
        ------
        CommandError
            If there are fewer than none.
        """
        require_steps(steps)
        self._steps += steps
        if self._compiled:
            self._run_compiled(steps)
        else:
            for _ in range(steps):
                self._step()

    def _step(self) -> None:
        """Do a step of all teams at once."""
        arena, progress = self.arena, self._progress
        extremes, seen = progress.extremes, arena.observe()
        wish = self.wish(seen, self.certificate.distance)
        arena.commands, info = self.certificate(wish, seen)
        arena.step()
        progress.statuses[self._teams, info.status] += 1
        extremes[VIOLATION] = np.fmax(extremes[VIOLATION], info.violation)
        extremes[INTERVENTION] = np.fmax(extremes[INTERVENTION], info.intervention)
        extremes[CLEARANCE] = np.fmin(extremes[CLEARANCE], info.clearance)
        self._handed_over += info.handed_over

    def _run_compiled(self, steps: int) -> None:
        """Go team by team, and let a single certificate answer where the compiled one does not."""
        arena, progress = self.arena, self._progress
        recipe, drive, pattern, answers = self.certificate.prepared(arena.poses)
        arguments = (
            arena.constants, self._wished, tuple(recipe), tuple(drive), tuple(pattern),
            arena.poses, tuple(arena.tally), tuple(answers), tuple(progress), self._steps,
        )  # fmt: skip
        left = self._teams
        while sum(over_teams(roll_teams, left.size, arena.threads, left, *arguments)):
            left = left[progress.done[left] < self._steps]
            for team in left.tolist():
                self._answer_alone(team, answers)
            left = left[progress.done[left] < self._steps]
        arena.rolled(answers.velocity, steps)

    def _answer_alone(self, team: int, answers: Answers) -> None:
        """Do a step of one team by a single certificate."""
        arena, progress = self.arena, self._progress
        status, numbers = self.certificate.answer_alone(team, arena.poses[team], answers)
        progress.statuses[team, status] += 1
        extremes = progress.extremes[:, team]
        extremes[:2] = np.fmax(extremes[:2], numbers[:2])
        extremes[CLEARANCE] = np.fmin(extremes[CLEARANCE], numbers[2])
        arena.step_team(team, answers.velocity)
        progress.done[team] += 1
        self._handed_over += 1


def rollout(
    arena: BatchArena, certificate: BatchCertificate, wish: Hold | ToGoals, steps: int
) -> RolloutOutcome:
    """Let all teams drive for some steps, each command certified.

    Parameters
    ----------
    arena : BatchArena
        Where they are; it is moved.
    certificate : BatchCertificate
        Who certifies: of unicycles.
    wish : Hold or ToGoals
        What robots would do.
    steps : int
        How many steps.

    Raises
    ------
    CommandError
        If what is wished is not for so many teams and robots.
    """
    way = Rollout(arena, certificate, wish)
    way.run(steps)
    return way.outcome
