"""Whether a flock hangs together: the graph that links each agent to its neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components as _components

from barrier_certificates.ties import beyond
from posflock_robotarium.alignment.metrics.states import checked_states, of_each_flock
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS, neighbour_pairs

Floats = NDArray[np.float64]


def algebraic_connectivity(positions: ArrayLike, radius: float | Floats) -> Floats:
    """Return the second smallest eigenvalue of the graph Laplacian: above 0 when connected.

    Agents are linked where either is the other's neighbour.  It is N for a complete graph and
    falls as the flock hangs together by fewer links; NaN for one agent.

    Parameters
    ----------
    positions : (..., d, N) array
        Metres.
    radius : float or (N,) array
        Interaction radius in metres.

    Returns
    -------
    (...) array
        The eigenvalue, from 0 to N.
    """
    p = checked_states(positions, "positions")
    adjacency = neighbours(p, radius)
    there = _there(p)
    if adjacency.shape[-1] < 2:
        return np.full(adjacency.shape[:-2], np.nan)
    links = (adjacency | np.swapaxes(adjacency, -1, -2)).astype(float)
    laplacian = -links
    agents = np.arange(links.shape[-1])
    laplacian[..., agents, agents] = links.sum(axis=-1)
    values = np.linalg.eigvalsh(laplacian)
    if there.all():
        second = values[..., 1]
    else:  # each agent that is not there has a zero of its own
        place = np.minimum(1 + (~there).sum(axis=-1), values.shape[-1] - 1)
        second = np.take_along_axis(values, place[..., np.newaxis], axis=-1)[..., 0]
    alone = there.sum(axis=-1) < 2
    return np.where(alone, np.nan, np.where(beyond(second, 0.0), second, 0.0))


def connected_components(positions: ArrayLike, radius: float | Floats) -> NDArray[np.int_]:
    """Return the number of groups: agents linked where either is the other's neighbour.

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.
    radius : float or (N,) array
        Interaction radius, m.

    Returns
    -------
    (...) integer array
        The number of groups.
    """
    p = checked_states(positions, "positions")
    there = _there(p)
    if p.shape[-1] >= TREE_FROM_AGENTS and there.all():
        groups = of_each_flock(lambda flock: _tree_components(flock, radius), p)
        return np.asarray(groups, dtype=int)
    adjacency = neighbours(p, radius)
    # One graph for all flocks, each with node numbers of its own.
    flocks = adjacency.reshape(-1, *adjacency.shape[-2:])
    of_flock, agent, other = np.nonzero(flocks)
    agents = p.shape[-1]
    nodes = len(flocks) * agents
    links = csr_array(
        (np.ones(len(agent)), (of_flock * agents + agent, of_flock * agents + other)),
        (nodes, nodes),
    )
    _, labels = _components(links, directed=False)
    counts = [len(np.unique(row)) for row in labels.reshape(-1, agents)]
    groups = np.asarray(counts, dtype=int).reshape(adjacency.shape[:-2])
    # Who is not there has no links, and is no group.
    return np.asarray(groups - (~there).sum(axis=-1), dtype=int)


def _there(p: Floats) -> NDArray[np.bool_]:
    """Return which agents are there, (..., N)."""
    return np.asarray(np.isfinite(p).all(axis=-2), dtype=bool)


def _tree_components(p: Floats, radius: float | Floats) -> int:
    pairs = neighbour_pairs(p, radius)
    links = csr_array((np.ones(len(pairs.agent)), (pairs.agent, pairs.other)), (pairs.agents,) * 2)
    return int(_components(links, directed=False, return_labels=False))
