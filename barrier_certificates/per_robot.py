"""Numbers that may differ from robot to robot: one for all of a team, or one for each.

A team of a large robot among small ones has radii, gains and limits that no one number tells. Where
a parameter takes a sequence, its numbers are those of robots 0, 1, 2, … It is kept as a tuple of
floats, so that what has it compares, hashes and can be written down, and it says for how many
robots it is: a team of another size is refused. What counts for two robots is made of the numbers
of both in `barrier_certificates.rows.unequal_pairs`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from barrier_certificates import checks
from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate_errors import ParameterError

PerRobot = float | Sequence[float] | FloatArray
"""One number for all robots, or one for each, (N,)."""


def settle(owner: Any, names: Iterable[str], checked: bool = True) -> None:
    """Turn each sequence among the parameters of a frozen dataclass into a tuple of floats.

    Parameters
    ----------
    owner : dataclass
        Whose parameters, set in place.
    names : iterable of str
        Which of them may be sequences.
    checked : bool
        Whether its parameters are checked; only then they may be.

    Raises
    ------
    ParameterError
        If one is neither a number nor a sequence of some, or a sequence that nobody checks.
    """
    for name in names:
        given = getattr(owner, name)
        if checked:
            object.__setattr__(owner, name, settled(name, given))
        elif given is not None and np.size(given) != 1:
            raise ParameterError(
                f"{name} is {given!r} of an unchecked certificate; expected one number for all"
                " robots, or checked=True"
            )


def settled(name: str, given: Any) -> Any:
    """Return a sequence as a tuple of floats, and all else as it is.

    Parameters
    ----------
    name : str
        What the error calls it.
    given : float or (N,) array-like
        What was given; what is neither is refused by who checks the number.

    Raises
    ------
    ParameterError
        If it has another shape, or holds what is no number.
    """
    if given is None or isinstance(given, (int, float, str, np.number)):
        return given
    try:
        numbers = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros((0, 0))
    if numbers.ndim == 0:
        return given
    if numbers.ndim != 1 or not numbers.size:
        raise ParameterError(
            f"{name} is {given!r}; expected one number for all robots, or a sequence of one for"
            " each"
        )
    return tuple(numbers.tolist())


def team_size(given: Mapping[str, Any]) -> int | None:
    """Return for how many robots there are numbers, or None where all are for any team.

    Parameters
    ----------
    given : mapping
        Parameters by name: numbers, tuples of numbers or None.

    Raises
    ------
    ParameterError
        If two are for teams of different sizes.
    """
    sizes = {name: len(value) for name, value in given.items() if isinstance(value, tuple)}
    if not sizes:
        return None
    first, size = next(iter(sizes.items()))
    for name, other in sizes.items():
        if other != size:
            raise ParameterError(
                f"{name} has numbers for {other} robots, but {first} for {size}; expected as many"
                " in both, or one number for all"
            )
    return size


def check_each(
    check: Callable[[str, Any, str], None], name: str, value: Any, unit: str = ""
) -> None:
    """Check the number of all robots, or that of each.

    Parameters
    ----------
    check : callable
        Who refuses a number, such as `checks.positive`.
    name : str
        What the error calls it.
    value : float or tuple of float
        What was given.
    unit : str
        What the error says after "a positive number", such as "of metres".
    """
    if isinstance(value, tuple):
        for robot, number in enumerate(value):
            check(f"{name} of robot {robot}", number, unit)
    else:
        check(name, value, unit)


def check_limit(name: str, value: Any, unit: str) -> None:
    """Refuse a limit that is neither None (no such limit) nor positive, for all or for each.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : float or tuple of float or None
        What was given.
    unit : str
        What the error says after "a positive number", such as "of m/s".
    """
    if isinstance(value, tuple):
        check_each(checks.positive, name, value, unit)
    else:
        checks.positive_or_none(name, value, f"{unit}, or None")


def as_numbers(value: PerRobot) -> float | FloatArray:
    """Return a number for all robots as it is, and those of each as an array to compute with.

    Parameters
    ----------
    value : float or (N,) array-like
        Of any unit.

    Returns
    -------
    float or (N,) array
        The same.
    """
    return np.array(value) if isinstance(value, tuple) else value  # type: ignore[return-value]


def widened(value: PerRobot, more: float) -> PerRobot:
    """Return a distance with more added to it, for all robots or for each.

    Parameters
    ----------
    value : float or (N,) array-like
        The distance, m.
    more : float
        What is added, m.

    Returns
    -------
    float or tuple of float
        The sum, m.
    """
    if isinstance(value, tuple):
        return tuple(number + more for number in value)
    return value + more  # type: ignore[operator]


def number_of(value: Any, robot: int) -> Any:
    """Return the number of one robot; None where there is none.

    Parameters
    ----------
    value : float or tuple of float or None
        The number of all, or one for each.
    robot : int
        Which robot.
    """
    return value[robot] if isinstance(value, tuple) else value


def largest(value: PerRobot) -> float:
    """Return the largest number that a robot has.

    Parameters
    ----------
    value : float or (N,) array-like
        The number of all, or one for each.
    """
    return max(value) if isinstance(value, tuple) else value  # type: ignore[return-value]


def smallest(value: PerRobot) -> float:
    """Return the smallest number that a robot has.

    Parameters
    ----------
    value : float or (N,) array-like
        The number of all, or one for each.
    """
    return min(value) if isinstance(value, tuple) else value  # type: ignore[return-value]
