"""What an analysis may be told: radius, window, thresholds, transient, questions and targets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.estimators import WINDOW
from posflock_robotarium.alignment.metrics import SLOWEST
from posflock_robotarium.alignment.questions import Questions
from posflock_robotarium.alignment.targets import parse_target
from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]

TRANSIENT = 20.0
"""Seconds of the transient, after which a flock should have aligned, unless told otherwise."""


@dataclass(frozen=True)
class AnalysisOptions:
    """What an analysis may be told.

    Parameters
    ----------
    radius : float or tuple of float, optional
        Neighbour radius in metres, one or one a robot; taken from the log where it has one.
    window : float
        Seconds of the Savitzky-Golay window.
    slowest : float
        Speed in m/s up to which a robot has no direction of motion. See `metrics.SLOWEST`.
    threshold : float
        γ from which the flock counts as aligned.
    transient : float, optional
        Seconds at the start that numbers named "settled" leave out; by default `TRANSIENT`, and
        nothing of a run that is shorter.
    drive : float, optional
        Seconds at the start in which robots drive to their initial conditions; the transient
        begins after them. By default what the log says, see `logs.start`.
    questions : Questions, optional
        What is asked of the run; by default what its log tells (see `questions.asked_of`).
    targets : tuple of str
        What metrics must keep to, each in the words of `targets.GRAMMAR`.

    Raises
    ------
    ParameterError
        When a value is not finite or outside its range, or a target does not follow the grammar.
    """

    radius: float | tuple[float, ...] | None = None
    window: float = WINDOW
    slowest: float = SLOWEST
    threshold: float = 0.9
    transient: float | None = None
    drive: float | None = None
    questions: Questions | None = None
    targets: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for target in self.targets:
            parse_target(target)
        for name, low in (("window", 0.0), ("slowest", 0.0), ("transient", 0.0), ("drive", 0.0)):
            value = getattr(self, name)
            if value is None and name in ("transient", "drive"):
                continue
            if not (math.isfinite(value) and value >= low) or (name == "window" and value <= 0):
                raise ParameterError(f"{name} is {value}; expected a finite number above {low:g}")
        if not -1.0 <= self.threshold <= 1.0:
            raise ParameterError(f"threshold is {self.threshold}; γ lies between -1 and 1")
        radii = np.atleast_1d(np.asarray(1.0 if self.radius is None else self.radius, dtype=float))
        if not (np.isfinite(radii).all() and (radii > 0).all()):
            raise ParameterError(f"neighbour radius is {self.radius}; expected metres above 0")


def settled_samples(
    t: Floats, transient: float | None, start: float | None = None
) -> NDArray[np.bool_]:
    """Return which samples come later than `transient` seconds; all of them in a shorter run.

    Parameters
    ----------
    t : (T,) array
        Times, s, of any origin.
    transient : float, optional
        Seconds at the start that do not count; by default `TRANSIENT`.
    start : float, optional
        When the experiment began, on the same clock: nothing before it counts. By default at the
        first sample.

    Returns
    -------
    (T,) boolean array
        Whether each sample counts.
    """
    elapsed = t - (t[0] if start is None else start)
    transient = TRANSIENT if transient is None else transient
    later = ties.beyond(elapsed, transient)
    return later if later.any() else np.asarray(ties.reached(elapsed, 0.0))
