"""Single-integrator velocities and unicycle commands, by the names of generation 1.

The mathematics is in :mod:`rps_compat.kinematics`.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from rps_compat import kinematics
from rps_compat.arguments import NotAnArrayError, matrix, number
from rps_compat.errors import RobotariumError
from rps_compat.kinematics import Array

__all__ = [
    "create_si_to_uni_dynamics",
    "create_si_to_uni_dynamics_with_backwards_motion",
    "create_si_to_uni_mapping",
    "create_uni_to_si_dynamics",
    "np",
]


class MissingVelocityError(RobotariumError, TypeError, UnboundLocalError):
    """``uni_to_si_dyn`` was given something else than an array of velocities."""


def create_si_to_uni_dynamics(
    linear_velocity_gain: float = 1, angular_velocity_limit: float = np.pi
) -> Callable[[Array, Array], Array]:
    """Create ``si_to_uni_dyn(dxi, poses)``: turn towards the velocity, and drive along it.

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

    def si_to_uni_dyn(dxi: Array, poses: Array) -> Array:
        matrix("dxi", dxi, 2)
        matrix("poses", poses, 3, dxi.shape[1])
        along, across = kinematics.along_and_across(dxi, poses)
        speed = linear_velocity_gain * along
        rates = kinematics.turn_rate(across, speed, poses[2], angular_velocity_limit)
        return np.array([speed, rates])

    return si_to_uni_dyn


def create_si_to_uni_dynamics_with_backwards_motion(
    linear_velocity_gain: float = 1, angular_velocity_limit: float = np.pi
) -> Callable[[Array, Array], Array]:
    """Create the same function as :func:`create_si_to_uni_dynamics`.

    The name promises robots that drive backwards rather than turn round; in generation 1 they
    turn round. Generation 2 keeps the promise.

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
    return create_si_to_uni_dynamics(linear_velocity_gain, angular_velocity_limit)


def create_si_to_uni_mapping(
    projection_distance: float = 0.05, angular_velocity_limit: float = np.pi
) -> tuple[Callable[[Array, Array], Array], Callable[[Array], Array]]:
    """Create the pair ``si_to_uni_dyn(dxi, poses)``, ``uni_to_si_states(poses)``.

    Parameters
    ----------
    projection_distance : float
        How far ahead of the centre the controlled point lies (m, > 0).
    angular_velocity_limit : float
        Turn rates are cut to ± this (rad/s).

    Returns
    -------
    si_to_uni_dyn : callable
        From velocities (2, N) of the points and poses (3, N) to commands (v; ω) (2, N).
    uni_to_si_states : callable
        From poses (3, N) to the points (2, N).

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    number("projection_distance", projection_distance, above=0)
    number("angular_velocity_limit", angular_velocity_limit)

    def si_to_uni_dyn(dxi: Array, poses: Array) -> Array:
        matrix("dxi", dxi, 2)
        matrix("poses", poses, 3, dxi.shape[1])
        commands = kinematics.unicycle_command(dxi, poses, projection_distance)
        commands[1] = kinematics.limited(commands[1], angular_velocity_limit)
        return commands

    def uni_to_si_states(poses: Array) -> Array:
        matrix("poses", poses, 3, more_rows=True)
        return kinematics.projection_point(poses, projection_distance)

    return si_to_uni_dyn, uni_to_si_states


def create_uni_to_si_dynamics(
    projection_distance: float = 0.05,
) -> Callable[[Any, Array], Array]:
    """Create ``uni_to_si_dyn(dxu, poses)``: how fast the points ahead of the robots move.

    Parameters
    ----------
    projection_distance : float
        How far ahead of the centre the point lies (m, > 0).

    Returns
    -------
    callable
        From commands (v; ω) (2, N) and poses (3, N) to velocities (2, N) in m/s.

    Raises
    ------
    NumberError
        `projection_distance` is outside its range.
    """
    number("projection_distance", projection_distance, above=0)

    def uni_to_si_dyn(dxu: Any, poses: Array) -> Array:
        try:
            matrix("dxu", dxu, 2)
        except NotAnArrayError as error:
            raise MissingVelocityError(*error.args) from None
        matrix("poses", poses, 3, dxu.shape[1])
        return kinematics.point_velocity(dxu, poses, projection_distance)

    return uni_to_si_dyn
