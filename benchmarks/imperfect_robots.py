"""The nine-robot experiment under imperfections worse than usual, and without its filter.

Twenty seeds of 120 s, arrived at the start within 5 cm and 0.2 rad, as the submitted script
controls them. ``harsh`` has no bar; those of ``gritsbot_x`` stand in ``certified_flock.py``, and of
``gternal`` it is asked that nobody collides or leaves the arena.
``--without-filter`` shows what the flock does when it acts on tracked poses alone.
"""

from __future__ import annotations

import argparse
import sys
from functools import partial

import numpy as np
from certified_flock import run, study

from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.pose_filter import PoseFilterParameters


def unfiltered() -> Flock:
    """Return a flock that acts on tracked poses alone."""
    return Flock(filtering=PoseFilterParameters(rate=1e3, lost=1e-9))


def main(arguments: list[str] | None = None) -> int:
    """Print what was measured; 1 where robots of a real kind collide or leave the arena."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--profiles", nargs="+", default=["gritsbot_x", "gternal", "harsh"])
    parser.add_argument("--without-filter", action="store_true")
    options = parser.parse_args(arguments)
    make = unfiltered if options.without_filter else Flock
    failed = False
    for profile in options.profiles:
        found = study(partial(run, make=make, profile=profile), range(options.seeds))
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
