r"""What a run was: alignment, distances, cohesion, one definition each.

Every function takes states with any leading axes, ``(..., d, N)``, typically ``(T, d, N)``
for a whole run, and returns one value for each of them.  Positions are in metres,
velocities in m/s.  The definitions are the paper's (Jond et al., Section "Simulation"),
made exact where it leaves room.

Alignment is the mean cosine between an agent's direction and its neighbours',

.. math:: \gamma = \frac1n \sum_i \frac{1}{|N_i|} \sum_{j \in N_i}
          \frac{v_i^\top v_j}{\|v_i\| \|v_j\|} \in [-1, 1].

For robots there are two of it, and a run must be judged by both: γ *from headings* takes
where the robots point, γ *from motion* where they go.  A flock parked at a wall has
parallel headings and does not move.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import savgol_filter
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components as _components

from barrier_certificates.ties import TIE, beyond
from barrier_certificates.wall_distance import wall_distances
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import displacements, neighbours
from posflock_robotarium.freespace.neighbour_search import (
    TREE_FROM_AGENTS,
    nearest_distances,
    neighbour_pairs,
)

Floats = NDArray[np.float64]

#: Logged poses jitter; eleven points (0.36 s) of a quadratic restore directions to a mean
#: cosine of 0.9997 where one-frame differences give 0.97 at 0.05 m/s.
SMOOTHING_POINTS = 11

#: m/s up to which a robot seen by the tracker has no direction of motion: seven times the speed
#: that 0.5 mm of noise pretends within those eleven points.  Whatever judges a log takes it.
SLOWEST = 0.01


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

    Returns
    -------
    Alignment
        γ and the number of agents it was taken over.

    Raises
    ------
    ParameterError
        Where velocities and positions have different shapes.
    """
    v, p = _states(velocities, "velocities"), _states(positions, "positions")
    if v.shape != p.shape:
        raise ParameterError(
            f"velocities and positions: expected one shape, got {v.shape} and {p.shape}"
        )
    speed = np.sqrt(np.square(v).sum(axis=-2))
    moving = beyond(speed, slowest)
    direction = np.divide(v, speed[..., None, :], out=np.zeros_like(v), where=moving[..., None, :])
    # Σ_j e_i·e_j = e_i · Σ_j e_j: no (N, N) matrix of cosines is needed.
    number, around = _neighbour_sums(p, radius, moving, direction)
    cosines = (direction * around).sum(axis=-2)
    counts = moving & (number > 0)
    mean = np.divide(cosines, number, out=np.zeros_like(cosines), where=counts)
    counted = counts.sum(axis=-1)
    total = mean.sum(axis=-1)
    gamma = np.divide(total, counted, out=np.full(np.shape(total), np.nan), where=counted > 0)
    return Alignment(np.clip(gamma, -1.0, 1.0), counted)


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


def velocities_by_differences(positions: ArrayLike, time_step: float) -> Floats:
    """Return velocities by one-frame differences.

    Exact for simulated poses; for tracked ones see :func:`smoothed_velocities`.  The first
    row repeats the second, so that rows and times still correspond.

    Parameters
    ----------
    positions : (T, d, N) array
        Evenly sampled positions, m.
    time_step : float
        Seconds between rows.

    Returns
    -------
    (T, d, N) array
        Velocities, m/s.
    """
    p = _track(positions, 2)
    step = np.diff(p, axis=0) / time_step
    return np.concatenate([step[:1], step])


def smoothed_velocities(
    positions: ArrayLike, time_step: float, points: int = SMOOTHING_POINTS
) -> Floats:
    """Return velocities by the Savitzky-Golay derivative.

    Parameters
    ----------
    positions : (T, d, N) array
        Evenly sampled, metres.
    time_step : float
        Seconds between rows.
    points : int
        Odd length of the window; a quadratic is fitted to each.

    Returns
    -------
    (T, d, N) array
        Velocities, m/s.

    Raises
    ------
    ParameterError
        Where the window is not odd, or longer than the run.
    """
    p = _track(positions, points)
    if points < 3 or points % 2 == 0:
        raise ParameterError(f"points: expected an odd number from 3, got {points}")
    return np.asarray(savgol_filter(p, points, polyorder=2, deriv=1, delta=time_step, axis=0))


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
    nearest = _nearest(positions)
    if nearest.shape[-1] < 2:
        return np.full(nearest.shape[:-1], np.nan)
    return np.asarray(nearest.mean(axis=-1))


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
    return np.asarray(_nearest(positions).min(axis=-1))


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
    p = _states(positions, "positions")
    offset = p - p.mean(axis=-1, keepdims=True)
    return np.asarray(np.sqrt(np.square(offset).sum(axis=-2)).max(axis=-1))


def mean_speed(velocities: ArrayLike) -> Floats:
    """Return the mean over agents of ‖v_i‖.

    Parameters
    ----------
    velocities : (..., d, N) array
        Velocities, m/s.

    Returns
    -------
    (...) array
        The mean, m/s.
    """
    return np.asarray(np.sqrt(np.square(_states(velocities, "velocities")).sum(-2)).mean(-1))


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
    p = _states(positions, "positions")
    return np.asarray(wall_distances(p, arena).min(axis=-1))


def fastest_wheel(commands: ArrayLike, wheel_radius: float, base_length: float) -> Floats:
    """Return the highest |wheel speed| that commands ask for.

    Parameters
    ----------
    commands : (..., 2, N) array
        Forward speeds v, m/s, and turn rates ω, rad/s.
    wheel_radius : float
        Radius of the wheels, m.
    base_length : float
        From wheel to wheel, m.

    Returns
    -------
    (...) array
        The speed, rad/s.
    """
    u = np.asarray(commands, dtype=float)
    fastest = np.abs(u[..., 0, :]) + np.abs(u[..., 1, :]) * (base_length / 2.0)
    return np.asarray(fastest.max(axis=-1) / wheel_radius)


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
    p = _states(positions, "positions")
    if p.shape[-1] < 2:
        raise ParameterError("positions: expected at least two agents to have a pair, got one")
    i, j = np.triu_indices(p.shape[-1], 1)
    offset = np.take(p, j, axis=-1) - np.take(p, i, axis=-1)
    return np.asarray(np.sqrt(np.square(offset).sum(axis=-2)))


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


def polarisation(velocities: ArrayLike, *, slowest: float = 0.0) -> Floats:
    """Return ‖mean of the unit directions‖ over the agents that move: 1 parallel, 0 none shared.

    Unlike γ it asks nothing of neighbours, so two groups that part in opposite directions read
    0 here and 1 there.  NaN where nobody moves.

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
    p = _states(positions, "positions")
    offset = p - p.mean(axis=-1, keepdims=True)
    return np.asarray(np.sqrt(np.square(offset).sum(axis=-2).mean(axis=-1)))


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
    adjacency = neighbours(_states(positions, "positions"), radius)
    if adjacency.shape[-1] < 2:
        return np.full(adjacency.shape[:-2], np.nan)
    links = (adjacency | np.swapaxes(adjacency, -1, -2)).astype(float)
    laplacian = -links
    agents = np.arange(links.shape[-1])
    laplacian[..., agents, agents] = links.sum(axis=-1)
    second = np.linalg.eigvalsh(laplacian)[..., 1]
    return np.where(beyond(second, 0.0), second, 0.0)


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
    p = _states(positions, "positions")
    if p.shape[-1] >= TREE_FROM_AGENTS:
        return np.asarray(_each_flock(lambda flock: _tree_components(flock, radius), p), dtype=int)
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
    return np.asarray(counts, dtype=int).reshape(adjacency.shape[:-2])


def _mean_direction(velocities: ArrayLike, slowest: float) -> Floats:
    """Return the mean unit vector of the agents that move, (..., d); NaN where nobody does."""
    v = _states(velocities, "velocities")
    speed = np.sqrt(np.square(v).sum(axis=-2))
    moving = beyond(speed, slowest)
    direction = np.divide(v, speed[..., None, :], out=np.zeros_like(v), where=moving[..., None, :])
    number = moving.sum(axis=-1)[..., None]
    total = direction.sum(axis=-1)
    return np.asarray(np.divide(total, number, out=np.full_like(total, np.nan), where=number > 0))


def _neighbour_sums(
    p: Floats, radius: float | Floats, moving: NDArray[np.bool_], direction: Floats
) -> tuple[NDArray[np.int_], Floats]:
    """Return how many moving neighbours each agent has, and the sum of their directions."""
    if p.shape[-1] < TREE_FROM_AGENTS:
        heard = neighbours(p, radius) & moving[..., None, :]
        around = np.einsum("...ij,...dj->...di", heard.astype(float), direction)
        return heard.sum(axis=-1), around
    number, around = np.zeros(moving.shape, dtype=int), np.zeros_like(direction)
    for at in np.ndindex(moving.shape[:-1]):
        pairs = neighbour_pairs(p[at], radius)
        pairs = pairs.where(moving[at][pairs.other])
        number[at] = pairs.counts
        around[at] = pairs.sums(direction[at][:, pairs.other])
    return number, around


def _nearest(positions: ArrayLike) -> Floats:
    """Return each agent's distance to the nearest other, (..., N); infinite where alone."""
    p = _states(positions, "positions")
    if p.shape[-1] >= TREE_FROM_AGENTS:
        return _each_flock(nearest_distances, p)
    return np.asarray(_distances(p).min(axis=-1))


def _distances(positions: ArrayLike) -> Floats:
    """Return ‖p_j − p_i‖ with infinity on the diagonal, (..., N, N)."""
    offset = displacements(_states(positions, "positions"))
    distance = np.sqrt(np.square(offset).sum(axis=-3))
    agents = np.arange(distance.shape[-1])
    distance[..., agents, agents] = np.inf
    return np.asarray(distance)


def _each_flock(measure: Callable[[Floats], ArrayLike], p: Floats) -> Floats:
    """Apply a function of one (d, N) flock along all leading axes."""
    values = [np.asarray(measure(p[at])) for at in np.ndindex(p.shape[:-2])]
    return np.reshape(values, (*p.shape[:-2], *values[0].shape))


def _tree_components(p: Floats, radius: float | Floats) -> int:
    pairs = neighbour_pairs(p, radius)
    links = csr_array((np.ones(len(pairs.agent)), (pairs.agent, pairs.other)), (pairs.agents,) * 2)
    return int(_components(links, directed=False, return_labels=False))


def _states(values: ArrayLike, name: str) -> Floats:
    x = np.asarray(values, dtype=float)
    if x.ndim < 2 or x.shape[-2] not in (2, 3) or x.shape[-1] < 1:
        raise ParameterError(
            f"{name}: expected shape (..., d, N), d = 2 or 3, N from 1; got {x.shape}"
        )
    return x


def _track(positions: ArrayLike, rows: int) -> Floats:
    p = _states(positions, "positions")
    if p.ndim != 3 or p.shape[0] < rows:
        raise ParameterError(
            f"positions: expected shape (T, d, N) with T of at least {rows}, got {p.shape}"
        )
    return p
