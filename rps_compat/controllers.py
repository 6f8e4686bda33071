"""Controllers that bring robots to positions and to poses, a column for each robot.

- :func:`velocity_to`: proportional, for points that move in any direction.
- :func:`command_to_position`: a unicycle to a position. With e the distance and α the angle from
  the heading to the goal, v = k e cos α and ω = h e sin α make e²/2 fall.
- :func:`command_to_pose`: a unicycle to a pose, by a Lyapunov function of e, α and φ, the bearing
  of the goal seen in the goal's own frame (Aicardi, Casalino, Bicchi and Balestrino, *Closed loop
  steering of unicycle like vehicles via Lyapunov techniques*, IEEE Robotics & Automation Magazine
  2(1), 1995).
- :class:`Hysteresis`: first drive to the position, then turn on the spot.
- :func:`arrived`: who is there.

Positions are (2, N), poses (3, N), commands (v; ω) (2, N); metres, radians, seconds. Nothing here
checks or changes its arguments; the faces in `rps_compat.v1` and `rps_compat.v2` do.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rps_compat import kinematics
from rps_compat.kinematics import HALF_TURN, Array, wrap

Flags = NDArray[np.bool_]


def distances(states: Array, goals: Array) -> Array:
    """Return how far each robot is from its goal.

    Parameters
    ----------
    states : (k, N) array
        Positions or poses; the first two rows are read, m.
    goals : (k, N) array
        Goals; the first two rows are read, m.

    Returns
    -------
    (N,) array
        Distances, m.
    """
    gaps: Array = np.hypot(goals[0] - states[0], goals[1] - states[1])
    return gaps


def velocity_to(
    goals: Array, positions: Array, x_gain: float, y_gain: float, speed_limit: float
) -> Array:
    """Return velocities proportional to the way to the goals.

    Parameters
    ----------
    goals : (2, N) array
        Positions to reach, m.
    positions : (2, N) array
        Positions now, m.
    x_gain : float
        Gain along x, 1/s.
    y_gain : float
        Gain along y, 1/s.
    speed_limit : float
        No velocity is longer, m/s.

    Returns
    -------
    (2, N) array
        Velocities, m/s.
    """
    velocities = np.array([x_gain * (goals[0] - positions[0]), y_gain * (goals[1] - positions[1])])
    return kinematics.scaled_to_norm(velocities, speed_limit)


def command_to_position(
    goals: Array, states: Array, linear_gain: float, angular_gain: float
) -> Array:
    """Return commands that bring unicycles to positions.

    Parameters
    ----------
    goals : (2, N) array
        Positions to reach, m.
    states : (3, N) array
        Poses now, m and rad.
    linear_gain : float
        Forward speed for each metre ahead, 1/s.
    angular_gain : float
        Turn rate for each metre to the left, rad/(m s).

    Returns
    -------
    (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    """
    along, across = kinematics.along_and_across(goals[:2] - states[:2], states)
    return np.array([linear_gain * along, angular_gain * across])


def way_to_pose(goals: Array, states: Array) -> tuple[Array, Array, Array]:
    """Measure the way to poses in polar coordinates.

    The distance, the angle from the heading to the goal, and the goal's bearing in its own frame.
    A robot that stands on its goal has φ = 0.

    Parameters
    ----------
    goals : (3, N) array
        Poses to reach, m and rad.
    states : (3, N) array
        Poses now, m and rad.

    Returns
    -------
    distance : (N,) array
        e, how far the goal is, m.
    angle : (N,) array
        α, from the heading to the goal, rad.
    bearing : (N,) array
        φ, the goal's bearing in its own frame, rad.
    """
    way = goals[:2] - states[:2]
    along, across = kinematics.along_and_across(way, goals)
    # Adding 0.0 turns -0.0 into 0.0, lest a robot on its goal have the bearing π.
    bearing = kinematics.bearing(across, along + 0.0)
    return np.hypot(way[0], way[1]), wrap(bearing + (goals[2] - states[2])), bearing


def command_to_pose(
    goals: Array,
    states: Array,
    approach_angle_gain: float,
    desired_angle_gain: float,
    rotation_error_gain: float,
) -> Array:
    """Return commands that bring unicycles to poses.

    With γ the approach angle gain, k the desired angle gain and h the rotation error gain,
    v = γ e cos α and ω = k α + γ (cos α sin α / α) (α + h φ), where sin α / α is 1 at α = 0.

    Parameters
    ----------
    goals : (3, N) array
        Poses to reach, m and rad.
    states : (3, N) array
        Poses now, m and rad.
    approach_angle_gain : float
        γ, 1/s.
    desired_angle_gain : float
        k, 1/s.
    rotation_error_gain : float
        h, without a unit.

    Returns
    -------
    (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    """
    distance, angle, bearing = way_to_pose(goals, states)
    cos = approach_angle_gain * np.cos(angle)
    turning = cos * np.sinc(angle / HALF_TURN) * (angle + rotation_error_gain * bearing)
    return np.array([cos * distance, desired_angle_gain * angle + turning])


def within_wheel_speed(commands: Array, to_wheels: Array, limit: float) -> Array:
    """Return commands, scaled down as a whole where a wheel would turn too fast.

    Parameters
    ----------
    commands : (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    to_wheels : (2, 2) array
        From a command to wheel speeds, see :func:`kinematics.wheels_from_command`.
    limit : float
        Largest wheel speed, rad/s.

    Returns
    -------
    (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    """
    fastest = np.abs(to_wheels @ commands).max(axis=0)
    scale = np.ones_like(fastest)
    np.divide(limit, fastest, out=scale, where=fastest > limit)
    scaled: Array = commands * scale
    return scaled


def turn_on_the_spot(
    goals: Array, states: Array, rotation_gain: float, rotation_error: float
) -> Array:
    """Return commands that turn robots to the headings of their goals.

    Parameters
    ----------
    goals : (3, N) array
        Poses to reach, m and rad.
    states : (3, N) array
        Poses now, m and rad.
    rotation_gain : float
        Turn rate for each radian that is left, 1/s.
    rotation_error : float
        Who is nearer to the heading than this stands still, rad.

    Returns
    -------
    (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    """
    errors = wrap(goals[2] - states[2])
    off = np.abs(errors) > rotation_error
    return np.array([np.zeros_like(errors), np.where(off, rotation_gain * errors, 0.0)])


def arrived(goals: Array, states: Array, position_error: Any, rotation_error: Any) -> Flags:
    """Return for each robot whether it is at its goal.

    Parameters
    ----------
    goals : (3, N) array
        Poses to reach, m and rad.
    states : (3, N) array
        Poses now, m and rad.
    position_error : float
        How far off the position may be, m.
    rotation_error : float
        How far off the heading may be, rad.

    Returns
    -------
    (N,) boolean array
        True for a robot that is within both.
    """
    near: Flags = (distances(states, goals) <= position_error) & (
        np.abs(wrap(states[2] - goals[2])) <= rotation_error
    )
    return near


class Hysteresis:
    """Who drives to its position, and who stands there and turns.

    A robot approaches until it is nearer than `position_error` − `position_epsilon`; from then on
    it turns, until it has been moved farther than `position_error` away.

    Parameters
    ----------
    position_error : float
        Beyond this a robot drives again, m.
    position_epsilon : float
        How much nearer than that it has to come first, m.
    """

    def __init__(self, position_error: float, position_epsilon: float) -> None:
        self._arrival = position_error - position_epsilon
        self._departure = position_error

    def approaching(self, distance: Array, was_approaching: Flags) -> tuple[Flags, Flags]:
        """Return who drives now, and who may drive in the next step.

        Parameters
        ----------
        distance : (N,) array
            How far each robot is from its position, m.
        was_approaching : (N,) boolean array
            Who might drive, by the last call.

        Returns
        -------
        driving : (N,) boolean array
            Who drives now.
        may_drive : (N,) boolean array
            To be handed to the next call.
        """
        driving = was_approaching & (distance > self._arrival)
        return driving, driving | (distance > self._departure)
