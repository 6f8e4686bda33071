"""Controllers by the names of generation 2. The mathematics is in :mod:`rps_compat.controllers`."""

from collections.abc import Callable, MutableSequence
from typing import Any, Protocol

import numpy as np

from rps_compat import controllers, kinematics
from rps_compat.arguments import ShapeError, matrix, number, scalar
from rps_compat.controllers import Flags, Hysteresis
from rps_compat.kinematics import Array
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

#: Turn rate for each radian of heading error of a robot that turns on the spot (1/s).
ROTATION_GAIN = 2.0

Controller = Callable[[Array, Array], Array]


class HybridController(Protocol):
    """A function of poses and goals that may be handed the memory of who is approaching."""

    def __call__(
        self, states: Array, poses: Array, in_approach_state: MutableSequence[int] | None = ...
    ) -> Any:
        """Return commands that bring robots to their poses.

        Parameters
        ----------
        states : (3, N) array
            Poses now, m and rad.
        poses : (3, N) array
            Poses to reach, m and rad.
        in_approach_state : sequence of N flags, optional
            Who is still approaching; updated in place.

        Returns
        -------
        commands : (2, N) array
            Commands (v; ω), m/s and rad/s.
        in_approach_state : sequence of N flags
            The memory, if it was handed in.
        """


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
    step = _Hybrid(
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
        robots = _robots(states, poses)
        commands, approaching = step.advance(states, poses, _flags(in_approach_state, robots))
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
    step = _Hybrid(
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


class _Hybrid:
    """Drive, then turn, with a memory of who is still driving."""

    def __init__(
        self,
        drive: Controller,
        speed_limit: float,
        position_error: float,
        position_epsilon: float,
        rotation_error: float,
    ) -> None:
        self._drive = drive
        self._speed_limit = speed_limit
        self._position_error = position_error
        self._position_epsilon = position_epsilon
        self._rotation_error = rotation_error
        self._approaching: Flags | None = None

    def __call__(self, states: Array, poses: Array) -> Array:
        robots = _robots(states, poses)
        if self._approaching is None or self._approaching.size != robots:
            self._approaching = np.ones(robots, dtype=bool)
        commands, self._approaching = self.advance(states, poses, self._approaching)
        return commands

    def advance(self, states: Array, poses: Array, approaching: Flags) -> tuple[Array, Flags]:
        """Commands (2, N), and who approaches in the next step (N,)."""
        scalar("position_error", self._position_error)
        scalar("position_epsilon", self._position_epsilon)
        poses = poses[:, : states.shape[1]]
        driving, next_approaching = Hysteresis(
            self._position_error, self._position_epsilon
        ).approaching(controllers.distances(states, poses), approaching)
        velocities = controllers.velocity_to(poses, states, 1, 1, self._speed_limit)
        commands = self._drive(velocities, states[:3])
        if not driving.all():
            turns = controllers.turn_on_the_spot(poses, states, ROTATION_GAIN, self._rotation_error)
            commands = np.where(driving, commands, turns)
        return commands, next_approaching


def _robots(states: Array, poses: Array) -> int:
    """Check both shapes; how many robots there are."""
    matrix("states", states, 3, more_rows=True)
    robots = int(states.shape[1])
    matrix("poses", poses, 3, robots, more_rows=True)
    return robots


def _flags(in_approach_state: Any, robots: int) -> Flags:
    flags = np.asarray(in_approach_state)
    if flags.ndim != 1 or flags.size < robots:
        raise ShapeError(
            f"in_approach_state has shape {flags.shape}, expected ({robots},): a flag each robot"
        )
    return flags[:robots].astype(bool)


def _wheels(wheel_radius: Any, base_length: Any) -> Array:
    """Matrix (2, 2) from a command to wheel speeds; refuses a robot without wheels or width."""
    scalar("wheel_radius", wheel_radius)
    scalar("base_length", base_length)
    if base_length == 0:
        raise ZeroDivisionError("base_length is 0: a robot needs its wheels apart")
    if wheel_radius == 0:
        raise np.linalg.LinAlgError("wheel_radius is 0: such wheels move nothing")
    return kinematics.wheels_from_command(float(wheel_radius), float(base_length))
