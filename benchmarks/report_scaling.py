"""Cost of an analysis: 900 s of 20 robots against plain numpy, within memory, linear in length.

What is judged are ratios of CPU time: the whole analysis of the longest run against the least that
says whether a flock aligned, in plain numpy and scipy: read the log, smooth velocities, and for
every sample all pairs' distances, neighbours and γ; and the cost per sample of the longest run
against a quarter of it. Every analysis has a process of its own, so that its peak of memory is its
own; they take turns. Memory is judged as it is.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from comparing import Table, Times
from history import recorded

LONGEST_SECONDS, ROBOTS, STEP = 900.0, 20, 0.033
LENGTHS = (0.25, 0.5, 1.0)
#: Most of the reference's time, and MB.
MOST_ANALYSIS, MOST_MEMORY = 10.0, 500.0
#: Cost per sample of the longest run over that of a quarter of it; 1 is linear.
MOST_GROWTH = 1.3

ANALYSIS = """
import json, resource, sys, time
from posflock_robotarium.report import analyse
before = time.process_time()
analysis = analyse(sys.argv[1])
cpu = time.process_time() - before
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(json.dumps([cpu, peak, len(analysis.recording.t)]))
"""
PLAIN = """
import json, sys, time
import numpy as np
from scipy.signal import savgol_filter
before = time.process_time()
rows = np.load(sys.argv[1])
p = rows["pose"][:, :2]
v = savgol_filter(p, 11, polyorder=2, deriv=1, delta=0.033, axis=0)
e = v / np.linalg.norm(v, axis=1, keepdims=True)
gamma, nearest = [], []
for at in range(0, len(p), 500):
    q, d = p[at : at + 500], e[at : at + 500]
    distance = np.linalg.norm(q[:, :, :, None] - q[:, :, None, :], axis=1)
    distance[:, range(20), range(20)] = np.inf
    near = distance < 0.75
    cosines = (d[:, :, :, None] * d[:, :, None, :]).sum(axis=1)
    gamma.append(((near * cosines).sum(axis=2) / np.maximum(near.sum(axis=2), 1)).mean(axis=1))
    nearest.append(distance.min(axis=2).mean(axis=1))
assert np.isfinite(np.concatenate(gamma)).all()
print(json.dumps([time.process_time() - before, 0.0, len(p)]))
"""


def write_log(folder: Path, share: float) -> Path:
    """Write a pose log of wandering robots whose neighbours keep changing: the worst case."""
    from posflock_robotarium.flocking.pose_log import row_type

    rng = np.random.default_rng(0)
    samples = round(share * LONGEST_SECONDS / STEP)
    rows = np.zeros(samples, dtype=row_type(ROBOTS))
    rows["t"] = STEP * np.arange(samples)
    rows["real_time"] = np.cumsum(STEP + 0.001 * rng.random(samples))
    heading = rng.uniform(-np.pi, np.pi, ROBOTS) + np.cumsum(
        0.05 * rng.standard_normal((samples, ROBOTS)), axis=0
    )
    velocity = 0.1 * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    places = rng.uniform(-1, 1, (2, ROBOTS)) + np.cumsum(velocity * STEP, axis=0)
    # Reflected at the walls, as if they turned there.
    for axis, half in ((0, 1.55), (1, 0.95)):
        folded = np.remainder(places[:, axis] + half, 4 * half)
        places[:, axis] = np.minimum(folded, 4 * half - folded) - half
    rows["pose"] = np.concatenate([places, heading[:, np.newaxis]], axis=1)
    rows["pose"] += 0.0005 * rng.standard_normal(rows["pose"].shape)
    rows["command"][:, 0] = 0.1
    rows["status"] = "optimal"
    path = folder / f"log-{share}.npy"
    np.save(path, rows)
    path.with_suffix(".json").write_text(json.dumps({"neighbour_radius": 0.75}))
    return path


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    told: dict[str, tuple[float, int]] = {}

    def child(name: str, program: str, log: Path) -> float:
        done = subprocess.run(
            [sys.executable, "-c", program, str(log)], check=True, capture_output=True, text=True
        )
        cpu, peak, samples = json.loads(done.stdout)
        told[name] = max(peak, told.get(name, (0.0, 0))[0]), samples
        return float(cpu)

    with tempfile.TemporaryDirectory() as folder:
        logs = {share: write_log(Path(folder), share) for share in LENGTHS}
        candidates = {
            f"{share:g}": partial(child, f"{share:g}", ANALYSIS, log) for share, log in logs.items()
        }
        candidates["plain"] = partial(child, "plain", PLAIN, logs[1.0])
        times = Times(candidates, rounds=3)
    longest, shortest = "1", f"{LENGTHS[0]:g}"
    for name in candidates:
        memory, samples = told[name]
        print(
            f"{name:>6}: {samples:6d} samples of {ROBOTS} robots, {times.median(name):5.2f} s CPU"
            + (f", {memory:4.0f} MB peak" if memory else "")
        )
    table = Table(44)
    table.ratio("analysis of 900 s, against plain numpy", times, longest, "plain", MOST_ANALYSIS)
    table.bar("memory", told[longest][0], "≤", MOST_MEMORY, "MB")
    growth = times.ratio(longest, shortest) * told[shortest][1] / told[longest][1]
    table.bar("cost per sample, 900 s over 225 s", growth, "≤", MOST_GROWTH, "×")
    return recorded("report_scaling", table)


if __name__ == "__main__":
    sys.exit(main())
