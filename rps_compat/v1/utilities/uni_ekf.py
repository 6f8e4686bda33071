"""The extended Kalman filter that came with the last release of generation 1."""

from typing import Any

import numpy as np

from rps_compat.errors import RobotariumError
from rps_compat.kinematics import Array
from rps_compat.unicycle_filter import UnicycleFilter

# Scripts get these names from `import *`, so every one of them is part of the interface.
__all__ = ["UnicycleEKF", "np"]


class NoInertialUpdateError(RobotariumError, NotImplementedError):
    """Accelerations say nothing about a state that has no speed in it."""


class UnicycleEKF(UnicycleFilter):
    """Estimates the pose of one robot, see `UnicycleFilter`.

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
    R_gps : (2, 2) array, optional
        Covariance of measured positions, m²; None where there are none.
    R_imu : (3, 3) array, optional
        Covariance of inertial measurements; kept, and used by nothing.
    """

    def __init__(
        self,
        initial_state: Array,
        initial_covariance: Array,
        b: float,
        r: float,
        M: Array,
        Q: Array,
        R_gps: Any = None,
        R_imu: Any = None,
    ) -> None:
        super().__init__(initial_state, initial_covariance, b, r, M, Q)
        self.R_gps, self.R_imu = R_gps, R_imu

    def update_gps(self, gps_measurement: Array) -> None:
        """Correct by a measured position of the axle's middle.

        Parameters
        ----------
        gps_measurement : (2,) array
            The position, m.

        Raises
        ------
        NoiseError, ShapeError
            `R_gps` was not given or is not positive definite; the position has another size.
        """
        self.correct_position(gps_measurement, "R_gps", self.R_gps)

    def update_imu(self, imu_measurement: Array) -> None:
        """Refuse an inertial measurement, as the published filter does.

        Parameters
        ----------
        imu_measurement : (...) array
            Not looked at.

        Raises
        ------
        NoInertialUpdateError
            Always.
        """
        raise NoInertialUpdateError(
            "update_imu() was never published: accelerations say nothing about a state of position "
            "and heading; correct the position by update_gps()"
        )
