"""Nine-robot studies: runs computed together, as a sweep does, against one at a time.

Both ways compute the same runs to the same rows, metrics included, batch after batch in turn in
one process; compiled code is loaded before. Of each profile there are runs that are alike but for
their starts, and runs of which each has drawn a law of its own. Judged are the ratio of CPU times
and the largest difference between rows. Exits 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
import time
from dataclasses import asdict
from typing import Any

import numpy as np
from comparing import Table

from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.simulation.flock_trial import simulate
from posflock_robotarium.sweep.execution import batches
from posflock_robotarium.sweep.experiments import Outcome, find, law_parameters
from posflock_robotarium.sweep.study import PlannedRun, Study, parse_study
from rps_compat.profiles import load_profile

LEAST_RATIO, MOST_DIFFERENCE = 5.0, 1e-9


#: About the paper's values; every run draws its own.
LAWS = {
    "distance_scale": {"uniform": [0.11, 0.13]},
    "radius": {"uniform": [0.7, 0.8]},
    "persistence": {"uniform": [0.1, 0.2]},
    "speed_limit": {"uniform": [0.12, 0.15]},
}


def study(runs: int, duration: float, profile: str, laws: dict[str, Any]) -> Study:
    given = {"duration": duration, "profile": profile}
    said = {"experiment": "robots", "replications": runs, "parameters": given}
    return parse_study(said | {"distributions": laws})


def together(runs: list[PlannedRun]) -> list[Outcome]:
    """Compute runs as a worker of a sweep does."""
    parameters, seeds = [run.parameters for run in runs], [run.stream for run in runs]
    return find("robots").outcomes(parameters, seeds)


def alone(run: PlannedRun, profile: str, duration: float) -> Outcome:
    """Compute one run by a flock and an arena of its own."""
    start = random_poses(9, np.random.default_rng(run.stream), side=1.0, spacing=0.3)
    seed = int(run.stream.spawn(1)[0].generate_state(1, np.uint64)[0])
    realism = load_profile(profile).start()
    flock = Flock(law_parameters(run.parameters))
    trial = simulate(flock, start, duration, realism=realism, seed=seed)
    return asdict(summarise(trial.truth()))


def difference(one: Outcome, other: Outcome) -> float:
    """Return the largest difference between the numbers of two runs; infinite if one is unknown."""
    largest = 0.0
    for name, value in one.items():
        expected = math.nan if other[name] is None else other[name]
        if math.isnan(value) != math.isnan(expected):
            return math.inf
        if not math.isnan(value):
            largest = max(largest, abs(value - expected))
    return largest


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=32)
    parser.add_argument("--duration", type=float, default=120.0, help="s, 10 or more")
    parser.add_argument("--profiles", nargs="+", default=["ideal", "gritsbot_x"])
    options = parser.parse_args()
    table = Table()
    together(study(1, 10.0, "ideal", {}).runs())
    for profile, laws in itertools.product(options.profiles, ({}, LAWS)):
        asked = study(options.runs, options.duration, profile, laws)
        of_batches, of_single, largest = 0.0, 0.0, 0.0
        for batch in batches(asked.runs(), asked.experiment):
            began = time.process_time()
            found = together(batch)
            between = time.process_time()
            expected = [alone(run, profile, options.duration) for run in batch]
            of_batches += between - began
            of_single += time.process_time() - between
            largest = max(largest, *map(difference, found, expected))
        ratio = of_single / of_batches
        called = f"{profile}, {options.runs} runs of {options.duration:g} s"
        called += ", each its law" if laws else ""
        table.bar(f"{called}, times as fast", ratio, "≥", LEAST_RATIO)
        table.bar(f"{called}, largest difference", largest, "≤", MOST_DIFFERENCE)
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
