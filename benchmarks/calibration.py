"""Calibration against known truth: fifty simulated testbeds, errors and coverage of intervals."""

from __future__ import annotations

import argparse
import os
import sys
import time

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # before NumPy reads it

import numpy as np  # noqa: E402

from posflock_robotarium.calibration import calibrate  # noqa: E402
from posflock_robotarium.logs.run import Run  # noqa: E402
from rps_compat.arena import Arena  # noqa: E402
from rps_compat.distributions import DistributionKind, RobotDistribution, constant  # noqa: E402
from rps_compat.realism import (  # noqa: E402
    DeadTime,
    Disturbance,
    Gains,
    HeadingOffset,
    Lag,
    Profile,
    TrackingJitter,
    TurnBias,
)

STEP = 0.033
#: What the errors of a single fit may be.
BARS = {"dead time": STEP, "lag": 0.20, "speed gain": 0.02, "turn gain": 0.02, "turn bias": 0.005}
COVERAGE = 0.90


def simulated_testbed(
    seed: int, robots: int = 4, rows: int = 1500
) -> tuple[Run, dict[str, np.ndarray]]:
    """Simulate robots with random imperfections under random commands of one to two seconds."""
    rng = np.random.default_rng([seed, 1])
    truth = {
        "dead time": rng.uniform(0.1, 0.3, 1),
        "lag": rng.uniform(0.08, 0.25, 1),
        "speed gain": rng.uniform(0.9, 1.1, robots),
        "turn gain": rng.uniform(0.9, 1.1, robots),
        "turn bias": rng.normal(0.0, 0.012, robots),
        "heading offset": rng.uniform(-0.03, 0.03, robots),
    }

    def each(name: str) -> RobotDistribution:
        return RobotDistribution(DistributionKind.ROBOTS, tuple(truth[name]))

    profile = Profile(
        dead_time=DeadTime(constant(float(truth["dead time"][0]))),
        lag=Lag(constant(float(truth["lag"][0]))),
        gains=Gains(each("speed gain"), each("turn gain")),
        turn_bias=TurnBias(each("turn bias")),
        disturbance=Disturbance(0.0017, 0.0175),
        heading_offset=HeadingOffset(each("heading offset")),
        tracking_jitter=TrackingJitter(0.0005, 0.0003, 0.0013),
    )
    commands = np.zeros((rows, 2, robots))
    for robot in range(robots):
        row = 0
        while row < rows:
            length = int(rng.integers(20, 60))
            speeds = rng.uniform(-0.12, 0.15), rng.uniform(-1.0, 1.0)
            commands[row : row + length, :, robot] = speeds
            row += length
    arena = Arena(np.zeros((3, robots)), realism=profile.start(), rng=np.random.default_rng(seed))
    poses = np.empty((rows, 3, robots))
    for k in range(rows):
        poses[k] = arena.observe()
        arena.commands = commands[k].copy()
        arena.step()
    return Run("calibration", np.arange(rows) * STEP, poses, commands), truth


def main(arguments: list[str] | None = None) -> int:
    """Print required against measured; 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fits", type=int, default=50)
    options = parser.parse_args(arguments)
    errors: dict[str, list[float]] = {}
    covered: dict[str, list[bool]] = {}
    began = time.process_time()
    for seed in range(options.fits):
        log, truth = simulated_testbed(seed)
        found = calibrate(log)
        estimates = {
            "dead time": (found.dead_time,),
            "lag": (found.lag,),
            "speed gain": found.speed_gain,
            "turn gain": found.turn_gain,
            "turn bias": found.turn_bias,
            "heading offset": found.heading_offset,
        }
        for name, values in estimates.items():
            for estimate, true in zip(values, truth[name], strict=True):
                relative = name in ("lag", "speed gain", "turn gain")
                error = abs(estimate.value - true) / (true if relative else 1.0)
                errors.setdefault(name, []).append(error)
                covered.setdefault(name, []).append(estimate.low <= true <= estimate.high)
    missed = False
    print(f"{options.fits} fits, {(time.process_time() - began) / options.fits:.2f} s of CPU each")
    print(f"{'':<16} {'largest error':>14} {'bar':>7} {'coverage':>9} {'bar':>5}")
    for name, found_errors in errors.items():
        worst, share = max(found_errors), float(np.mean(covered[name]))
        bar = BARS.get(name, np.inf)
        bad = worst > bar or share < COVERAGE
        missed |= bad
        limit = f"{bar:7.3f}" if np.isfinite(bar) else "       "
        print(f"{name:<16} {worst:14.5f} {limit} {share:9.3f} {COVERAGE:5.2f}"
              + ("  MISSED" if bad else ""))  # fmt: skip
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
