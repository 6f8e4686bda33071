"""Controllers by the names of generation 2. The mathematics is in :mod:`rps_compat.controllers`."""

from collections.abc import MutableSequence
from typing import Any

import numpy as np

from rps_compat import controllers, kinematics
from rps_compat.arguments import matrix, number, scalar
from rps_compat.kinematics import Array
from rps_compat.v2.drive_then_turn import (
    Controller,
    DriveThenTurn,
    HybridController,
    flags_of,
    robots_of,
)
from rps_compat.v2.utilities.transformations import (
    create_si_to_uni_dynamics,
    create_si_to_uni_dynamics_with_backwards_motion,
    create_si_to_uni_mapping,
    create_uni_to_si_mapping,
)

__all__ = [
    "create_pose_controller_clf",
    "create_pose_controller_hybrid",
    "create_pose_parking_controller_clf",
    "create_pose_parking_controller_hybrid",
    "create_si_position_controller",
    "create_si_to_uni_dynamics",
    "create_si_to_uni_dynamics_with_backwards_motion",
    "create_si_to_uni_mapping",
    "create_uni_position_controller",
    "create_uni_to_si_mapping",
    "np",
]


def create_si_position_controller(
    x_velocity_gain: float = 0.8,
    y_velocity_gain: float = 0.8,
    velocity_magnitude_limit: float = 0.15,
) -> Controller:
    """Create ``position_controller_si(states, poses)``: straight to the goals.

    Parameters
    ----------
    x_velocity_gain, y_velocity_gain : float
        Gains (1/s, > 0) on the way that is left in x and in y.
    velocity_magnitude_limit : float
        No velocity is longer than this (m/s, >= 0).

    Returns
    -------
    callable
        From positions or poses (2 or 3, N) and goals (2, N) to velocities (2, N).

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    number("x_velocity_gain", x_velocity_gain, above=0)
    number("y_velocity_gain", y_velocity_gain, above=0)
    number("velocity_magnitude_limit", velocity_magnitude_limit, least=0)

    def position_controller_si(states: Array, poses: Array) -> Array:
        matrix("states", states, 2, more_rows=True)
        matrix("poses", poses, 2, states.shape[1])
        return controllers.velocity_to(
            poses, states, x_velocity_gain, y_velocity_gain, velocity_magnitude_limit
        )

    return position_controller_si


def create_uni_position_controller(
    x_velocity_gain: float = 0.8,
    y_velocity_gain: float = 0.8,
    velocity_magnitude_limit: float = 0.15,
    projection_distance: float = 0.03,
) -> Controller:
    """Create ``position_controller_uni(states, poses)``: the points ahead go straight to the goals.

    Parameters
    ----------
    x_velocity_gain, y_velocity_gain : float
        Gains (1/s, > 0) on the way that is left in x and in y.
    velocity_magnitude_limit : float
        No point moves faster than this (m/s, >= 0).
    projection_distance : float
        How far ahead of the centre the controlled point lies (m, > 0).

    Returns
    -------
    callable
        From poses (3, N) and goals (2, N) to commands (v; ω) (2, N).

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    to_velocity = create_si_position_controller(
        x_velocity_gain, y_velocity_gain, velocity_magnitude_limit
    )
    to_command, to_point = create_si_to_uni_mapping(projection_distance)

    def position_controller_uni(states: Array, poses: Array) -> Array:
        matrix("states", states, 3)
        matrix("poses", poses, 2, states.shape[1])
        return to_command(to_velocity(to_point(states), poses), states)

    return position_controller_uni


def create_pose_controller_clf(
    approach_angle_gain: float = 1,
    desired_angle_gain: float = 2.7,
    rotation_error_gain: float = 1,
    wheel_velocity_limit: float = 10.0,
    wheel_radius: float = 0.016,
    base_length: float = 0.105,
) -> Controller:
    """Create ``controller_clf(states, poses)``: one smooth curve to each pose.

    Parameters
    ----------
    approach_angle_gain, desired_angle_gain, rotation_error_gain : float
        γ, k and h of :func:`rps_compat.controllers.command_to_pose`.
    wheel_velocity_limit : float
        A command that needs faster wheels (rad/s) is scaled down as a whole.
    wheel_radius, base_length : float
        Of the robot (m).

    Returns
    -------
    callable
        From poses (3, N) and goals (3, N) to commands (v; ω) (2, N). Raises NumberError where a
        gain is not a number.

    Raises
    ------
    NumberError
        `wheel_radius` or `base_length` is not a number.
    ZeroDivisionError, numpy.linalg.LinAlgError
        `base_length` or `wheel_radius` is zero.
    """
    to_wheels = _wheels(wheel_radius, base_length)

    def controller_clf(states: Array, poses: Array) -> Array:
        matrix("states", states, 3)
        matrix("poses", poses, 3, states.shape[1])
        scalar("approach_angle_gain", approach_angle_gain)
        scalar("desired_angle_gain", desired_angle_gain)
        scalar("rotation_error_gain", rotation_error_gain)
        commands = controllers.command_to_pose(
            poses, states, approach_angle_gain, desired_angle_gain, rotation_error_gain
        )
        return controllers.within_wheel_speed(commands, to_wheels, wheel_velocity_limit)

    return controller_clf


def create_pose_parking_controller_clf(
    approach_angle_gain: float = 1,
    desired_angle_gain: float = 2.7,
    rotation_error_gain: float = 1,
    wheel_velocity_limit: float = 10.0,
    wheel_radius: float = 0.016,
    base_length: float = 0.105,
    position_error: float = 0.05,
    rotation_error: float = 0.2,
) -> Controller:
    """Create ``controller_clf_parking(states, poses)``: a smooth curve, and stop at the pose.

    Parameters
    ----------
    approach_angle_gain, desired_angle_gain, rotation_error_gain : float
        γ, k and h of :func:`rps_compat.controllers.command_to_pose`.
    wheel_velocity_limit : float
        A command that needs faster wheels (rad/s) is scaled down as a whole.
    wheel_radius, base_length : float
        Of the robot (m).
    position_error, rotation_error : float
        A robot that is within both of its pose (m, rad) stands still.

    Returns
    -------
    callable
        As that of :func:`create_pose_controller_clf`.

    Raises
    ------
    NumberError
        `wheel_radius` or `base_length` is not a number.
    ZeroDivisionError, numpy.linalg.LinAlgError
        `base_length` or `wheel_radius` is zero.
    """
    approach = create_pose_controller_clf(
        approach_angle_gain,
        desired_angle_gain,
        rotation_error_gain,
        wheel_velocity_limit,
        wheel_radius,
        base_length,
    )

    def controller_clf_parking(states: Array, poses: Array) -> Array:
        commands = approach(states, poses)
        commands[:, controllers.arrived(poses, states, position_error, rotation_error)] = 0.0
        return commands

    return controller_clf_parking


def create_pose_controller_hybrid(
    linear_velocity_gain: float = 0.8,
    angular_velocity_limit: float = np.pi,
    velocity_magnitude_limit: float = 0.15,
    position_error: float = 0.03,
    position_epsilon: float = 0.01,
    rotation_error: float = 0.05,
) -> HybridController:
    """Create ``controller_hybrid(states, poses, in_approach_state)``: drive, then turn.

    Parameters
    ----------
    linear_velocity_gain : float
        Factor on the forward speed while driving, > 0.
    angular_velocity_limit : float
        Turn rate (rad/s, >= 0) for a goal at a right angle while driving.
    velocity_magnitude_limit : float
        Fastest speed while driving (m/s).
    position_error, position_epsilon : float
        A robot drives until it is within `position_error` − `position_epsilon` (m) of its goal, and
        again in the step after it was seen farther than `position_error` away.
    rotation_error : float
        A robot turns until its heading is right to this (rad).

    Returns
    -------
    callable
        From poses (3, N) and goals (3, N) to commands (v; ω) (2, N). The controller remembers who
        is approaching, and starts afresh when the number of robots changes. If a list or array of
        N flags `in_approach_state` is given, it is that memory instead: it is updated in place and
        returned beside the commands.

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    step = DriveThenTurn(
        create_si_to_uni_dynamics(linear_velocity_gain, angular_velocity_limit),
        velocity_magnitude_limit,
        position_error,
        position_epsilon,
        rotation_error,
    )

    def controller_hybrid(
        states: Array, poses: Array, in_approach_state: MutableSequence[int] | None = None
    ) -> Any:
        if in_approach_state is None:
            return step(states, poses)
        robots = robots_of(states, poses)
        commands, approaching = step.advance(states, poses, flags_of(in_approach_state, robots))
        for robot in range(robots):
            in_approach_state[robot] = int(approaching[robot])
        return commands, in_approach_state

    return controller_hybrid


def create_pose_parking_controller_hybrid(
    linear_velocity_gain: float = 0.8,
    angular_velocity_limit: float = np.pi,
    velocity_magnitude_limit: float = 0.15,
    position_error: float = 0.05,
    position_epsilon: float = 0.01,
    rotation_error: float = 0.2,
) -> Controller:
    """Create ``controller_hybrid_parking(states, poses)``: drive, turn, and stand at the pose.

    Parameters
    ----------
    linear_velocity_gain : float
        Factor on the forward speed while driving, > 0.
    angular_velocity_limit : float
        Turn rate (rad/s, >= 0) for a goal at a right angle while driving.
    velocity_magnitude_limit : float
        Fastest speed while driving (m/s).
    position_error, position_epsilon : float
        A robot drives until it is within `position_error` − `position_epsilon` (m) of its goal, and
        again in the step after it was seen farther than `position_error` away.
    rotation_error : float
        A robot within this (rad) and `position_error` of its pose stands still.

    Returns
    -------
    callable
        From poses (3, N) and goals (3, N) to commands (v; ω) (2, N). Who is approaching is always
        remembered inside.

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    step = DriveThenTurn(
        create_si_to_uni_dynamics(linear_velocity_gain, angular_velocity_limit),
        velocity_magnitude_limit,
        position_error,
        position_epsilon,
        rotation_error,
    )

    def controller_hybrid_parking(states: Array, poses: Array) -> Array:
        commands = step(states, poses)
        commands[:, controllers.arrived(poses, states, position_error, rotation_error)] = 0.0
        return commands

    return controller_hybrid_parking


def _wheels(wheel_radius: Any, base_length: Any) -> Array:
    """Matrix (2, 2) from a command to wheel speeds; refuses a robot without wheels or width."""
    scalar("wheel_radius", wheel_radius)
    scalar("base_length", base_length)
    if base_length == 0:
        raise ZeroDivisionError("base_length is 0: a robot needs its wheels apart")
    if wheel_radius == 0:
        raise np.linalg.LinAlgError("wheel_radius is 0: such wheels move nothing")
    return kinematics.wheels_from_command(float(wheel_radius), float(base_length))
