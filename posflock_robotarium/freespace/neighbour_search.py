"""The flocking law over a list of neighbouring pairs, for thousands of agents.

:mod:`posflock_robotarium.flocking.law` looks at all n² pairs, which is the fastest way up to a few
hundred agents.  In a flock of bounded density each agent has a bounded number of
neighbours, so that a list of the pairs that are closer than the radius, found with a k-d
tree, costs a time and a memory that grow with n alone.  Formulas and parameters are those
of :mod:`~posflock_robotarium.flocking.law`; only the order of the sums differs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.ties import short_of
from posflock_robotarium.flocking.law import LawParameters, check_states, phi, psi

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

#: From here on a k-d tree beats looking at all n² pairs (benchmarks/freespace_speed.py).
TREE_FROM_AGENTS = 200


@dataclass(frozen=True, eq=False)
class Pairs:
    """Who senses whom: agent ``agent[m]`` has the neighbour ``other[m]``.

    Attributes
    ----------
    agent, other : (M,) array of int
        Indices of agents; each ordered pair appears at most once.
    agents : int
        n.
    """

    agent: Indices
    other: Indices
    agents: int

    @property
    def counts(self) -> Indices:
        """|N_i| of every agent, shape (n,)."""
        return np.bincount(self.agent, minlength=self.agents)

    def offsets(self, states: Floats) -> Floats:
        """Return x_j − x_i of every pair.

        Parameters
        ----------
        states : (d, n) array
            Positions, m, or velocities, m/s.

        Returns
        -------
        (d, M) array
            The differences, in the same unit.
        """
        return np.asarray(states[:, self.other] - states[:, self.agent])

    def sums(self, values: Floats) -> Floats:
        """Return the sum over each agent's pairs.

        Parameters
        ----------
        values : (d, M) array
            A column a pair.

        Returns
        -------
        (d, n) array
            A column an agent, in the same unit.
        """
        return np.stack([np.bincount(self.agent, row, self.agents) for row in values])

    def where(self, kept: NDArray[np.bool_]) -> Pairs:
        """Return the pairs that a mask keeps.

        Parameters
        ----------
        kept : (M,) boolean array
            True for those that stay.
        """
        return Pairs(self.agent[kept], self.other[kept], self.agents)


def neighbour_pairs(positions: ArrayLike, radius: float | Floats) -> Pairs:
    """Find the pairs with ‖p_j − p_i‖ < r_i, j ≠ i, by k-d tree.

    Parameters
    ----------
    positions : (d, n) array
        Metres.
    radius : float or (n,) array
        Interaction radius r_i in metres.

    Returns
    -------
    Pairs
        The pairs that :func:`posflock_robotarium.flocking.law.neighbours` marks.
    """
    from scipy.spatial import cKDTree

    p = check_states(positions, "positions")
    # balanced_tree=False splits boxes in the middle: quicker to build, as good to search here.
    tree = cKDTree(p.T, balanced_tree=False, compact_nodes=False)
    # The tree counts distances equal to the radius and rounds otherwise; the law decides below.
    met = tree.query_pairs(float(np.max(radius)), output_type="ndarray")
    agent = np.concatenate([met[:, 0], met[:, 1]])
    other = np.concatenate([met[:, 1], met[:, 0]])
    pairs = Pairs(agent, other, p.shape[-1])
    distance = np.sqrt(np.square(pairs.offsets(p)).sum(axis=0))
    reach = radius[agent] if isinstance(radius, np.ndarray) else radius
    return pairs.where(short_of(distance, reach))


def neighbours_of_seen(positions: Floats, radius: float | Floats) -> Pairs:
    """Find the neighbouring pairs among the agents whose positions are known.

    Parameters
    ----------
    positions : (d, n) array
        Metres, NaN where unknown.
    radius : float or (n,) array
        Interaction radius r_i in metres.

    Returns
    -------
    Pairs
        As `neighbour_pairs`; who is not seen is in none.
    """
    seen = np.flatnonzero(np.isfinite(positions).all(axis=0))
    if not seen.size:
        return Pairs(seen, seen, positions.shape[-1])
    reach = radius[seen] if isinstance(radius, np.ndarray) else radius
    found = neighbour_pairs(positions[:, seen], reach)
    return Pairs(seen[found.agent], seen[found.other], positions.shape[-1])


def neighbour_matrices(positions: Floats, radius: float | Floats) -> NDArray[np.bool_]:
    """Tell who is whose neighbour at several times, as `flocking.law.neighbours`, by k-d trees.

    Parameters
    ----------
    positions : (K, d, n) array
        Metres, NaN where unknown.
    radius : float or (n,) array
        Interaction radius r_i in metres.

    Returns
    -------
    (K, n, n) boolean array
        Row i marks the members of N_i.
    """
    found = np.zeros((len(positions), positions.shape[-1], positions.shape[-1]), dtype=bool)
    for one, p in zip(found, positions, strict=True):
        pairs = neighbours_of_seen(p, radius)
        one[pairs.agent, pairs.other] = True
    return found


def pairs_within(positions: Floats, distance: float) -> tuple[Indices, Indices]:
    """Return the pairs of agents that may be as near as that, and none that is much farther.

    Parameters
    ----------
    positions : (d, n) array
        Metres, NaN where unknown.
    distance : float
        Metres.

    Returns
    -------
    first, second : (M,) array of int
        Agents, the first of each pair before the second, in no order.
    """
    from scipy.spatial import cKDTree

    seen = np.flatnonzero(np.isfinite(positions).all(axis=0))
    tree = cKDTree(positions[:, seen].T, balanced_tree=False, compact_nodes=False)
    # A little farther than asked: the tree rounds otherwise, and who asks decides.
    met = tree.query_pairs(distance * (1 + 1e-9), output_type="ndarray")
    return seen[met[:, 0]], seen[met[:, 1]]


def nearest_distances(positions: ArrayLike) -> Floats:
    """Return each agent's distance to the nearest other.

    Parameters
    ----------
    positions : (d, n) array
        Positions, m; two agents at least.

    Returns
    -------
    (n,) array
        Distances, m.
    """
    from scipy.spatial import cKDTree

    p = check_states(positions, "positions")
    return np.asarray(cKDTree(p.T).query(p.T, k=2)[0][:, 1])


def velocity_based_input_over(
    pairs: Pairs, positions: Floats, velocities: Floats, parameters: LawParameters
) -> Floats:
    """Return the baseline's input (paper Eq. 2), before saturation, summed over `pairs`.

    Parameters
    ----------
    pairs : Pairs
        Who senses whom.
    positions, velocities : (d, n) array
        Metres and m/s.
    parameters : LawParameters
        δ is used.

    Returns
    -------
    (d, n) array
        Inputs in m/s².
    """
    return pairs.sums(
        _cohesion_separation(pairs, positions, parameters) + pairs.offsets(velocities)
    )


def position_based_input_over(
    pairs: Pairs,
    positions: Floats,
    first: Floats,
    time: float,
    parameters: LawParameters,
    *,
    threshold: bool = True,
) -> Floats:
    """Return the position-based input (paper Eq. 6), before saturation, summed over `pairs`.

    Parameters
    ----------
    pairs : Pairs
        Who senses whom.
    positions : (d, n) array
        Metres.
    first : (d, n) array
        Positions of the first instant, from which the imprint of any pair follows: all n²
        displacements need not be stored.
    time : float
        Seconds since that instant, more than zero.
    parameters : LawParameters
        δ and k are used.
    threshold : bool
        Whether the alignment gain stops decaying at t = 1/k.

    Returns
    -------
    (d, n) array
        Inputs in m/s².
    """
    gain = phi(time, pairs.counts, parameters.persistence if threshold else None)
    changed = pairs.offsets(positions) - pairs.offsets(first)
    return pairs.sums(
        _cohesion_separation(pairs, positions, parameters) + gain[pairs.agent] * changed
    )


def _cohesion_separation(pairs: Pairs, positions: Floats, parameters: LawParameters) -> Floats:
    """Return ψ_ij·(p_j − p_i) of every pair, shape (d, M)."""
    parameters.agents_must_be(pairs.agents)
    offset = pairs.offsets(positions)
    rest_distance = parameters.distance_scale * pairs.counts
    gain = psi(np.sqrt(np.square(offset).sum(axis=0)), rest_distance[pairs.agent])
    return np.asarray(gain * offset)
