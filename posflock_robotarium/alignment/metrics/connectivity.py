"""Whether a flock hangs together: the graph that links each agent to its neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components as _components
from scipy.sparse.linalg import ArpackError, eigsh

from barrier_certificates.ties import beyond
from posflock_robotarium.alignment.metrics.states import checked_states, of_each_flock
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS, neighbour_pairs

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


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
    return algebraic_connectivity_of(neighbours(p, radius), _there(p))


def algebraic_connectivity_of(adjacency: Booleans, there: Booleans) -> Floats:
    """Return the same of graphs that are known already.

    Parameters
    ----------
    adjacency : (..., N, N) boolean array
        Row i marks the neighbours of agent i.
    there : (..., N) boolean array
        Which agents are there.

    Returns
    -------
    (...) array
        The eigenvalue, from 0 to N.
    """
    agents = adjacency.shape[-1]
    if agents < 2:
        return np.full(adjacency.shape[:-2], np.nan)
    links = adjacency | np.swapaxes(adjacency, -1, -2)
    # Each agent that is not there has a zero of its own.
    place = np.minimum(1 + (~there).sum(axis=-1), agents - 1)
    # A flock that has parted has more zeros, which is told for far less than eigenvalues.
    connected = connected_components_of(adjacency, there) == 1
    second = np.zeros(connected.shape)
    if agents >= TREE_FROM_AGENTS:
        for at in map(tuple, np.argwhere(connected)):
            here = np.flatnonzero(there[at])
            second[at] = _second_of_many(links[at][np.ix_(here, here)])
    elif connected.any():
        values = np.linalg.eigvalsh(_laplacians(links[connected]))
        second[connected] = np.take_along_axis(values, place[connected][:, np.newaxis], axis=1)[
            :, 0
        ]
    alone = there.sum(axis=-1) < 2
    return np.where(alone, np.nan, np.where(beyond(second, 0.0), second, 0.0))


def _laplacians(links: Booleans) -> Floats:
    """Return the Laplacians (K, N, N) of mutual links."""
    laplacian = -links.astype(float)
    agents = np.arange(links.shape[-1])
    laplacian[..., agents, agents] = links.sum(axis=-1)
    return laplacian


def _second_of_many(links: Booleans) -> float:
    """Return the second smallest eigenvalue of one connected graph with links (N, N)."""
    if len(links) < TREE_FROM_AGENTS:
        return float(np.linalg.eigvalsh(_laplacians(links))[:2].max())
    graph = csc_array(links.astype(float))
    laplacian = csc_array(diags_array(graph.sum(axis=0)) - graph)
    # The two that are nearest to a shift below the smallest, 0: the shifted matrix is definite.
    start = np.cos(np.arange(len(links)))
    try:
        values = eigsh(laplacian, 2, sigma=-1e-2, v0=start, return_eigenvectors=False)
    except ArpackError:
        values = np.linalg.eigvalsh(laplacian.toarray())[:2]
    return float(np.max(values))


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
    return connected_components_of(neighbours(p, radius), there)


def connected_components_of(adjacency: Booleans, there: Booleans) -> NDArray[np.int_]:
    """Return the same of graphs that are known already.

    Parameters
    ----------
    adjacency : (..., N, N) boolean array
        Row i marks the neighbours of agent i.
    there : (..., N) boolean array
        Which agents are there.

    Returns
    -------
    (...) integer array
        The number of groups.
    """
    # One graph for all flocks, each with node numbers of its own.
    flocks = adjacency.reshape(-1, *adjacency.shape[-2:])
    of_flock, agent, other = np.nonzero(flocks)
    agents = adjacency.shape[-1]
    nodes = len(flocks) * agents
    links = csr_array(
        (np.ones(len(agent)), (of_flock * agents + agent, of_flock * agents + other)),
        (nodes, nodes),
    )
    _, labels = _components(links, directed=False)
    # No group reaches from one flock into another: so each is counted where it is met first.
    _, met_first = np.unique(labels, return_index=True)
    counts = np.bincount(met_first // agents, minlength=len(flocks))
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
