"""The sensors of one generation-2 instance: their last readings, and how a step renews them.

Reading costs only those who read. A step draws its noise, counts the encoders' ticks and casts the
rays (the published random stream demands these three); inertial readings and compass are worked
out from the stored noise when a getter asks.
"""

import weakref
from typing import Any

import numpy as np

from barrier_certificates.ties import reached
from rps_compat import sensors
from rps_compat.arena import Array

_BATCH = 256


class SensorSuite:
    """Readings of all sensors of the robots of one instance.

    Parameters
    ----------
    robotarium : Robotarium
        The instance, of generation 2.

    Attributes
    ----------
    distances : (S, N) array
        Last distances, m; NaN before the first step and without distance sensors.
    encoders : (2, N) array
        Ticks counted, left then right.
    accelerations, gyros, magnetic_fields : (3, N) array
        m/s², rad/s and the field's parts; zero before the first step.
    orientations : (N,) array
        Headings in degrees, [0, 360).
    """

    def __init__(self, robotarium: Any) -> None:
        robots = robotarium.number_of_robots
        self._of = weakref.proxy(robotarium)  # it owns this suite
        self.distances: Array = np.full(
            (robotarium.DISTANCE_SENSORS_ORIENTATION.shape[1], robots), np.nan
        )
        self._encoders: Array = np.zeros((2, robots))
        # Ticks are added up many steps at once: what a step leaves is (wheels, noise).
        self._turning = np.empty((_BATCH, 2, robots))
        self._tick_noise = np.empty((_BATCH, 2, robots))
        self._uncounted = 0
        self._accelerations: Array = np.zeros((3, robots))
        self._gyros: Array = np.zeros((3, robots))
        self._magnetic_fields: Array = np.zeros((3, robots))
        self._orientations: Array = np.zeros(robots)
        self._noise: Array | None = None
        self._headings: Array = np.zeros(robots)
        self._turn_rates: Array = np.zeros(robots)

    def start_from(self, ticks: Array) -> None:
        """Begin to read in the middle of a run.

        Parameters
        ----------
        ticks : (2, N) array
            Ticks counted so far, left then right.
        """
        of = self._of
        self._encoders = self._encoders + ticks
        if of._arena.steps:
            self.remember()
            self._noise = np.random.randn(10 * of.number_of_robots)  # noqa: NPY002

    def sense(self) -> None:
        """Renew all readings after a step; draws noise in the published order."""
        self._noise = None  # nobody asked for the last step's readings
        of = self._of
        robots = of.number_of_robots
        if of._distance_sensors_enabled:
            self.sense_distances()
        noise = np.random.randn(12 * robots)  # noqa: NPY002 - the published stream
        self.count_ticks(noise[: 2 * robots].reshape(2, robots))
        self.remember()
        self._noise = noise[2 * robots :]

    def remember(self) -> None:
        """Keep what the last step did, for readings that are worked out later."""
        self.work_out()
        arena = self._of._arena
        self._headings = arena.poses[2].copy()
        self._turn_rates = arena.velocities[1]

    def sense_distances(self) -> None:
        """Cast the rays from the true poses and disturb them."""
        of = self._of
        reach = of.DISTANCE_SENSOR_RANGE
        exact = sensors.cast_rays(
            of._arena.poses,
            of.obstacles,
            of.DISTANCE_SENSORS_ORIENTATION,
            reach,
            robot_diameter=of.ROBOT_DIAMETER,
            ahead=of.CENTER_OFFSET,
        )
        self.distances = sensors.disturb_distances(
            exact,
            reach,
            of.DISTANCE_SENSOR_ERROR,
            of.DISTANCE_SENSOR_DROPOUT_PROB,
            of.DISTANCE_SENSOR_OUTLIER_PROB,
        )

    def count_ticks(self, noise: Array) -> None:
        """Add the ticks of the last step, disturbed.

        Parameters
        ----------
        noise : (2, N) array
            Standard normal numbers.
        """
        self._turning[self._uncounted] = self._of._arena.wheel_velocities
        self._tick_noise[self._uncounted] = noise
        self._uncounted += 1
        if self._uncounted == _BATCH:
            self._add_up()

    def _add_up(self) -> None:
        steps, of = slice(self._uncounted), self._of
        per_radian = of.ENCODER_COUNTS_PER_REVOLUTION * of.MOTOR_GEAR_RATIO / (2 * np.pi)
        turned = self._turning[steps] * (of.TIME_STEP * per_radian)
        ticks = sensors.encoder_ticks(turned, self._tick_noise[steps], of.ENCODER_NOISE_STD)
        self._encoders = self._encoders + ticks.sum(axis=0)
        self._uncounted = 0

    @property
    def encoders(self) -> Array:
        """Ticks counted (2, N), left then right."""
        if self._uncounted:
            self._add_up()
        return self._encoders

    def feel_accelerations(self, noise: Array) -> None:
        """Renew the accelerations, disturbed.

        Parameters
        ----------
        noise : (3, N) array
            Standard normal numbers.
        """
        of = self._of
        felt = sensors.accelerations(self._turn_rates, of.IMU_ORIENTATION)
        self._accelerations = felt + noise * of.ACCELEROMETER_NOISE_STDS[:, None]

    def feel_turning(self, noise: Array) -> None:
        """Renew the gyroscopes, disturbed.

        Parameters
        ----------
        noise : (3, N) array
            Standard normal numbers.
        """
        felt = noise * self._of.GYRO_NOISE_STDS[:, None]
        felt[2] += self._turn_rates
        self._gyros = felt

    def feel_magnetic_fields(self, noise: Array) -> None:
        """Renew the magnetic fields, disturbed.

        Parameters
        ----------
        noise : (3, N) array
            Standard normal numbers.
        """
        of = self._of
        felt = sensors.magnetic_fields(
            self._headings, of.MAGNETOMETER_XY_AVG, of.MAGNETOMETER_Z_AVG
        )
        self._magnetic_fields = felt + noise * of.MAGNETOMETER_NOISE_STDS[:, None]

    def feel_orientations(self, noise: Array) -> None:
        """Renew the orientations, disturbed.

        Parameters
        ----------
        noise : (N,) array
            Standard normal numbers.
        """
        degrees = np.rad2deg(self._headings) + noise * self._of.ORIENTATION_NOISE_STD
        around = np.mod(degrees, 360)
        self._orientations = np.where(reached(around, 360.0), 0.0, around)

    def work_out(self) -> None:
        """Finish the readings that a step left for whoever asks."""
        if self._noise is None:
            return
        robots = self._of.number_of_robots
        inertial = self._noise[: 9 * robots].reshape(3, 3, robots)
        self.feel_accelerations(inertial[0])
        self.feel_turning(inertial[1])
        self.feel_magnetic_fields(inertial[2])
        self.feel_orientations(self._noise[9 * robots :])
        self._noise = None

    @property
    def accelerations(self) -> Array:
        """Accelerations (3, N), m/s²."""
        self.work_out()
        return self._accelerations

    @property
    def gyros(self) -> Array:
        """Turn rates about the three axes (3, N), rad/s."""
        self.work_out()
        return self._gyros

    @property
    def magnetic_fields(self) -> Array:
        """Magnetic fields (3, N)."""
        self.work_out()
        return self._magnetic_fields

    @property
    def orientations(self) -> Array:
        """Headings (N,), degrees within [0, 360)."""
        self.work_out()
        return self._orientations
