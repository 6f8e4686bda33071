"""What a step of a flock costs: alone, in a batch, and with growing numbers of agents.

Flocks keep the paper's density, so that each agent has about 14 neighbours however many
agents there are.  Prints required against measured, exits 1 where a bar is missed, and with
``--plot FILE`` draws the growth.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from posflock_robotarium import freespace
from posflock_robotarium.freespace import FreeSpace, Model, simulate, simulate_batch
from posflock_robotarium.measures import measure

DENSITY = 50 / 25.0**2
SIZES = (1_000, 2_000, 5_000, 10_000, 20_000)


def flock_of(agents: int, steps: int) -> FreeSpace:
    return FreeSpace(
        agents=agents,
        side=float(np.sqrt(agents / DENSITY)),
        duration=steps * 0.05,
        record_interval=steps * 0.05,
    )


def cpu(run: Callable[[], object]) -> float:
    started = time.process_time()
    run()
    return time.process_time() - started


def step_seconds(agents: int, tree: bool, steps: int, rounds: int = 3) -> float:
    """Return the median CPU seconds of a step, by k-d tree or from all pairs."""
    freespace.TREE_FROM_AGENTS = 0 if tree else 10**9
    scenario = flock_of(agents, steps)
    return float(np.median([cpu(lambda: simulate(scenario, 0)) for _ in range(rounds)])) / steps


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--plot", type=Path)
    said = options.parse_args()
    scenario = FreeSpace(Model.POSITION)
    one = np.median([cpu(lambda: measure(simulate(scenario, 0), 7.5)) for _ in range(5)])
    short = replace(scenario, duration=20.0)
    alone, together = [], []
    for _ in range(5):  # interleaved: both meet the same neighbours on the machine
        alone.append(cpu(lambda: [simulate(short, seed) for seed in range(8)]))
        together.append(cpu(lambda: simulate_batch(short, range(8))))
    print(f"50 agents: a run of 100 s, measured         {one:7.3f} s of CPU   <= 0.5")
    gain = float(np.median(alone) / np.median(together))
    print(f"50 agents: batch of 8 quicker than 8 alone   {gain:6.2f} x")

    before = freespace.TREE_FROM_AGENTS
    print("\nagents   all pairs   k-d tree   (ms a step)")
    for agents in (50, 100, 200, 300, 500, 1000):
        dense, tree = step_seconds(agents, False, 20), step_seconds(agents, True, 20)
        print(f"{agents:6}   {1e3 * dense:9.2f}   {1e3 * tree:8.2f}")

    costs = np.array([step_seconds(agents, True, 5) for agents in SIZES])
    freespace.TREE_FROM_AGENTS = before
    print("\nagents   ms a step   µs an agent and step")
    for agents, cost in zip(SIZES, costs, strict=True):
        print(f"{agents:6}   {1e3 * cost:9.2f}   {1e6 * cost / agents:9.3f}")
    exponent = float(np.polyfit(np.log(SIZES), np.log(costs), 1)[0])
    print(f"growth: cost ~ n^{exponent:.2f}, 1,000 to 20,000 agents          <= 1.2")
    if said.plot:
        draw(costs, exponent, said.plot)
    return 1 if exponent > 1.2 or one > 0.5 else 0


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
