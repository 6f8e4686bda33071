"""What the rows of every team are made from, as arrays and numbers that compiled code takes.

A certificate's families of rows hold their numbers in objects; here they stand in tuples of arrays,
in the order in which the row book of a single team lays the rows out: limits, walls, obstacles,
each side by side and robot by robot, then the pairs. A row touches one robot, or two with opposite
coefficients, so each is two robots, one vector and a bound. All robots are equal.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.per_robot import largest
from barrier_certificates.rows import LimitRows, ObstacleRows, PairRows, WallRows


class Recipe(NamedTuple):
    """What rows are made from; K limits, W walls, M obstacles.

    Attributes
    ----------
    limits : (3, K) array
        Unit normals of the limits, x and y, and bounds, m/s.
    limits_turn : bool
        Whether they turn with the headings.
    walls : (3, W) array
        Outward unit normals of the walls, x and y, and distances of what is kept from the origin.
    obstacles : (8, M) array
        Start of each segment, vector to its end, the inverse of its squared length, velocity, and
        the distance that is kept.
    pairs : (2,) array
        Smallest distance, m, and its square; empty where robots are not kept apart.
    gains : (3, 2) array
        Factors of h³ for walls, obstacles and pairs: while they are clear, and once they are not.
    disturbances : (2, 2) array
        What wheels may do along and across a heading, m/s: as walls count it, and all else.
    disturbed : bool
        Whether wheels may do anything.
    cautious : bool
        Whether teams with something too close are left to a single certificate.
    """

    limits: FloatArray
    limits_turn: bool
    walls: FloatArray
    obstacles: FloatArray
    pairs: FloatArray
    gains: FloatArray
    disturbances: FloatArray
    disturbed: bool
    cautious: bool


class TeamRows(NamedTuple):
    """The rows of one team, written anew for each.

    Attributes
    ----------
    first, second : (m,) integer array
        The robots of each row; where there is no second one, N or a larger number, for each row
        another.
    ax, ay : (m,) array
        Coefficients of the first robot's velocity; the second's are the opposite.
    bound : (m,) array
        Right-hand sides, m/s.
    """

    first: IntArray
    second: IntArray
    ax: FloatArray
    ay: FloatArray
    bound: FloatArray


def recipe_of(
    limits: LimitRows | None,
    walls: WallRows | None,
    obstacles: ObstacleRows,
    pairs: PairRows | None,
    cautious: bool,
) -> Recipe:
    """Return what the rows of a certificate are made from.

    Parameters
    ----------
    limits, walls, obstacles, pairs : row families
        Those of a single certificate.
    cautious : bool
        Whether teams with something too close are left to a single certificate.
    """
    kinds = (walls, obstacles, pairs)
    gains = [(0.0, 0.0) if kind is None else (kind.gain, kind.unsafe_gain) for kind in kinds]
    factors = np.array([[0.4], [0.5], [0.5]])
    disturbances = np.array([_sizes(walls), _sizes(obstacles)])
    arrays = (
        np.zeros((3, 0)) if limits is None else np.vstack([limits.normals, limits.bounds]),
        np.zeros((3, 0)) if walls is None else np.vstack([walls.normals, walls.inner]),
        obstacles.table(),
    )
    # Compiled code is for one order of memory; another would be compiled anew.
    for_limits, for_walls, for_obstacles = map(np.ascontiguousarray, arrays)
    return Recipe(
        for_limits,
        limits is not None and limits.turning,
        for_walls,
        for_obstacles,
        np.zeros(0) if pairs is None else np.array([pairs.radius, pairs.radius**2]),
        factors * np.array(gains),
        disturbances,
        bool(disturbances.any()),
        cautious,
    )


def rows_of(recipe: Recipe, number: int) -> TeamRows:
    """Return the rows of a team of some size, with who is in each, and all else to be written.

    Parameters
    ----------
    recipe : Recipe
        What they are made from.
    number : int
        Number of robots, N.
    """
    alone = recipe.limits.shape[1] + recipe.walls.shape[1] + recipe.obstacles.shape[1]
    first, second = np.triu_indices(number if recipe.pairs.shape[0] else 0, 1)
    with_world = np.tile(np.arange(number), alone)
    total = with_world.shape[0] + first.shape[0]
    return TeamRows(
        np.concatenate([with_world, first]).astype(np.intp),
        np.concatenate([number + np.arange(with_world.shape[0]), second]).astype(np.intp),
        np.zeros(total),
        np.zeros(total),
        np.zeros(total),
    )


def _sizes(rows: WallRows | ObstacleRows | None) -> tuple[float, float]:
    if rows is None or rows.disturbance is None:
        return 0.0, 0.0
    return largest(rows.disturbance.along), largest(rows.disturbance.across)
