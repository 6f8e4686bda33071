"""The extended Kalman filter that the published example of generation 2 imports."""

import time
from typing import Any

import numpy as np

from rps_compat.kinematics import Array, wrap
from rps_compat.unicycle_filter import UnicycleFilter, numbers

# Scripts get these names from `import *`, so every one of them is part of the interface.
__all__ = ["UnicycleEKF", "np", "time", "wrap_angle"]


def wrap_angle(angle: Any) -> Any:
    """Bring an angle into [−π, π].

    Parameters
    ----------
    angle : float or (...) array
        The angle, rad.
    """
    return wrap(angle)


class UnicycleEKF(UnicycleFilter):
    """Estimates the pose of one robot, see `UnicycleFilter`.

    Variances of measurements come with each measurement.

    Parameters
    ----------
    initial_state : (3,) array
        Pose, m and rad.
    initial_covariance : (3, 3) array
        Of that pose, m² and rad².
    b : float
        Length of the axle, from wheel to wheel, m.
    r : float
        Radius of the wheels, m.
    M : (2, 2) array
        Covariance of the speeds that the encoders tell, right wheel first, rad²/s².
    Q : (3, 3) array
        Covariance that the model gains in a second.
    """

    def __init__(
        self,
        initial_state: Array,
        initial_covariance: Array,
        b: float,
        r: float,
        M: Array,
        Q: Array,
    ) -> None:
        super().__init__(initial_state, initial_covariance, b, r, M, Q)

    def update_gps(self, gps_measurement: Array, R_gps: Array) -> None:
        """Correct by a measured position of the axle's middle.

        Parameters
        ----------
        gps_measurement : (2,) array
            Position, m.
        R_gps : (2, 2) array
            Its covariance, m².

        Raises
        ------
        NoiseError, ShapeError
            An argument has another size, or the covariance is not positive definite.
        """
        self.correct_position(gps_measurement, "R_gps", R_gps)

    def update_range(
        self, beacon_position: Array, range_measurement: float, R_range: float
    ) -> None:
        """Correct by the distance of a beacon.

        Parameters
        ----------
        beacon_position : (2,) array
            Where it stands, m.
        range_measurement : float
            Its distance, m.
        R_range : float
            Variance of that, m².

        Raises
        ------
        NoiseError, ShapeError
            As for :meth:`update_gps`.
        """
        way = numbers("beacon_position", beacon_position, 2) - self.state[:2]
        distance = max(float(np.hypot(*way)), 1e-12)
        beyond = numbers("range_measurement", range_measurement, 1) - distance
        self.correct(beyond, [*(-way / distance), 0.0, 0.0], "R_range", R_range)

    def update_brearing(
        self, beacon_position: Array, bearing_measurement: float, R_bearing: Any = None
    ) -> None:
        """Correct by the direction in which the robot sees a beacon; published with this name.

        Parameters
        ----------
        beacon_position : (2,) array
            Where it stands, m.
        bearing_measurement : float
            Its direction from the robot's heading, counter-clockwise, rad.
        R_bearing : float
            Variance of that, rad².

        Raises
        ------
        NoiseError, ShapeError
            As for :meth:`update_gps`.
        """
        way = numbers("beacon_position", beacon_position, 2) - self.state[:2]
        squared = max(float(way @ way), 1e-24)
        expected = np.arctan2(way[1], way[0]) - self.state[2]
        beyond = wrap(numbers("bearing_measurement", bearing_measurement, 1) - expected)
        derivative = [way[1] / squared, -way[0] / squared, -1.0, 0.0]
        self.correct(beyond, derivative, "R_bearing", R_bearing)

    def update_orientation(self, orientation: float, R_orientation: Any = None) -> None:
        """Correct by a measured heading.

        Parameters
        ----------
        orientation
            The heading, rad.
        R_orientation
            Variance of that, rad².

        Raises
        ------
        NoiseError, ShapeError
            As for :meth:`update_gps`.
        """
        beyond = wrap(numbers("orientation", orientation, 1) - self.state[2])
        self.correct(beyond, [0.0, 0.0, 1.0, 0.0], "R_orientation", R_orientation)

    def update_gyro(self, yaw_rate: float, dt: float, R_gyro: Any = None) -> None:
        """Correct by a measured turn rate: by how far the robot has turned since the last time.

        Parameters
        ----------
        yaw_rate
            The turn rate, rad/s.
        dt
            Seconds since the last update of this kind, or since the start.
        R_gyro
            Variance of the turn rate, rad²/s².

        Raises
        ------
        NoiseError, ShapeError
            As for :meth:`update_gps`.
        """
        seconds = numbers("dt", dt, 1)
        turned = self.state[2] - self.previous_theta
        beyond = wrap(numbers("yaw_rate", yaw_rate, 1) * seconds - turned)
        noise = _over(R_gyro, seconds)
        self.correct(beyond, [0.0, 0.0, 1.0, -1.0], "R_gyro", noise)
        self.clone_heading()


def _over(variance: Any, seconds: Array) -> Any:
    """Variance of a rate, as that of what it adds up to; what is no number stays what it is."""
    try:
        return np.asarray(variance, dtype=float) * seconds**2
    except (TypeError, ValueError):
        return variance
