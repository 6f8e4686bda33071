"""Drive certified teams for over 200,000 steps under attack, and count what becomes unsafe.

Teams of 2 to 20 single integrators and unicycles start safe in the testbed's arena and are given
random commands, commands that attack (each robot drives at its nearest neighbour, or at a wall),
and commands to swap places. After every step: has a team that was safe become unsafe, has a limit
been exceeded, has the program been without solution? All three must never happen.

Teams of one size are driven together, in arrays. By default a single certificate answers for each,
as on board; with ``--engine numba`` the compiled batch does, which is quick enough for a wider
search: ``--teams`` says how many teams of each size and attack there are.

Then the ellipse swap with limits in the program, and with limits clipped afterwards, for
comparison; and what the arc of turning robots does where the certificate is not told the time step.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from dataclasses import dataclass

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # before NumPy reads it

import numpy as np  # noqa: E402

from barrier_certificates.batch import STATUSES, BatchCertificate, BatchInfo, Engine  # noqa: E402
from barrier_certificates.single_integrator import SingleIntegratorCertificate  # noqa: E402
from barrier_certificates.unicycle import UnicycleCertificate  # noqa: E402
from rps_compat.batch.batch_effects import together  # noqa: E402

STEP = 0.033
ARENA = (-1.6, 1.6, -1.0, 1.0)
RADIUS, SPEED, TURN, WHEEL = 0.15, 0.2, 3.6, 12.5
D, WHEEL_RADIUS, BASE = 0.05, 0.016, 0.105
ALLOWED = 1e-9
KINDS = ("random", "attack", "swap")
SOLVED = [code for word in ("trivial", "optimal") for code, s in STATUSES.items() if s == word]


@dataclass
class Tally:
    """What happened in certified steps."""

    steps: int = 0
    turned_unsafe: int = 0
    beyond_limit: int = 0
    without_solution: int = 0
    clearance: float = np.inf
    largest_violation: float = 0.0
    intervened: int = 0

    def count(self, info: BatchInfo, before: np.ndarray, excess: np.ndarray, teams: slice) -> None:
        """Add what happened to some teams in a step."""
        status, clearance = info.status[teams], info.clearance[teams]
        self.turned_unsafe += np.count_nonzero((clearance < 0) & (before[teams] >= 0))
        self.beyond_limit += np.count_nonzero(excess[teams] > ALLOWED)
        self.without_solution += np.count_nonzero(~np.isin(status, SOLVED))
        self.intervened += np.count_nonzero(status != SOLVED[0])
        self.clearance = min(self.clearance, float(clearance.min()))
        self.largest_violation = max(self.largest_violation, float(info.violation[teams].max()))

    def add(self, other: Tally) -> None:
        """Add what happened elsewhere."""
        for name in ("steps", "turned_unsafe", "beyond_limit", "without_solution", "intervened"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.clearance = min(self.clearance, other.clearance)
        self.largest_violation = max(self.largest_violation, other.largest_violation)

    def line(self, name: str) -> str:
        """Return the tally as a line of the table."""
        return (
            f"{name:<40}{self.steps:>8}{self.intervened:>11}{self.turned_unsafe:>8}"
            f"{self.beyond_limit:>8}{self.without_solution:>11}{self.clearance:>12.2e}"
            f"{self.largest_violation:>11.1e}"
        )


HEAD = (
    f"{'':<40}{'steps':>8}{'intervened':>11}{'unsafe':>8}{'limits':>8}{'infeasible':>11}"
    f"{'clearance':>12}{'violation':>11}"
)


def scatter(number: int, rng: np.random.Generator) -> np.ndarray:
    """Return random points with every barrier positive."""
    inside = np.array([[1.6], [1.0]]) - 0.5 * RADIUS - 1e-3
    points = np.zeros((2, 0))
    while points.shape[1] < number:
        point = rng.uniform(-1, 1, (2, 1)) * inside
        if not points.shape[1] or np.hypot(*(points - point)).min() > RADIUS + 1e-4:
            points = np.hstack([points, point])
    return points


class Wishes:
    """Commands of one kind for many teams, none of them careful.

    Parameters
    ----------
    kind : str
        Which of `KINDS`.
    rngs : list of Generator
        Where each team's chance comes from.
    points : (T, 2, N) array
        Where the teams start, m.
    """

    def __init__(self, kind: str, rngs: list[np.random.Generator], points: np.ndarray) -> None:
        self.kind, self.rngs, self.goals = kind, rngs, -points
        self.held = np.zeros(points.shape)
        self.at_wall = np.zeros((len(rngs), 1, points.shape[2]), dtype=bool)

    def __call__(self, step: int, points: np.ndarray) -> np.ndarray:
        """Return what teams at these points (T, 2, N) want, m/s."""
        number = points.shape[2]
        if self.kind == "random":
            if step % 10 == 0:
                shape = points.shape[1:]
                self.held = np.stack([r.uniform(-2 * SPEED, 2 * SPEED, shape) for r in self.rngs])
            return self.held
        if self.kind == "attack":
            if step % 15 == 0:
                self.at_wall = np.stack([[rng.random(number) < 0.3] for rng in self.rngs])
            apart = points[:, :, None, :] - points[:, :, :, None]
            nearest = (lengths(apart) + 9 * np.eye(number)).argmin(axis=2)
            way = np.take_along_axis(points, nearest[:, None], axis=2) - points
            way = np.where(self.at_wall, np.sign(points), way)
            return 2 * SPEED * way / np.maximum(lengths(way), 1e-9)[:, None]
        way = self.goals - points
        self.goals[lengths(way).max(axis=1) < 0.05] *= -1.0  # from the next step on
        return 2 * way


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths of vectors (T, 2, ...)."""
    return np.hypot(vectors[:, 0], vectors[:, 1])


def certificate_of(
    unicycle: bool, gain: float, time_step: float
) -> SingleIntegratorCertificate | UnicycleCertificate:
    """Return what keeps teams apart."""
    if not unicycle:
        return SingleIntegratorCertificate(RADIUS, gain, boundary=ARENA, speed_limit=SPEED)
    return UnicycleCertificate(
        RADIUS, gain, boundary=ARENA, speed_limit=SPEED, turn_rate_limit=TURN, time_step=time_step
    )


def run(
    number: int,
    certificate: SingleIntegratorCertificate | UnicycleCertificate,
    kinds: tuple[str, ...],
    seeds: list[int],
    steps: int,
    engine: Engine,
) -> list[Tally]:
    """Drive teams of one size, a seed each, under each kind of commands; count for each kind."""
    rngs = [np.random.default_rng(seed) for _ in kinds for seed in seeds]
    starts = np.stack([scatter(number, rng) for rng in rngs])
    headings = np.stack([rng.uniform(-np.pi, np.pi, number) for rng in rngs])
    poses = np.concatenate([starts, headings[:, None]], axis=1)
    if isinstance(certificate, UnicycleCertificate):
        poses[:, :2] -= D * np.stack([np.cos(headings), np.sin(headings)], axis=1)
    parts = [slice(at, at + len(seeds)) for at in range(0, len(rngs), len(seeds))]
    wishes = [
        Wishes(kind, rngs[part], starts[part]) for kind, part in zip(kinds, parts, strict=True)
    ]
    batch = BatchCertificate(certificate, engine=engine, threads=1)
    tallies = [Tally(steps * len(seeds)) for _ in kinds]
    before = np.full(len(rngs), np.inf)
    for step in range(steps):
        e = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)
        points = poses[:, :2] + D * e if batch.distance else poses[:, :2].copy()
        command = np.concatenate(
            [wish(step, points[part]) for wish, part in zip(wishes, parts, strict=True)]
        )
        if isinstance(certificate, UnicycleCertificate):
            velocity, info = batch.project(command, poses)
            columns = certificate.commands(together(velocity), together(poses))
            v, w = columns.reshape(2, len(rngs), number)
            wheel = (np.abs(v) + 0.5 * BASE * np.abs(w)) / WHEEL_RADIUS
            excess = np.stack([np.abs(v) - SPEED, np.abs(w) - TURN, wheel - WHEEL]).max(axis=(0, 2))
            poses = poses + STEP * np.stack([v * e[:, 0], v * e[:, 1], w], axis=1)
        else:
            velocity, info = batch(command, points)
            excess = lengths(velocity).max(axis=1) - SPEED
            poses[:, :2] += STEP * velocity
        for tally, part in zip(tallies, parts, strict=True):
            tally.count(info, before, excess, part)
        before = info.clearance
    return tallies


def campaign(
    unicycle: bool,
    kinds: tuple[str, ...],
    gain: float,
    steps: int,
    teams: int,
    engine: Engine,
    time_step: float = STEP,
) -> list[Tally]:
    """Drive teams of many sizes, of each so many, for so many steps altogether; for each kind."""
    sizes = (2, 3, 4, 6, 9, 12, 16, 20)
    total = [Tally() for _ in kinds]
    for first, number in enumerate(sizes):
        seeds = [first + len(sizes) * team for team in range(teams)]
        certificate = certificate_of(unicycle, gain, time_step)
        found = run(number, certificate, kinds, seeds, steps // len(sizes), engine)
        for one, tally in zip(total, found, strict=True):
            one.add(tally)
    return total


def ellipse(clip: bool, steps: int) -> Tally:
    """Swap ten unicycles across an ellipse, limits in the program or clipped afterwards."""
    speed, turn = 0.15, 0.55
    limits = {"speed_limit": None, "wheel_limit": None} if clip else {"turn_rate_limit": turn}
    certificate = UnicycleCertificate(
        0.21, 500.0, boundary=ARENA, **({"speed_limit": speed} | limits)
    )
    angle = 2 * np.pi * np.arange(10) / 10 + 0.02 * np.random.default_rng(1).normal(size=10)
    poses = np.stack([1.3 * np.cos(angle), 0.8 * np.sin(angle), angle + np.pi])
    goals, tally = -poses[:2], Tally(steps)
    for _ in range(steps):
        e = np.stack([np.cos(poses[2]), np.sin(poses[2])])
        way = goals - (poses[:2] + D * e)
        if np.hypot(*way).max() < 0.02:
            goals = -goals
        velocity, info = certificate.project(
            speed * way / np.maximum(np.hypot(*way), 0.5 * speed), poses
        )
        v, w = (velocity * e).sum(axis=0), (e[0] * velocity[1] - e[1] * velocity[0]) / D
        tally.beyond_limit += bool(
            np.any(np.abs(v) > speed + ALLOWED) or np.any(np.abs(w) > turn + ALLOWED)
        )
        if clip:
            v, w = np.clip(v, -speed, speed), np.clip(w, -turn, turn)
        tally.turned_unsafe += info.clearance < 0
        tally.without_solution += info.status not in ("trivial", "optimal")
        tally.intervened += info.status != "trivial"
        tally.clearance = min(tally.clearance, info.clearance)
        tally.largest_violation = max(tally.largest_violation, info.violation)
        poses = poses + STEP * np.stack([v * e[0], v * e[1], w])
    return tally


def main() -> int:
    """Drive, count, print; return 1 where something became unsafe."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=204_000, help="certified steps altogether")
    parser.add_argument("--teams", type=int, default=1, help="of each size and kind of commands")
    parser.add_argument("--engine", choices=("numpy", "numba"), default="numpy")
    options = parser.parse_args()
    started, total = time.process_time(), Tally()
    share, how = options.steps // (2 * len(KINDS) * 2), (options.teams, options.engine)
    print(HEAD)
    for unicycle in (False, True):
        for gain in (100.0, 10_000.0):
            found = campaign(unicycle, KINDS, gain, share // options.teams, *how)
            for kind, tally in zip(KINDS, found, strict=True):
                model = "unicycles" if unicycle else "single integrators"
                print(tally.line(f"{model}, {kind}, γ = {gain:g}"), flush=True)
                total.add(tally)
    print(total.line("all"))
    holds = not (total.turned_unsafe or total.beyond_limit or total.without_solution)

    print("ellipse swap of ten unicycles, 8000 steps (unsafe: every step with clearance < 0)")
    inside, after = ellipse(False, 8000), ellipse(True, 8000)
    print(inside.line("limits in the program"))
    print(after.line("limits clipped afterwards"))
    holds &= not (inside.turned_unsafe or inside.beyond_limit) and after.turned_unsafe > 0

    print("not required: certificates that are not told the time step (robots turn on arcs)")
    for gain in (500.0, 10_000.0):
        steps = share // options.teams
        (tally,) = campaign(True, ("attack",), gain, steps, *how, time_step=0.0)
        print(tally.line(f"unicycles, attack, γ = {gain:g}"))
    print(f"{'holds' if holds else 'MISSED'} ({time.process_time() - started:.0f} s of CPU time)")
    return int(not holds)


if __name__ == "__main__":
    sys.exit(main())
