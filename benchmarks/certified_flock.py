"""The nine-robot experiment over a hundred seeds: what the law does, and what the certificate adds.

Each seed is 120 s, in the ideal arena and under ``gritsbot_x`` after an arrival within 5 cm and
0.2 rad. Beside it stands its control: the same run without pair rows, which shows what the law does
on its own. All figures are of true poses, those of alignment for t > 20 s; clearances are what
remains beyond the radius and the margin that the certificate keeps. Exits 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np
from comparing import Table
from nine_robots import DURATION, start_of

from barrier_certificates.late.late_certificate import LateCertificate
from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.options import TRANSIENT
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.flocking.pose_log import INTERVENED
from rps_compat.arena import Arena, Array
from rps_compat.initial import near
from rps_compat.late_profiles import late_certificate
from rps_compat.profiles import load_profile
from rps_compat.testbed import GTERNAL

Figures = dict[str, float]


def without_pair_rows() -> Flock:
    """Return the flock of a control run."""
    return Flock(certificate=replace(EXPERIMENT_CERTIFICATE, pair_rows=False))


def papers_neighbours() -> Flock:
    """Return a flock whose robots have the neighbours of the moment, as in the paper."""
    return Flock(neighbour_hysteresis=0.0)


def late_flock() -> Flock:
    """Return a flock with the certificate for robots that answer as late as ``gritsbot_x``.

    It promises 0.185 m between look-ahead points, from which the points of the collision test are
    0.135 m apart.
    """
    ideal = replace(EXPERIMENT_CERTIFICATE, safety_radius=0.185, time_step=GTERNAL.time_step)
    ideal = replace(ideal, wall_margin=0.08)
    return Flock(certificate=late_certificate(ideal, load_profile("gritsbot_x"), barrier_gain=2e4))


MAKE: dict[str, Callable[[], Flock]] = {
    "certified": Flock,
    "control": without_pair_rows,
    "papers-neighbours": papers_neighbours,
    "late": late_flock,
}


def start_for(flock: Flock, seed: int) -> Array:
    """Return where a seed starts: no nearer than the certificate keeps robots after an arrival.

    Robots that answer late are kept as much further apart as that costs; so are their starts.
    """
    if not isinstance(flock.certificate, LateCertificate):
        return start_of(seed)
    rng = np.random.default_rng(seed)
    return random_poses(9, rng, side=1.2, spacing=0.36, look_ahead_spacing=0.39)


def run(seed: int, make: Callable[[], Flock] = Flock, profile: str = "ideal") -> Figures:
    """Run one seed under a profile and return what was true of the robots."""
    flock, realism = make(), None
    start = start_for(flock, seed)
    if profile != "ideal":
        start = near(start, GTERNAL, np.random.default_rng([seed, 1]))
        realism = load_profile(profile).start()
    arena = Arena(start, GTERNAL, realism=realism, rng=np.random.default_rng([seed, 2]))
    steps = flock.steps_in(DURATION)
    poses = np.empty((steps, *start.shape))
    unsolved, by_pairs = 0, 0
    for step in range(steps):
        poses[step] = arena.poses
        decision = flock.step(arena.observe())
        unsolved += decision.status in ("relaxed", "failed")
        by_pairs += decision.intervention > INTERVENED and any(
            row.startswith("robots") for row in decision.active
        )
        arena.commands = decision.command
        arena.step()
    return true_figures(poses, float(np.max(flock.law.radius))) | {
        "collisions": arena.violations.close_pairs,
        "outside": arena.violations.outside_steps,
        "unsolved": unsolved,
        "by_pairs": by_pairs / steps,
    }


def true_figures(poses: Array, radius: float) -> Figures:
    """Return what true poses (T, 3, N) say: alignment, speed, distances, clearance."""
    certificate, step = EXPERIMENT_CERTIFICATE, GTERNAL.time_step
    assert certificate.wall_margin is not None
    late = np.arange(len(poses)) * step > TRANSIENT
    positions, headings = poses[:, :2], metrics.heading_vectors(poses)
    velocity = metrics.smoothed_velocities(positions, step)[late]
    points = positions + certificate.projection_distance * headings
    walls = metrics.wall_distance(points, GTERNAL.boundaries)

    def gamma(vectors: Array, slowest: float = 0.0) -> float:
        found = metrics.alignment(vectors, positions[late], radius, slowest=slowest).gamma
        return float(np.nanmean(found)) if not np.isnan(found).all() else float("nan")

    return {
        "headings": gamma(headings[late]),
        "motion": gamma(velocity, metrics.SLOWEST),
        "speed": float(metrics.mean_speed(velocity).mean()),
        "apart": float(metrics.smallest_distance(points).min()) - certificate.safety_radius,
        "from_walls": float(walls.min()) - certificate.wall_margin,
        "centres": float(metrics.smallest_distance(positions).min()),
        "wall": float(metrics.wall_distance(positions, GTERNAL.boundaries).min()),
    }


def study(one: Callable[[int], Figures], seeds: Sequence[int]) -> dict[str, Array]:
    """Run many seeds on all processors; return each figure as an array."""
    with ProcessPoolExecutor() as pool:
        rows = list(pool.map(one, seeds))
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def tell(found: dict[str, Array]) -> None:
    """Print what was found, without judging."""
    print(
        f"  γ from motion {np.median(found['motion']):.4f}, lowest {found['motion'].min():.4f},"
        f" below .95 in {np.count_nonzero(~(found['motion'] >= 0.95))} seeds; least clearance of"
        f" pairs {1e3 * found['apart'].min():+.1f} mm, below 0 in"
        f" {np.count_nonzero(found['apart'] < 0.0)} seeds;"
        f" {int(found['collisions'].sum())} collisions (pairs × steps)"
    )


def judge(table: Table, found: dict[str, Array]) -> None:
    """Print what is required of one arena."""
    table.bar("γ from motion, median", float(np.median(found["motion"])), "≥", 0.999)
    table.bar("γ from motion, lowest seed", float(found["motion"].min()), "≥", 0.95)
    table.bar("mean speed, median", float(np.median(found["speed"])), "≥", 0.035, "m/s")
    table.bar("least clearance of pairs", 1e3 * float(found["apart"].min()), "≥", 0.0, "mm")
    table.bar("least clearance of walls", 1e3 * float(found["from_walls"].min()), "≥", 0.0, "mm")
    table.bar("collisions, pairs × steps", float(found["collisions"].sum()), "≤", 0)
    table.bar("outside the arena, steps", float(found["outside"].sum()), "≤", 0)
    table.bar("infeasible certificates, steps", float(found["unsolved"].sum()), "≤", 0)
    shares = 100.0 * found["by_pairs"]
    table.bar("steps that pair rows change > 1 mm/s, median", float(np.median(shares)), "≤", 0, "%")
    table.bar("the same, worst seed", float(shares.max()), "≤", 3, "%")


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--profiles", nargs="+", default=["ideal", "gritsbot_x"])
    parser.add_argument("--flocks", nargs="+", choices=MAKE, default=["certified", "control"])
    options = parser.parse_args()
    table = Table()
    for profile in options.profiles:
        for name in options.flocks:
            found = study(partial(run, make=MAKE[name], profile=profile), range(options.seeds))
            print(f"{profile}, {name}, {options.seeds} seeds of {DURATION:g} s")
            tell(found)
            if name == "certified":
                judge(table, found)
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
