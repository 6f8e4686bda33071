"""Sweeps: two processes against one, what the store costs, and how long a large one opens.

What is judged are ratios: runs a second of two processes against one, and the store's share of the
time of a study (both by the wall clock, the first on two free processors); and opening a large
store against reading its lines with `json.loads` and no more, in CPU time. Exits 1 where a bar is
missed.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
from comparing import Table, Times, cpu

from posflock_robotarium.sweep.execution import compute, execute, locally
from posflock_robotarium.sweep.store import Store
from posflock_robotarium.sweep.study import Study, parse_study

ROWS = 10_000
LEAST_GAIN, MOST_STORE, MOST_OPENING = 1.8, 0.05, 3.0


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


def fill(folder: Path) -> None:
    """Make a store of many runs."""
    (row,) = compute("freespace", study(1).runs()[:1])
    with Store(folder) as store:
        for at in range(0, ROWS, 100):
            store.append([{**row, "key": f"{key:016x}"} for key in range(at, at + 100)])


def open_store(folder: Path) -> None:
    """Open it, as a sweep that goes on does."""
    with Store(folder) as store:
        assert len(store.rows) == ROWS


def read_lines(folder: Path) -> None:
    """Read its lines, and no more."""
    segments = sorted(folder.glob("rows-*.jsonl"))
    rows = [json.loads(line) for segment in segments for line in segment.open()]
    assert len(rows) == ROWS


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    table = Table()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        rates = np.array([[throughput(w, here / f"{w}-{n}") for w in (1, 2)] for n in range(3)])
        gain = float(np.median(rates[:, 1] / rates[:, 0]))
        overhead = store_overhead(here / "overhead")
        fill(here / "many")
        times = Times(
            {
                "opening": lambda: cpu(partial(open_store, here / "many")),
                "lines": lambda: cpu(partial(read_lines, here / "many")),
            }
        )
    one, two = np.median(rates, axis=0)
    beside = f"{one:.2f} and {two:.2f} runs/s"
    table.bar("two processes against one", gain, "≥", LEAST_GAIN, "×", beside=beside)
    table.bar("share of the time that the store takes", overhead, "≤", MOST_STORE)
    what = f"opening {ROWS} runs, against reading their lines"
    table.ratio(what, times, "opening", "lines", MOST_OPENING)
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
