"""What benchmarks measured over time: a row a run, and a picture of all rows.

    make bench-nine RECORD=1      # measures, and adds a row to history/nine_robots.jsonl
    make bench-plot               # draws every history into results/

A row has the commit, the date, the versions, every figure with its bar, and the machine as eight
digits that tell one from another and nobody which. Figures are ratios where they judge
(`comparing`), so that rows of several machines can stand in one picture.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import platform
import subprocess
import sys
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from importlib.metadata import version
from itertools import cycle
from pathlib import Path
from typing import Any

from comparing import Table

from rps_compat.whole_files import write_whole

ROOT = Path(__file__).resolve().parents[1]
HISTORY = ROOT / "benchmarks" / "history"
#: Set to anything to add rows: who only looks leaves the files alone.
VARIABLE = "BENCH_RECORD"
Row = dict[str, Any]


def recorded(name: str, table: Table, folder: Path = HISTORY) -> int:
    """Add a table to the history of a benchmark, where that is asked for; return its exit code.

    Parameters
    ----------
    name : str
        Of the benchmark: its file's.
    table : Table
        What it measured, finished.
    folder : Path
        Where histories lie.
    """
    if os.environ.get(VARIABLE):
        append(folder / f"{name}.jsonl", row_of(table))
    return table.exit_code()


def row_of(table: Table) -> Row:
    """Return what is kept of one run of a benchmark."""
    return {
        "commit": _commit(),
        "date": datetime.now(timezone.utc).strftime("%Y-%m-%d"),
        "version": version("posflock-robotarium"),
        "machine": machine(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "figures": {
            bar.what: float(f"{bar.measured:.6g}")
            for bar in table.bars
            if math.isfinite(bar.measured)
        },
        "bars": {
            bar.what: f"{bar.sense} {bar.required:g} {bar.unit}".strip() for bar in table.bars
        },
    }


def machine() -> str:
    """Return eight digits that are the same on one kind of machine."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    model = next((line for line in lines if line.startswith("model name")), platform.processor())
    told = f"{platform.system()} {platform.machine()} {os.cpu_count()} {model}"
    return hashlib.sha256(told.encode()).hexdigest()[:8]


def _commit() -> str:
    """Return the commit, with a + where the tree is not as committed; empty without git."""
    told = subprocess.run(
        ["git", "describe", "--always", "--dirty=+", "--exclude=*"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return told.stdout.strip()


def append(path: Path, row: Row) -> None:
    """Add a row to a file of rows, which is whole at every moment."""
    path.parent.mkdir(parents=True, exist_ok=True)
    before = path.read_text(encoding="utf-8") if path.exists() else ""
    write_whole(path, before + json.dumps(row, ensure_ascii=False) + "\n")


def read(path: Path) -> list[Row]:
    """Return the rows of a file, the oldest first."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def draw(name: str, rows: Sequence[Row], out: Path) -> Path:
    """Draw every figure of a benchmark over its runs, with its bar; return the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys(what for row in rows for what in row["figures"]))
    across = min(3, len(names))
    down = math.ceil(len(names) / across)
    figure, axes = plt.subplots(
        down, across, figsize=(4.2 * across, 2.2 * down + 0.6), squeeze=False, layout="constrained"
    )
    for panel in axes.flat[len(names) :]:
        panel.set_axis_off()
    machines = list(dict.fromkeys(row["machine"] for row in rows))
    for what, panel in zip(names, axes.flat, strict=False):
        _panel(panel, what, rows, machines)
    figure.suptitle(f"{name} — runs: {len(rows)}, kinds of machine: {len(machines)}")
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"history-{name}.png"
    figure.savefig(path, dpi=130)
    plt.close(figure)
    return path


def _panel(panel: Any, what: str, rows: Sequence[Row], machines: Sequence[str]) -> None:
    for kind, marker in zip(machines, cycle("os^Dv")):
        here = {k: row["figures"].get(what) for k, row in enumerate(rows) if row["machine"] == kind}
        measured = {k: value for k, value in here.items() if value is not None}
        panel.plot(list(measured), list(measured.values()), f"{marker}-", markersize=4, label=kind)
    bar = next(row["bars"][what] for row in reversed(rows) if what in row["bars"])
    limit = float(bar.split()[1])
    panel.axhline(limit, color="black", linestyle=(0, (4, 2)), linewidth=0.8)
    panel.set_title(f"{what}  ({bar})", fontsize=7)
    panel.set_xticks(range(len(rows)), [_tick(row) for row in rows], fontsize=6, rotation=30)
    panel.tick_params(axis="y", labelsize=7)
    panel.margins(x=0.1, y=0.2)


def _tick(row: Mapping[str, Any]) -> str:
    return f"{row['date']}\n{row['commit']}"


def main() -> int:
    """Draw the histories that there are, and say where."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=ROOT / "results", help="folder")
    out = parser.parse_args().out
    for path in sorted(HISTORY.glob("*.jsonl")):
        print(draw(path.stem, read(path), out))
    return 0


if __name__ == "__main__":
    sys.exit(main())
