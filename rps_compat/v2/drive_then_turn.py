"""The hybrid controllers of generation 2: first drive to the position, then turn on the spot.

Who is still driving is remembered from step to step (:class:`rps_compat.controllers.Hysteresis`),
inside the controller or by the script that calls it.
"""

from collections.abc import Callable, MutableSequence
from typing import Any, Protocol

import numpy as np

from rps_compat import controllers
from rps_compat.arguments import ShapeError, matrix, scalar
from rps_compat.controllers import Flags, Hysteresis
from rps_compat.kinematics import Array

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


class DriveThenTurn:
    """Drive, then turn, with a memory of who is still driving.

    Parameters
    ----------
    drive : callable
        From velocities (2, N), m/s, and poses (3, N) to commands (v; ω) (2, N).
    speed_limit : float
        Fastest speed while driving (m/s).
    position_error, position_epsilon : float
        A robot drives until it is within `position_error` − `position_epsilon` (m) of its goal, and
        again in the step after it was seen farther than `position_error` away.
    rotation_error : float
        A robot turns until its heading is right to this (rad).
    """

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
        """Return the commands of one step; who drives still is remembered.

        Parameters
        ----------
        states : (k, N) array
            Poses now in the first three rows, m and rad.
        poses : (k, N) array
            Poses to reach in the first three rows, m and rad.

        Returns
        -------
        (2, N) array
            Commands (v; ω), m/s and rad/s.
        """
        robots = robots_of(states, poses)
        if self._approaching is None or self._approaching.size != robots:
            self._approaching = np.ones(robots, dtype=bool)
        commands, self._approaching = self.advance(states, poses, self._approaching)
        return commands

    def advance(self, states: Array, poses: Array, approaching: Flags) -> tuple[Array, Flags]:
        """Return the commands of one step, and who drives in the next; nothing is remembered.

        Parameters
        ----------
        states : (k, N) array
            Poses now in the first three rows, m and rad.
        poses : (k, N) array
            Poses to reach in the first three rows, m and rad.
        approaching : (N,) boolean array
            Who drives still.

        Returns
        -------
        commands : (2, N) array
            Commands (v; ω), m/s and rad/s.
        approaching : (N,) boolean array
            Who drives in the next step.
        """
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


def robots_of(states: Array, poses: Array) -> int:
    """Check both shapes, and return how many robots there are.

    Parameters
    ----------
    states : (k, N) array
        Poses now: three rows or more.
    poses : (k, N) array
        Poses to reach: three rows or more.
    """
    matrix("states", states, 3, more_rows=True)
    robots = int(states.shape[1])
    matrix("poses", poses, 3, robots, more_rows=True)
    return robots


def flags_of(in_approach_state: Any, robots: int) -> Flags:
    """Return the memory that a script hands in, of who is still driving.

    Parameters
    ----------
    in_approach_state : sequence of flags
        One a robot, or more.
    robots : int
        Number of robots, N.

    Returns
    -------
    (N,) boolean array
        A copy.

    Raises
    ------
    ShapeError
        There are too few, or they are nested.
    """
    flags = np.asarray(in_approach_state)
    if flags.ndim != 1 or flags.size < robots:
        raise ShapeError(
            f"in_approach_state has shape {flags.shape}, expected ({robots},): a flag each robot"
        )
    return flags[:robots].astype(bool)
