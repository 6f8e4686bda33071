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
    """Laplacian (n, n) of a line of `n` nodes; of one node, [[1]] as published."""
    laplacian = _band(n)
    laplacian[0, 0] = laplacian[-1, -1] = 1.0
    return laplacian


def cycle(n: int) -> Array:
    """Laplacian (n, n) of a ring of `n` nodes; from three nodes on, its rows sum to zero."""
    laplacian = _band(n)
    laplacian[0, -1] = laplacian[-1, 0] = -1.0
    return laplacian


def complete(n: int) -> Array:
    """Laplacian (n, n) of `n` nodes that are all joined."""
    laplacian: Array = n * np.eye(n) - np.ones((n, n))
    return laplacian


def random(nodes: int, edges: int) -> Array:
    """Laplacian of a random graph with `edges` edges, or with all there can be."""
    return _with_more_edges(np.zeros((nodes, nodes)), edges)


def random_connected(nodes: int, extra_edges: int) -> Array:
    """Laplacian of a random tree over `nodes` nodes with `extra_edges` edges more."""
    adjacency = np.zeros((nodes, nodes))
    for node in range(1, nodes):
        parent = np.random.randint(0, node)  # noqa: NPY002  (the published stream)
        adjacency[node, parent] = adjacency[parent, node] = 1.0
    return _with_more_edges(adjacency, extra_edges)


def topological_neighbors(laplacian: Array, agent: int) -> Indices:
    """Nodes that `laplacian` (n, n) joins to `agent`, in ascending order."""
    joined = laplacian[agent] != 0
    joined[agent] = False
    return np.nonzero(joined)[0]


def disk_neighbors(positions: Array, agent: int, radius: float) -> Indices:
    """Columns of `positions` (d, N) within `radius` (m) of column `agent`, in ascending order."""
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
