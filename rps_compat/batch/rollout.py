"""Runs of many teams under a certificate, many steps a call."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.batch.batch_certificate import BatchCertificate
from barrier_certificates.batch.compiling import over_teams
from rps_compat.arena_guests import Array
from rps_compat.batch.batch_arena import BatchArena
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

__all__ = ["Hold", "RolloutOutcome", "ToGoals", "rollout"]


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
    shape = (arena.poses.shape[0], 2, arena.poses.shape[2])
    if wish.wish().target.shape != shape:
        raise CommandError(f"the wish is of shape {wish.wish().target.shape}; expected {shape}")
    teams = shape[0]
    progress = Progress(
        np.zeros(teams, dtype=np.intp), np.zeros((teams, 4), dtype=np.intp), np.zeros((3, teams))
    )
    progress.extremes[CLEARANCE] = np.inf
    alike = arena.compiled and certificate.compiled and arena.realism is None
    roll = _roll_compiled if alike and not certificate.answers_late else _roll
    handed_over = roll(arena, certificate, wish, steps, progress)
    extremes = progress.extremes
    return RolloutOutcome(
        progress.statuses,
        extremes[VIOLATION],
        extremes[INTERVENTION],
        extremes[CLEARANCE],
        handed_over,
    )


def _roll(
    arena: BatchArena,
    certificate: BatchCertificate,
    wish: Hold | ToGoals,
    steps: int,
    progress: Progress,
) -> int:
    """Go step by step, all teams at once."""
    distance, teams, handed_over = certificate.distance, np.arange(arena.poses.shape[0]), 0
    extremes = progress.extremes
    for _ in range(steps):
        seen = arena.observe()
        arena.commands, info = certificate(wish(seen, distance), seen)
        arena.step()
        progress.statuses[teams, info.status] += 1
        extremes[VIOLATION] = np.fmax(extremes[VIOLATION], info.violation)
        extremes[INTERVENTION] = np.fmax(extremes[INTERVENTION], info.intervention)
        extremes[CLEARANCE] = np.fmin(extremes[CLEARANCE], info.clearance)
        handed_over += info.handed_over
    return handed_over


def _roll_compiled(
    arena: BatchArena,
    certificate: BatchCertificate,
    wish: Hold | ToGoals,
    steps: int,
    progress: Progress,
) -> int:
    """Go team by team, and let a single certificate answer where the compiled one does not."""
    recipe, drive, pattern, answers = certificate.prepared(arena.poses)
    asked, handed_over = wish.wish(), 0
    left = np.arange(arena.poses.shape[0])
    while left.size:
        over_teams(
            roll_teams, left.size, arena.threads, left, arena.constants, asked, recipe, drive,
            pattern, arena.poses, arena.tally, answers, progress, steps,
        )  # fmt: skip
        left = left[progress.done[left] < steps]
        for team in left.tolist():
            handed_over += 1
            status, numbers = certificate.answer_alone(team, arena.poses[team], answers)
            progress.statuses[team, status] += 1
            extremes = progress.extremes[:, team]
            extremes[:2] = np.fmax(extremes[:2], numbers[:2])
            extremes[CLEARANCE] = np.fmin(extremes[CLEARANCE], numbers[2])
            arena.step_team(team, answers.velocity)
            progress.done[team] += 1
        left = left[progress.done[left] < steps]
    arena.rolled(answers.velocity, steps)
    return handed_over
