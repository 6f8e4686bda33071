"""Graphs by the names of generation 2. The mathematics is in :mod:`rps_compat.graphs`."""

import numpy as np

from rps_compat import graphs
from rps_compat.arguments import agent_index, count, table
from rps_compat.graphs import Indices
from rps_compat.kinematics import Array

__all__ = [
    "completeGL",
    "cycleGL",
    "delta_disk_neighbors",
    "lineGL",
    "np",
    "randomGL",
    "random_connectedGL",
    "topological_neighbors",
]


def cycleGL(n: int) -> Array:  # noqa: N802
    """Laplacian (n, n) of a ring; NumberError unless `n` is an int of at least 3."""
    count("n", n, least=3)
    return graphs.cycle(n)


def lineGL(n: int) -> Array:  # noqa: N802
    """Laplacian (n, n) of a line; NumberError unless `n` is an int of at least 2."""
    count("n", n, least=2)
    return graphs.line(n)


def completeGL(n: int) -> Array:  # noqa: N802
    """Laplacian (n, n) of the complete graph; NumberError unless `n` is an int >= 1."""
    count("n", n)
    return graphs.complete(n)


def randomGL(v: int, e: int) -> Array:  # noqa: N802
    """Laplacian (v, v) of a random graph with `e` edges, as many as there can be at most.

    Raises
    ------
    NumberError
        `v` is not an int >= 1, or `e` not an int >= 0.
    """
    count("v", v)
    count("e", e, least=0)
    return graphs.random(v, e)


def random_connectedGL(v: int, e: int) -> Array:  # noqa: N802
    """Laplacian (v, v) of a random tree with `e` more edges, as many as there can be at most.

    Raises
    ------
    NumberError
        `v` is not an int >= 1, or `e` not an int >= 0.
    """
    count("v", v)
    count("e", e, least=0)
    return graphs.random_connected(v, e)


def topological_neighbors(L: Array, agent: int) -> Indices:
    """Neighbours of `agent` in the graph of the Laplacian `L` (n, n), ascending.

    Raises
    ------
    NotAnArrayError, ShapeError
        `L` is not an array, or not square.
    AgentError
        There is no such agent.
    """
    table("L", L, "(n, n)")
    agent_index(agent, L.shape[0], numpy_integers=True)
    return graphs.topological_neighbors(L, int(agent))


def delta_disk_neighbors(poses: Array, agent: int, delta: float) -> Indices:
    """Robots no farther than `delta` (m) from `agent`, ascending.

    Parameters
    ----------
    poses : array
        Positions or poses (2 or 3, N); headings are not read.

    Raises
    ------
    NotAnArrayError, ShapeError
        `poses` is not an array of two dimensions.
    AgentError
        There is no such agent.
    TypeError
        `delta` is not a number.
    """
    table("poses", poses, "(3, N)")
    agent_index(agent, poses.shape[1], numpy_integers=True)
    return graphs.disk_neighbors(poses[:2], int(agent), delta)
