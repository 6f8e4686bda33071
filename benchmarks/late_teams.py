"""Many teams of late robots under attack at once: what `late_robots.drive` does to one, in arrays.

Arena, prediction and certificate take all teams in one call; the adversary of each goes on by
itself. The certificate is compiled where numba is installed. Robots whose steps differ in length
from team to team have no common time, and are not driven so.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from late_attacks import ATTACKS, Array, discs
from late_cells import (
    OBSTACLE_SPEED,
    RADIUS,
    STEP,
    WALL,
    Cell,
    D,
    Found,
    among_discs,
    certificate_of,
    prey,
)

from barrier_certificates.batch import STATUSES, BatchCertificate
from barrier_certificates.rows import Disc
from rps_compat.batch import BatchArena
from rps_compat.batch.batch_effects import apart, together
from rps_compat.testbed import GTERNAL

STOPPED = [code for code, status in STATUSES.items() if status in ("failed", "relaxed")]


class Pilots:
    """Drive teams of late robots by a certificate, see `late_robots.Pilot`.

    Parameters
    ----------
    kind : str
        Which of `KINDS`.
    cell : Cell
        What the robots are like.
    """

    def __init__(self, kind: str, cell: Cell) -> None:
        self.one = certificate_of(kind, cell)
        self.certificate = BatchCertificate(self.one, threads=1)
        self.predictor = self.certificate
        if kind in ("predicted", "both"):
            self.predictor = BatchCertificate(certificate_of("late", cell), threads=1)
        self.clipped = kind == "published"
        self.limits = np.array([[cell.speed], [cell.turn]])

    def command(self, wish: Array, seen: Array, obstacles: Sequence[Disc]) -> tuple[Array, Array]:
        """Return certified commands (B, 2, N) for wished velocities, and who was stopped (B,)."""
        poses = self.predictor.stops(seen, STEP)
        velocity, info = self.certificate.project(wish, poses, obstacles)
        commands = apart(self.one.commands(together(velocity), together(poses)), len(poses))
        if self.clipped:
            commands = np.clip(commands, -self.limits, self.limits)
        self.predictor.sent(commands)
        return commands, np.isin(info.status, STOPPED)


def drive_teams(
    kind: str, cell: Cell, teams: Sequence[tuple[str, int]], number: int, steps: int
) -> list[Found]:
    """Drive teams of one size, each under an attack and from a seed of its own."""
    found: dict[tuple[str, int], Found] = {}
    for discs_are_there in (True, False):
        alike = [team for team in teams if among_discs(team[0]) is discs_are_there]
        if alike:
            driven = _drive(kind, cell, alike, number, steps, discs_are_there)
            found |= dict(zip(alike, driven, strict=True))
    return [found[team] for team in teams]


def _drive(
    kind: str,
    cell: Cell,
    teams: Sequence[tuple[str, int]],
    number: int,
    steps: int,
    discs_are_there: bool,
) -> list[Found]:
    pilots, preys = Pilots(kind, cell), [prey(cell, name, number, seed) for name, seed in teams]
    arena = BatchArena(
        [one.start for one in preys],
        GTERNAL,
        realism=[one.profile for one in preys],
        seeds=[one.chance for one in preys],
        threads=1,
    )
    least, stopped = np.full((3, len(teams)), np.inf), np.zeros(len(teams), dtype=int)
    for step in range(steps):
        obstacles = discs(step * STEP, OBSTACLE_SPEED) if discs_are_there else ()
        heading = arena.poses[:, 2]
        points = arena.poses[:, :2] + D * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        np.minimum(least, _beyond(points, obstacles), out=least)
        wish = np.stack(
            [
                ATTACKS[name](place, step, one.attack)
                for (name, _), one, place in zip(teams, preys, points, strict=True)
            ]
        )
        arena.commands, waited = pilots.command(wish, arena.observe(), obstacles)
        stopped += waited
        arena.step()
    return [
        Found(steps, *map(float, least[:, team]), int(stopped[team])).judged()
        for team in range(len(teams))
    ]


def _beyond(points: Array, obstacles: Sequence[Disc]) -> Array:
    """Return how far points (B, 2, N) are beyond what is kept of pairs, walls, discs, (3, B), m."""
    first, second = np.triu_indices(points.shape[2], 1)
    pairs = _lengths(points[:, :, first] - points[:, :, second]).min(axis=1) - RADIUS
    x, y = np.abs(points).max(axis=2).T
    walls = np.minimum(1.6 - x, 1.0 - y) - WALL
    off = np.full(len(points), np.inf)
    for disc in obstacles:
        way = points - np.array(disc.centre)[:, None]
        off = np.minimum(off, _lengths(way).min(axis=1) - disc.radius - 0.1)
    return np.stack([pairs, walls, off])


def _lengths(vectors: Array) -> Array:
    """Return the lengths of vectors (B, 2, ...)."""
    return np.hypot(vectors[:, 0], vectors[:, 1])
