"""Starting places, arrival tests and sizes in the figure, by the names of generation 1.

The mathematics is in :mod:`rps_compat.placement` and :mod:`rps_compat.controllers`.
"""

from typing import Any

import numpy as np

from rps_compat import controllers, deviations, placement
from rps_compat.arguments import count, matrix, number
from rps_compat.graphs import Indices
from rps_compat.kinematics import HALF_TURN, Array, rotations
from rps_compat.lazy import LazyModule
from rps_compat.v1.sensing import distance_points

__all__ = [
    "at_pose",
    "at_position",
    "calculate_global_distance_points",
    "determine_font_size",
    "determine_marker_size",
    "generate_initial_conditions",
    "np",
    "plt",
    "rotation_matrix",
]

plt: Any = LazyModule("matplotlib.pyplot")

#: Candidates drawn before :func:`generate_initial_conditions` gives up.
CANDIDATES = 200

#: Pixels for each metre that the published functions measure for an instance without a figure: on
#: an empty figure of matplotlib's default size, whose axes go from 0 to 1 (see _pixels_to_edge).
NO_FIGURE_WIDTH = 521.0
NO_FIGURE_HEIGHT = 115.5


def generate_initial_conditions(
    N: int, spacing: float = 0.3, width: float = 3, height: float = 1.8
) -> Array:
    """Draw poses in a centred rectangle, with a distance to keep.

    Draws from numpy's global generator: two numbers a candidate, then N headings.

    Parameters
    ----------
    N : int
        How many robots.
    spacing : float
        Smallest distance between two centres (m, > 0).
    width, height : float
        Of the rectangle (m, > 0).

    Returns
    -------
    (3, N) array
        Poses, m and rad.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    CrowdedError
        So many robots do not fit, or did not fit within 200 candidates.
    """
    count("N", N)
    number("spacing", spacing, above=0)
    number("width", width, above=0)
    number("height", height, above=0)
    positions = placement.spaced_positions(N, spacing, width, height, CANDIDATES)
    headings = np.random.uniform(-HALF_TURN, HALF_TURN, N)  # noqa: NPY002
    return np.vstack([positions, headings])


def at_pose(
    states: Array, poses: Array, position_error: float = 0.05, rotation_error: float = 0.2
) -> tuple[Indices, ...]:
    """Return which robots are at their poses.

    Parameters
    ----------
    states, poses : (3, N) array
        Where they are and where they should be, m and rad.
    position_error, rotation_error : float
        How near is near enough (m, rad).

    Returns
    -------
    tuple of one (k,) integer array
        Numbers of the robots that have arrived.

    Raises
    ------
    NotAnArrayError, ShapeError, NumberError
        An argument is of the wrong type or shape.
    """
    number("position_error", position_error)
    number("rotation_error", rotation_error)
    matrix("states", states, 3)
    matrix("poses", poses, 3, states.shape[1])
    return np.nonzero(controllers.arrived(poses, states, position_error, rotation_error))


def at_position(states: Array, points: Array, position_error: float = 0.02) -> tuple[Indices, ...]:
    """Return which robots are at their points: indices, as ``numpy.nonzero`` gives them.

    Parameters
    ----------
    states : (3, N) array
        Where the robots are, m and rad.
    points : (2, N) array
        Where they should be, m.
    position_error : float
        How near is near enough (m).

    Returns
    -------
    tuple of one (k,) integer array
        Numbers of the robots that have arrived.

    Raises
    ------
    NotAnArrayError, ShapeError, NumberError
        An argument is of the wrong type or shape.
    NameError
        The function is wanted as published.
    """
    number("position_error", position_error)
    matrix("states", states, 3)
    matrix("points", points, 2)
    if deviations.as_published("at_position"):
        raise NameError("at_position is wanted as published, where every call raises NameError")
    matrix("points", points, 2, states.shape[1])
    return np.nonzero(controllers.distances(states, points) <= position_error)


#: The published axes overhang the figure by 3 % on each side, and show 10 cm around the arena.
AXES_SPAN = 1.06
AXES_START = -0.03
MARGIN = 0.1


def determine_marker_size(robotarium_instance: Any, marker_size_meters: float) -> float:
    """Return the size `s` for ``scatter`` (points²) of a marker in the figure.

    Parameters
    ----------
    robotarium_instance : Robotarium
        Whose figure it is.
    marker_size_meters : float
        Its diameter in the arena (m).
    """
    if not robotarium_instance.show_figure:
        return float((NO_FIGURE_WIDTH * marker_size_meters) ** 2)
    width, _ = _figure_pixels(robotarium_instance)
    edge = robotarium_instance.boundaries[2]
    return float((_pixels_to_edge(width, edge) * marker_size_meters / edge) ** 2)


def determine_font_size(robotarium_instance: Any, font_height_meters: float) -> float:
    """Return the size (points) of letters in the figure.

    Parameters
    ----------
    robotarium_instance : Robotarium
        Whose figure it is.
    font_height_meters : float
        Their height in the arena (m).
    """
    if not robotarium_instance.show_figure:
        return float(NO_FIGURE_HEIGHT * font_height_meters)
    _, height = _figure_pixels(robotarium_instance)
    return float(AXES_SPAN * height * font_height_meters / robotarium_instance.boundaries[2])


def _figure_pixels(robotarium_instance: Any) -> tuple[float, float]:
    figure = robotarium_instance.figure
    width, height = figure.get_size_inches() * figure.dpi
    return float(width), float(height)


def _pixels_to_edge(width: float, edge: float) -> float:
    """Pixel column at which the published axes show x = `edge`, the arena's width in metres.

    The published function takes that for the width of the arena in pixels.
    """
    share = (edge + edge / 2 + MARGIN) / (edge + 2 * MARGIN)
    return width * (AXES_START + AXES_SPAN * share)


def rotation_matrix(theta: Any) -> Array:
    """Return rotations about the vertical axis, as the last release does.

    Parameters
    ----------
    theta : (M,) array-like
        Angles, rad.

    Returns
    -------
    (M, 3, 3) array
        A rotation matrix for each.
    """
    return np.moveaxis(rotations(theta), 2, 0)


def calculate_global_distance_points(
    robotarium_instance: Any, poses: Array, distances: Array
) -> Array:
    """Points that distance sensors have read, by the last release of generation 1.

    Parameters
    ----------
    robotarium_instance : Robotarium
        Where the sensors sit.
    poses : (3, N) array
        Poses at which they read, m and rad.
    distances : (7, N) array
        What they read, m.

    Returns
    -------
    (2, 7, N) array
        The points, m; NaN where nothing was read.
    """
    return distance_points(robotarium_instance, poses, distances)
