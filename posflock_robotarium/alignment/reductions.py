"""The usual ways to take one number from a curve; None where the recording has no such curve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.metric_registry import NumberFunction

Floats = NDArray[np.float64]


def settled_mean(key: str) -> NumberFunction:
    """Return a function of a run: the mean of a curve over the settled part, where defined.

    Parameters
    ----------
    key : str
        Key of the metric whose curve it is; the number has the unit of the curve.
    """
    return _reduced(key, MeasuredRun.settled_mean)


def smallest(key: str) -> NumberFunction:
    """Return a function of a run: the least value of a curve, where defined.

    Parameters
    ----------
    key : str
        Key of the metric whose curve it is; the number has the unit of the curve.
    """
    return _reduced(key, lambda run, curve: float(np.fmin.reduce(curve)))


def largest(key: str) -> NumberFunction:
    """Return a function of a run: the greatest value of a curve, where defined.

    Parameters
    ----------
    key : str
        Key of the metric whose curve it is; the number has the unit of the curve.
    """
    return _reduced(key, lambda run, curve: float(np.fmax.reduce(curve)))


def _reduced(key: str, reduce: Callable[[MeasuredRun, Floats], float | None]) -> NumberFunction:
    def number(run: MeasuredRun) -> float | None:
        curve = run.curve(key)
        return None if curve is None else reduce(run, curve)

    return number
