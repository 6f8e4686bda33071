"""The table of the docs: how often the 95 % band of γ holds the γ of the same run without noise.

Flocks from parallel to scattered (`alignment.band_truth`), few robots and many, are seen with the
noise of a good tracker and of a poor one, six times each. Samples of one recording are kin to
their neighbours, so that a coverage in the table is uncertain by about 0.005.
"""

from __future__ import annotations

import sys

import numpy as np

from posflock_robotarium.alignment.band_truth import FLOCKS, BandCoverage, clean_flock, coverage

ROBOTS = (4, 10, 20)
#: Position noise (m), heading noise (rad) and speed (m/s).
SEEN = ((0.00025, 0.001, 0.2), (0.0005, 0.0015, 0.1), (0.001, 0.005, 0.1), (0.002, 0.02, 0.1))
NAMES = {"motion": "Savitzky-Golay", "headings": "headings", "differences": "raw differences"}
LEAST, MOST = 0.93, 0.97


def cell(found: list[BandCoverage]) -> str:
    """Return coverage over all numbers of robots, least to greatest."""
    held = [each.held for each in found if np.isfinite(each.held)]
    if not held:
        return "no band"
    return f"{100 * min(held):.1f} to {100 * max(held):.1f}"


def main() -> int:
    """Print the table; return 1 where a coverage lies outside of what is required."""
    missed = []
    print("| flock | γ | noise (mm, mrad), speed | " + " | ".join(NAMES.values()) + " | width |")
    print("|---|---|---|" + "---|" * (len(NAMES) + 1))
    for flock in FLOCKS:
        for position, heading, speed in SEEN:
            found = [
                coverage(clean_flock(flock, robots, speed, seed=robots), position, heading)
                for robots in ROBOTS
            ]
            gamma = [each["motion"].gamma for each in found]
            seen = f"{1e3 * position:g}, {1e3 * heading:g}, {speed:g} m/s"
            cells = [cell([each[key] for each in found]) for key in NAMES]
            width = np.mean([each["motion"].width for each in found])
            values = " to ".join(dict.fromkeys(f"{v:.2f}" for v in (min(gamma), max(gamma))))
            print(
                f"| {flock} | {values} | {seen} | {' | '.join(cells)} | {width:.2g} |", flush=True
            )
            for robots, each in zip(ROBOTS, found, strict=True):
                missed += [
                    f"{flock}, {robots} robots, {seen}, {NAMES[key]}: {each[key].held:.3f}"
                    for key in NAMES
                    if np.isfinite(each[key].held) and not LEAST <= each[key].held <= MOST
                ]
    print("\n".join(["", *missed]) if missed else f"\nall within {LEAST:.0%} to {MOST:.0%}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
