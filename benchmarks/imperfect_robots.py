"""The nine-robot experiment under imperfections worse than usual, and without its filter.

Twenty seeds of 120 s, arrived at the start within 5 cm and 0.2 rad, as the submitted script
controls them. ``harsh`` has no bar; those of ``gritsbot_x`` stand in ``certified_flock.py``, and of
``gternal`` it is asked that nobody collides or leaves the arena.
``--without-filter`` shows what the flock does when it acts on tracked poses alone.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
from certified_flock import Figures, true_figures
from nine_robots import DURATION, start_of

from posflock_robotarium.batch.batch_flock import BatchFlock
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.pose_filter import PoseFilterParameters
from posflock_robotarium.simulation.workers import processors
from rps_compat.arena import Array
from rps_compat.batch import BatchArena
from rps_compat.initial import near
from rps_compat.profiles import load_profile
from rps_compat.testbed import GTERNAL


def unfiltered() -> Flock:
    """Return a flock that acts on tracked poses alone."""
    return Flock(filtering=PoseFilterParameters(rate=1e3, lost=1e-9))


def run_together(
    seeds: list[int], profile: str, flock: Flock, duration: float = DURATION
) -> list[Figures]:
    """Run seeds as ``certified_flock.run`` runs each, all at once."""
    starts = [near(start_of(seed), GTERNAL, np.random.default_rng([seed, 1])) for seed in seeds]
    noise = [np.random.default_rng([seed, 2]) for seed in seeds]
    arena = BatchArena(starts, GTERNAL, realism=load_profile(profile), seeds=noise, threads=1)
    flocks = BatchFlock(flock, len(seeds), threads=1)
    steps = flock.steps_in(duration)
    poses = np.empty((len(seeds), steps, *starts[0].shape))
    for step in range(steps):
        poses[:, step] = arena.poses
        arena.commands = flocks.step(arena.observe()).command
        arena.step()
    counted = arena.violations
    return [
        true_figures(poses[team], float(np.max(flock.law.radius)))
        | {
            "collisions": int(counted.close_pairs[team]),
            "outside": int(counted.outside_steps[team]),
        }
        for team in range(len(seeds))
    ]


def study(seeds: int, profile: str, flock: Flock) -> dict[str, Array]:
    """Run so many seeds on all processors; return each figure as an array."""
    shares = [part.tolist() for part in np.array_split(np.arange(seeds), processors()) if part.size]
    with ProcessPoolExecutor() as pool:
        parts = pool.map(partial(run_together, profile=profile, flock=flock), shares)
        rows = [row for part in parts for row in part]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def main(arguments: list[str] | None = None) -> int:
    """Print what was measured; 1 where robots of a real kind collide or leave the arena."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--profiles", nargs="+", default=["gritsbot_x", "gternal", "harsh"])
    parser.add_argument("--without-filter", action="store_true")
    options = parser.parse_args(arguments)
    flock = unfiltered() if options.without_filter else Flock()
    failed = False
    for profile in options.profiles:
        found = study(options.seeds, profile, flock)
        print(f"{profile}, {options.seeds} seeds of 120 s")
        for name, value in (
            ("γ from motion, median", np.median(found["motion"])),
            ("γ from motion, lowest seed", found["motion"].min()),
            ("γ from headings, median", np.median(found["headings"])),
            ("collisions, pairs × steps", found["collisions"].sum()),
            ("outside the arena, steps", found["outside"].sum()),
            ("least clearance of pairs, m", found["apart"].min()),
            ("smallest centre distance, m", found["centres"].min()),
            ("smallest wall distance, m", found["wall"].min()),
            ("mean speed, median, m/s", np.median(found["speed"])),
        ):
            print(f"  {name:<30} {value:9.4f}")
        unsafe = found["collisions"].sum() + found["outside"].sum() > 0
        failed |= unsafe and profile != "harsh"
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
