"""Sweeps: two processes against one, what the store costs, and how long a large one opens.

Prints required against measured; exits 1 where a bar is missed.  Throughput is the one
figure here taken in wall time: it needs a machine with two free processors.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from posflock_robotarium.sweep.execution import compute, execute, locally
from posflock_robotarium.sweep.store import Store
from posflock_robotarium.sweep.study import Study, parse_study

ROWS = 10_000


def study(replications: int) -> Study:
    return parse_study(
        {
            "experiment": "freespace",
            "replications": replications,
            "grid": {"model": ["velocity", "position"]},
        }
    )


def throughput(workers: int, folder: Path) -> float:
    """Return runs a second, without the start of the worker processes."""
    asked, times = study(32 * workers), []
    with Store(folder) as store:
        execute(asked, store, locally(workers), lambda done, _: times.append((time.time(), done)))
    (first, early), (last, late) = times[workers - 1], times[-1]
    return (late - early) / (last - first)


def store_overhead(folder: Path) -> float:
    """Return the store's share of the CPU and disk time of a study of short runs."""
    asked = study(32)
    runs = asked.runs()
    spent, started = 0.0, time.perf_counter()
    with Store(folder) as store:
        for at in range(0, len(runs), 8):
            rows = compute("freespace", runs[at : at + 8])
            entered = time.perf_counter()
            store.append(rows)
            spent += time.perf_counter() - entered
        entered = time.perf_counter()
    spent += time.perf_counter() - entered
    return spent / (time.perf_counter() - started)


def opening(folder: Path) -> float:
    """Return the seconds in which a store of many runs opens."""
    (row,) = compute("freespace", study(1).runs()[:1])
    with Store(folder) as store:
        for at in range(0, ROWS, 100):
            store.append([{**row, "key": f"{key:016x}"} for key in range(at, at + 100)])
    started = time.perf_counter()
    with Store(folder) as store:
        assert len(store.rows) == ROWS
    return time.perf_counter() - started


def main() -> int:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        rates = np.array([[throughput(w, here / f"{w}-{n}") for w in (1, 2)] for n in range(3)])
        gain = float(np.median(rates[:, 1] / rates[:, 0]))
        overhead = store_overhead(here / "overhead")
        opened = opening(here / "opening")
    one, two = np.median(rates, axis=0)
    print(f"one process   {one:6.2f} runs/s")
    print(f"two processes {two:6.2f} runs/s   {gain:5.2f} x   >= 1.8")
    print(f"store         {overhead:6.2%} of the time      <= 5 %")
    print(f"opening {ROWS} runs {opened:6.2f} s          <= 2 s")
    return 1 if gain < 1.8 or overhead > 0.05 or opened > 2.0 else 0


if __name__ == "__main__":
    sys.exit(main())
