"""The nine-robot experiment where each robot decides by what it senses and hears (``--local``).

Steering, law and certificate are those of ``experiments/robotarium_9bot.py --local``. Each seed is
120 s, in the ideal arena and under ``gritsbot_x`` after an arrival within 5 cm and 0.2 rad. All
figures are of true poses, those of alignment for t > 20 s. With ``--beside`` the same seeds are
flown by the mean over the flock and the team's certificate. Exits 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
import sys
from functools import partial

import numpy as np
from certified_flock import Figures, run, study, tell
from comparing import Table
from nine_robots import DURATION

from posflock_robotarium.flocking.flock import Flock
from rps_compat.arena import Array


def local_flock() -> Flock:
    """Return the flock of ``--local``."""
    return Flock(local=True)


def show(found: dict[str, Array], first: int) -> None:
    """Print what was found, without judging."""
    tell(found)
    worst = np.argsort(found["motion"])[:3]
    print(
        f"  mean speed {np.median(found['speed']):.4f} m/s, lowest {found['speed'].min():.4f};"
        f" least clearance of walls {1e3 * found['from_walls'].min():+.1f} mm;"
        f" outside {int(found['outside'].sum())} steps, unsolved {int(found['unsolved'].sum())};"
        f" pair rows change {100 * np.median(found['by_pairs']):.2f} % of steps,"
        f" worst {100 * found['by_pairs'].max():.2f} %; worst seeds"
        + "".join(f" {first + seed} ({found['motion'][seed]:.4f})" for seed in worst),
        flush=True,
    )


def judge(table: Table, found: dict[str, Array]) -> None:
    """Print what is required of a flock whose robots know their neighbours alone."""
    table.bar("γ from motion, median", float(np.median(found["motion"])), "≥", 0.99)
    table.bar("γ from motion, lowest seed", float(found["motion"].min()), "≥", 0.9)
    table.bar("mean speed, median", float(np.median(found["speed"])), "≥", 0.035, "m/s")
    table.bar("collisions, pairs × steps", float(found["collisions"].sum()), "≤", 0)
    table.bar("outside the arena, steps", float(found["outside"].sum()), "≤", 0)


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100, help="how many")
    parser.add_argument("--first", type=int, default=0, help="the first of them")
    parser.add_argument("--profiles", nargs="+", default=["ideal", "gritsbot_x"])
    parser.add_argument("--beside", action="store_true", help="the default flock on the same seeds")
    options = parser.parse_args()
    seeds, table = range(options.first, options.first + options.seeds), Table()
    for profile in options.profiles:
        table.part(f"{profile}, local, seeds {seeds[0]}-{seeds[-1]} of {DURATION:g} s")
        found = study(_local(profile), seeds)
        show(found, options.first)
        judge(table, found)
        if options.beside:
            print(f"{profile}, by the mean over the flock, the same seeds")
            show(study(partial(run, profile=profile), seeds), options.first)
    return table.exit_code()


def _local(profile: str) -> partial[Figures]:
    return partial(run, make=local_flock, profile=profile)


if __name__ == "__main__":
    sys.exit(main())
