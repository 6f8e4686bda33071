"""Thousands of teams at once, against the single arena here and against JaxRobotarium.

Nine robots a team, unicycles; certified with pairs, walls and limits. Team steps a second of CPU
time on one processor, median over rounds in which all candidates take turns. JaxRobotarium runs in
an environment of its own, where one is named:

    uv venv jax && uv pip install --python jax/bin/python 'jax[cpu]' jaxopt
    git clone https://github.com/shalin-jain/robotarium_python_simulator simulator
    python benchmarks/batch_speed.py --jax jax/bin/python --simulator simulator

Prints a line a cell with the least clearance of two projection points and the largest violated row,
its own at the end of a rollout and ours over all steps, and exits 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import date
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
from batch_teams import AHEAD, GAIN, KINDS, RADIUS, ROBOTS, SPEED, TIME_STEP, steps_of, teams
from comparing import Table, Times, cpu

from barrier_certificates.batch import BatchCertificate
from barrier_certificates.unicycle import UnicycleCertificate
from rps_compat.arena import Arena
from rps_compat.batch import BatchArena, Rollout, RolloutOutcome, ToGoals, rollout

CERTIFICATE = UnicycleCertificate(
    safety_radius=RADIUS, barrier_gain=2000.0, wall_gain=100.0, wall_margin=0.11,
    boundary=(-1.6, 1.6, -1.0, 1.0), speed_limit=SPEED, turn_rate_limit=0.55, time_step=TIME_STEP,
)  # fmt: skip
#: At least so many times JaxRobotarium, and the single arena here.
BARS = {"bare": (1.2, 100.0), "spread": (1.5, 40.0), "packed": (5.0, 10.0), "swap": (5.0, 10.0)}
_SINGLE_STEPS = 30
_LEAST_STEPS = 6_000  # of teams, in a row: fewer are timed before a processor has settled on them


class Batch:
    """Ours: a batch of teams, in a rollout or step by step."""

    def __init__(
        self,
        kind: str,
        number: int,
        engine: str = "numba",
        threads: int = 1,
        robots: int = ROBOTS,
    ) -> None:
        self.kind = kind
        self.poses, self.target = teams(kind, number, robots=robots)
        self.arena = BatchArena(self.poses, engine=engine, threads=threads)
        self.certificate = BatchCertificate(CERTIFICATE, engine=engine, threads=threads)
        self.outcome: RolloutOutcome | None = None
        self.roll(1)

    def roll(self, steps: int) -> None:
        """Do steps in one call."""
        self.start()
        if self.kind == "bare":
            self.arena.run(steps)
        else:
            wish = ToGoals(self.target, GAIN, SPEED)
            self.outcome = rollout(self.arena, self.certificate, wish, steps)

    def single(self, steps: int) -> None:
        """Do steps one by one."""
        self.start()
        arena = self.arena
        if self.kind == "bare":
            for _ in range(steps):
                arena.commands = self.target
                arena.step()
        else:
            way = Rollout(arena, self.certificate, ToGoals(self.target, GAIN, SPEED))
            for _ in range(steps):
                way.run()

    def start(self) -> None:
        """Put all teams where they begin."""
        self.certificate.reset()
        self.arena.poses[:] = self.poses
        self.arena.commands = self.target if self.kind == "bare" else np.zeros_like(self.target)


def alone(kind: str, steps: int) -> Callable[[], None]:
    """Return a run of one team in the single arena."""
    poses, target = teams(kind, 1)

    def run() -> None:
        arena, certificate = Arena(poses[0]), CERTIFICATE
        certificate.reset()
        wish = ToGoals(target, GAIN, SPEED)
        for _ in range(steps):
            if kind == "bare":
                arena.commands = target[0]
            else:
                asked = wish(arena.poses[None], AHEAD)[0]
                arena.commands, _ = certificate(asked, arena.poses)
            arena.step()

    return run


class Rival:
    """JaxRobotarium in a process of its own."""

    def __init__(self, python: Path, simulator: Path) -> None:
        worker = Path(__file__).with_name("jaxrobotarium_worker.py")
        self.process = subprocess.Popen(
            [python, worker, simulator], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.version = self.process.stdout.readline().strip()
        self.clearance = self.violation = np.nan

    def seconds(self, kind: str, mode: str, number: int, steps: int, times: int = 1) -> float:
        """Return the CPU seconds of so many steps, done so many times."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(kind, mode, number, steps, times, file=self.process.stdin, flush=True)
        seconds, self.clearance, self.violation = map(float, self.process.stdout.readline().split())
        return seconds


def cell(table: Table, rival: Rival | None, kind: str, mode: str, number: int, rounds: int) -> None:
    """Time one cell of the table, and judge it."""
    batch = Batch(kind, number)
    steps = steps_of(kind, number) if mode == "rollout" else _SINGLE_STEPS
    few = steps if kind == "bare" or number <= 64 else min(steps, 4)
    again = max(1, _LEAST_STEPS // (number * steps))
    reference = 400 if kind == "bare" else 150
    go = batch.roll if mode == "rollout" else batch.single

    def repeated() -> None:
        for _ in range(again):
            go(steps)

    candidates = {
        "batch": lambda: cpu(repeated) / again,
        "alone": lambda: cpu(alone(kind, reference)),
    }
    if rival is not None:
        candidates["rival"] = lambda: rival.seconds(kind, mode, number, few, again) / again
        candidates["rival"]()  # compiles
    times = Times(candidates, rounds)
    mine = number * steps / times.median("batch")
    single = reference / times.median("alone")
    jax, jax_clearance = "–", ""
    more_than_rival, more_than_one = BARS[kind]
    name = f"{kind} {mode} B={number}"
    if rival is not None:
        theirs = number * few / times.median("rival")
        ratio = 1 / times.ratio("batch", "rival") * (steps / few)
        jax = f"{theirs:.3g}"
        if kind != "bare":
            jax_clearance = f", theirs {1e3 * rival.clearance:.1f} mm, {rival.violation:.2g} m/s"
        table.bar(f"{name}, × JaxRobotarium", ratio, "≥", more_than_rival)
    ratio = number * steps / reference / times.ratio("batch", "alone")
    bar = more_than_one if rival is None or kind in ("packed", "swap") else 0.0
    table.bar(f"{name}, × the single arena", ratio, "≥", bar)
    safe = ""
    if batch.outcome is not None:
        safe = f"; clearance {1e3 * batch.outcome.clearance.min():.2f} mm{jax_clearance}"
        safe += f", violation {batch.outcome.violation.max():.1g} m/s"
    print(f"    {mine:.3g} team steps/s; JaxRobotarium {jax}; single arena {single:.3g}{safe}")


def numpy_alone(table: Table, rounds: int) -> None:
    """Judge the batch arena without compiled code."""
    batch, steps = Batch("bare", 1024, engine="numpy"), 20
    candidates = {
        "batch": lambda: cpu(lambda: batch.roll(steps)),
        "alone": lambda: cpu(alone("bare", 400)),
    }
    ratio = 1024 * steps / 400 / Times(candidates, rounds).ratio("batch", "alone")
    table.bar("bare, numpy alone, B=1024, × the single arena", ratio, "≥", 12.0)


def pinned() -> set[int]:
    """Stay on one processor from here on; return those that there are."""
    if not hasattr(os, "sched_setaffinity"):
        return set()
    processors = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(processors)})
    return processors


def two_processors(table: Table, rounds: int, processors: set[int]) -> None:
    """Judge teams shared between two processors by the clock: nothing else may run beside them."""
    if len(processors) < 2:
        print("  two processors: not measured, for there is one")
        return
    os.sched_setaffinity(0, processors)  # before threads begin, which inherit it
    for kind in ("bare", "packed"):
        batches = {threads: Batch(kind, 4096, threads=threads) for threads in (1, 2)}
        steps = steps_of(kind, 4096)

        def clock(batch: Batch, steps: int = steps) -> float:
            began = time.perf_counter()
            batch.roll(steps)
            return time.perf_counter() - began

        times = Times({str(n): partial(clock, batch) for n, batch in batches.items()}, rounds)
        table.bar(
            f"{kind} rollout B=4096, two processors, by the clock",
            1 / times.ratio("2", "1"),
            "≥",
            1.8,
        )


def main() -> int:
    """Time what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jax", type=Path, help="Python that has jax and jaxopt")
    parser.add_argument("--simulator", type=Path, help="folder that has rps_jax")
    parser.add_argument("--teams", type=int, nargs="+", default=[1, 64, 1024, 4096])
    parser.add_argument("--kinds", nargs="+", default=KINDS, choices=KINDS)
    parser.add_argument("--modes", nargs="+", default=["rollout", "single"])
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    processors = pinned()  # before the other process begins, which inherits it
    rival = Rival(asked.jax, asked.simulator) if asked.jax and asked.simulator else None
    print(
        f"{date.today()}, Python {sys.version.split()[0]}, numpy {np.__version__}, numba"
        f" {version('numba')}, jax {rival.version if rival else 'not asked'}"
    )
    table = Table(width=48)
    for kind in asked.kinds:
        for mode in asked.modes:
            for number in asked.teams:
                cell(table, rival, kind, mode, number, asked.rounds)
    numpy_alone(table, asked.rounds)
    two_processors(table, asked.rounds, processors)
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
