"""The dimensions and limits of a robot model as an array, which compiled code takes."""

from __future__ import annotations

import numpy as np

from barrier_certificates.ties import TIE
from rps_compat.arena_guests import Array
from rps_compat.testbed import RobotModel

#: Where each stands.
AXLE, PER_RADIUS, HALF_RADIUS, RADIUS_PER_AXLE, LIMIT, AHEAD, TOO_CLOSE, TIME_STEP = range(8)
X_MIN, X_MAX, Y_MIN, Y_MAX = range(8, 12)


def constants_of(robot: RobotModel) -> Array:
    """Return the dimensions and limits that a step takes, and what follows from them.

    Parameters
    ----------
    robot : RobotModel
        The robots and their arena.

    Returns
    -------
    (12,) array
        By the names above, in metres and radians.
    """
    radius, axle = robot.wheel_radius, robot.base_length
    close = robot.collision_diameter + TIE
    motion = (axle, 1 / (2 * radius), radius / 2, radius / axle, robot.max_wheel_velocity)
    return np.array([*motion, robot.collision_offset, close, robot.time_step, *robot.boundaries])
