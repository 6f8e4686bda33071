"""Cost of an analysis: 900 s of 20 robots within time and memory, and linear in the run's length.

Every length is analysed in a process of its own, so that its peak of memory is its own; processes
alternate between lengths, and medians of CPU time are compared.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import numpy as np

LONGEST_SECONDS, ROBOTS, STEP = 900.0, 20, 0.033
MOST_CPU, MOST_MEMORY = 10.0, 500.0
MOST_GROWTH = 1.3
"""Cost per sample of the longest run over that of a quarter of it; 1 is linear."""

LENGTHS = (0.25, 0.5, 1.0)
REPEATS = 3

CHILD = """
import json, resource, sys, time
from posflock_robotarium.report import analyse
before = time.process_time()
analysis = analyse(sys.argv[1])
cpu = time.process_time() - before
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(json.dumps([cpu, peak, len(analysis.recording.t)]))
"""


def write_log(folder: Path, share: float) -> Path:
    """Write a pose log of wandering robots whose neighbours keep changing: the worst case."""
    from posflock_robotarium.poselog import row_type

    rng = np.random.default_rng(0)
    samples = round(share * LONGEST_SECONDS / STEP)
    rows = np.zeros(samples, dtype=row_type(ROBOTS))
    rows["t"] = STEP * np.arange(samples)
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
    cpu: dict[float, list[float]] = {share: [] for share in LENGTHS}
    memory: dict[float, float] = {}
    samples: dict[float, int] = {}
    with tempfile.TemporaryDirectory() as folder:
        logs = {share: write_log(Path(folder), share) for share in LENGTHS}
        for _ in range(REPEATS):
            for share, log in logs.items():
                done = subprocess.run(
                    [sys.executable, "-c", CHILD, str(log)],
                    check=True,
                    capture_output=True,
                    text=True,
                )
                seconds, peak, count = json.loads(done.stdout)
                cpu[share].append(seconds)
                memory[share] = max(memory.get(share, 0.0), peak)
                samples[share] = count
    for share in LENGTHS:
        print(
            f"{samples[share]:6d} samples of {ROBOTS} robots: {median(cpu[share]):5.2f} s CPU, "
            f"{memory[share]:4.0f} MB peak"
        )
    per_sample = {share: median(cpu[share]) / samples[share] for share in LENGTHS}
    growth = per_sample[1.0] / per_sample[LENGTHS[0]]
    checks = [
        ("CPU seconds", median(cpu[1.0]), MOST_CPU),
        ("MB", memory[1.0], MOST_MEMORY),
        ("cost per sample, 900 s over 225 s", growth, MOST_GROWTH),
    ]
    for what, measured, most in checks:
        print(f"{what}: {measured:.2f}, at most {most:g}{'' if measured <= most else '  MISSED'}")
    return 0 if all(measured <= most for _, measured, most in checks) else 1


if __name__ == "__main__":
    sys.exit(main())
