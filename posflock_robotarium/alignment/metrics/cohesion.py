"""How close together a flock stays, and how much of its first formation it keeps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posflock_robotarium.alignment.metrics.distances import pairwise_distances
from posflock_robotarium.alignment.metrics.states import checked_states
from posflock_robotarium.alignment.of_seen import centroid_of_seen, mean_of_seen

Floats = NDArray[np.float64]


def cohesive_radius(positions: ArrayLike) -> Floats:
    """Return the largest distance of an agent from the centroid (paper, Fig. "hist").

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.

    Returns
    -------
    (...) array
        The distance, m.
    """
    p = checked_states(positions, "positions")
    offset = p - centroid_of_seen(p)[..., np.newaxis]
    return np.asarray(np.fmax.reduce(np.sqrt(np.square(offset).sum(axis=-2)), axis=-1))


def spread(positions: ArrayLike) -> Floats:
    """Return the root mean square distance of the agents from their centroid.

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.

    Returns
    -------
    (...) array
        The distance, m.
    """
    p = checked_states(positions, "positions")
    offset = p - centroid_of_seen(p)[..., np.newaxis]
    return np.sqrt(mean_of_seen(np.square(offset).sum(axis=-2)))


def pairwise_distance_variance(positions: ArrayLike) -> Floats:
    """Return Var(‖p_j − p_i‖) over all pairs (paper, Fig. "metrics").

    Parameters
    ----------
    positions : (..., d, N) array
        Positions, m.

    Returns
    -------
    (...) array
        The variance, m².
    """
    return np.asarray(pairwise_distances(positions).var(axis=-1))


def pairwise_change_variance(positions: ArrayLike, first: ArrayLike) -> Floats:
    """Return Var(‖p_ij(t)‖ − ‖p_ij(0)‖) over all pairs: zero for a rigid formation.

    This, and not :func:`pairwise_distance_variance`, measures what the paper's Fig.
    "metrics" argues: how much of the first formation is lost.

    Parameters
    ----------
    positions : (..., d, N) array
        Metres.
    first : (d, N) array
        The positions at t = 0.

    Returns
    -------
    (...) array
        The variance, m².
    """
    return np.asarray((pairwise_distances(positions) - pairwise_distances(first)).var(axis=-1))
