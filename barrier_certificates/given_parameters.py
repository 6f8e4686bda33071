"""Parameters of certificates in the one form in which they are kept: as tuples of floats.

Who writes a certificate gives lists, tuples or arrays; a certificate is a value that compares,
hashes and can be written down.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from barrier_certificates.certificate_errors import ParameterError


def boundary_points(boundary: Any) -> tuple[Any, ...]:
    """Return a boundary as nested tuples of floats.

    Parameters
    ----------
    boundary : (4,) or (2, W) array-like
        Limits of a rectangle, or corners of a convex polygon, m.

    Raises
    ------
    ParameterError
        If it has another shape.
    """
    try:
        points = np.asarray(boundary, dtype=float)
    except (TypeError, ValueError):
        raise no_boundary(boundary) from None
    if points.ndim == 2 and points.shape[0] == 2:
        return tuple(tuple(float(c) for c in row) for row in points)
    if points.size == 4:
        return tuple(float(b) for b in points.reshape(-1))
    raise no_boundary(boundary)


def no_boundary(boundary: Any) -> ParameterError:
    """Return the error for a boundary that is none.

    Parameters
    ----------
    boundary : (...) array-like
        What was given.
    """
    return ParameterError(
        f"boundary is {boundary!r}; expected (x_min, x_max, y_min, y_max) or the (2, W) corners of "
        "a convex polygon, in metres"
    )


def shares_of(shares: Any) -> tuple[float, ...]:
    """Return shares as a tuple of floats.

    Parameters
    ----------
    shares : (N,) array-like
        Positive numbers.

    Raises
    ------
    ParameterError
        If one is not positive and finite, or there is none.
    """
    try:
        numbers = np.asarray(shares, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.ndim != 1 or not numbers.size or not (np.isfinite(numbers) & (numbers > 0)).all():
        raise ParameterError(f"shares are {shares!r}; expected a positive number for each robot")
    return tuple(float(number) for number in numbers)
