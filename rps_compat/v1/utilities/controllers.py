"""Controllers by the names of generation 1. The mathematics is in :mod:`rps_compat.controllers`."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from rps_compat import controllers, deviations
from rps_compat.arguments import ShapeError, matrix, number, scalar
from rps_compat.controllers import Flags, Hysteresis
from rps_compat.errors import RobotariumError
from rps_compat.kinematics import Array
from rps_compat.v1.utilities.transformations import (
    create_si_to_uni_dynamics,
    create_si_to_uni_dynamics_with_backwards_motion,
    create_si_to_uni_mapping,
    create_uni_to_si_dynamics,
)

__all__ = [
    "create_clf_unicycle_pose_controller",
    "create_clf_unicycle_position_controller",
    "create_hybrid_unicycle_pose_controller",
    "create_si_position_controller",
    "create_si_to_uni_dynamics",
    "create_si_to_uni_dynamics_with_backwards_motion",
    "create_si_to_uni_mapping",
    "create_uni_to_si_dynamics",
    "np",
]


#: The default of ``approach_state``: all robots may approach.
EVERYBODY = np.empty([0, 0])


class HysteresisError(RobotariumError, TypeError, ValueError):
    """``position_epsilon`` leaves a robot that neither approaches nor has arrived."""


class PoseController(Protocol):
    """A function of poses and goals that may be told who is still approaching."""

    def __call__(self, states: Array, poses: Array, approach_state: Array = ...) -> Array:
        """Return commands that bring robots to their poses.

        Parameters
        ----------
        states : (3, N) array
            Poses now, m and rad.
        poses : (3, N) array
            Poses to reach, m and rad.
        approach_state : (1, 1) array
            Of a single robot: zero lets it turn where it stands.

        Returns
        -------
        (2, N) array
            Commands (v; ω), m/s and rad/s.
        """


def create_si_position_controller(
    x_velocity_gain: float = 1, y_velocity_gain: float = 1, velocity_magnitude_limit: float = 0.15
) -> Callable[[Array, Array], Array]:
    """Create ``si_position_controller(xi, positions)``: straight to the goals.

    Parameters
    ----------
    x_velocity_gain, y_velocity_gain : float
        Gains (1/s, > 0) on the way that is left in x and in y.
    velocity_magnitude_limit : float
        No velocity is longer than this (m/s, >= 0).

    Returns
    -------
    callable
        From positions (2, N) and goals (2, N) to velocities (2, N).

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    number("x_velocity_gain", x_velocity_gain, above=0)
    number("y_velocity_gain", y_velocity_gain, above=0)
    number("velocity_magnitude_limit", velocity_magnitude_limit, least=0)

    def si_position_controller(xi: Array, positions: Array) -> Array:
        matrix("xi", xi, 2)
        matrix("positions", positions, 2, xi.shape[1])
        return controllers.velocity_to(
            positions, xi, x_velocity_gain, y_velocity_gain, velocity_magnitude_limit
        )

    return si_position_controller


def create_clf_unicycle_position_controller(
    linear_velocity_gain: float = 0.8, angular_velocity_gain: float = 3
) -> Callable[[Array, Array], Array]:
    """Create ``position_uni_clf_controller(states, positions)``: turn and drive to the goals.

    Parameters
    ----------
    linear_velocity_gain, angular_velocity_gain : float
        Gains (>= 0) of v and ω on the way that is left along and across the heading.

    Returns
    -------
    callable
        From poses (3, N) and goals (2, N) to commands (v; ω) (2, N).

    Raises
    ------
    NumberError
        A gain is outside its range.
    """
    number("linear_velocity_gain", linear_velocity_gain, least=0)
    number("angular_velocity_gain", angular_velocity_gain, least=0)

    def position_uni_clf_controller(states: Array, positions: Array) -> Array:
        matrix("states", states, 3)
        matrix("positions", positions, 2, states.shape[1])
        return controllers.command_to_position(
            positions, states, linear_velocity_gain, angular_velocity_gain
        )

    return position_uni_clf_controller


def create_clf_unicycle_pose_controller(
    approach_angle_gain: float = 1, desired_angle_gain: float = 2.7, rotation_error_gain: float = 1
) -> Callable[[Array, Array], Array]:
    """Create ``pose_uni_clf_controller(states, poses)``: one smooth curve to each pose.

    Parameters
    ----------
    approach_angle_gain, desired_angle_gain, rotation_error_gain : float
        γ, k and h of :func:`rps_compat.controllers.command_to_pose`.

    Returns
    -------
    callable
        From poses (3, N) and goals (3, N) to commands (v; ω) (2, N), without limits. Raises
        NumberError where a gain is not a number.
    """

    def pose_uni_clf_controller(states: Array, poses: Array) -> Array:
        matrix("states", states, 3, more_rows=True)
        robots = states.shape[1]
        matrix("poses", poses, 3, robots, more_rows=True, more_columns=True)
        scalar("approach_angle_gain", approach_angle_gain)
        scalar("desired_angle_gain", desired_angle_gain)
        scalar("rotation_error_gain", rotation_error_gain)
        goals = poses[:, :robots]
        commands = controllers.command_to_pose(
            goals, states, approach_angle_gain, desired_angle_gain, rotation_error_gain
        )
        if deviations.as_published("pose controller at angle zero"):
            commands[1, controllers.way_to_pose(goals, states)[1] == 0] = np.nan
        return commands

    return pose_uni_clf_controller


def create_hybrid_unicycle_pose_controller(
    linear_velocity_gain: float = 1,
    angular_velocity_gain: float = 2,
    velocity_magnitude_limit: float = 0.15,
    angular_velocity_limit: float = np.pi,
    position_error: float = 0.05,
    position_epsilon: float = 0.03,
    rotation_error: float = 0.05,
) -> PoseController:
    """Create ``pose_uni_hybrid_controller(states, poses, approach_state)``: drive, then turn.

    Parameters
    ----------
    linear_velocity_gain : float
        Factor on the forward speed while driving, > 0.
    angular_velocity_gain : float
        Turn rate for each radian of heading error while turning (1/s).
    velocity_magnitude_limit : float
        Fastest speed while driving (m/s).
    angular_velocity_limit : float
        Turn rate (rad/s, >= 0) for a goal at a right angle while driving.
    position_error, position_epsilon : float
        A robot drives until it is within `position_error` − `position_epsilon` (m) of its goal.
    rotation_error : float
        A robot turns until its heading is right to this (rad).

    Returns
    -------
    callable
        From poses (3, N) and goals (3, N) to commands (v; ω) (2, N). It keeps nothing from
        call to call; a single
        robot may be given an `approach_state` (1, 1), zero to let it turn where it stands.

    Raises
    ------
    NumberError
        A parameter is outside its range.
    """
    drive = create_si_to_uni_dynamics(linear_velocity_gain, angular_velocity_limit)

    def pose_uni_hybrid_controller(
        states: Array, poses: Array, approach_state: Array = EVERYBODY
    ) -> Array:
        matrix("states", states, 3, more_rows=True)
        robots = states.shape[1]
        matrix("poses", poses, 3, robots, more_rows=True)
        scalar("position_error", position_error)
        scalar("position_epsilon", position_epsilon)
        allowed = _flags(approach_state, robots)
        way = poses[:2] - states[:2]
        distance = np.hypot(way[0], way[1])
        driving, displaced = Hysteresis(position_error, position_epsilon).approaching(
            distance, allowed
        )
        _refuse_lost(~driving & displaced, distance, position_error, position_epsilon)
        velocities = controllers.velocity_to(poses, states, 1, 1, velocity_magnitude_limit)
        commands = drive(velocities, states[:3])
        if driving.all():
            return commands
        turns = controllers.turn_on_the_spot(poses, states, angular_velocity_gain, rotation_error)
        return np.where(driving, commands, turns)

    return pose_uni_hybrid_controller


def _refuse_lost(lost: Flags, distance: Array, error: float, epsilon: float) -> None:
    """Refuse robots that neither drive nor turn.

    The published controller stumbles over such a robot unless it is the last one.
    """
    if lost[:-1].any():
        robot = int(np.argmax(lost))
        raise HysteresisError(
            f"robot {robot} is {distance[robot]:.3g} m from its goal: beyond position_error="
            f"{error}, yet it does not approach with position_epsilon={epsilon}; choose "
            "0 <= position_epsilon <= position_error"
        )


def _flags(approach_state: Array, robots: int) -> Flags:
    """Who may approach (N,): everybody, unless the only robot there is was told otherwise."""
    if approach_state.ndim != 2 or (approach_state.shape[1] == robots and robots > 1):
        raise ShapeError(
            f"approach_state has shape {approach_state.shape}; generation 1 takes it for a single "
            "robot, as an array (1, 1): leave it out"
        )
    if robots == 0 or approach_state.shape[1] != robots:
        return np.ones(robots, dtype=bool)
    flags: Flags = approach_state[0].astype(bool)
    return flags
