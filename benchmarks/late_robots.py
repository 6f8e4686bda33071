"""Late robots under attack: what the certificate for them keeps, and what others do.

Rows are cells: a profile of robots, or a point of a box of delays, lags, gains and jitter. Each
certificate drives teams of late robots whose true poses the adversary of `late_attacks` sees. What
is told is the smallest true distance of projection points beyond what is promised, and the price:
radius, speed, swaps completed in 60 s. Exits 1 where the late certificate breaks its promise.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from typing import Any

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # before NumPy reads it

import numpy as np  # noqa: E402
from late_attacks import ARENA, ATTACKS, Array, Attack, discs  # noqa: E402

from barrier_certificates.late.late_certificate import LateCertificate  # noqa: E402
from barrier_certificates.late.late_robots import LateRobots  # noqa: E402
from barrier_certificates.rows import Disc  # noqa: E402
from barrier_certificates.unicycle import UnicycleCertificate  # noqa: E402
from rps_compat.arena import Arena  # noqa: E402
from rps_compat.command_effects import DeadTime  # noqa: E402
from rps_compat.distributions import DistributionKind, RobotDistribution  # noqa: E402
from rps_compat.late_profiles import late_robots  # noqa: E402
from rps_compat.motor_effects import Gains, Lag  # noqa: E402
from rps_compat.profiles import load_profile  # noqa: E402
from rps_compat.realism import Imperfections, Profile  # noqa: E402
from rps_compat.testbed import GTERNAL  # noqa: E402
from rps_compat.tracking_effects import TrackingJitter  # noqa: E402

STEP = 0.033
RADIUS, WALL, D = 0.185, 0.05, 0.05
SIZES = (2, 4, 9)
OBSTACLE_SPEED = 0.02
KINDS = ("late", "today", "predicted", "disturbed", "both", "published")


@dataclass(frozen=True)
class Cell:
    """Robots and their limits.

    Parameters
    ----------
    name : str
        What the table calls it.
    profile : Profile
        What the robots are like.
    speed, turn : float
        Limits of commands, m/s and rad/s.
    """

    name: str
    profile: Profile
    speed: float = 0.15
    turn: float = 0.55

    def robots(self) -> LateRobots:
        """Return what the certificate is told of them."""
        return late_robots(self.profile, speed_limit=self.speed, turn_rate_limit=self.turn)


def between(low: float, high: float) -> RobotDistribution:
    """Return a number a robot, anywhere in a range."""
    return RobotDistribution(DistributionKind.UNIFORM, (low, high))


def boxed(dead: float, lag: float, gain: float, jitter: float) -> Cell:
    """Return a corner of the box: dead time and lag known to 5 %, gains to a part, jitter in m."""
    profile = Profile(
        name="box",
        dead_time=DeadTime(between(0.95 * dead, 1.05 * dead)) if dead else None,
        lag=Lag(between(0.95 * lag, 1.05 * lag)) if lag else None,
        gains=Gains(between(1 - gain, 1 + gain), between(1 - gain, 1 + gain)) if gain else None,
        tracking_jitter=TrackingJitter(jitter, jitter, 2.0 * jitter) if jitter else None,
    )
    name = f"τ {dead:g} T {lag:g} ±{100 * gain:g} % σ {1e3 * jitter:g} mm"
    return Cell(name, profile)


def at_ends(profile: Profile, number: int, rng: np.random.Generator) -> Profile:
    """Return a profile in which each robot is at one end of every range, drawn by chance."""

    def ends(effect: Any) -> Any:
        changes = {}
        for entry in fields(effect):
            value = getattr(effect, entry.name)
            if getattr(value, "kind", None) is DistributionKind.UNIFORM:
                drawn = tuple(rng.choice(value.values, number).tolist())
                changes[entry.name] = RobotDistribution(DistributionKind.ROBOTS, drawn)
        return replace(effect, **changes)

    effects = {name: ends(getattr(profile, name)) for name in profile.effects}
    return replace(profile, **effects)


def cells() -> list[Cell]:
    """Return all cells of the table."""
    named = [Cell(name, load_profile(name)) for name in ("gritsbot_x", "gternal")]
    named.append(Cell("gritsbot_x, 0.10 m/s", load_profile("gritsbot_x"), 0.10))
    box = [
        boxed(dead, lag, gain, jitter)
        for dead in (0.0, 0.2, 0.4)
        for lag in (0.0, 0.12, 0.2)
        for gain, jitter in ((0.0, 0.0), (0.1, 0.001))
        if gain or (dead, lag) in ((0.0, 0.0), (0.2, 0.12), (0.4, 0.2))
    ]
    return [*named, *box]


def certificate_of(kind: str, cell: Cell) -> UnicycleCertificate:
    """Return one of the certificates that are compared."""
    plain = UnicycleCertificate(
        RADIUS,
        2000.0,
        boundary=ARENA,
        wall_margin=WALL,
        obstacle_margin=0.1,
        speed_limit=cell.speed,
        turn_rate_limit=cell.turn,
        time_step=STEP,
        projection_distance=D,
        wall_gain=200.0,
    )
    if kind == "published":
        return replace(
            plain, barrier_gain=100.0, wall_gain=100.0, turn_rate_limit=None, time_step=0.0
        )
    if kind in ("disturbed", "both"):
        return replace(plain, wheel_disturbance=0.05 * 12.5)
    if kind != "late":
        return plain
    robots = cell.robots()
    gain = 190.0 if robots.longest_step else 2e4
    return LateCertificate.of(
        plain, robots, barrier_gain=gain, wall_gain=gain / 10, obstacle_speed=OBSTACLE_SPEED
    )


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


@dataclass
class Found:
    """What was true of the robots."""

    steps: int = 0
    pairs: float = np.inf
    walls: float = np.inf
    obstacles: float = np.inf
    stopped: int = 0

    def add(self, other: Found) -> Found:
        """Return both together."""
        return Found(
            self.steps + other.steps,
            min(self.pairs, other.pairs),
            min(self.walls, other.walls),
            min(self.obstacles, other.obstacles),
            self.stopped + other.stopped,
        )


def scattered(
    number: int, apart: float, inside: float, rng: np.random.Generator, crowded: bool
) -> Array:
    """Return random poses whose projection points are so far apart, and from walls and discs.

    A crowd stands in the middle, as close as chance finds places quickly, and no disc is there.
    """
    while True:
        heading = rng.uniform(-np.pi, np.pi, number)
        points = np.zeros((2, 0))
        size = np.array([[1.6], [1.0]]) - inside - 0.01
        if crowded:
            size = np.minimum(size, 0.8 * (apart + 0.01) * np.sqrt(number))
        for _ in range(3000):
            point = rng.uniform(-1, 1, (2, 1)) * size
            clear = crowded or all(
                np.hypot(*(point[:, 0] - np.array(d.centre))) > d.radius + 0.1 + inside + apart / 2
                for d in discs(0.0, OBSTACLE_SPEED)
            )
            if clear and (not points.shape[1] or np.hypot(*(points - point)).min() > apart + 0.01):
                points = np.hstack([points, point])
                if points.shape[1] == number:
                    return np.vstack(
                        [points - D * np.stack([np.cos(heading), np.sin(heading)]), heading]
                    )


def drive(kind: str, cell: Cell, name: str, number: int, steps: int, seed: int) -> Found:
    """Drive one team under one attack."""
    rng = np.random.default_rng([seed, number])
    pilot = Pilot(kind, cell)
    late = certificate_of("late", cell)
    assert isinstance(late, LateCertificate)
    apart = late.guarantee().stops_apart
    with_discs = name == "greedy"
    crowded = seed % 2 == 1 and not with_discs
    start = scattered(number, apart, WALL + late.late_margins.wall(), rng, crowded)
    realism = Timed(at_ends(cell.profile, number, rng))
    arena = Arena(start, GTERNAL, realism=realism, rng=np.random.default_rng([seed, number, 1]))
    attack = Attack(rng, start[:2] + D * np.stack([np.cos(start[2]), np.sin(start[2])]))
    found, elapsed = Found(steps), STEP
    first, second = np.triu_indices(number, 1)
    for step in range(steps):
        before = discs(step * STEP, OBSTACLE_SPEED) if with_discs else ()
        heading = np.stack([np.cos(arena.poses[2]), np.sin(arena.poses[2])])
        points = arena.poses[:2] + D * heading
        apart_now = np.hypot(*(points[:, first] - points[:, second])).min()
        found.pairs = min(found.pairs, float(apart_now) - RADIUS)
        gap = min(1.6 - np.abs(points[0]).max(), 1.0 - np.abs(points[1]).max())
        found.walls = min(found.walls, float(gap) - WALL)
        for disc in before:
            off = np.hypot(*(points - np.array(disc.centre)[:, None])).min() - disc.radius
            found.obstacles = min(found.obstacles, float(off) - 0.1)
        wish = ATTACKS[name](points, step, attack)
        arena.commands, status = pilot.command(wish, arena.observe(), elapsed, before)
        found.stopped += status in ("failed", "relaxed")
        arena.step()
        elapsed = realism.spent
    return found


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


def measured(task: tuple[str, Cell, int, int]) -> dict[str, float | str]:
    """Return what was found of one certificate in one cell: a row of the table."""
    kind, cell, steps, seed = task
    began = time.process_time()
    late = certificate_of("late", cell)
    assert isinstance(late, LateCertificate)
    share, total = steps // (len(ATTACKS) * len(SIZES)), Found()
    for name in ATTACKS:
        for number in SIZES:
            total = total.add(drive(kind, cell, name, number, share, seed))
    done, speed = swaps(kind, cell) if seed == 0 else (0, 0.0)  # the price, once
    return {
        "cell": cell.name,
        "kind": kind,
        "seed": seed,
        "steps": total.steps,
        "pairs": total.pairs,
        "walls": total.walls,
        "obstacles": total.obstacles,
        "stopped": total.stopped,
        "margin": late.late_margins.pair(RADIUS),
        "swaps": done,
        "speed": speed,
        "cpu": time.process_time() - began,
    }


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
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", help="a file that rows are added to, a line each")
    options = parser.parse_args()
    wanted = tuple(options.cells) or ("",)
    tasks = [
        (kind, cell, options.steps, options.seed)
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
        for row in pool.map(measured, tasks):
            print(line(row), flush=True)
            if options.json:
                with open(options.json, "a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
            least = min(float(row[name]) for name in ("pairs", "walls", "obstacles"))
            broken += row["kind"] == "late" and least < 0.0
    print("kept" if not broken else f"BROKEN in {broken} cells")
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
