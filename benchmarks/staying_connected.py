"""What it costs a team to stay connected, by which links are kept.

Nine robots drive to places drawn at random, new ones every ten seconds, with and without rows of
links. How often the team is connected, how far it gets, how often the tree changes, CPU time of a
call. Exits 1 where a team that has such rows is not connected at some step, is unsafe, or finds no
safe velocity, or where one without them never falls apart.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass, field, replace

import numpy as np
from comparing import Table
from scipy.sparse.csgraph import connected_components

from barrier_certificates.certificate import Certificate
from barrier_certificates.projection import ProjectionInfo
from barrier_certificates.rows import ConnectivityParameters
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA, STEP, AHEAD, RANGE, ROBOTS = (-1.6, 1.6, -1.0, 1.0), 0.033, 0.05, 0.6, 9
POINTS = SingleIntegratorCertificate(0.15, 500.0, boundary=ARENA, speed_limit=0.2)
WHEELS = UnicycleCertificate(
    0.2, 500.0, boundary=ARENA, speed_limit=0.2, turn_rate_limit=3.6, time_step=STEP
)
LINKS = ConnectivityParameters(RANGE, gain=2000.0, time_step=STEP)
WAYS: dict[str, tuple[ConnectivityParameters | None, bool]] = {
    "no links": (None, False),
    "tree": (LINKS, False),
    "tree, no hysteresis": (replace(LINKS, hysteresis=0.0), False),
    "the first tree": (replace(LINKS, hysteresis=1.0), False),
    "all of the first call": (replace(LINKS, links="all"), False),
    "tree, each by itself": (LINKS, True),
}


@dataclass
class Driven:
    """What became of a team."""

    apart: int = 0
    hopeless: int = 0
    clearance: float = np.inf
    switches: int = 0
    left: list[float] = field(default_factory=list)
    spent: list[float] = field(default_factory=list)


def moved(poses: np.ndarray, certificate: Certificate, velocity: np.ndarray) -> np.ndarray:
    """Return the poses after a step, unicycles' on arcs."""
    if not isinstance(certificate, UnicycleCertificate):
        return poses + STEP * np.vstack([velocity, np.zeros(ROBOTS)])
    v, w = certificate.commands(velocity, poses)
    half = 0.5 * STEP * w
    arc, middle = STEP * v * np.sinc(half / np.pi), poses[2] + half
    return poses + np.stack([arc * np.cos(middle), arc * np.sin(middle), STEP * w])


def kept(info: ProjectionInfo) -> frozenset[str]:
    """Return the names of the links that rows are about."""
    assert info.rows is not None
    return frozenset(
        name for name in map(info.rows.label, range(len(info.rows))) if name.endswith("in range")
    )


def drive(certificate: Certificate, steps: int, seed: int, driven: Driven) -> None:
    """Drive one team from place to place."""
    rng = np.random.default_rng(seed)
    grid = np.array(np.meshgrid(np.arange(3), np.arange(3))).reshape(2, -1)
    poses = np.vstack([0.35 * (grid - 1.0), rng.uniform(-np.pi, np.pi, (1, ROBOTS))])
    links: frozenset[str] | None = None
    for step in range(steps):
        if step % round(10.0 / STEP) == 0:
            places = rng.uniform([[-1.5], [-0.9]], [[1.5], [0.9]], (2, ROBOTS))
        points = poses[:2]
        if isinstance(certificate, UnicycleCertificate):
            points = points + AHEAD * np.stack([np.cos(poses[2]), np.sin(poses[2])])
        way = places - points
        wish = 0.2 * way / np.maximum(np.hypot(*way), 0.1)
        entered = time.process_time()
        if isinstance(certificate, UnicycleCertificate):
            velocity, info = certificate.project(wish, poses)
        else:
            assert isinstance(certificate, SingleIntegratorCertificate)
            velocity, info = certificate(wish, points)
        driven.spent.append(time.process_time() - entered)
        apart = np.hypot(*(points[:, :, None] - points[:, None, :]))
        driven.apart += connected_components(apart <= RANGE + 1e-9)[0] > 1
        driven.hopeless += info.status in ("relaxed", "failed")
        driven.clearance = min(driven.clearance, info.clearance)
        driven.left.append(float(np.hypot(*way).mean()))
        if certificate.connectivity is not None:
            now = kept(info)
            driven.switches += links is not None and now != links
            links = now
        poses = moved(poses, certificate, velocity)


def main() -> int:
    """Measure, print, and return 1 where something does not hold that has to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5, help="teams of each kind")
    parser.add_argument("--steps", type=int, default=3000, help="of each team, 33 ms each")
    options, table = parser.parse_args(), Table()
    minutes = options.seeds * options.steps * STEP / 60.0
    for kind, robots in (("single integrators", POINTS), ("unicycles", WHEELS)):
        table.part(f"nine {kind}, {options.seeds} teams, {minutes:.1f} minutes of each way")
        for name, (connectivity, alone) in WAYS.items():
            certificate, driven = replace(robots, decentralised=alone), Driven()
            certificate = replace(certificate, connectivity=connectivity)
            for seed in range(options.seeds):
                certificate.reset()
                drive(certificate, options.steps, seed, driven)
            print(
                f"  {name:<22} {100.0 * driven.apart / len(driven.left):5.1f} % of steps apart;"
                f" places {np.mean(driven.left):.3f} m away on average;"
                f" {driven.switches / minutes:.1f} switches a minute;"
                f" {1e3 * np.median(driven.spent):.3f} ms a call"
            )
            if connectivity is None:
                table.bar(f"steps apart, {name}", driven.apart, "≥", 1)
            else:
                table.bar(f"steps apart, {name}", driven.apart, "≤", 0)
                table.bar(f"steps without a safe velocity, {name}", driven.hopeless, "≤", 0)
                table.bar(f"least clearance, {name}", driven.clearance, "≥", 0.0, "m")
    return table.exit_code()


if __name__ == "__main__":
    sys.exit(main())
