"""An adversary that sees everything: commands that try to make late, certified robots collide.

It knows the true poses, which the certificate does not, and asks for velocities of projection
points at the limit. Each way of attacking is one function from the true points, the step and what
it remembers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.rows import Disc

Array = NDArray[np.float64]
ARENA = (-1.6, 1.6, -1.0, 1.0)
SPEED = 1.0
"""What is asked for, m/s: more than any robot can."""


@dataclass
class Attack:
    """What an adversary remembers.

    Parameters
    ----------
    rng : Generator
        Where chance comes from.
    start : (2, N) array
        Points at the start, m.
    """

    rng: np.random.Generator
    start: Array
    memory: dict[str, Array] = field(default_factory=dict)


def towards(way: Array) -> Array:
    """Return velocities at the limit along ways (2, N)."""
    return SPEED * way / np.maximum(np.hypot(way[0], way[1]), 1e-9)


def nearest(points: Array) -> Array:
    """Return the nearest other robot of each, (N,)."""
    apart = points[:, None, :] - points[:, :, None]
    return np.asarray((np.hypot(*apart) + 99 * np.eye(points.shape[1])).argmin(axis=1))


def greedy(points: Array, step: int, attack: Attack) -> Array:
    """Everybody drives at his nearest neighbour, some at a wall for a while."""
    if step % 60 == 0:
        attack.memory["at wall"] = attack.rng.random(points.shape[1]) < 0.2
    way = points[:, nearest(points)] - points
    return towards(np.where(attack.memory["at wall"], np.sign(points), way))


def feint(points: Array, step: int, attack: Attack) -> Array:
    """Drive at the neighbour and draw back, in turns as long as the delay."""
    if step % 12 == 0:
        attack.memory["sign"] = np.where(attack.rng.random(points.shape[1]) < 0.35, -1.0, 1.0)
    return attack.memory["sign"] * towards(points[:, nearest(points)] - points)


def orbit(points: Array, step: int, attack: Attack) -> Array:
    """Circle around the neighbour while pressing at him, half of the robots the other way round."""
    way = towards(points[:, nearest(points)] - points)
    sides = np.where(np.arange(points.shape[1]) % 2, 1.0, -1.0) * (-1.0) ** (step // 200)
    return towards(way + sides * np.array([-way[1], way[0]]))


def corner(points: Array, step: int, attack: Attack) -> Array:
    """One robot flees into a corner, all others press it there; another one every ten seconds."""
    victim = (step // 300) % points.shape[1]
    way = points[:, [victim]] - points
    corners = np.array([[1.6, 1.6, -1.6, -1.6], [1.0, -1.0, 1.0, -1.0]])
    way[:, victim] = corners[:, (step // 300) % 4] - points[:, victim]
    return towards(way)


def swap(points: Array, step: int, attack: Attack) -> Array:
    """Everybody to the place opposite, and back."""
    goals = attack.memory.setdefault("goals", -attack.start)
    way = goals - points
    if np.hypot(way[0], way[1]).max() < 0.1 or step % 900 == 899:
        attack.memory["goals"] = -goals
    return towards(way)


def chance(points: Array, step: int, attack: Attack) -> Array:
    """Something else every third of a second."""
    if step % 10 == 0:
        attack.memory["held"] = attack.rng.normal(0.0, 0.3, points.shape)
    return attack.memory["held"]


Way = Callable[[Array, int, Attack], Array]
ATTACKS: dict[str, Way] = {
    "greedy": greedy,
    "feint": feint,
    "orbit": orbit,
    "corner": corner,
    "swap": swap,
    "chance": chance,
}


def discs(time: float, speed: float) -> tuple[Disc, ...]:
    """Return three discs on their ways across the arena and back, never fast.

    Parameters
    ----------
    time : float
        When, s.
    speed : float
        How fast, m/s; half a lap is far longer than any delay.
    """
    out = []
    for number, (x, y, width) in enumerate(((-0.8, 0.6, 1.0), (0.9, -0.6, 1.0), (0.0, 0.0, 0.0))):
        place = (speed * time) % (2 * width) if width else 0.0
        back = place > width
        along = 2 * width - place if back else place
        sign = 1.0 if x < 0 else -1.0
        velocity = (sign * speed * (-1.0 if back else 1.0), 0.0) if width else (0.0, 0.0)
        out.append(Disc((x + sign * along, y), 0.08, velocity=velocity, name=f"disc {number}"))
    return tuple(out)
