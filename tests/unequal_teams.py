"""Teams of unequal robots, and the programs that keep them safe, written out robot by robot."""

from dataclasses import dataclass

import numpy as np
from dense_program import Program
from scipy.optimize import nnls

from barrier_certificates.rows import Disc
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)
OBSTACLE = Disc((0.2, -0.1), 0.08, velocity=(0.02, -0.01))

# A large slow robot with wheels of its own among small fast ones.
SIZES = np.array([0.5, 0.12, 0.12, 0.12, 0.2])
SPEEDS = np.array([0.05, 0.3, 0.3, 0.2, 0.15])
GAINS = np.array([2e3, 2e4, 5e4, 2e4, 1e4])
AHEAD = np.array([0.12, 0.03, 0.03, 0.05, 0.05])
DRIVE = {
    "projection_distance": AHEAD,
    "speed_limit": SPEEDS,
    "turn_rate_limit": [0.5, 3.0, 3.0, 2.0, 1.0],
    "wheel_limit": [4.0, 20.0, 20.0, 15.0, 12.5],
    "wheel_radius": [0.05, 0.016, 0.016, 0.016, 0.02],
    "base_length": [0.3, 0.08, 0.08, 0.105, 0.105],
}


def clearances(points):
    """Return how much farther apart any two robots are than both of their discs."""
    first, second = np.triu_indices(points.shape[1], 1)
    apart = np.hypot(*(points[:, first] - points[:, second]))
    return apart - 0.5 * (SIZES[first] + SIZES[second])


@dataclass(frozen=True)
class Team:
    """Numbers of each robot, (N,) arrays, and where the team is."""

    numbers: dict[str, np.ndarray]
    poses: np.ndarray
    desired: np.ndarray

    def certificate(self, unicycles, **given):
        kind = UnicycleCertificate if unicycles else SingleIntegratorCertificate
        drive = set(kind.may_differ)
        numbers = {name: value for name, value in self.numbers.items() if name in drive}
        return kind(**{"boundary": ARENA, "obstacles": [OBSTACLE]} | numbers | given)

    def ask(self, certificate):
        if isinstance(certificate, UnicycleCertificate):
            return certificate.project(self.desired, self.poses)
        return certificate(self.desired, self.poses[:2])

    def points(self, unicycles):
        heading = np.stack([np.cos(self.poses[2]), np.sin(self.poses[2])])
        ahead = self.numbers["projection_distance"] if unicycles else 0.0
        return self.poses[:2] + ahead * heading

    def take(self, order):
        numbers = {name: value[order] for name, value in self.numbers.items()}
        return Team(numbers, self.poses[:, order], self.desired[:, order])


def drawn_team(seed, robots, spread=0.8):
    """Return a team of which each robot has other numbers: one may be ten times another."""
    rng = np.random.default_rng(seed)
    numbers = {
        "safety_radius": rng.uniform(0.05, 0.4, robots),
        "barrier_gain": 10.0 ** rng.uniform(1, 3, robots),
        "unsafe_gain": 10.0 ** rng.uniform(1, 3, robots),
        "wall_gain": 10.0 ** rng.uniform(0, 2, robots),
        "wall_margin": rng.uniform(0.0, 0.2, robots),
        "obstacle_margin": rng.uniform(0.02, 0.2, robots),
        "projection_distance": rng.uniform(0.02, 0.1, robots),
        "speed_limit": rng.uniform(0.05, 0.5, robots),
        "turn_rate_limit": rng.uniform(0.5, 5.0, robots),
        "wheel_limit": rng.uniform(5.0, 20.0, robots),
        "wheel_radius": rng.uniform(0.01, 0.04, robots),
        "base_length": rng.uniform(0.08, 0.3, robots),
        "wheel_disturbance": rng.uniform(0.0, 0.1, robots),
    }
    poses = np.vstack([rng.uniform(-spread, spread, (2, robots)), rng.uniform(-3, 3, robots)])
    return Team(numbers, poses, rng.normal(0, 0.2, (2, robots)))


def program_of(team, unicycles):
    """Write out all that must hold, from the words of the documentation."""
    points = team.points(unicycles)
    program, numbers = Program(points, team.desired), team.numbers
    for i in range(points.shape[1]):
        own = {name: value[i] for name, value in numbers.items()}
        loss = _loss(own, team.poses[2, i]) if unicycles else lambda row: 0.0
        for j in range(i):
            other = {name: value[j] for name, value in numbers.items()}
            offset = points[:, i] - points[:, j]
            h = offset @ offset - (own["safety_radius"] / 2 + other["safety_radius"] / 2) ** 2
            gain = min(own["barrier_gain"], other["barrier_gain"])
            if h < 0:
                gain = max(own["unsafe_gain"], other["unsafe_gain"])
            lost = loss(2 * offset)
            lost += _loss(other, team.poses[2, j])(2 * offset) if unicycles else 0.0
            program.row([(i, -2 * offset), (j, 2 * offset)], gain * h**3 - lost)
        offset = points[:, i] - np.array(OBSTACLE.centre)
        h = offset @ offset - (OBSTACLE.radius + own["obstacle_margin"]) ** 2
        moving = 2 * offset @ np.array(OBSTACLE.velocity)
        program.row([(i, -2 * offset)], own["barrier_gain"] * h**3 - moving - loss(2 * offset))
        for normal, wall in (((1, 0), 1.6), ((-1, 0), 1.6), ((0, 1), 1.0), ((0, -1), 1.0)):
            gap = wall - np.array(normal) @ points[:, i] - own["wall_margin"]
            bound = 0.4 * own["wall_gain"] * gap**3
            program.row([(i, normal)], bound - loss(np.array(normal)))
        for side, bound in _limits(own, team.poses[2, i], unicycles):
            program.row([(i, side)], bound)
    return program


def _limits(own, heading, unicycles):
    if not unicycles:
        for k in range(8):
            side = np.array([np.cos(k * np.pi / 4), np.sin(k * np.pi / 4)])
            yield side, own["speed_limit"] * np.cos(np.pi / 8)
        return
    forward = np.array([np.cos(heading), np.sin(heading)])
    turn = np.array([-np.sin(heading), np.cos(heading)]) / own["projection_distance"]
    for sign in (1, -1):
        yield sign * forward, own["speed_limit"]
        yield sign * turn, own["turn_rate_limit"]
        for wheel in (1, -1):
            rim = sign * (forward + wheel * turn * own["base_length"] / 2)
            yield rim, own["wheel_limit"] * own["wheel_radius"]


def _loss(own, heading):
    """Return what a row loses at most through wheels that do what they like."""
    forward = np.array([np.cos(heading), np.sin(heading)])
    aside = np.array([-np.sin(heading), np.cos(heading)])
    rim = own["wheel_disturbance"] * own["wheel_radius"]
    corners = [
        forward * rim * (right + left) / 2
        + aside * own["projection_distance"] * rim * (right - left) / own["base_length"]
        for right in (1, -1)
        for left in (1, -1)
    ]
    return lambda row: max(row @ corner for corner in corners)


def optimum(program):
    """Return the velocities nearest to those wanted, or None where no velocities keep all rows.

    By least-distance programming, from the textbook (Lawson and Hanson, Solving Least Squares
    Problems, 1974, chapter 23); that it is the optimum is shown for each answer.
    """
    rows, bounds = np.array(program.rows), np.array(program.bounds)
    lengths = np.linalg.norm(rows, axis=1)
    rows, bounds, wanted = rows / lengths[:, None], bounds / lengths, program.wanted.T.ravel()
    excess = rows @ wanted - bounds
    last = np.append(np.zeros(wanted.size), 1.0)
    push, left = nnls(np.vstack([-rows.T, excess]), last)
    if left < 1e-8:
        return None
    tight = rows[push > 0]
    push = np.linalg.lstsq(tight @ tight.T, excess[push > 0], rcond=None)[0]
    point = wanted - tight.T @ push
    assert (rows @ point - bounds).max() < 1e-9  # all rows hold,
    assert push.min(initial=0.0) > -1e-9  # and none of those that bind pulls
    return point.reshape(-1, 2).T
