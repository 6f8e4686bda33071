"""Long runs: memory, files and descriptors stay level, on both generations of the API.

- 900 s of 50 robots with plots, as many as a run has frames;
- a thousand Robotarium instances in one process;
- a hundred thousand steps of two robots.

Each runs by ``posflock run``, with its pose log, and is watched from outside. What counts is growth
from the first third of the run on, when everything that is loaded once has been loaded.

    python benchmarks/faults_long_runs.py [--share 1.0]
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from comparing import Table

ROOT = Path(__file__).parents[1]
#: MiB by which memory may grow in two thirds of a run, and open files.
MOST_GROWTH, MOST_FILES = 32.0, 3

_LOOP = """
for k in range({steps}):
    x = r.get_poses()
    r.set_velocities(np.arange({robots}), 0.02 * np.ones((2, {robots})))
    r.step()
r.{finish}()
"""
_HEAD = """
import numpy as np
from rps.robotarium import Robotarium
"""
PLOTS = (
    _HEAD
    + """
side = np.linspace(-1.2, 1.2, 10)
places = np.array([[a, b, 0.0] for a in side for b in np.linspace(-0.8, 0.8, 5)]).T
r = Robotarium(number_of_robots=50, show_figure=True, initial_conditions=places{options})
axes = getattr(r, "_axes_handle", None) or r.axes
line, = axes.plot([], [])
for k in range({steps}):
    x = r.get_poses()
    line.set_data(x[0], x[1])
    r.set_velocities(np.arange(50), 0.02 * np.ones((2, 50)))
    r.step()
r.{finish}()
"""
)
INSTANCES = (
    _HEAD
    + """
for k in range({steps}):
    r = Robotarium(number_of_robots=3, show_figure=False)
    for _ in range(3):
        r.get_poses()
        r.step()
    r.{finish}()
"""
)
STEPS = (
    _HEAD
    + """
r = Robotarium(number_of_robots={robots}, show_figure=False,
               initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]){options})
"""
    + _LOOP
)


@dataclass
class Watched:
    """What was seen of a process: seconds, MiB in memory, open files."""

    seen: list[tuple[float, float, int]] = field(default_factory=list)
    seconds: float = 0.0
    code: int = 0

    def growth(self, column: int) -> float:
        """Return how much one of them grew from the first third on: last third's most, less its."""
        begun, third = self.seen[0][0], (self.seen[-1][0] - self.seen[0][0]) / 3
        first = [row[column] for row in self.seen if third <= row[0] - begun < 2 * third]
        last = [row[column] for row in self.seen if row[0] - begun >= 2 * third]
        return max(last) - max(first) if first and last else float("inf")


def watch(script: str, generation: int) -> Watched:
    """Run a script by the command, in a folder of its own, and look at it ten times a second."""
    found, begun = Watched(), time.monotonic()
    with tempfile.TemporaryDirectory(prefix="long-") as place:
        (Path(place) / "main.py").write_text(script)
        words = ["run", "--headless", "--initial", "exact", "-o", "out"]
        words += ["--generation", str(generation)]
        process = subprocess.Popen(
            [sys.executable, "-m", "posflock_robotarium", *words, "main.py"],
            cwd=place,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
        while process.poll() is None:
            try:
                pages = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1])
                files = len(os.listdir(f"/proc/{process.pid}/fd"))
            except (OSError, IndexError):
                break
            now = time.monotonic() - begun
            found.seen.append((now, pages * os.sysconf("SC_PAGE_SIZE") / 2**20, files))
            time.sleep(0.1)
        found.code = process.wait()
    found.seconds = time.monotonic() - begun
    return found


def main() -> int:
    """Watch every long run, print, and return 1 where one grows."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--share", type=float, default=1.0, help="of the lengths")
    share = parser.parse_args().share
    table = Table()
    for generation, finish in ((1, "call_at_scripts_end"), (2, "debug")):
        options = ", skip_initialization=True" if generation == 2 else ""
        for name, script, steps in (
            ("900 s of 50 robots with plots", PLOTS, 27_273),
            ("1,000 instances", INSTANCES, 1000),
            ("100,000 steps", STEPS, 100_000),
        ):
            steps = max(30, int(share * steps))
            text = script.format(steps=steps, finish=finish, options=options, robots=2)
            found = watch(text, generation)
            print(f"generation {generation}, {name}: {steps} of them in {found.seconds:.0f} s")
            most = max(row[1] for row in found.seen)
            table.bar("  exit code", found.code, "≤", 0)
            table.bar("  growth", found.growth(1), "≤", MOST_GROWTH, "MiB", beside=f"{most:.0f}")
            table.bar("  further open files", found.growth(2), "≤", MOST_FILES)
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
