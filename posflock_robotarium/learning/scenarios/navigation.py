"""Goal navigation with swaps: robots on a circle change places with who is opposite.

All straight ways meet in the middle. A certificate keeps such a crowd safe, and slow; what is to be
learnt is to give way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.goal_view import (
    VIEW_SIZE,
    goal_view,
    look_ahead_points,
    swapped_places,
)
from posflock_robotarium.learning.scenario import Flags, Floats, Initial, Marker, Scenario, World

__all__ = ["Navigation"]


@dataclass(frozen=True)
class Navigation(Scenario):
    """Robots change places with who is opposite.

    The reward of a robot is how much nearer its goal it came, m, less `haste` for each second that
    it is not there. An episode ends when all have arrived.

    Attributes
    ----------
    robots : int
        How many, an even number.
    duration : float
        Seconds until an episode is cut off.
    arrived : float
        A look-ahead point this near its goal has arrived, m.
    haste : float
        What a second not at the goal costs, m.

    Raises
    ------
    ParameterError
        Where a number makes no sense.
    """

    robots: int = 8
    duration: float = 30.0
    arrived: float = 0.05
    haste: float = 0.1
    observation_size: ClassVar[int] = VIEW_SIZE  # type: ignore[misc]

    @property
    def observation_bound(self) -> float:  # type: ignore[override]
        """Sums over the others are no larger than their number."""
        return float(self.robots)

    def __post_init__(self) -> None:
        if self.robots < 2 or self.robots % 2:
            raise ParameterError(f"robots: expected an even number, got {self.robots!r}")
        for name in ("duration", "arrived"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ParameterError(f"{name}: expected more than 0, got {getattr(self, name)!r}")

    def begin(self, rng: np.random.Generator, initial: Initial | None) -> dict[str, NDArray[Any]]:
        if initial is None:
            start, goals = swapped_places(self.robots, rng)
        else:
            start = initial(self.robots, rng)
            goals = look_ahead_points(start)[:, np.arange(self.robots) ^ 1]
        return {"poses": start, "goals": goals, "arrival": np.full(self.robots, np.nan)}

    def distances(self, poses: Floats, goals: Floats) -> Floats:
        """Return how far look-ahead points are from their goals.

        Parameters
        ----------
        poses : (B, 3, N) array
            Poses, m and rad.
        goals : (B, 2, N) array
            Goals, m.

        Returns
        -------
        (B, N) array
            Distances, m.
        """
        way = goals - look_ahead_points(poses)
        return np.hypot(way[..., 0, :], way[..., 1, :])

    def there(self, world: World) -> Flags:
        """Return who is at its goal.

        Parameters
        ----------
        world : World
            Now.

        Returns
        -------
        (B, N) boolean array
            True for those.
        """
        distance = self.distances(world.true_poses, world.memory["goals"])
        here: Flags = ~ties.beyond(distance, self.arrived)
        return here

    def advance(self, world: World) -> None:
        """Note when robots came to stay: the time since which each is at its goal."""
        arrival = world.memory["arrival"]
        here = self.there(world)
        now = np.broadcast_to(world.time[:, None], arrival.shape)
        arrival[...] = np.where(here, np.where(np.isnan(arrival), now, arrival), np.nan)

    def observe(self, world: World) -> Floats:
        return goal_view(world.poses, world.memory["goals"])

    def reward(self, world: World) -> Floats:
        goals = world.memory["goals"]
        after = self.distances(world.true_poses, goals)
        nearer = self.distances(world.before, goals) - after
        late = ties.beyond(after, self.arrived)
        rewards: Floats = nearer - self.haste * world.time_step * late
        return rewards

    def done(self, world: World) -> Flags:
        return np.asarray(self.there(world).all(axis=1))

    def metrics(self, world: World) -> dict[str, Floats]:
        """Return who is at their goals, a share, and since when; others count as the duration."""
        arrival = world.memory["arrival"]
        return {
            "arrived": self.there(world).mean(axis=1),
            "time": np.where(np.isnan(arrival), self.duration, arrival).mean(axis=1),
            "distance": self.distances(world.true_poses, world.memory["goals"]).mean(axis=1),
        }

    def marks(self, world: World, team: int) -> tuple[Marker, ...]:
        goals = world.memory["goals"][team]
        return tuple(
            Marker(x, y, "goal", label=str(k)) for k, (x, y) in enumerate(goals.T.tolist())
        )
