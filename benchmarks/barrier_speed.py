"""How fast the certificates are, against the program as it is commonly written.

What is judged are ratios of CPU time. References are the dense program with every row, written in a
Python loop and given to cvxopt at a tolerance of 1e-2 (`references.dense_certificate`);
and for teams that it cannot take, what an expert writes: pairs within reach from a k-d tree, their
rows assembled by numpy as a sparse matrix, OSQP warm-started to 1e-6
(`references.sparse_certificate`). All candidates certify the same recorded states, in turn at each
state, in one process with one BLAS thread. Teams swap places (every robot heads through the middle
of the field), or press together (every robot heads for the middle of a packed field). The smallest
team is also measured in turns with what a compiled solver alone takes: daqp's call, in C, with all
rows given and made ready beforehand. Prints measured against required, plots the growth with the
number of robots, and exits 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from comparing import Table
from history import recorded
from references import GAIN, RADIUS, SPEED, Certify, dense_certificate, sparse_certificate

from barrier_certificates import solvers
from barrier_certificates.rows import RowBook, Scene
from barrier_certificates.single_integrator import SingleIntegratorCertificate

STEP = 0.033  # the testbed's, s
State = tuple[np.ndarray, np.ndarray]


def ours(boundary: tuple[float, float, float, float], solver: str = "auto") -> Certify:
    """Return this package's certificate with the same rows."""
    return SingleIntegratorCertificate(RADIUS, GAIN, boundary=boundary, solver=solver)


def bare(boundary: tuple[float, float, float, float], states: list[State]) -> Certify:
    """Return daqp's call alone: the programs of the states are ready, and are taken in order."""
    import daqp

    families = ours(boundary).row_families()
    book = RowBook([families.limits, families.walls], families.pairs)
    programs = []
    for desired, positions in states:
        rows, _ = book.write(Scene(positions))
        size, count = rows.size, len(rows)
        bounds = rows.bound.copy(), np.full(count, -1e30), np.zeros(count, dtype=np.intc)
        matrix = rows.dense(np.arange(count))
        programs.append((np.eye(size), -desired.T.reshape(-1), matrix, *bounds))
    following = iter(programs)
    return lambda desired, positions: daqp.solve(*next(following), primal_tol=1e-11, dual_tol=1e-12)


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


def beside_a_bare_call(number: int, count: int) -> tuple[float, float]:
    """Return median milliseconds of a certificate's call, and of daqp's alone, in turns."""
    states, boundary = record(number, "swap", count)
    candidates = {"ours": partial(ours, boundary), "bare": partial(bare, boundary, states)}
    cost = times(states, candidates)
    return float(np.median(cost["ours"])), float(np.median(cost["bare"]))


def main() -> int:
    """Measure, print, plot; return 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the states")
    parser.add_argument("-o", "--out", type=Path, default=Path("results"), help="folder for plot")
    arguments = parser.parse_args()
    share = 0.1 if arguments.quick else 1.0
    table = Table(44)
    growth: dict[str, dict[int, float]] = {}
    print(f"{'CPU ms per call':<18}{'':<18}{'p50':>9}{'p99':>9}")

    def measure(number: int, kind: str, count: int, names: list[str]) -> dict[str, float]:
        states, boundary = record(number, kind, max(12, int(share * count)))
        references = {"dense": dense_certificate, "sparse": sparse_certificate}
        candidates = {
            name: partial(references[name], boundary)
            if name in references
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

    small = ["dense", "auto", *(name for name in ("nnls", "daqp") if solvers.installed(name))]
    nine = measure(9, "swap", 600, small)
    twenty = measure(20, "swap", 400, small)
    fifty = measure(50, "swap", 80, small)
    packed = {n: measure(n, "packed", c, small) for n, c in ((9, 300), (20, 150), (50, 50))}
    large = {
        (n, kind): measure(n, kind, count, ["sparse", "auto"] if kind == "swap" else ["auto"])
        for n, count in ((100, 80), (300, 60), (1000, 40))
        for kind in ("swap", "packed")
    }

    print("required")
    for what, medians, reference, least in (
        ("N = 9", nine, "dense", 8),
        ("N = 20", twenty, "dense", 12),
        ("N = 50, swap", fifty, "dense", 35),
        ("N = 50, packed", packed[50], "dense", 10),
        ("N = 300, swap", large[300, "swap"], "sparse", 1),
        ("N = 1000, swap", large[1000, "swap"], "sparse", 1),
    ):
        beside = f"{medians['auto']:.3g} ms against {medians[reference]:.3g} ms"
        gain = medians[reference] / medians["auto"]
        table.bar(f"times faster than the {reference}, {what}", gain, "≥", least, beside=beside)
    if solvers.installed("daqp"):
        mine, its = beside_a_bare_call(9, max(12, int(share * 600)))
        beside = f"{mine:.3g} ms against {its:.3g} ms"
        table.bar("times daqp's call alone, N = 9", mine / its, "≤", 2, beside=beside)
    part, whole = large[1000, "packed"]["auto"], 1e3 * STEP
    beside = f"{part:.3g} ms of {whole:.0f} ms"
    table.bar("of the testbed's step, N = 1000, packed", part / whole, "≤", 1, beside=beside)
    plot(growth, arguments.out / "barrier-speed.png")
    print(f"growth with the number of robots: {arguments.out / 'barrier-speed.png'}")
    return recorded("barrier_speed", table)


def plot(growth: dict[str, dict[int, float]], path: Path) -> None:
    """Draw median CPU time against the number of robots."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown = {
        "dense": ("dense cvxopt, all rows, 1e-2", "0.45"),
        "sparse": ("sparse OSQP, near pairs", "tab:green"),
        "nnls": ("lazy rows, nnls alone", "tab:orange"),
        "auto": ("this package", "tab:blue"),
    }
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    for name, (label, colour) in shown.items():
        for kind, style in (("swap", "o-"), ("packed", "s--")):
            if line := growth.get(f"{name}, {kind}"):
                words = f"{label}, {kind}"
                axes.loglog(line.keys(), line.values(), style, color=colour, label=words)
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
