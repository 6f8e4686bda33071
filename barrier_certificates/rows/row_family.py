"""What a kind of rows is: how many, between whom, and what they are at present."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray

WORLD = -1
"""Stands in for a robot where a row has no second one."""


class Barrier(NamedTuple):
    """What is nearest to being unsafe: its barrier, the same in metres, and its row.

    ``h`` is ‖D‖² − r² in m² for pairs and obstacles, and the distance less the margin in m for
    walls; ``clearance`` is in metres for all, so it is what barriers are compared by. Both are
    negative exactly when something is unsafe. ``row`` is −1 where there is nothing.
    """

    h: float
    clearance: float
    row: int


NOTHING_NEAR = Barrier(np.inf, np.inf, -1)


class Scene(NamedTuple):
    """Where the team is: positions (2, N) in m and, where robots have one, headings (2, N)."""

    positions: FloatArray
    headings: FloatArray | None = None


class Family(Protocol):
    """Rows of one kind whose number depends on the number of robots alone."""

    weight: float

    def partners(self, number: int) -> IntArray:
        """Which robots each row joins, shape (2, m); `WORLD` where there is no second one."""

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write what never changes into ``coefficient`` (4, m) and ``bound`` (m,)."""

    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Write what changes with the scene; return the barrier of least clearance."""

    def measure(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return barrier and clearance of each row; empty where the family has no barrier."""

    def label(self, number: int, row: int) -> str:
        """Say what the row stands for."""


def with_world(rows_each: int, number: int) -> IntArray:
    """Return the partners of ``rows_each`` rows for each robot with the world, (2, m)."""
    partners = np.full((2, rows_each * number), WORLD)
    partners[0] = np.tile(np.arange(number), rows_each)
    return partners
