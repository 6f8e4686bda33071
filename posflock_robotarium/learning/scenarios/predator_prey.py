"""Predator–capture–prey: some robots can find prey, others can capture what was found.

Prey does not move and is hidden. *Sensing* robots find what comes within their radius, and the team
knows of it from then on; *capture* robots capture what is found and within theirs. Neither kind can
do it alone. The task is one of MARBLER's (Torbati et al., 2023), which has it from Seraj et al.
(2022); words, numbers and code here are our own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.goal_view import crowd, in_own_frame, look_ahead_points
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.learning.scenario import Flags, Floats, Initial, Marker, Scenario, World
from rps_compat.testbed import GRITSBOT_X

__all__ = ["PredatorPrey"]

_RIGHT, _TOP = GRITSBOT_X.boundaries[1], GRITSBOT_X.boundaries[3]
_CROWD = 0.6  # m


@dataclass(frozen=True)
class PredatorPrey(Scenario):
    """A team of two kinds of robots finds and captures prey.

    A robot sees whether it senses or captures; where it is and looks, in the arena; the nearest
    prey that is found and not captured, ahead and left, and whether there is any; who is near; and
    what share of the prey is still hidden, and still at large. All robots share the reward: 1 for
    prey found, 5 for prey captured, less `haste` a second. An episode ends when all is captured.

    Attributes
    ----------
    sensing, capture : int
        How many robots of each kind; the sensing ones come first.
    prey : int
        How many there are.
    sensing_radius, capture_radius : float
        How near to a look-ahead point prey is found, and captured, m.
    duration : float
        Seconds until an episode is cut off.
    haste : float
        What a second costs.

    Raises
    ------
    ParameterError
        Where a number makes no sense.
    """

    sensing: int = 2
    capture: int = 2
    prey: int = 6
    sensing_radius: float = 0.4
    capture_radius: float = 0.2
    duration: float = 60.0
    haste: float = 0.05
    observation_size: ClassVar[int] = 16  # type: ignore[misc]

    def __post_init__(self) -> None:
        for name in ("sensing", "capture", "prey"):
            if getattr(self, name) < 1:
                raise ParameterError(f"{name}: expected one at least, got {getattr(self, name)!r}")
        for name in ("sensing_radius", "capture_radius", "duration"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ParameterError(f"{name}: expected more than 0, got {getattr(self, name)!r}")

    @property
    def robots(self) -> int:  # type: ignore[override]
        """How many of both kinds together."""
        return self.sensing + self.capture

    @property
    def observation_bound(self) -> float:  # type: ignore[override]
        """Sums over the others are no larger than their number, ways no longer than the arena."""
        return float(max(self.robots, 4))

    def begin(self, rng: np.random.Generator, initial: Initial | None) -> dict[str, NDArray[Any]]:
        """Place robots at the left, and prey anywhere from the middle on."""
        if initial is None:
            side = max(0.8, 0.45 * np.sqrt(self.robots))
            start = random_poses(self.robots, rng, side=side, centre=(-1.45 + side / 2, 0.0))
        else:
            start = initial(self.robots, rng)
        least, most = [[-0.4], [0.15 - _TOP]], [[_RIGHT - 0.15], [_TOP - 0.15]]
        prey = rng.uniform(least, most, (2, self.prey))
        nobody = np.zeros(self.prey, dtype=bool)
        rates = {"just_found": np.zeros(()), "just_captured": np.zeros(())}
        return {"poses": start, "prey": prey, "found": nobody, "captured": nobody, **rates}

    def advance(self, world: World) -> None:
        """Find what is near a sensing robot, then capture what is found and near the others."""
        prey, found, captured = (world.memory[name] for name in ("prey", "found", "captured"))
        points = look_ahead_points(world.true_poses)
        apart = np.hypot(*np.moveaxis(prey[:, :, :, None] - points[:, :, None, :], 1, 0))
        seen = ties.within(apart[:, :, : self.sensing], self.sensing_radius).any(axis=2)
        reached = ties.within(apart[:, :, self.sensing :], self.capture_radius).any(axis=2)
        new = seen & ~found
        found |= new
        caught = found & reached & ~captured
        captured |= caught
        world.memory["just_found"][...] = new.sum(axis=1)
        world.memory["just_captured"][...] = caught.sum(axis=1)

    def observe(self, world: World) -> Floats:
        points, headings = look_ahead_points(world.poses), world.poses[:, 2]
        teams = len(points)
        kind = np.zeros((teams, self.robots, 2))
        kind[:, : self.sensing, 0] = kind[:, self.sensing :, 1] = 1.0
        place = np.moveaxis(world.poses[:, :2] / np.array([[_RIGHT], [_TOP]]), 1, 2)
        looks = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
        at_large = world.memory["found"] & ~world.memory["captured"]
        way = world.memory["prey"][:, :, None, :] - points[:, :, :, None]  # (B, 2, N, prey)
        apart = np.hypot(way[:, 0], way[:, 1]) + np.where(at_large, 0.0, 100.0)[:, None]
        nearest = np.argmin(np.round(apart, 9), axis=2)  # the first of those equally near
        chosen = np.take_along_axis(way, nearest[:, None, :, None], axis=3)[..., 0]
        known = at_large.any(axis=1)
        target = in_own_frame(np.where(known[:, None, None], chosen, 0.0), headings)
        hidden = 1.0 - world.memory["found"].mean(axis=1)
        free = 1.0 - world.memory["captured"].mean(axis=1)
        team = np.stack([known, hidden, free], axis=1)[:, None]
        others = crowd(points, headings, _CROWD)
        everyone = np.broadcast_to(team, (teams, self.robots, 3))
        bound = self.observation_bound
        seen = np.concatenate([kind, place, looks, target, everyone, others], axis=-1)
        return np.asarray(np.clip(seen, -bound, bound))

    def reward(self, world: World) -> Floats:
        worth = world.memory["just_found"] + 5.0 * world.memory["just_captured"]
        shared = worth - self.haste * world.time_step
        rewards: Floats = np.repeat(shared[:, None], self.robots, axis=1)
        return rewards

    def done(self, world: World) -> Flags:
        return np.asarray(world.memory["captured"].all(axis=1))

    def metrics(self, world: World) -> dict[str, Floats]:
        """Return which shares of the prey were found, and captured."""
        found, captured = world.memory["found"], world.memory["captured"]
        return {"found": found.mean(axis=1), "captured": captured.mean(axis=1)}

    def marks(self, world: World, team: int) -> tuple[Marker, ...]:
        memory, points = world.memory, look_ahead_points(world.true_poses)[team]
        shown = []
        for robot, (x, y) in enumerate(points.T.tolist()):
            senses = robot < self.sensing
            radius = self.sensing_radius if senses else self.capture_radius
            shown.append(Marker(x, y, "sensing" if senses else "capture", radius))
        for k, (x, y) in enumerate(memory["prey"][team].T.tolist()):
            if not memory["captured"][team, k]:
                shown.append(Marker(x, y, "found" if memory["found"][team, k] else "hidden"))
        return tuple(shown)
