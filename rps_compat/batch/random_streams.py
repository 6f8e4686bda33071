"""The random numbers of many teams, each from a stream of its own, as one large team takes them.

The effects of a realism profile draw for N robots from one generator. For B teams they are asked as
for one team of B·N robots, and given this in the place of the generator: every draw is made team by
team, from each team's own stream, and laid side by side. So each team gets the numbers that it
would get alone, and no effect knows of teams.

Drawing is done once a step and team, in Python, so it is done ahead where that is the same: several
standard normal numbers, or numbers from 0 to 1, are those that would be drawn one after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_AHEAD = 32  # draws


class RandomStreams:
    """Stands in for a generator, for teams that each have their own.

    Parameters
    ----------
    streams : sequence of Generator
        One a team.
    """

    def __init__(self, streams: Sequence[np.random.Generator]) -> None:
        self.streams = tuple(streams)
        self._last: tuple[str, tuple[int, ...]] | None = None
        self._block: Array | None = None  # (teams, draws, ..., robots of a team)
        self._used = 0
        self._states: list[Any] = []

    def standard_normal(self, shape: tuple[int, int]) -> Array:
        """Return standard normal numbers.

        Parameters
        ----------
        shape : (rows, B N) tuple
            Rows, and robots of all teams.

        Returns
        -------
        (rows, B N) array
            Drawn team by team.
        """
        return self._ahead("standard_normal", shape)

    def random(self, robots: int) -> Array:
        """Return numbers from 0 to 1.

        Parameters
        ----------
        robots : int
            Robots of all teams, B N.

        Returns
        -------
        (B N,) array
            Drawn team by team.
        """
        return self._ahead("random", (robots,))

    def exponential(self, scale: float, robots: int) -> Array:
        """Return exponential numbers.

        Parameters
        ----------
        scale : float
            Their mean, in any unit.
        robots : int
            Robots of all teams, B N.

        Returns
        -------
        (B N,) array
            Drawn team by team.
        """
        return self.each(robots, lambda stream, number: stream.exponential(scale, number))

    def each(self, robots: int, draw: Callable[[np.random.Generator, int], Array]) -> Array:
        """Return what is drawn for each team from its stream, side by side.

        Parameters
        ----------
        robots : int
            Robots of all teams, B N.
        draw : callable
            Takes a generator and the robots of a team, N.

        Returns
        -------
        (B N,) array
            The numbers.
        """
        self._give_back()
        number = robots // len(self.streams)
        return np.concatenate([draw(stream, number) for stream in self.streams])

    def _ahead(self, what: str, shape: tuple[int, ...]) -> Array:
        number = shape[-1] // len(self.streams)
        if self._last != (what, shape):
            self._give_back()
            self._last = (what, shape)
            drawn = self._draw(what, (1, *shape[:-1], number))
            return _side_by_side(drawn[:, 0])
        if self._block is None or self._used == self._block.shape[1]:
            self._states = [stream.bit_generator.state for stream in self.streams]
            self._block = self._draw(what, (_AHEAD, *shape[:-1], number))
            self._used = 0
        self._used += 1
        return _side_by_side(self._block[:, self._used - 1])

    def _draw(self, what: str, shape: tuple[int, ...]) -> Array:
        return np.stack([getattr(stream, what)(shape) for stream in self.streams])

    def _give_back(self) -> None:
        """Take the streams back to where they would be, had nothing been drawn ahead."""
        if self._block is not None and self._last is not None:
            for stream, state in zip(self.streams, self._states, strict=True):
                stream.bit_generator.state = state
            self._draw(self._last[0], (self._used, *self._block.shape[2:]))
        self._block, self._last = None, None


def _side_by_side(drawn: Array) -> Array:
    """Return numbers (B, ..., N) as those (..., B N) of one large team."""
    if drawn.ndim == 2:
        return drawn.reshape(-1)
    return np.ascontiguousarray(drawn.swapaxes(0, 1)).reshape(drawn.shape[1], -1)
