r"""Whether a flock goes one way: γ of neighbours, polarisation of all, common heading.

Alignment is the mean cosine between an agent's direction and its neighbours',

.. math:: \gamma = \frac1n \sum_i \frac{1}{|N_i|} \sum_{j \in N_i}
          \frac{v_i^\top v_j}{\|v_i\| \|v_j\|} \in [-1, 1].

For robots there are two of it, and a run must be judged by both: γ *from headings* takes
where the robots point, γ *from motion* where they go.  A flock parked at a wall has
parallel headings and does not move.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.ties import TIE, beyond
from posflock_robotarium.alignment.metrics.states import checked_states
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS, neighbours_of_seen

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Alignment:
    """γ and whom it speaks for.

    Attributes
    ----------
    gamma : (...) array
        Mean cosine to neighbours, from -1 to 1; NaN where no agent could be counted.
    counted : (...) array of int
        Agents in the mean: those that move and have a neighbour that moves.
    """

    gamma: Floats
    counted: NDArray[np.int_]


def alignment(
    velocities: ArrayLike,
    positions: ArrayLike,
    radius: float | Floats,
    *,
    slowest: float = 0.0,
    heard: NDArray[np.bool_] | None = None,
) -> Alignment:
    """Return γ, the mean over agents of the mean cosine to their neighbours.

    An agent that has no neighbour, or is no faster than `slowest` and so has no direction,
    is left out of the means, as the agent and as a neighbour.

    Parameters
    ----------
    velocities, positions : (..., d, N) array
        m/s (or unit headings) and metres.
    radius : float or (N,) array
        Interaction radius in metres: who is whose neighbour.
    slowest : float
        Speed in m/s that does not count as moving.
    heard : (..., N, N) boolean array, optional
        Who is whose neighbour, where that is known already; row i marks the neighbours of i.

    Returns
    -------
    Alignment
        γ and the number of agents it was taken over.

    Raises
    ------
    ParameterError
        Where velocities and positions have different shapes.
    """
    v, p = checked_states(velocities, "velocities"), checked_states(positions, "positions")
    if v.shape != p.shape:
        raise ParameterError(
            f"velocities and positions: expected one shape, got {v.shape} and {p.shape}"
        )
    speed = np.sqrt(np.square(v).sum(axis=-2))
    moving = beyond(speed, slowest)
    direction = np.divide(v, speed[..., None, :], out=np.zeros_like(v), where=moving[..., None, :])
    # Σ_j e_i·e_j = e_i · Σ_j e_j: no (N, N) matrix of cosines is needed.
    number, around = _neighbour_sums(p, radius, moving, direction, heard)
    cosines = (direction * around).sum(axis=-2)
    counts = moving & (number > 0)
    mean = np.divide(cosines, number, out=np.zeros_like(cosines), where=counts)
    counted = counts.sum(axis=-1)
    total = mean.sum(axis=-1)
    gamma = np.divide(total, counted, out=np.full(np.shape(total), np.nan), where=counted > 0)
    return Alignment(np.clip(gamma, -1.0, 1.0), counted)


def alignment_without_each(
    velocities: Floats, positions: Floats, radius: float | Floats, *, slowest: float = 0.0
) -> Floats:
    """Return γ as it would be without each of the agents, at the cost of γ itself.

    Parameters
    ----------
    velocities, positions : (T, d, N) array
        m/s and metres.
    radius : float or (N,) array
        Interaction radius in metres.
    slowest : float
        Speed in m/s that does not count as moving.

    Returns
    -------
    (T, N) array
        Column n is what :func:`alignment` says where agent n is not there.
    """
    speed = np.sqrt(np.square(velocities).sum(axis=1))
    moving = beyond(speed, slowest)
    found = np.empty(speed.shape)
    for t, (v, p) in enumerate(zip(velocities, positions, strict=True)):
        pairs = neighbours_of_seen(p, radius)
        pairs = pairs.where(moving[t, pairs.agent] & moving[t, pairs.other])
        e = np.divide(v, speed[t], out=np.zeros_like(v), where=moving[t])
        cosine = (e[:, pairs.agent] * e[:, pairs.other]).sum(axis=0)
        number, total = pairs.counts, pairs.sums(cosine[np.newaxis])[0]
        mean = np.divide(total, number, out=np.zeros(number.shape), where=number > 0)
        # Who has `other` for a neighbour has one less without it, or is no longer counted.
        left = number[pairs.agent] - 1
        rest = total[pairs.agent] - cosine
        new = np.divide(rest, left, out=np.zeros_like(cosine), where=left > 0)
        changed = np.bincount(pairs.other, new - mean[pairs.agent], pairs.agents)
        gone = np.bincount(pairs.other, left == 0, pairs.agents)
        count = (number > 0).sum() - (number > 0) - gone
        sums = mean.sum() - mean + changed
        found[t] = np.divide(sums, count, out=np.full(sums.shape, np.nan), where=count > 0)
    return np.clip(found, -1.0, 1.0)


def heading_vectors(poses: ArrayLike) -> Floats:
    """Return unit vectors along the headings.

    Parameters
    ----------
    poses : (..., 3, N) array
        Poses, m and rad.

    Returns
    -------
    (..., 2, N) array
        Unit vectors.
    """
    theta = np.asarray(poses, dtype=float)[..., 2, :]
    return np.stack([np.cos(theta), np.sin(theta)], axis=-2)


def polarisation(velocities: ArrayLike, *, slowest: float = 0.0) -> Floats:
    """Return ‖mean of the unit directions‖ over the agents that move: 1 parallel, 0 none shared.

    The order parameter of flocking.  Unlike γ it asks nothing of neighbours, so two groups that
    part in opposite directions read 0 here and 1 there.  NaN where nobody moves.

    Parameters
    ----------
    velocities : (..., d, N) array
        m/s, or unit headings.
    slowest : float
        Speed in m/s that does not count as moving.

    Returns
    -------
    (...) array
        From 0 to 1.
    """
    mean = _mean_direction(velocities, slowest)
    return np.asarray(np.sqrt(np.square(mean).sum(axis=-1)))


def common_heading(velocities: ArrayLike, *, slowest: float = 0.0) -> Floats:
    """Return the angle of the mean direction in the plane.

    Parameters
    ----------
    velocities : (..., 2, N) array
        m/s, or unit headings.
    slowest : float
        Speed in m/s that does not count as moving.

    Returns
    -------
    (...) array
        The angle, rad in (-π, π]; NaN where undefined.
    """
    mean = _mean_direction(velocities, slowest)
    angle = np.arctan2(mean[..., 1], mean[..., 0])
    # Opposite robots cancel: what rounding leaves of their mean has no direction.
    return np.where(np.square(mean).sum(axis=-1) > TIE**2, angle, np.nan)


def _mean_direction(velocities: ArrayLike, slowest: float) -> Floats:
    """Return the mean unit vector of the agents that move, (..., d); NaN where nobody does."""
    v = checked_states(velocities, "velocities")
    speed = np.sqrt(np.square(v).sum(axis=-2))
    moving = beyond(speed, slowest)
    direction = np.divide(v, speed[..., None, :], out=np.zeros_like(v), where=moving[..., None, :])
    number = moving.sum(axis=-1)[..., None]
    total = direction.sum(axis=-1)
    return np.asarray(np.divide(total, number, out=np.full_like(total, np.nan), where=number > 0))


def _neighbour_sums(
    p: Floats,
    radius: float | Floats,
    moving: NDArray[np.bool_],
    direction: Floats,
    heard: NDArray[np.bool_] | None,
) -> tuple[NDArray[np.int_], Floats]:
    """Return how many moving neighbours each agent has, and the sum of their directions."""
    if p.shape[-1] < TREE_FROM_AGENTS:
        heard = (neighbours(p, radius) if heard is None else heard) & moving[..., None, :]
        around = np.einsum("...ij,...dj->...di", heard.astype(float), direction)
        return heard.sum(axis=-1), around
    number, around = np.zeros(moving.shape, dtype=int), np.zeros_like(direction)
    for at in np.ndindex(moving.shape[:-1]):
        pairs = neighbours_of_seen(p[at], radius)
        pairs = pairs.where(moving[at][pairs.other])
        number[at] = pairs.counts
        around[at] = pairs.sums(direction[at][:, pairs.other])
    return number, around
