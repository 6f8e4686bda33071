"""What the sensors of a generation-2 Robotarium read, by the published names."""

from abc import ABC

import numpy as np
from numpy.typing import NDArray

from rps_compat.arena import Array
from rps_compat.sensors import ray_ends
from rps_compat.v2.sensor_suite import SensorSuite


class SensorReadings(ABC):
    """The readings of all robots: distances, encoders, inertial sensors, headings.

    A Robotarium has them by inheriting from this class; it sets the attributes below.
    """

    DISTANCE_SENSORS_ORIENTATION: Array
    _poses: Array
    _suite: SensorSuite
    _initial_encoders: Array
    _distance_sensors_enabled: bool

    @property
    def _distances(self) -> Array:
        return self._suite.distances

    @property
    def _distance_endpoints(self) -> Array:
        if not self._distance_sensors_enabled:
            raise AttributeError  # told in words by __getattr__, which Python asks next
        return self._calculate_endpoints(self._distances)

    @property
    def _encoders(self) -> Array:
        return self._suite.encoders

    @property
    def _accelerations(self) -> Array:
        return self._suite.accelerations

    @property
    def _gyros(self) -> Array:
        return self._suite.gyros

    @property
    def _magnetic_fields(self) -> Array:
        return self._suite.magnetic_fields

    @property
    def _orientations(self) -> Array:
        return self._suite.orientations

    def get_distances(self) -> Array:
        """Copy of the distance readings (7, N) in metres.

        −1 where nothing was hit; NaN before the first step and without distance sensors.
        """
        return np.array(self._distances)

    def get_distance_endpoints(self) -> Array:
        """Points (2, 7, N) in metres that the distance sensors read; NaN where nothing was hit.

        Raises
        ------
        AttributeError
            The instance has no distance sensors.
        """
        return self._distance_endpoints

    def get_encoders(self) -> NDArray[np.int32]:
        """Ticks of the wheels since the start, (2, N): left, then right."""
        return (self._encoders - self._initial_encoders).astype(np.int32)

    def get_accelerations(self) -> Array:
        """Copy of the accelerations (3, N), m/s²."""
        return np.array(self._accelerations)

    def get_gyros(self) -> Array:
        """Copy of the turn rates about the three axes, (3, N), rad/s."""
        return np.array(self._gyros)

    def get_magnetic_fields(self) -> Array:
        """Copy of the magnetic fields (3, N) in the robots' frames."""
        return np.array(self._magnetic_fields)

    def get_orientations(self) -> Array:
        """Copy of the headings (N,) in degrees, [0, 360)."""
        return np.array(self._orientations)

    def _calculate_endpoints(self, distances: Array) -> Array:
        # As published, drawn from the poses: the body's centre offset is left out.
        return ray_ends(self._poses, distances, self.DISTANCE_SENSORS_ORIENTATION, 0.0)
