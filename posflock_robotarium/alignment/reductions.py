"""The usual ways to take one number from a curve; None where the recording has no such curve."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.alignment.metric_registry import NumberFunction


def settled_mean(key: str) -> NumberFunction:
    """Return a function of a run: the mean of a curve over the settled part, where defined.

    Parameters
    ----------
    key : str
        Key of the metric whose curve it is; the number has the unit of the curve.
    """

    def mean(run: MeasuredRun) -> float | None:
        curve = run.curve(key)
        return None if curve is None else run.settled_mean(curve)

    return mean


def smallest(key: str) -> NumberFunction:
    """Return a function of a run: the least value of a curve, where defined.

    Parameters
    ----------
    key : str
        Key of the metric whose curve it is; the number has the unit of the curve.
    """

    def least(run: MeasuredRun) -> float | None:
        curve = run.curve(key)
        return None if curve is None else float(np.fmin.reduce(curve))

    return least


def largest(key: str) -> NumberFunction:
    """Return a function of a run: the greatest value of a curve, where defined.

    Parameters
    ----------
    key : str
        Key of the metric whose curve it is; the number has the unit of the curve.
    """

    def greatest(run: MeasuredRun) -> float | None:
        curve = run.curve(key)
        return None if curve is None else float(np.fmax.reduce(curve))

    return greatest
