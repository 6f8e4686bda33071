"""How fast the certificates are, against the program as it is commonly written.

The baseline assembles every row in a Python loop into dense matrices and gives all of them to
cvxopt at a tolerance of 1e-2.  All candidates certify the same recorded states, in turn at each
state, in one process with one BLAS thread; what counts is CPU time.  Teams swap places
(every robot heads through the middle of the field), or press together (every robot heads for the
middle of a packed field).  Prints required against measured, plots the growth with the number of
robots, and exits 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # before NumPy reads it

import numpy as np  # noqa: E402

from barrier_certificates import solvers  # noqa: E402
from barrier_certificates.single_integrator import SingleIntegratorCertificate  # noqa: E402

RADIUS, GAIN, SPEED, STEP = 0.15, 100.0, 0.2, 0.033
State = tuple[np.ndarray, np.ndarray]
Certify = Callable[[np.ndarray, np.ndarray], Any]


def baseline(boundary: tuple[float, float, float, float]) -> Certify:
    """Return the certificate as it is commonly written: every row in a loop, dense, 1e-2."""
    from cvxopt import matrix, sparse
    from cvxopt.solvers import qp

    options = {"show_progress": False, "reltol": 1e-2, "feastol": 1e-2, "maxiters": 50}
    x_min, x_max, y_min, y_max = boundary

    def certify(desired: np.ndarray, x: np.ndarray) -> np.ndarray:
        number = x.shape[1]
        rows = number * (number - 1) // 2 + 12 * number
        a, b = np.zeros((rows, 2 * number)), np.zeros(rows)
        count = 0
        for i in range(number - 1):
            for j in range(i + 1, number):
                error = x[:, i] - x[:, j]
                h = error[0] ** 2 + error[1] ** 2 - RADIUS**2
                a[count, [2 * i, 2 * i + 1]] = -2 * error
                a[count, [2 * j, 2 * j + 1]] = 2 * error
                b[count] = GAIN * h**3
                count += 1
        for i in range(number):
            for direction, coordinate, wall in (
                (1, 0, x_max), (-1, 0, x_min), (1, 1, y_max), (-1, 1, y_min),
            ):  # fmt: skip
                a[count, 2 * i + coordinate] = direction
                gap = direction * (wall - x[coordinate, i]) - RADIUS / 2
                b[count] = 0.4 * GAIN * gap**3
                count += 1
            for k in range(8):
                a[count, 2 * i] = np.cos(k * np.pi / 4)
                a[count, 2 * i + 1] = np.sin(k * np.pi / 4)
                b[count] = SPEED * np.cos(np.pi / 8)
                count += 1
        wish = desired.reshape((2 * number, 1), order="F")
        result = qp(
            sparse(matrix(2 * np.eye(2 * number))), matrix(-2 * wish), matrix(a), matrix(b),
            options=options,
        )["x"]  # fmt: skip
        return np.reshape(result, (2, number), order="F")

    return certify


def ours(boundary: tuple[float, float, float, float], solver: str = "auto") -> Certify:
    """Return this package's certificate with the same rows."""
    return SingleIntegratorCertificate(RADIUS, GAIN, boundary=boundary, solver=solver)


def field(number: int, spacing: float, seed: int) -> np.ndarray:
    """Return positions on a shaken grid, no two closer than the safety radius."""
    rng = np.random.default_rng(seed)
    across = int(np.ceil(np.sqrt(number)))
    grid = np.array(np.meshgrid(np.arange(across), np.arange(across))).reshape(2, -1)[:, :number]
    shake = min(0.12 * spacing, 0.5 * (spacing - 1.01 * RADIUS))
    return spacing * (grid - 0.5 * (across - 1)) + rng.uniform(-shake, shake, (2, number)) / 1.5


def record(number: int, kind: str, count: int) -> tuple[list[State], tuple[float, ...]]:
    """Return commands and positions along a certified run, and the arena it took place in."""
    positions = field(number, 0.35 if kind == "swap" else 1.08 * RADIUS, seed=number)
    half = float(np.abs(positions).max()) + 0.15
    boundary = (-half, half, -half, half)
    certificate = ours(boundary)
    goals = -positions if kind == "swap" else 0.5 * positions
    states = []
    for _ in range(count):
        way = goals - positions
        desired = way * (SPEED / np.maximum(np.hypot(*way), SPEED))
        states.append((desired, positions))
        velocity, info = certificate(desired, positions)
        assert info.status in ("trivial", "optimal"), info
        positions = positions + STEP * velocity
    return states, boundary


def times(
    states: list[State], candidates: dict[str, Callable[[], Certify]], passes: int = 3
) -> dict[str, np.ndarray]:
    """Return milliseconds of CPU time at each state.

    Candidates take turns at each state, and a different one goes first each time, since the first
    finds the processor's caches cold.  Each state counts with its least of three passes: what else
    the machine does is not the candidates' doing.
    """
    names = list(candidates)
    cost = {name: np.full((passes, len(states)), np.nan) for name in names}
    for run in range(passes):
        certify = {name: make() for name, make in candidates.items()}
        for number, (desired, positions) in enumerate(states):
            for turn in range(len(names)):
                name = names[(number + turn) % len(names)]
                before = time.process_time_ns()
                certify[name](desired, positions)
                cost[name][run, number] = 1e-6 * (time.process_time_ns() - before)
    return {name: values.min(axis=0)[1:] for name, values in cost.items()}


class Report:
    """Lines of measured against required."""

    def __init__(self) -> None:
        self.missed = 0

    def bar(self, what: str, measured: float, sign: str, required: float, unit: str) -> None:
        """Print one requirement; `sign` is ≥ or ≤."""
        holds = measured >= required if sign == "≥" else measured <= required
        self.missed += not holds
        verdict = "ok" if holds else "MISSED"
        print(f"  {what:<44}{measured:>9.3g} {unit:<3} {sign} {required:<6g}{verdict}")


def main() -> int:
    """Measure, print, plot; return 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the states")
    parser.add_argument("-o", "--out", type=Path, default=Path("results"), help="folder for plot")
    arguments = parser.parse_args()
    share = 0.1 if arguments.quick else 1.0
    report = Report()
    growth: dict[str, dict[int, float]] = {}
    print(f"{'CPU ms per call':<18}{'':<18}{'p50':>9}{'p99':>9}")

    def measure(number: int, kind: str, count: int, names: list[str]) -> dict[str, float]:
        states, boundary = record(number, kind, max(12, int(share * count)))
        candidates = {
            name: partial(baseline, boundary)
            if name == "baseline"
            else partial(ours, boundary, name)
            for name in names
        }
        medians = {}
        for name, cost in times(states, candidates).items():
            median, worst = np.percentile(cost, (50, 99))
            print(f"N = {number:<5}{kind:<9}{name:<18}{median:>9.3f}{worst:>9.3f}")
            medians[name] = float(median)
            growth.setdefault(f"{name}, {kind}", {})[number] = float(median)
        return medians

    small = ["baseline", "auto", *(name for name in ("nnls", "daqp") if solvers.installed(name))]
    nine = measure(9, "swap", 600, small)
    twenty = measure(20, "swap", 400, small)
    fifty = measure(50, "swap", 80, small)
    packed = {n: measure(n, "packed", c, small) for n, c in ((9, 300), (20, 150), (50, 50))}
    large = {
        (n, kind): measure(n, kind, count, ["auto"])["auto"]
        for n, count in ((100, 80), (300, 60), (1000, 40))
        for kind in ("swap", "packed")
    }

    print("required")
    report.bar("times faster than the baseline, N = 9", nine["baseline"] / nine["auto"], "≥", 8, "")
    report.bar("N = 20", twenty["baseline"] / twenty["auto"], "≥", 12, "")
    report.bar("N = 50, swap", fifty["baseline"] / fifty["auto"], "≥", 35, "")
    report.bar("N = 50, packed", packed[50]["baseline"] / packed[50]["auto"], "≥", 10, "")
    if solvers.installed("daqp"):
        report.bar("N = 9, with daqp installed", nine["auto"], "≤", 0.12, "ms")
    report.bar("N = 300, swap", large[300, "swap"], "≤", 30, "ms")
    report.bar("N = 1000, swap", large[1000, "swap"], "≤", 90, "ms")
    plot(growth, arguments.out / "barrier-speed.png")
    print(f"growth with the number of robots: {arguments.out / 'barrier-speed.png'}")
    return int(report.missed > 0)


def plot(growth: dict[str, dict[int, float]], path: Path) -> None:
    """Draw median CPU time against the number of robots."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown = {
        "baseline": ("dense cvxopt, all rows, 1e-2", "0.45"),
        "nnls": ("lazy rows, nnls alone", "tab:orange"),
        "auto": ("this package", "tab:blue"),
    }
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    for name, (label, colour) in shown.items():
        for kind, style in (("swap", "o-"), ("packed", "s--")):
            line = growth.get(f"{name}, {kind}", {})
            axes.loglog(line.keys(), line.values(), style, color=colour, label=f"{label}, {kind}")
    axes.axhline(33, color="tab:red", linewidth=0.8)
    axes.text(9, 36, "one step of the testbed, 33 ms", color="tab:red", fontsize=8)
    ticks = sorted({n for line in growth.values() for n in line})
    axes.set_xticks(ticks, [str(n) for n in ticks])
    axes.minorticks_off()
    axes.set(xlabel="robots", ylabel="CPU time per step (ms, median)")
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8, frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    sys.exit(main())
