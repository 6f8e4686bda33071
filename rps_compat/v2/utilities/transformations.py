"""Single-integrator velocities and unicycle commands, by the names of generation 2.

The mathematics is in :mod:`rps_compat.kinematics`.
"""

from collections.abc import Callable

import numpy as np

from rps_compat import kinematics
from rps_compat.arguments import matrix, number
from rps_compat.kinematics import Array

__all__ = [
    "create_si_to_uni_dynamics",
    "create_si_to_uni_dynamics_with_backwards_motion",
    "create_si_to_uni_mapping",
    "create_uni_to_si_mapping",
    "np",
]


def create_si_to_uni_dynamics(
    linear_velocity_gain: float = 1, angular_velocity_limit: float = np.pi
) -> Callable[[Array, Array], Array]:
    """Create ``si_to_uni(dxi, states)``: turn towards the velocity, and drive along it.

    Parameters
    ----------
    linear_velocity_gain : float
        Factor on the forward speed, > 0.
    angular_velocity_limit : float
        Turn rate (rad/s, >= 0) for a velocity at a right angle to the heading.

    Returns
    -------
    callable
        From velocities (2, N) in m/s and poses (3, N) to commands (v; ω) (2, N).

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    number("linear_velocity_gain", linear_velocity_gain, above=0)
    number("angular_velocity_limit", angular_velocity_limit, least=0)

    def si_to_uni(dxi: Array, states: Array) -> Array:
        matrix("dxi", dxi, 2)
        matrix("states", states, 3, dxi.shape[1])
        along, across = kinematics.along_and_across(dxi, states)
        # Adding 0.0 turns -0.0 into 0.0, lest a robot told to stand turn round.
        rates = kinematics.turn_rate(across, along + 0.0, states[2], angular_velocity_limit)
        return np.array([linear_velocity_gain * along, rates])

    return si_to_uni


def create_si_to_uni_dynamics_with_backwards_motion(
    linear_velocity_gain: float = 1, angular_velocity_limit: float = np.pi
) -> Callable[[Array, Array], Array]:
    """Create ``si_to_uni(dxi, states)`` that drives backwards rather than turn round.

    A velocity from behind is met with the robot's back, so the turn rate never exceeds
    `angular_velocity_limit`.

    Parameters
    ----------
    linear_velocity_gain : float
        Factor on the forward speed, > 0.
    angular_velocity_limit : float
        Turn rate (rad/s, >= 0) for a velocity at a right angle to the heading.

    Returns
    -------
    callable
        From velocities (2, N) in m/s and poses (3, N) to commands (v; ω) (2, N).

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    number("linear_velocity_gain", linear_velocity_gain, above=0)
    number("angular_velocity_limit", angular_velocity_limit, least=0)

    def si_to_uni(dxi: Array, states: Array) -> Array:
        matrix("dxi", dxi, 2)
        matrix("states", states, 3, dxi.shape[1])
        forwards = kinematics.facing(dxi, states[2])
        along, across = kinematics.along_and_across(dxi, states)
        speed = linear_velocity_gain * along
        # The velocity as the end sees it that goes first; again, -0.0 becomes 0.0.
        sense = np.where(forwards, 1.0, -1.0)
        seen = sense * across, sense * speed + 0.0
        rates = kinematics.turn_rate(*seen, states[2], angular_velocity_limit)
        return np.array([speed, rates])

    return si_to_uni


def create_si_to_uni_mapping(
    projection_distance: float = 0.05,
) -> tuple[Callable[[Array, Array], Array], Callable[[Array], Array]]:
    """Create the pair ``si_to_uni(dxi, states)``, ``uni_to_si(states)``.

    Parameters
    ----------
    projection_distance : float
        How far ahead of the centre the controlled point lies (m, > 0).

    Returns
    -------
    si_to_uni : callable
        From velocities (2, N) of the points and poses (3, N) to commands (v; ω) (2, N); the turn
        rates are not cut, unlike in generation 1.
    uni_to_si : callable
        From poses (3, N) to the points (2, N).

    Raises
    ------
    NumberError
        `projection_distance` is outside its range.
    """
    number("projection_distance", projection_distance, above=0)

    def si_to_uni(dxi: Array, states: Array) -> Array:
        matrix("dxi", dxi, 2)
        matrix("states", states, 3, dxi.shape[1])
        return kinematics.unicycle_command(dxi, states, projection_distance)

    def uni_to_si(states: Array) -> Array:
        matrix("states", states, 3)
        return kinematics.projection_point(states, projection_distance)

    return si_to_uni, uni_to_si


def create_uni_to_si_mapping(
    projection_distance: float = 0.05,
) -> tuple[Callable[[Array, Array], Array], Callable[[Array, Array], Array]]:
    """Create the pair ``uni_to_si(dxu, states)``, ``si_to_uni(uni_states, si_states)``.

    Parameters
    ----------
    projection_distance : float
        How far ahead of the centre the point lies (m, > 0).

    Returns
    -------
    uni_to_si : callable
        From commands (v; ω) (2, N) and poses (3, N) to velocities (2, N) of the points.
    si_to_uni : callable
        From poses (3, N), read for their headings, and points (2, N) to the centres (2, N).

    Raises
    ------
    NumberError
        `projection_distance` is outside its range.
    """
    number("projection_distance", projection_distance, above=0)

    def uni_to_si(dxu: Array, states: Array) -> Array:
        matrix("dxu", dxu, 2)
        matrix("states", states, 3, dxu.shape[1])
        return kinematics.point_velocity(dxu, states, projection_distance)

    def si_to_uni(uni_states: Array, si_states: Array) -> Array:
        matrix("uni_states", uni_states, 3)
        matrix("si_states", si_states, 2, uni_states.shape[1])
        return kinematics.center_of(si_states, uni_states, projection_distance)

    return uni_to_si, si_to_uni
