"""The robust certificate by its older name, without walls."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from rps_compat.deferred import matrix, solvers
from rps_compat.deferred import quadprog as solver2
from rps_compat.kinematics import Array
from rps_compat.v1.wheel_certificate import RobustWheels, robust_wheels

__all__ = ["create_robust_barriers", "matrix", "np", "solver2", "solvers", "time"]


def create_robust_barriers(
    max_num_obstacles: int = 100,
    max_num_robots: int = 30,
    d: float = 5,
    wheel_vel_limit: float = 12.5,
    base_length: float = 0.105,
    wheel_radius: float = 0.016,
    projection_distance: float = 0.05,
    gamma: float = 150,
    safety_radius: float = 0.12,
) -> Callable[[Array, Array, Array], Any]:
    """Create ``robust_barriers(dxu, x, obstacles)``: safe commands that the wheels can obey.

    Parameters
    ----------
    max_num_obstacles, max_num_robots : int
        Most obstacles and robots that a call may have.
    d : float
        Unwanted speed of a wheel (rad/s, either way) that robots stay safe under.
    wheel_vel_limit : float
        Fastest that a wheel turns (rad/s).
    base_length, wheel_radius : float
        Of the robots (m).
    projection_distance : float
        How far ahead of the centres the certified points lie (m).
    gamma : float
        γ of the rows.
    safety_radius : float
        Smallest distance between two points, or a point and an obstacle (m).

    Returns
    -------
    callable
        From commands (v; ω) (2, N), poses (3, N) and obstacles (2, M), which are points, to
        commands (2, N).

    Raises
    ------
    NumberError, ZeroDivisionError
        A parameter is not a number, or zero where robots need an extent.
    """
    certified = robust_wheels(
        RobustWheels(
            max_num_obstacles,
            max_num_robots,
            d,
            wheel_vel_limit,
            base_length,
            wheel_radius,
            projection_distance,
            gamma,
            safety_radius,
        )
    )

    def robust_barriers(dxu: Array, x: Array, obstacles: Array) -> Any:
        safe = certified(dxu, x, obstacles)
        return safe if safe.size else []  # an empty list for no robots, as published

    return robust_barriers
