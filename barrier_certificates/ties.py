"""Ties: what is decided where two numbers are equal but for their last bits.

A robot stands *on* the wall, two start *exactly* 0.15 m apart, a velocity points *exactly* back. In
such a case the last bit of a sine decides, and that bit differs from processor to processor, from
one numpy to the next, and with the order of a sum. A verdict must not hang on it. So there is one
margin, `TIE`, a thousand times the rounding of a long run and a thousandth of what a tracker sees,
and every comparison that a designed experiment can meet exactly is made with it, by one of four
functions:

=========================  ===================  ==============================================
`within` (value, bound)    value ≤ bound + TIE  equal counts: robots that touch
`beyond` (value, bound)    value > bound + TIE  equal does not: on the wall is inside
`reached` (value, bound)   value ≥ bound − TIE  equal counts: time is up
`short_of` (value, bound)  value < bound − TIE  equal does not: at the radius is no neighbour
=========================  ===================  ==============================================

This does not do away with the edge; it moves it by a nanometre, to where nobody puts a robot.
``docs/explanations/reproducibility.md`` lists what is decided how.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

#: What differs by no more is equal: metres, seconds, radians, m/s, rad/s, shares.
TIE = 1e-9


def within(value: Any, bound: Any) -> Any:
    """Return whether a value is at most the bound; equal counts, NaN is not.

    Parameters
    ----------
    value : float or (...) array
        What is compared.
    bound : float or (...) array
        What it is compared with, in the same unit.
    """
    return value <= bound + TIE


def beyond(value: Any, bound: Any) -> Any:
    """Return whether a value is more than the bound; equal does not count, NaN is not.

    Parameters
    ----------
    value : float or (...) array
        What is compared.
    bound : float or (...) array
        What it is compared with, in the same unit.
    """
    return value > bound + TIE


def reached(value: Any, bound: Any) -> Any:
    """Return whether a value is at least the bound; equal counts, NaN is not.

    Parameters
    ----------
    value : float or (...) array
        What is compared.
    bound : float or (...) array
        What it is compared with, in the same unit.
    """
    return value >= bound - TIE


def short_of(value: Any, bound: Any) -> Any:
    """Return whether a value is less than the bound; equal does not count, NaN is not.

    Parameters
    ----------
    value : float or (...) array
        What is compared.
    bound : float or (...) array
        What it is compared with, in the same unit.
    """
    return value < bound - TIE


def first_smallest(values: ArrayLike) -> int:
    """Return the index of the smallest value; the first of those that are equal.

    Parameters
    ----------
    values : (N,) array-like
        Finite numbers, one or more.
    """
    x = np.asarray(values, dtype=float)
    return int(np.argmax(within(x, x.min())))


def first_largest(values: ArrayLike) -> int:
    """Return the index of the largest value; the first of those that are equal.

    Parameters
    ----------
    values : (N,) array-like
        Finite numbers, one or more.
    """
    return first_smallest(-np.asarray(values, dtype=float))


def rank(value: float) -> float:
    """Return what to sort by, so that equal values keep their order.

    Parameters
    ----------
    value : float
        A finite number.
    """
    return round(value / TIE)


def whole(value: float) -> int:
    """Return the largest whole number that is at most `value`: 28.999999999999996 is 29.

    Parameters
    ----------
    value : float
        A finite number.
    """
    return math.floor(value + TIE)


def nearest_whole(value: float) -> int:
    """Round `value` to a whole number, halves up: a duration of 2.5 steps is three steps.

    Parameters
    ----------
    value : float
        A finite number.
    """
    return math.floor(value + 0.5 + TIE)
