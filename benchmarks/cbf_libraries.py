"""Other libraries for control barrier functions on the same states: time, rows broken, error.

Nine single integrators on a plane, kept 0.15 m apart by 36 pairs with h = ‖D‖² − r² and γ h³ at
γ = 100, and slower than 0.2 m/s: each by the limit that a library has, a box or an octagon. They
head for places nearby ("spread"), change places ("swap"), or press together ("packed"), in runs
that are recorded first. Each library certifies all states in a process and an environment of its
own, named by an option:

    uv venv cbfpy && uv pip install --python cbfpy/bin/python cbfpy elastiqp
    uv venv cbfjax && uv pip install --python cbfjax/bin/python cbfjax
    git clone https://github.com/bardhh/cbfkit sources/cbfkit
    uv venv cbfkit && uv pip install --python cbfkit/bin/python sources/cbfkit
    git clone https://github.com/robotarium/robotarium_python_simulator sources/rps
    uv venv rps && uv pip install --python rps/bin/python sources/rps
    python benchmarks/cbf_libraries.py --cbfpy cbfpy/bin/python --cbfjax cbfjax/bin/python \
        --cbfkit cbfkit/bin/python --rps rps/bin/python

Told of each: CPU milliseconds of a call, the median over rounds in which all take turns, compiled
before; the largest excess over a row of unit norm; and how far the answer is from the optimum of
the same program, which this library computes exactly (largest over robots; median and largest over
states). Only that optimum can fail here, by its own conditions: exit 1.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import NamedTuple

from comparing import Table, cpu  # before numpy

# isort: split
import numpy as np
from cbf_library_worker import CANDIDATES
from scipy.optimize import nnls

from barrier_certificates.rows import VelocityPolygon
from barrier_certificates.single_integrator import SingleIntegratorCertificate

RADIUS, GAIN, SPEED, ROBOTS = 0.15, 100.0, 0.2, 9
TIME_STEP, STEPS = 0.033, 10
#: How far apart robots begin, m, and where each heads: that part of where it began; 0 is anywhere.
KINDS = {"spread": (0.6, 0.0), "swap": (0.35, -1.0), "packed": (1.08 * RADIUS, 0.5)}
BOX, OCTAGON = VelocityPolygon.box(SPEED), VelocityPolygon.octagon(SPEED)
#: The published utilities have one side of their octagon on the circle.
PUBLISHED = replace(OCTAGON, bounds=np.where(np.arange(8) == 0, SPEED, OCTAGON.bounds))


class Figures(NamedTuple):
    """What is told of a candidate on one kind of states."""

    milliseconds: float
    broken: float
    """Largest excess over a row, mm/s."""
    error: float
    """How far from the optimum, mm/s: the median."""
    largest_error: float
    silent: float
    """In which part of the states there was no answer, or one that is not a number."""

    def __str__(self) -> str:
        return (
            f"{self.milliseconds:>10.3f}{self.broken:>14.2g}{self.error:>14.2g}"
            f"{self.largest_error:>12.2g}{self.silent:>10.1%}"
        )


def certificate(limits: VelocityPolygon, solver: str = "auto") -> SingleIntegratorCertificate:
    """Return this library's certificate with the same rows."""
    return SingleIntegratorCertificate(RADIUS, GAIN, limits=limits.rows(), solver=solver)


def record(kind: str, runs: int) -> tuple[np.ndarray, np.ndarray]:
    """Return wishes and positions (R, T, 2, N): ten steps somewhere in each of the runs."""
    spacing, reach = KINDS[kind]
    rng = np.random.default_rng(ROBOTS)
    grid = np.array(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0])).reshape(2, -1)
    shake = min(0.08 * spacing, 0.3 * (spacing - RADIUS))
    wishes, at = np.empty((2, runs, STEPS, 2, ROBOTS))
    certify = certificate(OCTAGON)
    for run in range(runs):
        positions = spacing * grid + rng.uniform(-shake, shake, grid.shape)
        goals = reach * positions if reach else positions + rng.uniform(-0.5, 0.5, grid.shape)
        begin = int(rng.integers(0, 60))
        for step in range(begin + STEPS):
            way = goals - positions
            wish = way * (SPEED / np.maximum(np.hypot(*way), SPEED))
            if step >= begin:
                wishes[run, step - begin], at[run, step - begin] = wish, positions
            positions = positions + TIME_STEP * certify(wish, positions)[0]
    return wishes, at


class Ours:
    """Certifies with this library."""

    def __init__(self, limits: VelocityPolygon, states: dict[str, tuple[np.ndarray, np.ndarray]]):
        self.limits, self._states = limits, states
        self.answers: dict[str, np.ndarray] = {}
        self.milliseconds: dict[str, list[float]] = {kind: [] for kind in states}

    def round(self, kind: str) -> None:
        """Certify all states of a kind, and take the time."""
        certify, answers = certificate(self.limits), []
        for run in zip(*self._states[kind], strict=True):
            certify.reset()
            for wish, at in zip(*run, strict=True):
                cost = cpu(lambda wish=wish, at=at: answers.append(certify(wish, at)[0]))
                self.milliseconds[kind].append(1e3 * cost)
        self.answers[kind] = np.array(answers)


class Rival:
    """Another library, in a process of its own."""

    def __init__(self, name: str, python: Path, states: Path) -> None:
        self.limits = PUBLISHED if name.startswith("rps") else BOX
        self.answers: dict[str, np.ndarray] = {}
        self.milliseconds: dict[str, list[float]] = {kind: [] for kind in KINDS}
        self._name, self._log = name, states.with_name(f"{name}.log")
        worker = Path(__file__).with_name("cbf_library_worker.py")
        self._process = subprocess.Popen(
            [python, worker, name, states], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=self._log.open("w"), text=True,
        )  # fmt: skip
        assert self._process.stdout is not None
        self.version = self._process.stdout.readline().strip()
        for kind in KINDS:  # compiles
            self.round(kind)
            self.milliseconds[kind].clear()

    def round(self, kind: str) -> None:
        """Have all states of a kind certified."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(kind, file=self._process.stdin, flush=True)
        line = self._process.stdout.readline()
        if not line:
            raise SystemExit(f"{self._name} ended:\n{self._log.read_text()[-2000:]}")
        told = json.loads(line)
        answers = np.array(told["answers"]).reshape(-1, ROBOTS, 2)
        self.answers[kind] = np.swapaxes(answers, 1, 2)
        self.milliseconds[kind] += told["ms"]

    def end(self) -> None:
        """Let the process go."""
        self._process.communicate()


def each(states: tuple[np.ndarray, np.ndarray]) -> Iterable[tuple[np.ndarray, np.ndarray]]:
    """Return wish and positions of every state, run after run."""
    return zip(*(values.reshape(-1, 2, ROBOTS) for values in states), strict=True)


def judged(candidate: Ours | Rival, kind: str, states: tuple[np.ndarray, np.ndarray]) -> Figures:
    """Return what is told of the answers to one kind of states."""
    exact, broken, errors = certificate(candidate.limits), 0.0, []
    for (wish, at), answer in zip(each(states), candidate.answers[kind], strict=True):
        if np.isfinite(answer).all():
            best, info = exact(wish, at)
            assert info.rows is not None
            broken = max(broken, float(info.rows.excess(answer.T.ravel()).max()))
            errors.append(np.hypot(*(answer - best)).max())
    return Figures(
        float(np.median(candidate.milliseconds[kind])),
        1e3 * broken,
        1e3 * float(np.median(errors)),
        1e3 * float(np.max(errors)),
        1.0 - len(errors) / len(candidate.answers[kind]),
    )


def doubt(limits: VelocityPolygon, states: tuple[np.ndarray, np.ndarray]) -> float:
    """Return how far the conditions of optimality are from holding at the exact answers, m/s.

    What no row is broken by, and whose way to the wish is a sum of normals of rows that bind, with
    weights that are not negative, is the nearest point; whoever found it.
    """
    certify, worst = certificate(limits), 0.0
    for wish, at in each(states):
        velocity, info = certify(wish, at)
        assert info.rows is not None
        excess = info.rows.excess(velocity.T.ravel())
        normals = info.rows.dense(np.flatnonzero(excess > -1e-12))
        way = (wish - velocity).T.ravel()
        left = nnls(normals.T, way)[1] if len(normals) else float(np.linalg.norm(way))
        worst = max(worst, float(excess.max()), left)
    return worst


def asked_for(asked: argparse.Namespace) -> Iterable[tuple[str, Path]]:
    """Return each candidate whose environment is named."""
    for name in CANDIDATES:
        python = getattr(asked, name.partition("-")[0])
        if python is not None and (not asked.only or name in asked.only):
            yield name, python


def main() -> int:
    """Measure what is asked for; return 1 where the optimum is in doubt."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for library in ("cbfpy", "cbfkit", "cbfjax", "rps"):
        parser.add_argument(f"--{library}", type=Path, help="Python of its environment")
    parser.add_argument("--only", nargs="+", choices=CANDIDATES, help="these candidates alone")
    parser.add_argument("--runs", type=int, default=20, help="of each kind, of ten steps each")
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # and that of all others
    states = {kind: record(kind, asked.runs) for kind in KINDS}
    table = Table(width=56)
    for kind, recorded in states.items():
        for name, limits in (("box", BOX), ("octagon", OCTAGON)):
            worst = 1e3 * doubt(limits, recorded)
            table.bar(f"{kind}, {name}: conditions of the optimum", worst, "≤", 1e-5, "mm/s")
    candidates: dict[str, Ours | Rival] = {
        "this library, box": Ours(BOX, states),
        "this library, octagon": Ours(OCTAGON, states),
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "states.npz"
        arrays = {}
        for kind, recorded in states.items():
            for what, values in zip(("wishes", "at"), recorded, strict=True):
                arrays[f"{kind} {what}"] = np.swapaxes(values, 2, 3).reshape(len(values), STEPS, -1)
        np.savez(file, radius=RADIUS, gain=GAIN, speed=SPEED, size=2 * ROBOTS, **arrays)
        for name, python in asked_for(asked):
            candidates[name] = rival = Rival(name, python, file)
            print(f"{name}: {rival.version}", flush=True)
        order = list(candidates.values())
        for turn in range(asked.rounds):
            for kind in KINDS:
                for candidate in order[turn % len(order) :] + order[: turn % len(order)]:
                    candidate.round(kind)
        for candidate in order:
            if isinstance(candidate, Rival):
                candidate.end()
    print(f"{date.today()}, Python {sys.version.split()[0]}, numpy {np.__version__}")
    print(
        f"{'':<32}{'CPU ms':>10}{'broken mm/s':>14}{'error mm/s':>14}{'largest':>12}{'silent':>10}"
    )
    for kind, recorded in states.items():
        for name, candidate in candidates.items():
            print(f"{kind:<8}{name:<24}{judged(candidate, kind, recorded)}")
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
