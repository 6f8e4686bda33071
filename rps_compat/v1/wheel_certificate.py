"""The certificate of generation 1 for what wheels can do, and for what they do unasked.

Rows are on the velocities of the points ahead of the robots. Wheels turn at most so fast, either
way; and each wheel may turn up to `disturbance` faster or slower than it was told, so pairs and
obstacles are kept with the worst that can do (Emam, Glotfelter and Egerstedt, *Robust barrier
functions for a fully autonomous, remotely accessible swarm-robotics testbed*, IEEE Conference on
Decision and Control, 2019).
"""

from dataclasses import dataclass
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
        """Return the safe commands nearest to those wanted.

        Parameters
        ----------
        dxu : (2, N) array
            Commands (v; ω), m/s and rad/s.
        x : (3, N) array
            Poses, m and rad.
        obstacles : (2, M) array
            Points that stand still, m; empty for none.

        Returns
        -------
        (2, N) array
            Commands (v; ω), m/s and rad/s.
        """


@dataclass(frozen=True)
class RobustWheels:
    """Parameters of the robust, differential-drive functions, as their callers gave them.

    Attributes
    ----------
    max_num_obstacles, max_num_robots : int
        The most obstacle points and robots of a call.
    disturbance : float
        How much faster or slower a wheel may turn than it was told (rad/s).
    wheel_vel_limit : float
        Fastest wheel (rad/s).
    base_length, wheel_radius, projection_distance : float
        Between the wheels, of a wheel, from the axle to the point that is kept apart (m).
    barrier_gain : float
        How fast a distance may shrink.
    safety_radius : float
        Kept between the points ahead of two robots (m).
    walls : tuple
        Empty, or the boundary points.

    Raises
    ------
    NumberError
        A parameter is not a number, or the certified points lie on the axle.
    ZeroDivisionError
        `base_length` is zero.
    """

    max_num_obstacles: Any
    max_num_robots: Any
    disturbance: Any
    wheel_vel_limit: Any
    base_length: Any
    wheel_radius: Any
    projection_distance: Any
    barrier_gain: Any
    safety_radius: Any
    walls: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        # What the published functions refuse when they are created; the rest, when called.
        for name in ("max_num_obstacles", "max_num_robots"):
            most = getattr(self, name)
            if not isinstance(most, int | np.integer) or (
                most is True and name == "max_num_robots"
            ):
                raise NumberError(f"{name} is {most!r} ({type(most).__name__}), expected an int")
        for name in ("disturbance", "base_length", "wheel_radius", "projection_distance"):
            scalar(name, getattr(self, name))
        if self.base_length == 0:
            raise ZeroDivisionError(
                "base_length is 0, expected the distance between the wheels (m)"
            )
        if self.projection_distance == 0:
            raise NumberError("projection_distance is 0, expected a point ahead of the axle (m)")

    def certificate(self) -> UnicycleCertificate:
        """Create the certificate with these parameters.

        Raises
        ------
        NumberError
            A parameter is not a number.
        numpy.linalg.LinAlgError
            `wheel_radius` is 0.
        """
        for name in ("wheel_vel_limit", "barrier_gain", "safety_radius"):
            scalar(name, getattr(self, name))
        if self.wheel_radius == 0:
            raise np.linalg.LinAlgError("wheel_radius is 0: such wheels move nothing")
        one_rad = DifferentialDrive(
            projection_distance=abs(self.projection_distance),
            speed_limit=None,
            wheel_limit=1.0,
            wheel_radius=abs(self.wheel_radius),
            base_length=abs(self.base_length),
        ).polygon()
        assert one_rad is not None
        return UnicycleCertificate(
            abs(self.safety_radius),
            self.barrier_gain,
            boundary=certificates.boundary(self.walls[0]) if self.walls else None,
            wall_margin=self.safety_radius / 2,
            obstacle_margin=abs(self.safety_radius),
            limits=certificates.times(self.wheel_vel_limit, one_rad, turning=True),
            projection_distance=self.projection_distance,
            wheel_radius=self.wheel_radius,
            base_length=self.base_length,
            wheel_disturbance=self.disturbance,
            robust_walls=False,
            checked=False,
        )


def robust_wheels(parameters: RobustWheels, published: str = "") -> WheelFilter:
    """Create the certificate of the robust, differential-drive functions; see there.

    Parameters
    ----------
    parameters : RobustWheels
        What the certificate keeps apart, and with which robots.
    published : str
        Name of the deviation, if the published function always raises NameError.
    """
    certificate = cache(parameters.certificate)

    def robust_barriers(dxu: Array, x: Array, obstacles: Array = NOTHING) -> Array:
        if published and deviations.as_published(published):
            raise NameError("wanted as published, where every call raises NameError")
        matrix("dxu", dxu, 2)
        matrix("x", x, 3, dxu.shape[1], more_rows=True)
        certificates.require_finite("dxu", dxu)
        certificates.require_finite("x", x[:3])
        if dxu.shape[1] == 0:
            return dxu.astype(float)
        if dxu.shape[1] > parameters.max_num_robots:
            raise CrowdedError(
                f"{dxu.shape[1]} robots, but max_num_robots is {parameters.max_num_robots}: "
                "create the certificate for more"
            )
        points = _obstacles(obstacles, parameters.max_num_obstacles)
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
