"""Starting places, arrival tests and small helpers, by the names of generation 2.

The mathematics is in :mod:`rps_compat.placement` and :mod:`rps_compat.controllers`.
"""

import random
from collections.abc import Callable
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rps_compat import controllers, placement
from rps_compat.arguments import NumberError, count, matrix
from rps_compat.controllers import Flags
from rps_compat.errors import RobotariumError
from rps_compat.kinematics import HALF_TURN, Array, rotations
from rps_compat.v2.robotarium_abc import ARobotarium

__all__ = [
    "ARobotarium",
    "NDArray",
    "create_at_pose",
    "create_at_position",
    "datetime",
    "determine_font_size",
    "generate_initial_poses",
    "generate_random_poses",
    "generate_random_positions",
    "np",
    "random",
    "rotation_matrix",
    "unique_filename",
]

#: Candidates drawn before the random places give up.
CANDIDATES = 10_000


class NoFigureError(RobotariumError, AttributeError):
    """The size of something in a figure was asked for, and there is no figure."""


def generate_random_positions(
    N: int, spacing: float = 0.5, width: float = 3.0, height: float = 1.8
) -> Array:
    """Draw positions in a centred rectangle, with a distance to keep.

    Draws from numpy's global generator, two numbers a candidate.

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
    (2, N) array
        Positions, m.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    CrowdedError
        So many robots do not fit, or did not fit within 10,000 candidates.
    """
    count("N", N)
    for name, value in (("spacing", spacing), ("width", width), ("height", height)):
        if not isinstance(value, (int, float, np.number)) or not value > 0:
            raise NumberError(
                f"{name} is {value!r} ({type(value).__name__}), expected a number > 0"
            )
    return placement.spaced_positions(N, spacing, width, height, CANDIDATES)


def generate_random_poses(
    N: int, spacing: float = 0.5, width: float = 3.0, height: float = 1.8
) -> Array:
    """Draw positions as :func:`generate_random_positions` does, then headings.

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
        So many robots do not fit, or did not fit within 10,000 candidates.
    """
    positions = generate_random_positions(N, spacing, width, height)
    headings = (np.random.rand(N) - 0.5) * 2 * HALF_TURN  # noqa: NPY002
    return np.vstack([positions, headings])


def generate_initial_poses(
    N: int, width: float = 3.0, height: float = 1.0
) -> NDArray[np.floating[Any]]:
    """Draw poses from 22 places in two rows that look at each other.

    Draws from Python's global generator, ``random``.

    Parameters
    ----------
    N : int
        How many robots, 0 to 22.
    width, height : float
        Length of the rows, and the distance between them (m).

    Returns
    -------
    (3, N) array
        Poses, m and rad.

    Raises
    ------
    ValueError
        More than 22 robots, or fewer than none.
    TypeError
        `N` is not an integer.
    """
    return placement.two_rows(N, width, height)


def create_at_pose(
    position_error: float = 0.05, rotation_error: float = 0.2
) -> Callable[[Array, Array], tuple[bool, Flags]]:
    """Create ``check_at_pose(states, poses)``: whether all have arrived, and who has.

    Parameters
    ----------
    position_error, rotation_error : float
        How near is near enough (m, rad).

    Returns
    -------
    callable
        From poses (3, N) and goals (3, N) to a bool and flags (N,). Raises NotAnArrayError or
        ShapeError for anything else.
    """

    def check_at_pose(states: Array, poses: Array) -> tuple[bool, Flags]:
        matrix("states", states, 3)
        matrix("poses", poses, 3, states.shape[1])
        done = controllers.arrived(poses, states, position_error, rotation_error)
        return bool(done.all()), done

    return check_at_pose


def create_at_position(
    position_error: float = 0.05,
) -> Callable[[Array, Array], tuple[bool, Flags]]:
    """Create ``check_at_position(states, positions)``: whether all have arrived, and who has.

    Parameters
    ----------
    position_error : float
        How near is near enough (m).

    Returns
    -------
    callable
        From positions or poses (2 or 3, N) and goals (2, N) to a bool and flags (N,). Raises
        NotAnArrayError or ShapeError for anything else.
    """

    def check_at_position(states: Array, positions: Array) -> tuple[bool, Flags]:
        matrix("states", states, 2, more_rows=True)
        matrix("positions", positions, 2, states.shape[1])
        done: Flags = controllers.distances(states, positions) <= position_error
        return bool(done.all()), done

    return check_at_position


def determine_font_size(robotarium_instance: ARobotarium, font_height_meters: float) -> float:
    """Return the size (points) of letters in the figure.

    Parameters
    ----------
    robotarium_instance : Robotarium
        Whose figure it is.
    font_height_meters : float
        Their height in the arena (m).

    Raises
    ------
    NoFigureError
        The instance was made with ``show_figure=False``.
    """
    if not robotarium_instance.show_figure:
        raise NoFigureError(
            "this Robotarium has no figure to measure: it was made with show_figure=False; "
            "ask for the font size only where there is a figure"
        )
    figure = robotarium_instance._fig
    height = figure.get_size_inches()[1] * figure.dpi
    return float(height * font_height_meters / 2.0)


def rotation_matrix(theta: Any) -> Array:
    """Return rotations about the vertical axis.

    Parameters
    ----------
    theta : (...) array-like
        M angles in any shape, rad.

    Returns
    -------
    (3, 3, M) array
        A rotation matrix for each.
    """
    return rotations(theta)


def unique_filename(file_name: str) -> str:
    """Return a file's name with the present date and time: ``data_2026_04_23_09_00_00.npy``.

    Parameters
    ----------
    file_name : str
        The beginning of the name.
    """
    return f"{file_name}_{datetime.now():%Y_%m_%d_%H_%M_%S}.npy"
