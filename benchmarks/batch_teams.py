"""Teams that batches are timed on: bare, spread, packed, swapping places.

Plain numpy, so that simulators in environments of their own can import it, too.
"""

from __future__ import annotations

import numpy as np

#: Robots of a team.
ROBOTS = 9
#: How far ahead of the axle projection points lie, m.
AHEAD = 0.05
#: To goals: speed for each metre of the way, 1/s, and how fast at most, m/s.
GAIN, SPEED = 1.0, 0.15
#: Smallest distance of two projection points, m.
RADIUS = 0.20
TIME_STEP = 0.033

KINDS = ("bare", "spread", "packed", "swap")


def teams(
    kind: str, number: int, seed: int = 0, robots: int = ROBOTS
) -> tuple[np.ndarray, np.ndarray]:
    """Return poses (B, 3, N), and goals (B, 2, N); of bare teams unicycle commands instead.

    Parameters
    ----------
    kind : {"bare", "spread", "packed", "swap"}
        Spread: nine robots 1 m and 0.7 m apart, on their way to places up to 0.3 m off. Packed:
        projection points 0.215 m apart, all on their way to the centre. Swap: from places 0.45 m
        apart to the opposite ones, through the centre.
    number : int
        Number of teams, B.
    seed : int
        What they are drawn from.
    robots : int
        Robots of a team, N, a square number; more than nine are packed or bare.
    """
    rng, side = np.random.default_rng(seed), np.sqrt(robots)
    along = np.arange(side) - 0.5 * (side - 1.0)
    grid = np.array(np.meshgrid(along, along)).reshape(2, -1)
    if robots > ROBOTS:
        grid *= 3.0 / side if kind == "bare" else 1.0  # in the arena, whoever they pass
    apart = {"packed": np.array([0.215, 0.215]), "swap": np.array([0.45, 0.45])}
    points = grid * apart.get(kind, np.array([1.0, 0.7]))[:, None]
    shake = {"packed": 0.007, "swap": 0.03}.get(kind, 0.05)
    points = points + rng.uniform(-shake, shake, (number, 2, robots))
    heading = rng.uniform(-np.pi, np.pi, (number, 1, robots))
    axle = points - AHEAD * np.concatenate([np.cos(heading), np.sin(heading)], axis=1)
    poses = np.concatenate([axle, heading], axis=1)
    if kind == "bare":
        limits = np.array([0.02, 0.5])[:, None]
        return poses, rng.uniform(-limits, limits, (number, 2, robots))
    if kind == "spread":
        return poses, points + rng.uniform(-0.3, 0.3, points.shape)
    return poses, np.zeros_like(points) if kind == "packed" else -points


def steps_of(kind: str, number: int) -> int:
    """Return how many steps a rollout of a kind has: of few teams half a minute, else 4 s."""
    if kind == "bare":
        return max(100, 200_000 // number)
    return 120
