"""Distance sensors of generation 2; the mathematics is in :mod:`rps_compat.sensors`."""

import numpy as np
from numpy.typing import NDArray

from rps_compat.sensors import cast_rays, disturb_distances

__all__ = [
    "NDArray", "np", "simulate_distance_sensors", "simulate_distance_sensors_without_robots",
]  # fmt: skip


def simulate_distance_sensors(
    poses: NDArray[np.floating],
    obstacles: NDArray[np.floating],
    distance_sensors_orientation: NDArray[np.floating],
    robot_diameter: float,
    robot_center_offset: float,
    distance_sensor_range: float,
    distance_sensor_error: float,
    distance_sensor_dropout_prob: float,
    distance_sensor_outlier_prob: float,
) -> NDArray[np.floating]:
    """Simulate distance sensors on robots that see obstacles and each other.

    Parameters
    ----------
    poses : (3, N) array
        Poses of the robots, m and rad.
    obstacles : (M, 2, 2) array or None
        Segments, m.
    distance_sensors_orientation : (3, S) array
        Sensors on the body: forward, left (m), direction (rad).
    robot_diameter, robot_center_offset : float
        Diameter of the bodies, and how far their centres lie ahead of the poses, m.
    distance_sensor_range : float
        Farthest reading, m; beyond it a sensor reads −1.
    distance_sensor_error, distance_sensor_dropout_prob, distance_sensor_outlier_prob : float
        Spread of the proportional error; probabilities of a −1 and of an outlier.

    Returns
    -------
    (S, N) array
        Readings, m.

    Raises
    ------
    SensorError
        An array of the wrong shape; it is an IndexError.
    """
    distances = cast_rays(
        np.asarray(poses, dtype=float),
        None if obstacles is None else np.asarray(obstacles, dtype=float),
        np.asarray(distance_sensors_orientation, dtype=float),
        distance_sensor_range,
        robot_diameter=robot_diameter,
        ahead=robot_center_offset,
    )
    return disturb_distances(
        distances,
        distance_sensor_range,
        distance_sensor_error,
        distance_sensor_dropout_prob,
        distance_sensor_outlier_prob,
    )


def simulate_distance_sensors_without_robots(
    poses: NDArray[np.floating],
    obstacles: NDArray[np.floating],
    distance_sensors_orientation: NDArray[np.floating],
    distance_sensor_range: float,
    distance_sensor_error: float,
    distance_sensor_dropout_prob: float,
    distance_sensor_outlier_prob: float,
) -> NDArray[np.floating]:
    """Simulate distance sensors that see obstacles only, and sit about the poses.

    Parameters
    ----------
    poses : (3, N) array
        Poses of the robots, m and rad.
    obstacles : (M, 2, 2) array or None
        Segments, m.
    distance_sensors_orientation : (3, S) array
        Sensors on the body: forward, left (m), direction (rad).
    distance_sensor_range : float
        Farthest reading, m; beyond it a sensor reads −1.
    distance_sensor_error, distance_sensor_dropout_prob, distance_sensor_outlier_prob : float
        Spread of the proportional error; probabilities of a −1 and of an outlier.

    Returns
    -------
    (S, N) array
        Readings, m.

    Raises
    ------
    SensorError
        An array of the wrong shape; it is an IndexError.
    """
    distances = cast_rays(
        np.asarray(poses, dtype=float),
        None if obstacles is None else np.asarray(obstacles, dtype=float),
        np.asarray(distance_sensors_orientation, dtype=float),
        distance_sensor_range,
    )
    return disturb_distances(
        distances,
        distance_sensor_range,
        distance_sensor_error,
        distance_sensor_dropout_prob,
        distance_sensor_outlier_prob,
    )
