"""Calibration against known truth: fifty simulated testbeds, errors and coverage of intervals."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # also when run as a file
for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # before NumPy reads it

import numpy as np  # noqa: E402

from benchmarks.simulated_testbed import nominal, simulated_testbed  # noqa: E402
from posflock_robotarium.calibration import calibrate  # noqa: E402
from rps_compat.testbed import TIME_STEP  # noqa: E402

#: What the errors of a single fit may be; of lag and gains as a share.
BARS = {
    "dead_time": TIME_STEP,
    "lag": 0.20,
    "speed_gain": 0.02,
    "turn_gain": 0.02,
    "turn_bias": 0.005,
    "heading_offset": np.inf,
}
RELATIVE = ("lag", "speed_gain", "turn_gain")
COVERAGE = 0.95


class Scores:
    """Errors of estimates, and whether their intervals held the truth."""

    def __init__(self) -> None:
        self.errors: dict[str, list[float]] = {name: [] for name in BARS}
        self.held: dict[str, list[bool]] = {name: [] for name in BARS}
        self.missing = 0

    def add(self, found, truth) -> None:
        """Compare one calibration with what is true of its testbed."""
        for name in BARS:
            estimates, true = getattr(found, name), np.atleast_1d(getattr(truth, name))
            each = estimates if isinstance(estimates, tuple) else (estimates,)
            for estimate, value in zip(each, true, strict=True):
                if estimate is None:
                    self.missing += 1
                    continue
                error = estimate.value - value
                self.errors[name].append(error / value if name in RELATIVE else error)
                self.held[name].append(estimate.low <= value <= estimate.high)

    def missed(self) -> bool:
        """Print required against measured; True where a bar is missed."""
        missed = self.missing > 0
        print(f"{'':<16} {'largest error':>14} {'bar':>7} {'coverage':>9} {'bar':>5}")
        for name, bar in BARS.items():
            worst, share = np.abs(self.errors[name]).max(), float(np.mean(self.held[name]))
            bad = worst > bar or share < COVERAGE
            missed |= bad
            limit = f"{bar:7.3f}" if np.isfinite(bar) else "       "
            print(f"{name.replace('_', ' '):<16} {worst:14.5f} {limit} {share:9.3f} "
                  f"{COVERAGE:5.2f}" + ("  MISSED" if bad else ""))  # fmt: skip
        if self.missing:
            print(f"{self.missing} estimates left out  MISSED")
        return missed


def main(arguments: list[str] | None = None) -> int:
    """Print required against measured; 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fits", type=int, default=50)
    options = parser.parse_args(arguments)
    real, counted = Scores(), Scores()
    spent, steps = 0.0, []
    for seed in range(options.fits):
        log, truth = simulated_testbed(seed)
        steps.append(np.diff(log.t))
        began = time.process_time()
        real.add(calibrate(log), truth)
        spent += time.process_time() - began
        counted.add(calibrate(nominal(log)), truth)
    every = 1e3 * np.concatenate(steps)
    means = [1e3 * part.mean() for part in steps]
    print(
        f"{options.fits} fits, {spent / options.fits:.2f} s of CPU each; steps: median"
        f" {np.median(every):.1f} ms, mean of a run {min(means):.1f} to {max(means):.1f} ms,"
        f" longest {every.max():.0f} ms"
    )
    missed = real.missed()
    print("the same logs with nominal times, which is what most logs have:")
    for name in ("speed_gain", "turn_gain"):
        errors, held = counted.errors[name], float(np.mean(counted.held[name]))
        print(f"{name.replace('_', ' '):<16} {100 * min(errors):+.1f} to {100 * max(errors):+.1f}"
              f" %, mean {100 * np.mean(errors):+.1f} %; coverage {held:.3f}")  # fmt: skip
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
