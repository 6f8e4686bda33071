"""What metrics are taken of: states of one flock, or of a flock at many times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]


def checked_states(values: ArrayLike, name: str) -> Floats:
    """Return states as floats, of a shape that every metric takes.

    Parameters
    ----------
    values : (..., d, N) array
        Positions, m, or velocities, m/s, in 2 or 3 dimensions.
    name : str
        What an error calls them.

    Returns
    -------
    (..., d, N) array
        The same values.

    Raises
    ------
    ParameterError
        Where they have another shape, or no agent.
    """
    x = np.asarray(values, dtype=float)
    if x.ndim < 2 or x.shape[-2] not in (2, 3) or x.shape[-1] < 1:
        raise ParameterError(
            f"{name}: expected shape (..., d, N), d = 2 or 3, N from 1; got {x.shape}"
        )
    return x


def checked_track(positions: ArrayLike, rows: int) -> Floats:
    """Return positions over time as floats, long enough to take velocities of.

    Parameters
    ----------
    positions : (T, d, N) array
        Positions, m.
    rows : int
        The least T that will do.

    Returns
    -------
    (T, d, N) array
        The same positions.

    Raises
    ------
    ParameterError
        Where they have another shape, or too few rows.
    """
    p = checked_states(positions, "positions")
    if p.ndim != 3 or p.shape[0] < rows:
        raise ParameterError(
            f"positions: expected shape (T, d, N) with T of at least {rows}, got {p.shape}"
        )
    return p


def of_each_flock(measure: Callable[[Floats], ArrayLike], p: Floats) -> Floats:
    """Apply a function of one flock along all leading axes.

    Parameters
    ----------
    measure : callable
        Takes the (d, N) states of one flock and returns a number or an array.
    p : (..., d, N) array
        States of all of them.

    Returns
    -------
    (...) array
        What it returned; its own axes follow the leading ones.
    """
    values = [np.asarray(measure(p[at])) for at in np.ndindex(p.shape[:-2])]
    return np.reshape(values, (*p.shape[:-2], *values[0].shape))
