"""What is attacked in `late_robots`: cells of robots, certificates for them, and their starts."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from late_attacks import ARENA, Array, Attack, discs

from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_robots import LateRobots
from barrier_certificates.unicycle import UnicycleCertificate
from rps_compat.command_effects import DeadTime
from rps_compat.distributions import DistributionKind, RobotDistribution
from rps_compat.late_profiles import late_robots
from rps_compat.motor_effects import Gains, Lag
from rps_compat.profiles import load_profile
from rps_compat.realism import Profile
from rps_compat.tracking_effects import TrackingJitter

STEP = 0.033
RADIUS, WALL, D = 0.185, 0.05, 0.05
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


@dataclass
class Found:
    """What was true of the robots."""

    steps: int = 0
    pairs: float = np.inf
    walls: float = np.inf
    obstacles: float = np.inf
    stopped: int = 0
    broken: int = 0

    def judged(self) -> Found:
        """Return the same of one team with whether the promise was broken.

        A disc goes on where nobody can give way, so that nothing is promised of discs to a team
        that had to stop.
        """
        obstacles = self.obstacles if not self.stopped else np.inf
        return replace(self, broken=int(min(self.pairs, self.walls, obstacles) < 0.0))

    def add(self, other: Found) -> Found:
        """Return both together."""
        return Found(
            self.steps + other.steps,
            min(self.pairs, other.pairs),
            min(self.walls, other.walls),
            min(self.obstacles, other.obstacles),
            self.stopped + other.stopped,
            self.broken + other.broken,
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


@dataclass(frozen=True)
class Prey:
    """A team before it is attacked, the same whoever drives it.

    Parameters
    ----------
    start : (3, N) array
        Poses, m and rad.
    profile : Profile
        What its robots are like, each at one end of every range.
    chance : Generator
        What imperfections are drawn from.
    attack : Attack
        The adversary, who has seen nothing yet.
    """

    start: Array
    profile: Profile
    chance: np.random.Generator
    attack: Attack


def prey(cell: Cell, name: str, number: int, seed: int) -> Prey:
    """Return the team of a seed that is attacked in a way of `ATTACKS`."""
    rng = np.random.default_rng([seed, number])
    late = certificate_of("late", cell)
    assert isinstance(late, LateCertificate)
    crowded = seed % 2 == 1 and not among_discs(name)
    inside = WALL + late.late_margins.wall()
    start = scattered(number, late.guarantee().stops_apart, inside, rng, crowded)
    profile = at_ends(cell.profile, number, rng)
    points = start[:2] + D * np.stack([np.cos(start[2]), np.sin(start[2])])
    return Prey(start, profile, np.random.default_rng([seed, number, 1]), Attack(rng, points))


def among_discs(name: str) -> bool:
    """Return whether an attack of this name takes place among moving discs."""
    return name == "greedy"
