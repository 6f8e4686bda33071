"""The sensors that came with the last release of generation 1, by its names.

Generation 2 has the same sensors, so :class:`~rps_compat.v2.sensor_suite.SensorSuite` reads both.
Scripts of earlier releases know no sensors, and their random numbers must not change: nothing is
drawn before a script asks for distance sensors, or for its first reading.
"""

import weakref
from typing import Any

import numpy as np

from rps_compat.arena import Arena, Array
from rps_compat.errors import CommandError, ConstructorError
from rps_compat.sensors import ray_ends
from rps_compat.v2.robotarium_abc import ARobotarium
from rps_compat.v2.sensor_suite import SensorSuite


class _ByNewNames:
    """An instance of generation 1 by the names of generation 2, which the sensors ask for."""

    #: The body's centre is where the pose is.
    CENTER_OFFSET = 0.0

    def __init__(self, robotarium: "SensorFace") -> None:
        self._of = weakref.proxy(robotarium)  # it owns this

    def __getattr__(self, name: str) -> Any:
        if name == "_distance_sensors_enabled":
            return self._of.distance_sensors_enabled
        if name == "obstacles":  # here a column for each end, there a row
            return np.swapaxes(np.asarray(self._of.obstacles, dtype=float), -1, -2)
        return getattr(self._of, name.lower() if name.isupper() else name)


class SensorFace:
    """What an instance of generation 1 has of sensors; constants may be changed by scripts."""

    encoder_counts_per_revolution = float(ARobotarium.ENCODER_COUNTS_PER_REVOLUTION)
    motor_gear_ratio = ARobotarium.MOTOR_GEAR_RATIO
    encoder_noise_std = ARobotarium.ENCODER_NOISE_STD
    accelerometer_noise_stds = ARobotarium.ACCELEROMETER_NOISE_STDS
    gyro_noise_stds = ARobotarium.GYRO_NOISE_STDS
    magnetometer_noise_stds = ARobotarium.MAGNETOMETER_NOISE_STDS
    magnetometer_xy_avg = ARobotarium.MAGNETOMETER_XY_AVG
    magnetometer_z_avg = ARobotarium.MAGNETOMETER_Z_AVG
    orientation_noise_std = ARobotarium.ORIENTATION_NOISE_STD
    imu_orientation = ARobotarium.IMU_ORIENTATION[:, None]
    distance_sensors_orientation = ARobotarium.DISTANCE_SENSORS_ORIENTATION
    distance_sensor_range = ARobotarium.DISTANCE_SENSOR_RANGE
    distance_sensor_error = ARobotarium.DISTANCE_SENSOR_ERROR
    distance_sensor_dropout_prob = ARobotarium.DISTANCE_SENSOR_DROPOUT_PROB
    distance_sensor_outlier_prob = ARobotarium.DISTANCE_SENSOR_OUTLIER_PROB

    _arena: Arena
    number_of_robots: int
    time_step: float

    def _begin_sensing(self, use_distance_sensors: bool, obstacles: Any) -> None:
        if not isinstance(use_distance_sensors, bool):
            raise ConstructorError(
                f"use_distance_sensors is {use_distance_sensors!r}, expected True or False"
            )
        self.distance_sensors_enabled = use_distance_sensors
        self.obstacles = obstacles
        self.leds = np.zeros((3, self.number_of_robots))
        self._sensors: SensorSuite | None = None
        self._turned: Array = np.zeros((2, self.number_of_robots))  # wheels, in rad per time step
        if use_distance_sensors:
            self._suite()

    def _suite(self) -> SensorSuite:
        """Return the sensors, which begin to read when they are first asked for."""
        if self._sensors is None:
            self._new_names = _ByNewNames(self)
            suite = self._sensors = SensorSuite(self._new_names)
            per_radian = self.encoder_counts_per_revolution * self.motor_gear_ratio / (2 * np.pi)
            suite.start_from(np.round(self._turned * (self.time_step * per_radian)))
        return self._sensors

    def _after_sensed_step(self) -> None:
        if self._sensors is None:
            self._turned += self._arena.wheel_velocities
        else:
            self._sensors.sense()

    @property
    def distances(self) -> Array:
        """Last distance readings (7, N), m; −1 where nothing was hit, and without sensors."""
        return np.nan_to_num(self._suite().distances, nan=-1.0)

    @property
    def encoders(self) -> Array:
        """Ticks counted (2, N), left then right."""
        return self._suite().encoders

    @property
    def accelerations(self) -> Array:
        """Accelerations (3, N), m/s²."""
        return self._suite().accelerations

    @property
    def gyros(self) -> Array:
        """Turn rates about the three axes (3, N), rad/s."""
        return self._suite().gyros

    @property
    def magnetic_fields(self) -> Array:
        """Magnetic fields (3, N) in the robots' frames."""
        return self._suite().magnetic_fields

    @property
    def orientations(self) -> Array:
        """Headings (N,), degrees within [0, 360)."""
        return self._suite().orientations

    def get_distances(self) -> Array:
        """Copy of the distance readings (7, N), m; −1 where nothing was hit or nothing senses."""
        return np.array(self.distances)

    def get_encoders(self) -> Any:
        """Ticks of the wheels since the start, (2, N): left, then right."""
        return self.encoders.astype(np.int32)

    def get_accelerations(self) -> Array:
        """Copy of the accelerations (3, N), m/s²."""
        return np.array(self.accelerations)

    def get_gyros(self) -> Array:
        """Copy of the turn rates about the three axes, (3, N), rad/s."""
        return np.array(self.gyros)

    def get_magnetic_fields(self) -> Array:
        """Copy of the magnetic fields (3, N) in the robots' frames."""
        return np.array(self.magnetic_fields)

    def get_orientations(self) -> Array:
        """Copy of the headings (N,) in degrees, [0, 360)."""
        return np.array(self.orientations)

    def transform_distance_readings(self) -> Array:
        """Points (2, 7 N) that the distance sensors read, robot by robot; NaN where none is hit."""
        ends = distance_points(self, self._arena.poses, self.distances)
        points: Array = ends.transpose(0, 2, 1).reshape(2, -1)
        return points

    def set_leds(self, ids: Any, leds: Array) -> None:
        """Keep the colours of robots in ``leds``; the figure does not show them.

        Parameters
        ----------
        ids : (M,) array-like
            Which robots.
        leds : (3, M) array
            Red, green and blue of each.

        Raises
        ------
        CommandError
            There is no column for each robot, or no such robot.
        """
        colors = np.asarray(leds, dtype=float)
        if colors.shape != (3, np.size(ids)):
            raise CommandError(
                f"leds have shape {colors.shape}, expected (3, {np.size(ids)}): red, green and "
                "blue of each robot"
            )
        try:
            self.leds[:, np.ravel(ids)] = colors
        except IndexError as error:
            raise CommandError(
                f"ids are {ids!r}, but there are robots 0 to {self.number_of_robots - 1}"
            ) from error


def distance_points(robotarium: Any, poses: Array, distances: Array) -> Array:
    """Return the points that distance sensors have read; NaN where there is no reading.

    Parameters
    ----------
    robotarium : Robotarium
        Where the sensors sit.
    poses : (3, N) array
        Poses at which they read, m and rad.
    distances : (7, N) array
        What they read, m; −1 for nothing.

    Returns
    -------
    (2, 7, N) array
        The points, m.
    """
    return ray_ends(poses, distances, robotarium.distance_sensors_orientation, 0.0)
