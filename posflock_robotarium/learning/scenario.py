"""What a scenario for learning says: where it begins, what is seen, what is good, when it is over.

One small class, for B teams at once: every method takes a `World`, whose arrays have an axis of
teams first. A scenario holds its parameters and nothing else; what it has to remember of an episode
(goals, who was caught) lies in `World.memory`, an array a name, so that one object serves any
number of teams, and a team begins anew by having its rows written.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Initial", "Marker", "Scenario", "World"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: From a number of robots and a source of chance to first poses (3, N), m and rad.
Initial = Callable[[int, np.random.Generator], Floats]


@dataclass(eq=False)
class World:
    """B teams at one moment.

    Attributes
    ----------
    poses : (B, 3, N) array
        As the tracking system sees them, m and rad: all that robots know.
    true_poses : (B, 3, N) array
        Where they really are, m and rad: what they are judged by.
    before : (B, 3, N) array
        Where they really were before this step, m and rad.
    actions : (B, N, 2) array
        What was asked for in this step, from -1 to 1.
    time : (B,) array
        Seconds since each team began.
    time_step : float
        Duration of a step, s.
    memory : dict of (B, ...) arrays
        What the scenario remembers of an episode.
    """

    poses: Floats
    true_poses: Floats
    before: Floats
    actions: Floats
    time: Floats
    time_step: float
    memory: dict[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Marker:
    """What there is in the arena beside robots, for pictures.

    Attributes
    ----------
    x, y : float
        Where, m.
    kind : {"goal", "hidden", "found", "sensing", "capture"}
        What it is.
    radius : float
        Of a disc, m; 0 is a point.
    label : str
        What is written beside it.
    """

    x: float
    y: float
    kind: str
    radius: float = 0.0
    label: str = ""


class Scenario(ABC):
    """A task for a team.

    Attributes
    ----------
    robots : int
        How many take part, N.
    duration : float
        Seconds after which an episode is cut off.
    observation_size : int
        How many numbers a robot sees.
    observation_bound : float
        None of them is larger than this, or smaller than its negative.
    """

    robots: int
    duration: float
    observation_size: int
    observation_bound: float

    @abstractmethod
    def begin(self, rng: np.random.Generator, initial: Initial | None) -> dict[str, NDArray[Any]]:
        """Return how an episode of one team begins.

        Parameters
        ----------
        rng : numpy.random.Generator
            Where chance comes from.
        initial : callable, optional
            Where robots start; as the scenario has it if None.

        Returns
        -------
        dict of (...) arrays
            ``poses``, (3, N), m and rad, and what is to be remembered.
        """

    def advance(self, world: World) -> None:  # noqa: B027  # most scenarios remember nothing new
        """Bring `world.memory` up to date after a step, in place.

        Parameters
        ----------
        world : World
            After the step.
        """

    @abstractmethod
    def observe(self, world: World) -> Floats:
        """Return what each robot sees.

        Parameters
        ----------
        world : World
            Now.

        Returns
        -------
        (B, N, D) array
            D numbers a robot, finite.
        """

    @abstractmethod
    def reward(self, world: World) -> Floats:
        """Return what the step was worth to each robot.

        Parameters
        ----------
        world : World
            After the step.

        Returns
        -------
        (B, N) array
            The more the better.
        """

    @abstractmethod
    def done(self, world: World) -> Flags:
        """Return which teams have done what there was to do.

        Parameters
        ----------
        world : World
            After the step.

        Returns
        -------
        (B,) boolean array
            True where an episode has ended by itself.
        """

    @abstractmethod
    def metrics(self, world: World) -> dict[str, Floats]:
        """Return how each team fares, in words that a paper would use.

        Parameters
        ----------
        world : World
            Now.

        Returns
        -------
        dict of (B,) arrays
            By name.
        """

    def marks(self, world: World, team: int) -> tuple[Marker, ...]:
        """Return what a picture shows beside robots.

        Parameters
        ----------
        world : World
            Now.
        team : int
            Whose picture.
        """
        return ()
