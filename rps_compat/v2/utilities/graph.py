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
    """Return the Laplacian of a ring.

    Parameters
    ----------
    n : int
        Number of nodes.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.

    Raises
    ------
    NumberError
        `n` is not an int >= 3.
    """
    count("n", n, least=3)
    return graphs.cycle(n)


def lineGL(n: int) -> Array:  # noqa: N802
    """Return the Laplacian of a line.

    Parameters
    ----------
    n : int
        Number of nodes.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.

    Raises
    ------
    NumberError
        `n` is not an int >= 2.
    """
    count("n", n, least=2)
    return graphs.line(n)


def completeGL(n: int) -> Array:  # noqa: N802
    """Return the Laplacian of the complete graph.

    Parameters
    ----------
    n : int
        Number of nodes.

    Returns
    -------
    (n, n) array
        Degrees on the diagonal, −1 for each edge, else 0.

    Raises
    ------
    NumberError
        `n` is not an int >= 1.
    """
    count("n", n)
    return graphs.complete(n)


def randomGL(v: int, e: int) -> Array:  # noqa: N802
    """Return the Laplacian of a random graph.

    Parameters
    ----------
    v : int
        Number of nodes.
    e : int
        Number of edges, as many as there can be at most.

    Returns
    -------
    (v, v) array
        Degrees on the diagonal, −1 for each edge, else 0.

    Raises
    ------
    NumberError
        `v` is not an int >= 1, or `e` not an int >= 0.
    """
    count("v", v)
    count("e", e, least=0)
    return graphs.random(v, e)


def random_connectedGL(v: int, e: int) -> Array:  # noqa: N802
    """Return the Laplacian of a random tree with some edges more.

    Parameters
    ----------
    v : int
        Number of nodes.
    e : int
        Number of edges beyond the tree's, as many as there can be at most.

    Returns
    -------
    (v, v) array
        Degrees on the diagonal, −1 for each edge, else 0.

    Raises
    ------
    NumberError
        `v` is not an int >= 1, or `e` not an int >= 0.
    """
    count("v", v)
    count("e", e, least=0)
    return graphs.random_connected(v, e)


def topological_neighbors(L: Array, agent: int) -> Indices:
    """Return the neighbours of an agent in a graph, ascending.

    Parameters
    ----------
    L : (n, n) array
        Laplacian of the graph.
    agent : int
        The agent's number.

    Returns
    -------
    (k,) integer array
        Numbers of the neighbours.

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
    """Return the robots no farther than a radius from one, ascending.

    Parameters
    ----------
    poses : (2, N) or (3, N) array
        Positions or poses, m; headings are not read.
    agent : int
        The agent in the middle.
    delta : float
        Radius around it (m); who is exactly there counts.

    Returns
    -------
    (k,) integer array
        Numbers of the neighbours.

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
