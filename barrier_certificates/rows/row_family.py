"""What a kind of rows is: how many, between whom, and what they are at present."""

from __future__ import annotations

from abc import abstractmethod
from typing import NamedTuple, Protocol

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray

WORLD = -1
"""Stands in for a robot where a row has no second one."""


class Barrier(NamedTuple):
    """What is nearest to being unsafe: its barrier, the same in metres, and its row.

    Barrier and clearance are negative exactly when something is unsafe.

    Attributes
    ----------
    h : float
        ‖D‖² − r² in m² for pairs and obstacles; the distance less the margin in m for walls.
    clearance : float
        The same in metres for all, so it is what barriers are compared by.
    row : int
        Index of the row; −1 where there is nothing.
    """

    h: float
    clearance: float
    row: int


NOTHING_NEAR = Barrier(np.inf, np.inf, -1)


class Scene(NamedTuple):
    """Where the team is.

    Attributes
    ----------
    positions : (2, N) array
        Positions, m: of projection points, where robots have one.
    headings : (2, N) array or None
        Cosine and sine of each heading; None for robots without one.
    """

    positions: FloatArray
    headings: FloatArray | None = None


class RowFamily(Protocol):
    """Rows of one kind whose number depends on the number of robots alone."""

    weight: float

    @abstractmethod
    def partners(self, number: int) -> IntArray:
        """Return which robots each row joins.

        Parameters
        ----------
        number : int
            Number of robots, N.

        Returns
        -------
        (2, m) array
            Numbers of the robots in each row; `WORLD` where there is no second one.
        """

    @abstractmethod
    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write what never changes.

        Parameters
        ----------
        number : int
            Number of robots, N.
        coefficient : (4, m) array
            Where the coefficients are written: x and y of the first robot, x and y of the second.
        bound : (m,) array
            Where the right-hand sides are written, m/s.
        """

    @abstractmethod
    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Write what changes with the scene.

        Parameters
        ----------
        scene : Scene
            Where the team is.
        coefficient : (4, m) array
            Where the coefficients are written: x and y of the first robot, x and y of the second.
        bound : (m,) array
            Where the right-hand sides are written, m/s.

        Returns
        -------
        Barrier
            The one of least clearance.
        """

    @abstractmethod
    def measure(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return barrier and clearance of each row; empty where the family has no barrier.

        Parameters
        ----------
        scene : Scene
            Where the team is.

        Returns
        -------
        h : (m,) array
            Barriers, m² or m.
        clearance : (m,) array
            The same in metres.
        """

    @abstractmethod
    def label(self, number: int, row: int) -> str:
        """Say what the row stands for.

        Parameters
        ----------
        number : int
            Number of robots, N.
        row : int
            Index among the rows of this kind.

        Returns
        -------
        str
            Words for people, as in ``info.active``.
        """


def with_world(rows_each: int, number: int) -> IntArray:
    """Return the partners of rows that join every robot with the world.

    Parameters
    ----------
    rows_each : int
        Rows of each robot.
    number : int
        Number of robots, N.

    Returns
    -------
    (2, m) array
        The robots, all of them for the first of their rows, then for the second; `WORLD` below.
    """
    partners = np.full((2, rows_each * number), WORLD)
    partners[0] = np.tile(np.arange(number), rows_each)
    return partners
