"""What a log says about its run, carried inside files that otherwise hold numbers alone.

A converted log takes its parameters along as one JSON object named `NAME`: an array of its bytes
in ``.npz`` and ``.mat`` files, a comment ``# NAME: {…}`` in front of a CSV table. What reads the
numbers without knowing of it loses nothing. How many rows follow stands in it under `ROWS`, so that
a file that was cut is told from a whole one.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError

NAME = "posflock_parameters"
ROWS = "posflock_rows"
LARGEST = 16 << 20
"""Bytes beyond which no description of a run is read."""


def to_json(parameters: Mapping[str, Any], rows: int) -> str:
    """Return parameters as one line of ASCII, whatever their strings hold.

    Parameters
    ----------
    parameters : mapping
        What the log says about its run.
    rows : int
        How many rows are written with them.
    """
    return json.dumps({**parameters, ROWS: rows}, default=_plain)


def rows_promised(parameters: dict[str, Any]) -> int | None:
    """Return how many rows were written with parameters, and take that out of them.

    Parameters
    ----------
    parameters : dict
        As `from_json` gives them.

    Returns
    -------
    int, optional
        None where they do not say it, as of a run that was killed.
    """
    rows = parameters.pop(ROWS, None)
    ended = parameters.get("ended")
    if rows is None and isinstance(ended, Mapping) and ended.get("how") != "running":
        rows = ended.get("rows")
    return rows if type(rows) is int and rows >= 0 else None


def to_bytes(parameters: Mapping[str, Any], rows: int) -> NDArray[np.uint8]:
    """Return parameters as an array, for files of arrays.

    Parameters
    ----------
    parameters : mapping
        What the log says about its run.
    rows : int
        How many rows are written with them.

    Returns
    -------
    (k,) integer array
        The bytes of their JSON.
    """
    return np.frombuffer(to_json(parameters, rows).encode("ascii"), dtype=np.uint8)


def from_json(text: str | bytes, where: str) -> dict[str, Any]:
    """Read parameters back.

    Parameters
    ----------
    text : str or bytes
        What `to_json` gave.
    where : str
        File (and variable) name for messages.

    Raises
    ------
    LogError
        When the text is too long, no JSON, or no object.
    """
    if len(text) > LARGEST:
        raise LogError(f"{where}: {len(text)} bytes, too large for a description")
    try:
        parameters = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise LogError(f"{where}: not readable as JSON ({error})") from error
    if not isinstance(parameters, dict):
        raise LogError(
            f"{where}: expected an object of parameters, got {type(parameters).__name__}"
        )
    return parameters


def from_array(array: NDArray[Any], where: str) -> dict[str, Any]:
    """Read parameters back from the bytes of `to_bytes`, in whatever number type they come.

    Parameters
    ----------
    array : (...) array
        The bytes of `to_bytes`, as numbers of any kind.
    where : str
        File (and variable) name for messages.

    Raises
    ------
    LogError
        When the array holds no bytes, or they are no parameters.
    """
    if array.dtype.kind not in "fiu" or array.size > LARGEST:
        raise LogError(f"{where}: expected bytes, got {array.dtype} of shape {array.shape}")
    values = np.asarray(array).reshape(-1)
    if not ((values >= 0) & (values <= 255)).all():
        raise LogError(f"{where}: expected bytes, got numbers that are none")
    return from_json(values.astype(np.uint8).tobytes(), where)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)
