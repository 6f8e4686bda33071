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

    `d` is the disturbance of the wheels (rad/s) and `gamma` the gain; for everything else see
    :func:`rps_compat.v1.utilities.barrier_certificates.\
create_unicycle_differential_drive_barrier_certificate`.
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
