"""The certificate of generation 1 for what wheels can do, and for what they do unasked.

Rows are on the velocities of the points ahead of the robots. Wheels turn at most so fast, either
way; and each wheel may turn up to `disturbance` faster or slower than it was told, so pairs and
obstacles are kept with the worst that can do (Emam, Glotfelter and Egerstedt, *Robust barrier
functions for a fully autonomous, remotely accessible swarm-robotics testbed*, IEEE Conference on
Decision and Control, 2019).
"""

from functools import cache
from typing import Any, Protocol

import numpy as np

from barrier_certificates.differential_drive import DifferentialDrive
from barrier_certificates.unicycle import UnicycleCertificate
from rps_compat import certificates, deviations
from rps_compat.arguments import NumberError, matrix, scalar
from rps_compat.kinematics import Array
from rps_compat.placement import CrowdedError

NOTHING = np.empty(0)


class WheelFilter(Protocol):
    """A function of commands and poses that may be told of obstacles."""

    def __call__(self, dxu: Array, x: Array, obstacles: Array = ...) -> Array:
        """Commands (v; ω) (2, N)."""


def robust_wheels(
    max_num_obstacles: Any,
    max_num_robots: Any,
    disturbance: Any,
    wheel_vel_limit: Any,
    base_length: Any,
    wheel_radius: Any,
    projection_distance: Any,
    barrier_gain: Any,
    safety_radius: Any,
    walls: tuple[Any, ...] = (),
    published: str = "",
) -> WheelFilter:
    """Create the certificate of the robust, differential-drive functions; see there.

    Parameters
    ----------
    walls : tuple
        Empty, or the boundary points.
    published : str
        Name of the deviation, if the published function always raises NameError.
    """
    for name, most in (
        ("max_num_obstacles", max_num_obstacles),
        ("max_num_robots", max_num_robots),
    ):
        if not isinstance(most, (int, np.integer)) or (most is True and name == "max_num_robots"):
            raise NumberError(f"{name} is {most!r} ({type(most).__name__}), expected an int")
    for name, value in (
        ("disturbance", disturbance),
        ("base_length", base_length),
        ("wheel_radius", wheel_radius),
        ("projection_distance", projection_distance),
    ):
        scalar(name, value)
    if base_length == 0:
        raise ZeroDivisionError("base_length is 0, expected the distance between the wheels (m)")
    if projection_distance == 0:
        raise NumberError("projection_distance is 0, expected a point ahead of the axle (m)")

    @cache
    def certificate() -> UnicycleCertificate:
        scalar("wheel_vel_limit", wheel_vel_limit)
        scalar("barrier_gain", barrier_gain)
        scalar("safety_radius", safety_radius)
        if wheel_radius == 0:
            raise np.linalg.LinAlgError("wheel_radius is 0: such wheels move nothing")
        one_rad = DifferentialDrive(
            projection_distance=abs(projection_distance),
            speed_limit=None,
            wheel_limit=1.0,
            wheel_radius=abs(wheel_radius),
            base_length=abs(base_length),
        ).polygon()
        assert one_rad is not None
        return UnicycleCertificate(
            abs(safety_radius),
            barrier_gain,
            boundary=certificates.boundary(walls[0]) if walls else None,
            wall_margin=safety_radius / 2,
            obstacle_margin=abs(safety_radius),
            limits=certificates.times(wheel_vel_limit, one_rad, turning=True),
            projection_distance=projection_distance,
            wheel_radius=wheel_radius,
            base_length=base_length,
            wheel_disturbance=disturbance,
            robust_walls=False,
            checked=False,
        )

    def robust_barriers(dxu: Array, x: Array, obstacles: Array = NOTHING) -> Array:
        if published and deviations.as_published(published):
            raise NameError("wanted as published, where every call raises NameError")
        matrix("dxu", dxu, 2)
        matrix("x", x, 3, dxu.shape[1], more_rows=True)
        certificates.require_finite("dxu", dxu)
        certificates.require_finite("x", x[:3])
        if dxu.shape[1] == 0:
            return dxu.astype(float)
        if dxu.shape[1] > max_num_robots:
            raise CrowdedError(
                f"{dxu.shape[1]} robots, but max_num_robots is {max_num_robots}: create the "
                "certificate for more"
            )
        points = _obstacles(obstacles, max_num_obstacles)
        return certificates.certify(certificate(), dxu, x[:3], points)[0]

    return robust_barriers


def _obstacles(obstacles: Any, most: int) -> Array | None:
    """Obstacles (2, M), None if there are none."""
    if np.size(obstacles) == 0:
        return None
    matrix("obstacles", obstacles, 2)
    certificates.require_finite("obstacles", obstacles)
    if obstacles.shape[1] > most:
        raise CrowdedError(
            f"{obstacles.shape[1]} obstacles, but at most {most} were asked for: create the "
            "certificate for more"
        )
    points: Array = obstacles.astype(float)
    return points
