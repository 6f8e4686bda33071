"""Position-based flocking: go one way together, without sensing any velocity.

As in the paper, a robot sees where its neighbours are and knows where they were at the start. What
the law makes of that is to be learnt: which way all go is for the team to find.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.metrics import alignment, heading_vectors
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.goal_view import crowd, in_own_frame, look_ahead_points
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.learning.scenario import Flags, Floats, Initial, Scenario, World
from rps_compat.testbed import GRITSBOT_X

__all__ = ["Flocking"]

_LEFT, _RIGHT, _BOTTOM, _TOP = GRITSBOT_X.boundaries
#: From where on a wall is seen, m.
_WALL_REACH = 0.4


@dataclass(frozen=True)
class Flocking(Scenario):
    """Robots align.

    A robot sees, in its own frame: how its neighbours are displaced against the start, their mean;
    who is within `radius`, and within half of it (five sums each); and how it is pushed by walls
    nearer than 0.4 m. The reward of a robot is the way that it went along the team's mean motion,
    m: most where all go one way at full speed. An episode ends with its time alone.

    Attributes
    ----------
    robots : int
        How many.
    duration : float
        Seconds until an episode is cut off.
    side : float
        Of the square that they start in, m.
    radius : float
        Who is a neighbour, m.

    Raises
    ------
    ParameterError
        Where a number makes no sense.
    """

    robots: int = 6
    duration: float = 30.0
    side: float = 1.2
    radius: float = 0.75
    observation_size: ClassVar[int] = 14  # type: ignore[misc]

    def __post_init__(self) -> None:
        if self.robots < 2:
            raise ParameterError(f"robots: expected two at least, got {self.robots!r}")
        for name in ("duration", "side", "radius"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ParameterError(f"{name}: expected more than 0, got {getattr(self, name)!r}")

    @property
    def observation_bound(self) -> float:  # type: ignore[override]
        """Sums over the others are no larger than their number; displacements are cut there."""
        return float(max(self.robots, 2))

    def begin(self, rng: np.random.Generator, initial: Initial | None) -> dict[str, NDArray[Any]]:
        start = (
            random_poses(self.robots, rng, side=self.side)
            if initial is None
            else initial(self.robots, rng)
        )
        return {"poses": start, "imprint": look_ahead_points(start)}

    def observe(self, world: World) -> Floats:
        points, headings = look_ahead_points(world.poses), world.poses[:, 2]
        near = neighbours(points, self.radius).astype(float)
        moved = points - world.memory["imprint"]  # of j less that of i, over i's neighbours
        count = np.maximum(near.sum(axis=2), 1.0)[:, None]
        mean = np.einsum("bij,bdj->bdi", near, moved) / count
        change = in_own_frame(
            np.where(near.max(axis=2)[:, None] > 0.0, mean - moved, 0.0), headings
        )
        x, y = points[:, 0], points[:, 1]
        push_x = np.maximum(0.0, _WALL_REACH - (x - _LEFT)) - np.maximum(
            0.0, _WALL_REACH - (_RIGHT - x)
        )
        push_y = np.maximum(0.0, _WALL_REACH - (y - _BOTTOM)) - np.maximum(
            0.0, _WALL_REACH - (_TOP - y)
        )
        walls = in_own_frame(np.stack([push_x, push_y], axis=1) / _WALL_REACH, headings)
        bound = self.observation_bound
        others = [crowd(points, headings, reach) for reach in (self.radius, self.radius / 2)]
        return np.clip(np.concatenate([change, *others, walls], axis=-1), -bound, bound)

    def reward(self, world: World) -> Floats:
        way = look_ahead_points(world.true_poses) - look_ahead_points(world.before)
        mean = way.mean(axis=2, keepdims=True)
        length = np.hypot(mean[:, 0], mean[:, 1])[:, None]
        along = mean / np.maximum(length, 1e-9)
        rewards: Floats = (way * along).sum(axis=1)
        return rewards

    def done(self, world: World) -> Flags:
        return np.zeros(len(world.time), dtype=bool)

    def metrics(self, world: World) -> dict[str, Floats]:
        """Return γ of the headings, and how fast the team as a whole goes, m/s."""
        ahead = heading_vectors(world.true_poses)
        gamma = alignment(ahead, world.true_poses[:, :2], self.radius).gamma
        way = (world.true_poses - world.before)[:, :2].mean(axis=2)
        return {"gamma": gamma, "team_speed": np.hypot(way[:, 0], way[:, 1]) / world.time_step}
