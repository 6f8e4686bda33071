"""What a step of a flock costs: alone, in a batch, and with growing numbers of agents.

What is judged are ratios of CPU time, taken in turns: a run of 50 agents, recorded and measured,
against the bare law written as its formulas read, all pairs in plain numpy
(`references.plain_flock`); the k-d tree against all pairs, both ours; and how the cost of a step
grows with the number of agents. Flocks keep the paper's density, so that each agent has about 14
neighbours however many agents there are. Exits 1 where a bar is missed, and with ``--plot FILE``
draws the growth.
"""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path

import numpy as np
from comparing import Table, Times, cpu, seconds
from references import plain_flock

from posflock_robotarium import freespace
from posflock_robotarium.freespace import (
    FreeSpace,
    Model,
    initial_states,
    simulate,
    simulate_batch,
)
from posflock_robotarium.measures import measure

DENSITY = 50 / 25.0**2
SIZES = (1_000, 2_000, 5_000, 10_000, 20_000)
#: Most of the reference's time; a flock that became half as slow again misses it.
MOST_RUN, MOST_BATCH, MOST_TREE, MOST_EXPONENT = 3.6, 0.55, 0.2, 1.2


def flock_of(agents: int, steps: int) -> FreeSpace:
    return FreeSpace(
        agents=agents,
        side=float(np.sqrt(agents / DENSITY)),
        duration=steps * 0.05,
        record_interval=steps * 0.05,
    )


def step_seconds(agents: int, tree: bool, steps: int) -> float:
    """Return the CPU seconds of a step, by k-d tree or from all pairs."""
    freespace.TREE_FROM_AGENTS = 0 if tree else 10**9
    return cpu(partial(simulate, flock_of(agents, steps), 0)) / steps


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--plot", type=Path)
    said = options.parse_args()
    table = Table(64)
    scenario = FreeSpace(Model.POSITION)
    start = initial_states(scenario, np.random.default_rng(0))
    run = Times(
        {
            "ours": lambda: cpu(lambda: measure(simulate(scenario, 0), 7.5)),
            "plain": lambda: cpu(lambda: plain_flock(*start, scenario.steps)),
        }
    )
    what = "50 agents: 100 s, recorded and measured, against the bare law"
    table.ratio(what, run, "ours", "plain", MOST_RUN)
    batch = Times(
        {
            "alone": lambda: cpu(lambda: [simulate(scenario, seed) for seed in range(8)]),
            "batch": lambda: cpu(lambda: simulate_batch(scenario, range(8))),
        },
        rounds=3,
    )
    table.ratio("a batch of 8, against 8 alone", batch, "batch", "alone", MOST_BATCH)

    before = freespace.TREE_FROM_AGENTS
    print("\nagents   all pairs    k-d tree   (a step)")
    for agents in (50, 100, 200, 300, 500, 1000):
        kinds = {
            kind: partial(step_seconds, agents, kind == "tree", 20) for kind in ("dense", "tree")
        }
        search = Times(kinds, rounds=3)
        print(f"{agents:6}", *(f"{seconds(search.median(kind)):>11}" for kind in kinds))
    table.ratio("1000 agents: k-d tree, against all pairs", search, "tree", "dense", MOST_TREE)

    growth = Times({size: partial(step_seconds, size, True, 5) for size in SIZES}, rounds=3)
    freespace.TREE_FROM_AGENTS = before
    costs = np.array([growth.median(size) for size in SIZES])
    print("\nagents   a step        an agent and step")
    for agents, cost in zip(SIZES, costs, strict=True):
        print(f"{agents:6} {seconds(cost):>11} {seconds(cost / agents):>11}")
    exponent = float(np.polyfit(np.log(SIZES), np.log(costs), 1)[0])
    table.bar("growth from 1,000 to 20,000 agents, exponent", exponent, "≤", MOST_EXPONENT)
    if said.plot:
        draw(costs, exponent, said.plot)
    return table.exit_code()


def draw(costs: np.ndarray, exponent: float, path: Path) -> None:
    from posflock_robotarium.drawing import BLUE, GREY, in_style, new_figure

    @in_style
    def growth() -> None:
        figure = new_figure(3.5, 2.6)
        axes = figure.subplots()
        linear = 1e3 * costs[0] * np.array(SIZES) / SIZES[0]
        axes.loglog(SIZES, linear, color=GREY, linestyle="--", linewidth=1.0, label="linear")
        axes.loglog(
            SIZES,
            1e3 * costs,
            "o-",
            color=BLUE,
            linewidth=1.1,
            markersize=4,
            label=f"measured, n$^{{{exponent:.2f}}}$",
        )
        axes.set(xlabel="agents n (–)", ylabel="CPU time of a step (ms)")
        axes.set_xticks(SIZES, [f"{size:,}" for size in SIZES])
        ticks = [tick for tick in (1, 2, 5, 10, 20, 50, 100, 200) if tick < 1.2e3 * costs[-1]]
        axes.set_yticks(ticks, [str(tick) for tick in ticks])
        axes.minorticks_off()
        axes.legend()
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=200)

    growth()


if __name__ == "__main__":
    sys.exit(main())
