r"""The flocking law: what each agent wants to do, from where its neighbours are.

Three models share one cohesion-separation term and differ in how they align
(Jond et al., "Position-Based Flocking for Persistent Alignment without Velocity
Sensing"):

==============  ==========================================================================
velocity-based  :math:`u_i = \sum_j \psi_{ij}\,p_{ij} + \sum_j (v_j - v_i)`
position-based  :math:`u_i = \sum_j (\psi_{ij} + \phi_i)\,p_{ij} - \phi_i\sum_j p_{ij}(0)`
no threshold    as position-based, with a gain :math:`\phi_i` that decays for ever
==============  ==========================================================================

where :math:`p_{ij} = p_j - p_i` and the sums run over the neighbours
:math:`N_i(t) = \{j \ne i : \|p_{ij}\| < r_i\}`, found anew at every step.  The *imprint*
:math:`p_{ij}(0)`, every displacement of the first instant, is what the position-based
models remember instead of sensing velocities: the change of a displacement, divided by
the time it took, stands in for a relative velocity.

The functions are pure and know neither arena nor wheels.  Arrays are ``(..., d, n)``: the
last two axes are coordinates (d = 2 or 3) and agents, any axes before them a batch of
independent flocks.  Units are metres, seconds, and what follows from them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.ties import short_of
from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class LawParameters:
    """What the flocking law is told; each may be a scalar or one value per agent.

    Attributes
    ----------
    distance_scale : float or (n,) array
        δ ≥ 0, metres per neighbour: a pair is at rest at distance δ·|N_i|.
    radius : float or (n,) array
        r > 0, metres: agents closer than this are neighbours.
    persistence : float
        k > 0, 1/s: from t = 1/k on, the alignment gain stays at k·|N_i|.
    speed_limit : float or (n,) array
        v_max > 0, m/s.
    input_limit : float or (n,) array
        u_max > 0, m/s².

    Raises
    ------
    ParameterError
        Where a value is not finite or not of the sign stated above.
    """

    distance_scale: float | Floats
    radius: float | Floats
    persistence: float
    speed_limit: float | Floats
    input_limit: float | Floats

    def __post_init__(self) -> None:
        for field in fields(self):
            got = getattr(self, field.name)
            value = _as_floats(got, field.name)
            if value.ndim > (0 if field.name == "persistence" else 1):
                raise ParameterError(
                    f"{field.name}: expected a number"
                    f"{'' if field.name == 'persistence' else ' or one number per agent'},"
                    f" got an array of shape {value.shape}"
                )
            least = 0.0 if field.name == "distance_scale" else np.nextafter(0.0, 1.0)
            if not (np.isfinite(value).all() and (value >= least).all()):
                sign = "zero or more" if field.name == "distance_scale" else "more than zero"
                raise ParameterError(f"{field.name}: expected finite and {sign}, got {got!r}")
            object.__setattr__(self, field.name, float(value) if value.ndim == 0 else value)

    def agents_must_be(self, agents: int) -> None:
        """Refuse per-agent parameters whose length is not the number of agents.

        Parameters
        ----------
        agents : int
            Number of agents.

        Raises
        ------
        ParameterError
            Naming the parameter, its length and the number of agents.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray) and value.shape != (agents,):
                raise ParameterError(
                    f"{field.name}: expected one value for each of {agents} agents,"
                    f" got {value.shape[0]}"
                )

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters as numbers and lists, ready for JSON."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in values.items()}


def displacements(positions: ArrayLike) -> Floats:
    """Return every p_j − p_i, the raw material of the law and, at t = 0, its imprint.

    Parameters
    ----------
    positions : (..., d, n) array
        Positions in metres.

    Returns
    -------
    (..., d, n, n) array
        Metres; ``[..., :, i, j]`` is p_j − p_i.
    """
    p = np.asarray(positions, dtype=float)
    offset: Floats = p[..., :, None, :] - p[..., :, :, None]
    return offset


def neighbours(positions: ArrayLike, radius: float | Floats) -> Booleans:
    """Tell who is whose neighbour: ‖p_j − p_i‖ < r_i, j ≠ i.

    Parameters
    ----------
    positions : (..., d, n) array
        Positions in metres.
    radius : float or (n,) array
        Interaction radius r_i in metres.

    Returns
    -------
    (..., n, n) boolean array
        Row i marks the members of N_i.  With unequal radii it need not be symmetric.
    """
    return _within(_lengths(displacements(positions), -3), radius)


def psi(distance: ArrayLike, rest_distance: ArrayLike) -> Floats:
    """Return the cohesion-separation gain ψ = 1 − δ_i·|N_i| / ‖p_j − p_i‖.

    Negative (repulsive) below the rest distance δ_i·|N_i|, positive beyond.  The paper
    defines it for positive distances only; here a distance of zero gives 1, so that the
    term ψ·(p_j − p_i) of coincident agents is zero.

    Parameters
    ----------
    distance : (...) array
        ‖p_j − p_i‖ in metres.
    rest_distance : (...) array
        δ_i·|N_i| in metres; broadcast against `distance`.

    Returns
    -------
    (...) array
        The gain, in 1/s².
    """
    d = np.asarray(distance, dtype=float)
    gain: Floats = 1.0 - np.divide(rest_distance, d, out=np.zeros_like(d), where=d > 0.0)
    return gain


def phi(time: float, neighbour_count: ArrayLike, persistence: float | Floats | None) -> Floats:
    """Return the alignment gain φ: |N_i|/t until t = 1/k, and k·|N_i| from then on.

    Parameters
    ----------
    time : float
        Seconds since the imprint, more than zero.
    neighbour_count : (...) array
        |N_i|.
    persistence : float or (...) array or None
        k in 1/s; broadcast against `neighbour_count`.  None is the model without threshold:
        |N_i|/t for ever.

    Returns
    -------
    (...) array
        The gain, in 1/s.

    Raises
    ------
    ParameterError
        Where `time` is not a positive number.
    """
    if not time > 0.0:
        raise ParameterError(
            f"time: expected more than 0 s (the first input is computed at t = dt), got {time!r}"
        )
    rate = 1.0 / time if persistence is None else np.maximum(1.0 / time, persistence)
    return np.asarray(neighbour_count, dtype=float) * rate


def saturate(vectors: ArrayLike, limit: float | Floats) -> Floats:
    """Shorten each agent's vector smoothly, x_max·tanh(‖x‖/x_max)·x/‖x‖; keep its direction.

    Parameters
    ----------
    vectors : (..., d, n) array
        Velocities or inputs.
    limit : float or (n,) array
        x_max > 0, in the unit of `vectors`.

    Returns
    -------
    (..., d, n) array
        Vectors no longer than the limit; zero stays zero.
    """
    x = np.asarray(vectors, dtype=float)
    length = _lengths(x, -2)
    shortened = limit * np.tanh(length / limit)
    factor = np.divide(shortened, length, out=np.zeros_like(length), where=length > 0.0)
    out: NDArray[np.float64] = x * factor[..., None, :]
    return out


def velocity_based_input(
    positions: ArrayLike,
    velocities: ArrayLike,
    parameters: LawParameters,
    *,
    detected: Booleans | None = None,
) -> Floats:
    """Return the baseline's input (paper Eq. 2), before saturation.

    Parameters
    ----------
    positions, velocities : (..., d, n) array
        Metres and m/s.
    parameters : LawParameters
        δ and r are used.
    detected : (..., n, n) boolean array, optional
        Row i marks the agents that i senses; by default every one within its radius.

    Returns
    -------
    (..., d, n) array
        Inputs in m/s².

    Raises
    ------
    ParameterError
        Where an array has the wrong shape or a value that is not finite.
    """
    p = check_states(positions, "positions")
    v = check_states(velocities, "velocities", like=p)
    offset, adjacency, weights = _cohesion_separation(p, parameters, detected)
    return _weighted_sum(weights, offset) + _weighted_sum(adjacency.astype(float), displacements(v))


def position_based_input(
    positions: ArrayLike,
    imprint: ArrayLike,
    time: float,
    parameters: LawParameters,
    *,
    threshold: bool = True,
    detected: Booleans | None = None,
) -> Floats:
    """Return the position-based input (paper Eq. 6), before saturation.

    Parameters
    ----------
    positions : (..., d, n) array
        Positions in metres.
    imprint : (..., d, n, n) array
        ``displacements`` of the first instant, metres.
    time : float
        Seconds since that instant, more than zero.
    parameters : LawParameters
        δ, r and k are used.
    threshold : bool
        Whether the alignment gain stops decaying at t = 1/k.
    detected : (..., n, n) boolean array, optional
        Row i marks the agents that i senses; by default every one within its radius.

    Returns
    -------
    (..., d, n) array
        Inputs in m/s².

    Raises
    ------
    ParameterError
        Where an array has the wrong shape or a value that is not finite, or time is not
        positive.
    """
    p = check_states(positions, "positions")
    remembered = np.asarray(imprint, dtype=float)
    if remembered.shape != (*p.shape, p.shape[-1]):
        raise ParameterError(
            f"imprint: expected shape {(*p.shape, p.shape[-1])}, the displacements of"
            f" {p.shape[-1]} agents, got {remembered.shape}"
        )
    offset, adjacency, weights = _cohesion_separation(p, parameters, detected)
    gain = phi(time, adjacency.sum(axis=-1), parameters.persistence if threshold else None)
    alignment = adjacency * gain[..., None]
    return _weighted_sum(weights, offset) + _weighted_sum(alignment, offset - remembered)


def check_states(values: ArrayLike, name: str, like: Floats | None = None) -> Floats:
    """Return values as a finite float array of positions or velocities, d = 2 or 3.

    Parameters
    ----------
    values : (..., d, n) array
        What was given.
    name : str
        What to call it in an error.
    like : (..., d, n) array, optional
        An array whose shape `values` must have.

    Returns
    -------
    (..., d, n) array
        What was given, copied only where it was no float array.

    Raises
    ------
    ParameterError
        Naming what was got and what was expected, and the first agent that is not finite.
    """
    x = _as_floats(values, name)
    if x.ndim < 2 or x.shape[-2] not in (2, 3) or x.shape[-1] < 1:
        raise ParameterError(
            f"{name}: expected shape (d, n) with d = 2 or 3 coordinates and at least one agent,"
            f" got {x.shape}"
        )
    if like is not None and x.shape != like.shape:
        raise ParameterError(f"{name}: expected the shape of positions {like.shape}, got {x.shape}")
    if not np.isfinite(x).all():
        where = np.argwhere(~np.isfinite(x))[0]
        raise ParameterError(
            f"{name}: expected finite numbers, got {x[tuple(where)]} for agent {where[-1]}"
        )
    return x


def _cohesion_separation(
    p: Floats, parameters: LawParameters, detected: Booleans | None
) -> tuple[Floats, Booleans, Floats]:
    """Return displacements, adjacency, and ψ where adjacent and 0 elsewhere."""
    parameters.agents_must_be(p.shape[-1])
    offset = displacements(p)
    distance = _lengths(offset, -3)
    adjacency = _within(distance, parameters.radius)
    if detected is not None:
        adjacency &= detected
    rest_distance = parameters.distance_scale * adjacency.sum(axis=-1)
    return offset, adjacency, adjacency * psi(distance, rest_distance[..., None])


def _within(distance: Floats, radius: float | Floats) -> Booleans:
    reach = radius[..., None] if isinstance(radius, np.ndarray) else radius
    adjacency: Booleans = short_of(distance, reach)
    agents = np.arange(distance.shape[-1])
    adjacency[..., agents, agents] = False
    return adjacency


def _lengths(vectors: Floats, axis: int) -> Floats:
    """Return Euclidean norms over the coordinate axis: -2 of states, -3 of displacements."""
    return np.asarray(np.sqrt(np.square(vectors).sum(axis=axis)))


def _weighted_sum(weights: Floats, offset: Floats) -> Floats:
    """Return Σ_j weights[i, j]·offset[:, i, j] for every agent i."""
    return np.asarray(np.einsum("...ij,...dij->...di", weights, offset))


def _as_floats(value: Any, name: str) -> Floats:
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{name}: expected numbers, got {value!r}") from error


#: The paper's simulation: n = 50 in a square of 25 m.  δ is not in the paper; 0.4 to 0.55
#: reproduces its figures.
PAPER_SIMULATION = LawParameters(
    distance_scale=0.5, radius=7.5, persistence=0.1, speed_limit=2.5, input_limit=5.0
)

#: The paper's experiment: nine GRITSBot X robots in the Robotarium.
PAPER_EXPERIMENT = LawParameters(
    distance_scale=0.12, radius=0.75, persistence=0.15, speed_limit=0.15, input_limit=0.5
)
