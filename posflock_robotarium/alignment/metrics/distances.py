"""How far agents are from each other and from the walls."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.wall_distance import wall_distances
from posflock_robotarium.alignment.metrics.states import checked_states, of_each_flock
from posflock_robotarium.alignment.of_seen import mean_of_seen
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS, nearest_distances

Floats = NDArray[np.float64]


def distances_to_nearest(positions: ArrayLike) -> Floats:
    """Return each agent's distance to the nearest other.

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.

    Returns
    -------
    (..., N) array
        The distances, m; infinite where an agent is alone.
    """
    p = checked_states(positions, "positions")
    if p.shape[-1] >= TREE_FROM_AGENTS and not np.isnan(p).any():
        return of_each_flock(nearest_distances, p)
    return np.asarray(_distances(p).min(axis=-1))


def nearest_neighbour_distance(positions: ArrayLike) -> Floats:
    """Return the mean over agents of the distance to the nearest other.

    This is what the paper plots as inter-agent separation: the mean over *all* pairs of its
    flock is five times as large.  NaN for one agent.

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.

    Returns
    -------
    (...) array
        The mean, m.
    """
    return mean_to_nearest(distances_to_nearest(positions))


def mean_to_nearest(nearest: Floats) -> Floats:
    """Return the mean over agents of the distance to the nearest other.

    Parameters
    ----------
    nearest : (..., N) array
        From `distances_to_nearest`, m.

    Returns
    -------
    (...) array
        The mean, m; NaN where nobody has another.
    """
    if nearest.shape[-1] < 2:
        return np.full(nearest.shape[:-1], np.nan)
    alone = np.isinf(nearest)
    return mean_of_seen(np.where(alone, np.nan, nearest)) if alone.any() else nearest.mean(axis=-1)


def smallest_distance(positions: ArrayLike) -> Floats:
    """Return the distance of the closest pair.

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.

    Returns
    -------
    (...) array
        The distance, m; infinite for one agent.
    """
    return np.asarray(distances_to_nearest(positions).min(axis=-1))


def wall_distance(positions: ArrayLike, arena: tuple[float, float, float, float]) -> Floats:
    """Return how far the agent nearest to a wall is inside the arena.

    Negative where an agent is outside.

    Parameters
    ----------
    positions : (..., d, N) array
        Metres; the first two coordinates count.
    arena : (4,) tuple
        Least x, greatest x, least y, greatest y in metres.

    Returns
    -------
    (...) array
        The distance, m.
    """
    p = checked_states(positions, "positions")
    return np.asarray(np.fmin.reduce(wall_distances(p, arena), axis=-1))


def pairwise_distances(positions: ArrayLike) -> Floats:
    """Return ‖p_j − p_i‖ of every pair once.

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.

    Returns
    -------
    (..., P) array
        The distances of the P = N(N−1)/2 pairs, m.

    Raises
    ------
    ParameterError
        Where there is only one agent.
    """
    p = checked_states(positions, "positions")
    if p.shape[-1] < 2:
        raise ParameterError("positions: expected at least two agents to have a pair, got one")
    i, j = np.triu_indices(p.shape[-1], 1)
    offset = np.take(p, j, axis=-1) - np.take(p, i, axis=-1)
    return np.asarray(np.sqrt(np.square(offset).sum(axis=-2)))


def _distances(p: Floats) -> Floats:
    """Return ‖p_j − p_i‖ with infinity on the diagonal, (..., N, N)."""
    squares = np.zeros((*p.shape[:-2], p.shape[-1], p.shape[-1]))
    for x in np.moveaxis(p, -2, 0):
        offset = x[..., np.newaxis, :] - x[..., :, np.newaxis]
        squares += np.square(offset, out=offset)
    distance: Floats = np.sqrt(squares, out=squares)
    distance[np.isnan(distance)] = np.inf
    agents = np.arange(distance.shape[-1])
    distance[..., agents, agents] = np.inf
    return distance
