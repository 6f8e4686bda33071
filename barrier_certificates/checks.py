"""Validation of parameters and arrays, in one place and with one way of saying what is wrong."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate_errors import NotFiniteError, ParameterError, ShapeError


def positive(name: str, value: float, unit: str = "") -> None:
    """Refuse a number that is not positive and finite.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : float
        What was given; numpy's numbers pass, too.
    unit : str
        What the error says after "a positive number", such as "of metres".

    Raises
    ------
    ParameterError
        If it is zero, negative, infinite, NaN or no number.
    """
    if not (isinstance(value, (int, float, np.number)) and math.isfinite(value) and value > 0):
        raise ParameterError(f"{name} is {value!r}; expected a positive number {unit}".rstrip())


def not_negative(name: str, value: float, unit: str = "") -> None:
    """Refuse a number that is negative or not finite.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : float
        What was given; numpy's numbers pass, too.
    unit : str
        What the error says after "a positive number", such as "of metres".

    Raises
    ------
    ParameterError
        If it is negative, infinite, NaN or no number.
    """
    if not (isinstance(value, (int, float, np.number)) and math.isfinite(value) and value >= 0):
        raise ParameterError(
            f"{name} is {value!r}; expected zero or a positive number {unit}".rstrip()
        )


def positive_or_none(name: str, value: float | None, unit: str = "") -> None:
    """Refuse a limit that is neither None (no such limit) nor positive and finite.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : float or None
        What was given; numpy's numbers pass, too.
    unit : str
        What the error says after "a positive number", such as "of metres".

    Raises
    ------
    ParameterError
        If it is zero, negative, infinite, NaN or no number.
    """
    if value is not None:
        positive(name, value, unit)


def angle(name: str, value: float) -> None:
    """Refuse an angle that is not a finite number.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : float
        The angle, rad.

    Raises
    ------
    ParameterError
        If it is infinite, NaN or no number.
    """
    if not (isinstance(value, (int, float, np.number)) and math.isfinite(value)):
        raise ParameterError(f"{name} is {value!r}; expected a finite angle in radians")


def columns(name: str, array: Any, rows: int, robots: int | None = None) -> FloatArray:
    """Return a team's array as floats, a column a robot.

    Parameters
    ----------
    name : str
        What the error calls it.
    array : (rows, N) array-like
        What was given.
    rows : int
        Rows that it must have: 2 for positions and commands, 3 for poses.
    robots : int, optional
        Columns that it must have, where each robot has numbers of its own.

    Returns
    -------
    (rows, N) array
        The same numbers, as floats.

    Raises
    ------
    ShapeError
        If it cannot be read as numbers, has another shape, no column or one for another robot.
    """
    try:
        values = np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ShapeError(f"{name} cannot be read as numbers: {error}") from None
    if values.ndim != 2 or values.shape[0] != rows or values.shape[1] == 0:
        raise ShapeError(
            f"{name} have shape {values.shape}; expected ({rows}, N), a column a robot"
        )
    if robots is not None and values.shape[1] != robots:
        raise ShapeError(
            f"{name} have shape {values.shape}, but there are parameters for each of {robots}"
            f" robots; expected ({rows}, {robots}), or parameters for this team"
        )
    return values


def finite(*arrays: FloatArray) -> bool:
    """Whether no array holds NaN or infinity.

    Parameters
    ----------
    *arrays : (...) array
        Arrays with at least one number each.
    """
    # A sum of squares costs half of looking at each on small arrays; huge numbers overflow it.
    return all(math.isfinite(np.vdot(a, a)) or bool(np.isfinite(a).all()) for a in arrays)


def require_finite(name: str, array: FloatArray) -> None:
    """Refuse NaN and infinity where there is no policy for them.

    Parameters
    ----------
    name : str
        What the error calls it.
    array : (...) array
        Numbers, at least one.

    Raises
    ------
    NotFiniteError
        If one is NaN or infinite.
    """
    if not finite(array):
        raise NotFiniteError(f"{name} hold NaN or infinity; expected finite numbers")


def team(
    desired: Any, states: Any, name: str, rows: int, robots: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return commands and the states that they are for, as floats.

    Parameters
    ----------
    desired : (2, N) array-like
        Commands, m/s, or m/s and rad/s.
    states : (rows, N) array-like
        Positions, m, or poses, m and rad.
    name : str
        What the error calls the states.
    rows : int
        Rows of the states: 2 or 3.
    robots : int, optional
        How many robots the team must have, where each has numbers of its own.

    Returns
    -------
    commands : (2, N) array
        The commands, as floats.
    states : (rows, N) array
        The states, as floats.

    Raises
    ------
    ShapeError
        If either has another shape, or they are for different or wrong numbers of robots.
    """
    commands, states = columns("commands", desired, 2), columns(name, states, rows, robots)
    if commands.shape[1] != states.shape[1]:
        raise ShapeError(
            f"commands are for {commands.shape[1]} robots, but there are {name} of "
            f"{states.shape[1]}"
        )
    return commands, states
