"""The paper's simulation over seeds, against what its reproduction must show.

Prints required against measured, with 95 % intervals over seeds, and exits 1 where a bar is missed:
where the whole interval is before it.  A bar within the interval is not settled by these seeds,
and no fault.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
from comparing import Table
from numpy.typing import NDArray

from posflock_robotarium.alignment.point_agents import measure, summarise
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.simulation import FreeSpace, simulate_batch
from posflock_robotarium.paper.claim import NEARLY_ALL
from posflock_robotarium.paper.default_seeds import SEEDS
from posflock_robotarium.paper.measured import Measured, median_of, share_of

Floats = NDArray[np.float64]

V, P, N = Model.VELOCITY, Model.POSITION, Model.POSITION_NO_THRESHOLD
#: Flocks whose states are kept at once: all of them would take gigabytes.
TOGETHER = 20
ALIGNED = 0.95


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seeds", type=int, default=SEEDS)
    options.add_argument("--first-seed", type=int, default=0)
    said = options.parse_args()
    seeds = range(said.first_seed, said.first_seed + said.seeds)
    numbers = {model: numbers_of(FreeSpace(model), seeds) for model in Model}

    def median(model: Model, name: str) -> Measured:
        return median_of(numbers[model][name])

    def pairs(name: str, less: Model, more: Model) -> Measured:
        return share_of(numbers[less][name] < numbers[more][name])

    def aligned(model: Model) -> Measured:
        return share_of(numbers[model]["gamma_settled"] >= ALIGNED)

    bars = [
        ("P: mean γ on [20, 100] s, median", median(P, "gamma_settled"), "≥", 0.99),
        (f"P: seeds that align (mean γ ≥ {ALIGNED}), share", aligned(P), "≥", NEARLY_ALL),
        (f"V: seeds that align (mean γ ≥ {ALIGNED}), share", aligned(V), "≥", NEARLY_ALL),
        ("V: mean γ on [20, 100] s, median", median(V, "gamma_settled"), "≥", 0.98),
        ("no thr.: γ on [80, 100] − [10, 30] s, median", median(N, "gamma_change"), "≤", -0.10),
        ("P reaches γ 0.9 before V, share", pairs("alignment_time", P, V), "≥", 0.7),
        ("P: nearest neighbour at 100 s, m", median(P, "nearest_neighbour_end"), "≥", 1.7),
        ("P: nearest neighbour at 100 s, m", median(P, "nearest_neighbour_end"), "≤", 2.0),
        ("V: nearest neighbour at 100 s, m", median(V, "nearest_neighbour_end"), "≥", 2.2),
        ("V: nearest neighbour at 100 s, m", median(V, "nearest_neighbour_end"), "≤", 2.6),
        ("P nearer than V, share", pairs("nearest_neighbour_end", P, V), "≥", NEARLY_ALL),
        ("P: cohesive radius, largest/smallest", median(P, "cohesive_radius_ratio"), "≤", 1.02),
        ("P: spread of heading, degrees", median(P, "heading_spread"), "≤", 5.0),
        ("P better than no thr., share", pairs("gamma_settled", N, P), "≥", NEARLY_ALL),
    ]
    table = Table(48)
    print(f"seeds {seeds.start} to {seeds.stop - 1}")
    for name, measured, sense, bar in bars:
        table.bar(name, measured.value, sense, bar, interval=measured.interval)
    return table.exit_code()


def numbers_of(scenario: FreeSpace, seeds: range) -> dict[str, Floats]:
    """Return the summary numbers of a scenario, each (B,) over seeds."""
    parts = [
        summarise(measure(simulate_batch(scenario, seeds[at : at + TOGETHER]), scenario.law.radius))
        for at in range(0, len(seeds), TOGETHER)
    ]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


if __name__ == "__main__":
    sys.exit(main())
