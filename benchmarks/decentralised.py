"""What it costs that each robot certifies itself: the same teams, jointly and decentralised.

Random teams that are safe, and ones in which robots overlap: how far commands are moved, and how
often there is no safe velocity. Then ten robots that swap places across an ellipse and back: swaps
completed, unsafe steps, CPU time of a call. Exits 1 where a decentralised answer breaks the team's
rows by more than the tolerance, or a safe team becomes unsafe.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace

import numpy as np
from comparing import Table

from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA, STEP, AHEAD = (-1.6, 1.6, -1.0, 1.0), 0.033, 0.05
JOINT = SingleIntegratorCertificate(0.15, 500.0, boundary=ARENA, speed_limit=0.2)
WHEELS = UnicycleCertificate(
    0.21, 500.0, boundary=ARENA, speed_limit=0.15, turn_rate_limit=0.55, time_step=STEP
)
INFEASIBLE = ("relaxed", "failed")


def crowd(rng: np.random.Generator, robots: int, least: float) -> np.ndarray:
    """Return random positions (2, N), in a crowd, `least` apart."""
    side = 0.15 * np.sqrt(robots)
    while True:
        x = rng.uniform(-side, side, (2, robots))
        apart = np.hypot(*(x[:, :, None] - x[:, None, :])) + 9.0 * np.eye(robots)
        if apart.min() >= least:
            return x


def compare(table: Table, states: int, least: float, title: str) -> None:
    """Certify the same commands both ways, and print how far they were moved."""
    rng, robots = np.random.default_rng(0), 9
    moved: list[list[float]] = [[], []]
    changed, infeasible = np.zeros(2, dtype=int), np.zeros(2, dtype=int)
    only, worst = 0, 0.0
    apart = replace(JOINT, decentralised=True)
    for _ in range(states):
        x, command = crowd(rng, robots, least), rng.normal(0.0, 0.1, (2, robots))
        answers = [certificate(command, x) for certificate in (JOINT, apart)]
        failed = [info.status in INFEASIBLE for _, info in answers]
        infeasible += failed
        only += failed[1] and not failed[0]
        changed += [info.status != "trivial" for _, info in answers]
        if not failed[1]:
            worst = max(worst, answers[0][1].rows.excess(answers[1][0].T.reshape(-1)).max())
        if not any(failed):
            for k, (velocity, _) in enumerate(answers):
                moved[k].extend(np.hypot(*(velocity - command)))
    table.part(f"{title}: {states} teams of {robots}")
    for k, name in enumerate(("jointly", "decentralised")):
        mean, high = 1e3 * np.mean(moved[k]), 1e3 * np.quantile(moved[k], 0.95)
        print(
            f"  {name:<14} changes {100 * changed[k] / states:.1f} % of teams; moves a command by"
            f" {mean:.1f} mm/s on average, {high:.1f} in one of twenty;"
            f" no safe velocity in {100 * infeasible[k] / states:.1f} % of teams"
        )
    print(f"  decentralised alone finds none in {100 * only / states:.1f} %")
    table.bar("a decentralised answer on the team's rows", worst, "≤", 1e-9, "m/s")


def swap(certificate: UnicycleCertificate, steps: int) -> tuple[int, int, float]:
    """Swap ten unicycles across an ellipse; return swaps completed, unsafe steps, s a call."""
    angle = 2.0 * np.pi * np.arange(10) / 10 + 0.02 * np.random.default_rng(1).normal(size=10)
    poses = np.stack([1.3 * np.cos(angle), 0.8 * np.sin(angle), angle + np.pi])
    goals, swaps, unsafe, spent = -poses[:2], 0, 0, []
    for _ in range(steps):
        ahead = np.stack([np.cos(poses[2]), np.sin(poses[2])])
        way = goals - poses[:2] - AHEAD * ahead
        if np.hypot(*way).max() < 0.05:
            goals, swaps = -goals, swaps + 1
        desired = 0.15 * way / np.maximum(np.hypot(*way), 0.075)
        entered = time.process_time()
        velocity, info = certificate.project(desired, poses)
        spent.append(time.process_time() - entered)
        unsafe += info.smallest_h < 0.0
        v, w = certificate.commands(velocity, poses)
        half = 0.5 * STEP * w
        arc = STEP * v * np.sinc(half / np.pi)
        middle = poses[2] + half
        poses = poses + np.stack([arc * np.cos(middle), arc * np.sin(middle), STEP * w])
    return swaps, int(unsafe), float(np.median(spent))


def main() -> int:
    """Measure, print, and return 1 where something does not hold that has to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--states", type=int, default=1000, help="random teams of each kind")
    parser.add_argument("--steps", type=int, default=9000, help="of the swaps, 33 ms each")
    options, table = parser.parse_args(), Table()
    compare(table, options.states, 0.15, "safe teams, 0.15 m apart at least")
    compare(table, options.states, 0.10, "teams in which robots may overlap, 0.10 m at least")
    table.part(f"ten unicycles swapping across an ellipse, {options.steps * STEP:.0f} s")
    for name, decentralised in (("jointly", False), ("decentralised", True)):
        for tilt in (0.0, 0.3):
            certificate = replace(WHEELS, decentralised=decentralised, tilt=tilt)
            swaps, unsafe, call = swap(certificate, options.steps)
            print(f"  {name}, tilt {tilt:g}: {swaps} swaps, {1e3 * call:.2f} ms a call")
            table.bar(f"unsafe steps, {name}, tilt {tilt:g}", unsafe, "≤", 0)
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
