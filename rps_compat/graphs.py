"""Graph Laplacians of common topologies, and who is whose neighbour.

L is the degree matrix less the adjacency matrix: L[i, i] counts the neighbours of i, and L[i, j] is
−1 where i and j are joined. Its rows sum to zero. With it, ẋ = −L x is consensus.

The random graphs draw from numpy's global generator, in the published order, so that a seeded
script meets the same graphs here and there.
"""

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import within
from rps_compat.kinematics import Array

Indices = NDArray[np.intp]


def line(n: int) -> Array:
    """Return the Laplacian of a line; of one node it is [[1]], as published.

    Parameters
    ----------
    n : int
        Number of nodes.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.
    """
    laplacian = _band(n)
    laplacian[0, 0] = laplacian[-1, -1] = 1.0
    return laplacian


def cycle(n: int) -> Array:
    """Return the Laplacian of a ring; from three nodes on, its rows sum to zero.

    Parameters
    ----------
    n : int
        Number of nodes.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.
    """
    laplacian = _band(n)
    laplacian[0, -1] = laplacian[-1, 0] = -1.0
    return laplacian


def complete(n: int) -> Array:
    """Return the Laplacian of nodes that are all joined.

    Parameters
    ----------
    n : int
        Number of nodes.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.
    """
    laplacian: Array = n * np.eye(n) - np.ones((n, n))
    return laplacian


def random(nodes: int, edges: int) -> Array:
    """Return the Laplacian of a random graph.

    Parameters
    ----------
    nodes : int
        Number of nodes, n.
    edges : int
        Number of edges; with more than there can be, all are there.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.
    """
    return _with_more_edges(np.zeros((nodes, nodes)), edges)


def random_connected(nodes: int, extra_edges: int) -> Array:
    """Return the Laplacian of a random tree with some edges more.

    Parameters
    ----------
    nodes : int
        Number of nodes, n.
    extra_edges : int
        Edges beyond the tree's n − 1; with more than there can be, all are there.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.
    """
    adjacency = np.zeros((nodes, nodes))
    for node in range(1, nodes):
        parent = np.random.randint(0, node)  # noqa: NPY002  (the published stream)
        adjacency[node, parent] = adjacency[parent, node] = 1.0
    return _with_more_edges(adjacency, extra_edges)


def topological_neighbors(laplacian: Array, agent: int) -> Indices:
    """Return the nodes that are joined to an agent, in ascending order.

    Parameters
    ----------
    laplacian : (n, n) array
        Laplacian of the graph.
    agent : int
        The agent's node.

    Returns
    -------
    (k,) integer array
        Numbers of the neighbours.
    """
    joined = laplacian[agent] != 0
    joined[agent] = False
    return np.nonzero(joined)[0]


def disk_neighbors(positions: Array, agent: int, radius: float) -> Indices:
    """Return the agents within a radius of one, in ascending order.

    Parameters
    ----------
    positions : (d, N) array
        Positions, m.
    agent : int
        Column of the one in the middle.
    radius : float
        The radius, m; who is exactly there counts.

    Returns
    -------
    (k,) integer array
        Numbers of the neighbours.
    """
    near: NDArray[np.bool_] = within(
        np.linalg.norm(positions - positions[:, [agent]], axis=0), radius
    )
    near[agent] = False
    return np.nonzero(near)[0]


def _band(n: int) -> Array:
    band: Array = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    return band


def _with_more_edges(adjacency: Array, edges: int) -> Array:
    free = np.argwhere(np.triu(adjacency == 0, 1))
    order = np.random.permutation(len(free))  # noqa: NPY002  (the published stream)
    first, second = free[order[: max(edges, 0)]].T
    adjacency[first, second] = adjacency[second, first] = 1.0
    laplacian: Array = np.diag(adjacency.sum(axis=1)) - adjacency
    return laplacian
