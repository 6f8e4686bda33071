"""How the speed of batches grows with teams and with robots, as a picture.

Team steps a second of CPU time on one processor in rollouts of 120 steps: over B for teams of nine,
of JaxRobotarium too where `batch_speed.py` finds it, and over N for 64 teams. Judges nothing.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from batch_speed import Batch, Rival, pinned
from batch_teams import KINDS
from comparing import Times, cpu

from posflock_robotarium.figures.palette import BLACK, BLUE, GREEN, ORANGE
from posflock_robotarium.figures.style import new_figure

TEAMS = (1, 4, 16, 64, 256, 1024, 4096)
ROBOTS = (4, 9, 16, 25, 36)
_COLOURS = dict(zip(KINDS, (BLUE, GREEN, ORANGE, BLACK), strict=True))
_LEAST_STEPS = 6_000


def ours(kind: str, number: int, robots: int = 9) -> float:
    """Return team steps a second of a batch."""
    batch, steps = Batch(kind, number, robots=robots), 120
    again = max(1, _LEAST_STEPS // (number * steps))

    def go() -> None:
        for _ in range(again):
            batch.roll(steps)

    return number * steps * again / Times({"batch": lambda: cpu(go)}, 5).median("batch")


def theirs(rival: Rival, kind: str, number: int) -> float:
    """Return team steps a second of JaxRobotarium, of large batches in the first four steps."""
    steps = 120 if number <= 64 or kind == "bare" else 4
    again = max(1, _LEAST_STEPS // (number * steps))
    rival.seconds(kind, "rollout", number, steps)  # compiles
    times = Times({"rival": lambda: rival.seconds(kind, "rollout", number, steps, again)}, 3)
    return number * steps * again / times.median("rival")


def main() -> int:
    """Time, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jax", type=Path, help="Python that has jax and jaxopt")
    parser.add_argument("--simulator", type=Path, help="folder that has rps_jax")
    parser.add_argument("-o", "--out", type=Path, default=Path("results"), help="folder for plot")
    asked = parser.parse_args()
    pinned()
    rival = Rival(asked.jax, asked.simulator) if asked.jax and asked.simulator else None
    figure = new_figure(7.2, 3.0)
    over_teams, over_robots = figure.subplots(1, 2, sharey=True)
    for kind in KINDS:
        rates = [ours(kind, number) for number in TEAMS]
        over_teams.loglog(TEAMS, rates, "o-", color=_COLOURS[kind], label=kind, markersize=3)
        print(kind, "over B", *(f"{rate:.3g}" for rate in rates), flush=True)
        if rival is not None:
            rates = [theirs(rival, kind, number) for number in TEAMS]
            over_teams.loglog(TEAMS, rates, "x--", color=_COLOURS[kind], markersize=4)
            print(kind, "JaxRobotarium", *(f"{rate:.3g}" for rate in rates), flush=True)
    for kind in ("bare", "packed"):
        rates = [ours(kind, 64, robots) for robots in ROBOTS]
        over_robots.loglog(ROBOTS, rates, "o-", color=_COLOURS[kind], label=kind, markersize=3)
        print(kind, "over N", *(f"{rate:.3g}" for rate in rates), flush=True)
    over_teams.set(xlabel="teams B (nine robots)", ylabel="team steps / CPU second")
    over_teams.set_xticks(TEAMS, [f"{number:,}" for number in TEAMS], fontsize=7)
    if rival is not None:
        over_teams.plot([], [], "x--", color="0.4", label="JaxRobotarium")
    over_teams.set_ylim(top=3e8)  # room for the legend
    over_teams.legend(fontsize=7, ncols=2, loc="upper center")
    over_robots.set(xlabel="robots N (64 teams)")
    over_robots.set_xticks(ROBOTS, [str(number) for number in ROBOTS])
    for axes in (over_teams, over_robots):
        axes.minorticks_off()
        axes.grid(True, which="major", alpha=0.3)
    asked.out.mkdir(parents=True, exist_ok=True)
    figure.savefig(asked.out / "batch-growth.png", dpi=110)
    return 0


if __name__ == "__main__":
    sys.exit(main())
