"""What the utilities refuse, in one place and in words.

The published simulators guard their functions with bare ``assert`` statements, or fail deeper down
with whatever Python says there. We refuse the same arguments, with the argument's name, what was
got and what was expected. Scripts may catch what the published functions raise, so each class here
derives from all of those built-in exceptions: ``except AssertionError`` written for generation 1
and ``except IndexError`` met in generation 2 both catch a :class:`ShapeError`.
"""

from typing import Any

import numpy as np

from rps_compat.errors import RobotariumError


class NotAnArrayError(RobotariumError, AssertionError, AttributeError, TypeError, ValueError):
    """A list, a number or None stands where a numpy array is expected."""


class ShapeError(RobotariumError, AssertionError, IndexError, ValueError):
    """An array has the wrong number of rows, columns or dimensions."""


class NumberError(RobotariumError, AssertionError, TypeError, ValueError):
    """A gain, limit, distance or count is not a number, or outside its range."""


class AgentError(NumberError, IndexError):
    """There is no agent of that index."""


def number(
    name: str,
    value: Any,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
) -> None:
    """Refuse `value` unless it is a Python number in range.

    As in the published simulators, ``int``, ``float``, ``bool`` and ``np.float64`` are numbers;
    other numpy scalars are refused.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : object
        What was given.
    above : float, optional
        It has to be greater than this.
    least : float, optional
        It has to be at least this.
    most : float, optional
        It has to be at most this.

    Raises
    ------
    NumberError
        Not such a number, not > `above`, not >= `least`, or not <= `most`; NaN is in no range.
    """
    expected = "a number"
    if above is not None:
        expected += f" > {above:g}"
    if least is not None:
        expected += f" >= {least:g}"
    if most is not None:
        expected += f", <= {most:g}"
    if not isinstance(value, (int, float)):
        raise NumberError(
            f"{name} is {value!r} ({type(value).__name__}), expected {expected}"
            + ("; convert it with float(...)" if isinstance(value, np.generic) else "")
        )
    if (
        (above is not None and not value > above)
        or (least is not None and not value >= least)
        or (most is not None and not value <= most)
    ):
        raise NumberError(f"{name} is {value!r}, expected {expected}")


def scalar(name: str, value: Any) -> None:
    """Refuse `value` unless arithmetic with arrays treats it as one number (NaN may pass).

    Parameters
    ----------
    name : str
        What the error calls it.
    value : object
        What was given.

    Raises
    ------
    NumberError
        A string, None, or a sequence.
    """
    if not isinstance(value, (int, float, np.number)):
        raise NumberError(f"{name} is {value!r} ({type(value).__name__}), expected a number")


def count(name: str, value: Any, *, least: int = 1) -> None:
    """Refuse `value` unless it is an ``int`` of at least `least`.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : object
        What was given.
    least : int
        It has to be at least this.

    Raises
    ------
    NumberError
        Not an ``int``, or too small.
    """
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise NumberError(
            f"{name} is {value!r} ({type(value).__name__}), expected an int >= {least}"
        )


def table(name: str, value: Any, expected: str) -> None:
    """Refuse a value unless it is an array of two dimensions.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : object
        What was given.
    expected : str
        Which dimensions, for the error: ``"(2, N)"``.

    Raises
    ------
    NotAnArrayError, ShapeError
        Not a numpy array, or of other dimensions.
    """
    if not isinstance(value, np.ndarray):
        raise NotAnArrayError(
            f"{name} is a {type(value).__name__}, expected a numpy array {expected}: convert it "
            "with numpy.array(...)"
        )
    if value.ndim != 2:
        raise ShapeError(f"{name} has shape {value.shape}, expected {expected}")


def matrix(
    name: str,
    value: Any,
    rows: int,
    columns: int | None = None,
    *,
    more_rows: bool = False,
    more_columns: bool = False,
) -> None:
    """Refuse `value` unless it is an array (`rows`, `columns`), a column for each robot.

    Parameters
    ----------
    name : str
        What the error calls it.
    value : object
        What was given.
    rows : int
        How many rows it must have: 2 for velocities, 3 for poses.
    columns : int, optional
        How many robots there are; any number if left out.
    more_rows, more_columns : bool
        Whether surplus rows or columns pass (they are left unread).

    Raises
    ------
    NotAnArrayError
        Not a numpy array.
    ShapeError
        Of another shape.
    """
    robots = "N" if columns is None else columns
    expected = f"({rows}, {robots}), a column for each robot"
    table(name, value, expected)
    shape = value.shape
    if (shape[0] < rows if more_rows else shape[0] != rows) or (
        columns is not None and (shape[1] < columns if more_columns else shape[1] != columns)
    ):
        raise ShapeError(f"{name} has shape {shape}, expected {expected}")


def agent_index(agent: Any, agents: int, *, numpy_integers: bool) -> None:
    """Refuse `agent` unless it is one of 0 … `agents` − 1.

    Parameters
    ----------
    agent : object
        What was given.
    agents : int
        How many agents there are.
    numpy_integers : bool
        Whether integers of numpy pass, too.

    Raises
    ------
    AgentError
        Not an integer, or no such agent.
    """
    kinds = (int, np.integer) if numpy_integers else (int,)
    if not isinstance(agent, kinds) or not 0 <= agent < agents:
        raise AgentError(
            f"agent is {agent!r} ({type(agent).__name__}), expected an int from 0 to {agents - 1}"
        )
