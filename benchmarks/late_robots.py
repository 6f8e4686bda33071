"""Late robots under attack: what the certificate for them keeps, and what others do.

Rows are cells: a profile of robots, or a point of a box of delays, lags, gains and jitter. Each
certificate drives teams of late robots whose true poses the adversary of `late_attacks` sees. What
is told is the smallest true distance of projection points beyond what is promised, and the price:
radius, speed, swaps completed in 60 s. Exits 1 where the late certificate breaks its promise; of
discs it promises nothing to a team that has had to stop, since they go on.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # before NumPy reads it

import numpy as np  # noqa: E402
from late_attacks import ATTACKS, Array, discs  # noqa: E402
from late_cells import (  # noqa: E402
    KINDS,
    OBSTACLE_SPEED,
    RADIUS,
    STEP,
    WALL,
    Cell,
    D,
    Found,
    among_discs,
    cells,
    certificate_of,
    prey,
)
from late_teams import drive_teams  # noqa: E402

from barrier_certificates.late.late_certificate import LateCertificate  # noqa: E402
from barrier_certificates.rows import Disc  # noqa: E402
from rps_compat.arena import Arena  # noqa: E402
from rps_compat.realism import Imperfections  # noqa: E402
from rps_compat.testbed import GTERNAL  # noqa: E402

SIZES = (2, 4, 9)


class Timed(Imperfections):
    """Imperfections that tell how long the last step really took, as a clock on board would.

    Parameters
    ----------
    profile : Profile
        Which effects there are.
    """

    spent = STEP

    def parts(self) -> tuple[float, ...]:
        """Return the seconds of the parts in which the coming step is driven."""
        seconds = super().parts()
        self.spent = sum(seconds)
        return seconds


class Pilot:
    """Drives late robots by a certificate.

    Parameters
    ----------
    kind : str
        Which of `KINDS`.
    cell : Cell
        What the robots are like.
    """

    def __init__(self, kind: str, cell: Cell, tilt: float = 0.0) -> None:
        self.certificate = replace(certificate_of(kind, cell), tilt=tilt)
        predicting = kind in ("predicted", "both")
        self.predictor = self.certificate if isinstance(self.certificate, LateCertificate) else None
        if predicting:
            late = certificate_of("late", cell)
            assert isinstance(late, LateCertificate)
            self.predictor = late
        self.clipped = kind == "published"
        self.limits = np.array([[cell.speed], [cell.turn]])

    def command(
        self, wish: Array, seen: Array, elapsed: float, obstacles: Sequence[Disc]
    ) -> tuple[Array, str]:
        """Return certified commands for wished velocities of projection points, and the status."""
        poses = seen if self.predictor is None else self.predictor.stops(seen, elapsed)
        velocity, info = self.certificate.project(wish, poses, obstacles)
        commands = self.certificate.commands(velocity, poses)
        if self.clipped:
            commands = np.clip(commands, -self.limits, self.limits)
        if self.predictor is not None:
            self.predictor.sent(commands)
        return commands, str(info.status)


def drive(kind: str, cell: Cell, name: str, number: int, steps: int, seed: int) -> Found:
    """Drive one team under one attack."""
    pilot, team = Pilot(kind, cell), prey(cell, name, number, seed)
    realism = Timed(team.profile)
    arena = Arena(team.start, GTERNAL, realism=realism, rng=team.chance)
    found, elapsed = Found(steps), STEP
    first, second = np.triu_indices(number, 1)
    for step in range(steps):
        before = discs(step * STEP, OBSTACLE_SPEED) if among_discs(name) else ()
        heading = np.stack([np.cos(arena.poses[2]), np.sin(arena.poses[2])])
        points = arena.poses[:2] + D * heading
        apart_now = np.hypot(*(points[:, first] - points[:, second])).min()
        found.pairs = min(found.pairs, float(apart_now) - RADIUS)
        gap = min(1.6 - np.abs(points[0]).max(), 1.0 - np.abs(points[1]).max())
        found.walls = min(found.walls, float(gap) - WALL)
        for disc in before:
            off = np.hypot(*(points - np.array(disc.centre)[:, None])).min() - disc.radius
            found.obstacles = min(found.obstacles, float(off) - 0.1)
        wish = ATTACKS[name](points, step, team.attack)
        arena.commands, status = pilot.command(wish, arena.observe(), elapsed, before)
        found.stopped += status in ("failed", "relaxed")
        arena.step()
        elapsed = realism.spent
    return found.judged()


def swaps(kind: str, cell: Cell, seed: int = 0) -> tuple[int, float]:
    """Return how often six robots change places in 60 s, and their mean speed, m/s."""
    rng = np.random.default_rng([seed, 6])
    pilot = Pilot(kind, cell, tilt=0.3)
    angle = 2 * np.pi * np.arange(6) / 6 + 0.02 * rng.normal(size=6)
    points = np.stack([1.2 * np.cos(angle), 0.7 * np.sin(angle)])
    start = np.vstack([points - D * np.stack([np.cos(angle), np.sin(angle)]), angle])
    realism = Timed(cell.profile)
    arena = Arena(start, GTERNAL, realism=realism, rng=np.random.default_rng([seed, 6, 1]))
    goals, done, way_driven = -points, 0, 0.0
    for _ in range(round(60.0 / STEP)):
        heading = np.stack([np.cos(arena.poses[2]), np.sin(arena.poses[2])])
        way = goals - (arena.poses[:2] + D * heading)
        away = np.hypot(way[0], way[1])
        if away.max() < 0.1:
            goals, done = -goals, done + 1
        wish = cell.speed * way / np.maximum(away, 0.5 * cell.speed)
        arena.commands, _ = pilot.command(wish, arena.observe(), realism.spent, ())
        was = arena.poses[:2].copy()
        arena.step()
        way_driven += float(np.hypot(*(arena.poses[:2] - was)).mean())
    return done, way_driven / 60.0


@dataclass(frozen=True)
class Task:
    """One certificate in one cell, against the teams of some seeds.

    Parameters
    ----------
    kind : str
        Which of `KINDS`.
    cell : Cell
        What the robots are like.
    steps : int
        Of each seed, over all attacks and sizes.
    seeds : tuple of int
        Several are driven together, where robots' steps are of one length.
    """

    kind: str
    cell: Cell
    steps: int
    seeds: tuple[int, ...]

    def found(self) -> dict[int, Found]:
        """Return what was true of the teams of each seed."""
        share = self.steps // (len(ATTACKS) * len(SIZES))
        total = {seed: Found() for seed in self.seeds}
        for number in SIZES:
            teams = [(name, seed) for name in ATTACKS for seed in self.seeds]
            if len(self.seeds) > 1 and self.cell.profile.clock is None:
                found = drive_teams(self.kind, self.cell, teams, number, share)
            else:
                found = [drive(self.kind, self.cell, n, number, share, s) for n, s in teams]
            for (_, seed), one in zip(teams, found, strict=True):
                total[seed] = total[seed].add(one)
        return total


def measured(task: Task) -> list[dict[str, float | str]]:
    """Return what was found of one certificate in one cell: a row of the table for each seed."""
    began = time.process_time()
    late = certificate_of("late", task.cell)
    assert isinstance(late, LateCertificate)
    rows: list[dict[str, float | str]] = []
    for seed, total in task.found().items():
        done, speed = swaps(task.kind, task.cell) if seed == 0 else (0, 0.0)  # the price, once
        rows.append(
            {
                "cell": task.cell.name,
                "kind": task.kind,
                "seed": seed,
                "steps": total.steps,
                "pairs": total.pairs,
                "walls": total.walls,
                "obstacles": total.obstacles,
                "stopped": total.stopped,
                "broken": total.broken,
                "margin": late.late_margins.pair(RADIUS),
                "swaps": done,
                "speed": speed,
            }
        )
    spent = (time.process_time() - began) / len(rows)
    return [row | {"cpu": spent} for row in rows]


def line(row: dict[str, float | str]) -> str:
    """Return a row as text."""
    mm = {
        name: 1e3 * float(row[name]) for name in ("pairs", "walls", "obstacles", "margin", "speed")
    }
    return (
        f"{row['cell']:<30}{row['kind']:<10}{row['steps']:>8}{mm['pairs']:>+9.1f}"
        f"{mm['walls']:>+8.1f}{mm['obstacles']:>+8.1f}{row['stopped']:>8}{mm['margin']:>8.0f}"
        f"{row['swaps']:>7}{mm['speed']:>7.0f}"
    )


def main() -> int:
    """Drive, print, return 1 where the promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=9_000, help="of each cell and certificate")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS[:1]))
    parser.add_argument("--cells", nargs="+", default=[], help="names begin like one of these")
    parser.add_argument("--seed", type=int, default=0, help="the first")
    parser.add_argument("--seeds", type=int, default=1, help="how many, driven together")
    parser.add_argument("--json", help="a file that rows are added to, a line each")
    options = parser.parse_args()
    wanted = tuple(options.cells) or ("",)
    seeds = tuple(range(options.seed, options.seed + options.seeds))
    tasks = [
        Task(kind, cell, options.steps, seeds)
        for cell in cells()
        if cell.name.startswith(wanted)
        for kind in options.kinds
    ]
    print(
        f"{'least beyond what is promised, mm':<40}{'steps':>8}{'pairs':>9}{'walls':>8}{'discs':>8}"
        f"{'stopped':>8}{'margin':>8}{'swaps':>7}{'mm/s':>7}"
    )
    broken = 0
    with ProcessPoolExecutor(2) as pool:
        for row in chain.from_iterable(pool.map(measured, tasks)):
            print(line(row), flush=True)
            if options.json:
                with open(options.json, "a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
            broken += int(row["broken"]) if row["kind"] == "late" else 0
    print("kept" if not broken else f"BROKEN to {broken} teams")
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
