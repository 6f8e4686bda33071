"""What a GTernal robot's sensors read: infrared distances, wheel encoders, inertial unit, compass.

**Distances.** Each sensor sends a ray from its place on the body. The nearest wall segment or other
robot (a disc) that the ray meets within range is read with a proportional error; a reading may drop
out (−1), or be an outlier anywhere within range. No hit reads −1.

**Encoders** count whole ticks. In a step in which a wheel turns by n ticks, the count grows by n
plus noise whose spread goes with √n, rounded.

**Inertial unit.** It sits off the wheel axle, so it feels the centripetal acceleration ω²r towards
the axle, and gravity. (Acceleration along the path, dv/dt, is left out, as in the published
simulator.) **Compass.** The horizontal field turns against the heading; the orientation is the
heading in degrees within [0, 360).

All noise comes from numpy's global generator in the published order, so that a script that seeds it
reads the same numbers.
"""

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import reached, within
from rps_compat.errors import RobotariumError

Array = NDArray[np.float64]

GRAVITY = 9.81
NO_READING = -1.0


class SensorError(RobotariumError, IndexError, ValueError):
    """Poses, obstacles or sensor places of the wrong shape."""


def ray_origins(poses: Array, places: Array, ahead: float) -> tuple[Array, Array, Array, Array]:
    """Return where the rays of all sensors begin, and their directions.

    Parameters
    ----------
    poses : (3, N) array
        Poses, m and rad.
    places : (3, S) array
        Sensors on the body: forward and left of its centre, m, and direction, rad.
    ahead : float
        How far the body's centre lies ahead of the pose, m.

    Returns
    -------
    x, y : (S, N) array
        Origins, m.
    along_x, along_y : (S, N) array
        Unit directions.
    """
    x, y, theta = poses
    forward, left, turn = (places[row][:, None] for row in range(3))
    cosine, sine = np.cos(theta), np.sin(theta)
    forward = forward + ahead
    direction = theta + turn
    return (
        x + forward * cosine - left * sine,
        y + forward * sine + left * cosine,
        np.cos(direction),
        np.sin(direction),
    )


def cast_rays(
    poses: Array,
    obstacles: Array | None,
    places: Array,
    reach: float,
    *,
    robot_diameter: float | None = None,
    ahead: float = 0.0,
) -> Array:
    """Return the exact distances that the rays travel; −1 where nothing is within reach.

    Parameters
    ----------
    poses : (3, N) array
        Poses, m and rad.
    obstacles : (M, 2, 2) array or None
        Segments, both ends' x and y, m. None or empty: no segments.
    places : (3, S) array
        Sensors on the body: forward and left of its centre, m, and direction, rad.
    reach : float
        Range of the sensors, m.
    robot_diameter : float, optional
        Diameter of the other robots' bodies, m; None leaves them out.
    ahead : float
        How far the body's centre lies ahead of the pose, m.

    Returns
    -------
    (S, N) array
        Distances, m.

    Raises
    ------
    SensorError
        Poses that are not (3, N), obstacles that are not (M, 2, 2).
    """
    if poses.ndim != 2 or poses.shape[0] != 3:
        raise SensorError(f"poses have shape {poses.shape}, expected (3, N)")
    from_x, from_y, along_x, along_y = ray_origins(poses, places, ahead)
    nearest = np.full(from_x.shape, np.inf)
    for (start_x, start_y), (end_x, end_y) in _segments(obstacles):
        wall_x, wall_y = end_x - start_x, end_y - start_y
        to_x, to_y = start_x - from_x, start_y - from_y
        turn = along_x * wall_y - along_y * wall_x
        with np.errstate(divide="ignore", invalid="ignore"):  # rays parallel to the segment
            distance = (to_x * wall_y - to_y * wall_x) / turn
            share = (to_x * along_y - to_y * along_x) / turn
        met = reached(distance, 0.0) & reached(share, 0.0) & within(share, 1.0)
        np.minimum(nearest, distance, out=nearest, where=met)
    if robot_diameter is not None:
        x, y, theta = poses
        body_x, body_y = x + ahead * np.cos(theta), y + ahead * np.sin(theta)
        for robot in range(poses.shape[1]):
            to_x, to_y = body_x[robot] - from_x, body_y[robot] - from_y
            squared = to_x * to_x + to_y * to_y
            closest = to_x * along_x + to_y * along_y
            chord = (robot_diameter / 2) ** 2 - (squared - closest * closest)
            distance = closest - np.sqrt(np.maximum(chord, 0.0))
            # A body whose centre is out of range is not seen, though its rim may be in range.
            met = reached(chord, 0.0) & reached(distance, 0.0) & within(squared, reach * reach)
            met[:, robot] = False
            np.minimum(nearest, distance, out=nearest, where=met)
    return np.where(within(nearest, reach), np.clip(nearest, 0.0, reach), NO_READING)


def _segments(obstacles: Array | None) -> Array:
    if obstacles is None or np.size(obstacles) == 0:
        return np.empty((0, 2, 2))
    segments = np.asarray(obstacles, dtype=float)
    if segments.ndim != 3 or segments.shape[1:] != (2, 2):
        raise SensorError(
            f"obstacles have shape {segments.shape}, expected (M, 2, 2): for each of M segments "
            "its two ends, for each end its x and y"
        )
    return segments


def disturb_distances(
    distances: Array, reach: float, error: float, dropout: float, outlier: float
) -> Array:
    """Disturb exact distances into readings: a hit may drop out, stray, or err a little.

    Parameters
    ----------
    distances : (S, N) array
        Exact distances, m, −1 where nothing was hit.
    reach : float
        Outliers are uniform within [0, `reach`], m.
    error : float
        Standard deviation of the proportional error.
    dropout, outlier : float
        Probabilities of a hit to read −1, and else to be an outlier.

    Returns
    -------
    (S, N) array
        Readings, m, −1 where there is none.
    """
    readings: Array = distances.copy()
    for robot, sensor in np.argwhere(distances.T >= 0):
        if np.random.rand() < dropout:  # noqa: NPY002 - the published stream
            readings[sensor, robot] = NO_READING
        elif np.random.rand() < outlier:  # noqa: NPY002
            readings[sensor, robot] = np.random.uniform(0, reach)  # noqa: NPY002
        else:
            read = readings[sensor, robot] * (1 + error * np.random.randn())  # noqa: NPY002
            readings[sensor, robot] = min(max(read, 0.0), reach)
    return readings


def ray_ends(poses: Array, distances: Array, places: Array, ahead: float) -> Array:
    """Return the points that rays reach; NaN where there is no reading.

    Parameters
    ----------
    poses : (3, N) array
        Poses, m and rad.
    distances : (S, N) array
        Readings, m, −1 where there is none.
    places : (3, S) array
        Sensors on the body: forward and left of its centre, m, and direction, rad.
    ahead : float
        How far the body's centre lies ahead of the pose, m.

    Returns
    -------
    (2, S, N) array
        Points, m.
    """
    from_x, from_y, along_x, along_y = ray_origins(poses, places, ahead)
    length = np.where(distances >= 0, distances, np.nan)
    return np.stack([from_x + length * along_x, from_y + length * along_y])


def encoder_ticks(turned: Array, noise: Array, spread: float) -> Array:
    """Return the whole ticks counted in one step of turning wheels.

    `noise` is standard normal, (2, N); `spread` its standard deviation for up to one tick, growing
    with the square root of their number.

    Parameters
    ----------
    turned : (2, N) array
        Ticks that the wheels really turned.
    noise : (2, N) array
        Standard normal numbers.
    spread : float
        Standard deviation for up to one tick, growing with the square root of their number.

    Returns
    -------
    (2, N) array
        Counted ticks.
    """
    ticks: Array = np.round(turned + spread * np.sqrt(np.maximum(1.0, np.abs(turned))) * noise)
    return ticks


def accelerations(turn_rates: Array, place: Array) -> Array:
    """Return what an accelerometer off the axle of a turning robot reads.

    Parameters
    ----------
    turn_rates : (N,) array
        Turn rates, rad/s.
    place : (3,) array
        Where it sits, from the middle of the axle, m.

    Returns
    -------
    (3, N) array
        Accelerations in the robot's frame, m/s².
    """
    squared = turn_rates * turn_rates
    return np.stack([-squared * place[0], -squared * place[1], np.full_like(squared, -GRAVITY)])


def magnetic_fields(headings: Array, horizontal: float, vertical: float) -> Array:
    """Return the magnetic field in the frame of each robot.

    Parameters
    ----------
    headings : (N,) array
        Headings, rad.
    horizontal : float
        Horizontal part of the field, in any unit.
    vertical : float
        Vertical part, in the same unit.

    Returns
    -------
    (3, N) array
        The field, in that unit.
    """
    return np.stack(
        [
            horizontal * np.cos(headings),
            -horizontal * np.sin(headings),
            np.full_like(headings, vertical),
        ]
    )
