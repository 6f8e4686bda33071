r"""Which parameters a log determines, by the information matrix, and why the others are left out.

With whitened residuals the information matrix is :math:`I = J^T J`.  Were all else known, parameter
p would have the standard deviation :math:`1 / \sqrt{I_{pp}}`; since nothing is, it has
:math:`\sqrt{(I^{-1})_{pp}}`.  A log that holds too little of a parameter makes the first too wide,
one in which a second parameter does the same (in a circle, turn gain and bias) only the other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.calibration.estimate import Z

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class FittedParameter(Enum):
    """What a parameter is."""

    DEAD_TIME = "dead time"
    LAG = "lag"
    SPEED_GAIN = "speed gain"
    TURN_GAIN = "turn gain"
    TURN_BIAS = "turn bias"
    HEADING_OFFSET = "heading offset"


#: An interval that reaches farther than this from its value says nothing worth writing down: the
#: guess that a robot is like others is better. Gains; seconds; rad/s; rad.
USEFUL = {
    FittedParameter.DEAD_TIME: 0.25,
    FittedParameter.LAG: 0.25,
    FittedParameter.SPEED_GAIN: 0.3,
    FittedParameter.TURN_GAIN: 0.3,
    FittedParameter.TURN_BIAS: 0.03,
    FittedParameter.HEADING_OFFSET: 0.05,
}
#: Of two parameters that do the same, the one that comes first here is left out.
_DISPENSABLE = (
    FittedParameter.TURN_BIAS,
    FittedParameter.LAG,
    FittedParameter.DEAD_TIME,
    FittedParameter.TURN_GAIN,
    FittedParameter.SPEED_GAIN,
)


@dataclass(frozen=True)
class LeftOut:
    """A parameter that a log does not determine.

    Attributes
    ----------
    kind : FittedParameter
        What it is.
    robot : int, optional
        Whose; None for the team's.
    reason : str
        Why it is left out.
    """

    kind: FittedParameter
    robot: int | None
    reason: str

    def __str__(self) -> str:
        return f"{name_of(self.kind, self.robot)}: {self.reason}"


def name_of(kind: FittedParameter, robot: int | None) -> str:
    """Return what a parameter is called in messages.

    Parameters
    ----------
    kind : FittedParameter
        What it is.
    robot : int or None
        Whose; None for the team's.
    """
    return f"the {kind.value}" + ("" if robot is None else f" of robot {robot}")


class ParameterLayout:
    """Where parameters stand in a vector: dead time, lag, then three a robot, kind by kind.

    Parameters
    ----------
    robots : int
        Number of robots, N.
    """

    def __init__(self, robots: int) -> None:
        each = (FittedParameter.SPEED_GAIN, FittedParameter.TURN_GAIN, FittedParameter.TURN_BIAS)
        self.names: list[tuple[FittedParameter, int | None]] = [
            (FittedParameter.DEAD_TIME, None),
            (FittedParameter.LAG, None),
        ]
        self.names += [(kind, robot) for kind in each for robot in range(robots)]
        self.kinds = np.array([kind for kind, _ in self.names])
        self.useful = np.array([USEFUL[kind] for kind, _ in self.names])

    def of(self, kind: FittedParameter) -> Flags:
        """Return which entries are of a kind, (p,).

        Parameters
        ----------
        kind : FittedParameter
            Which of them.

        Returns
        -------
        (p,) boolean array
            True for these.
        """
        flags: Flags = self.kinds == kind
        return flags


def undetermined(
    information: Floats, free: Flags, layout: ParameterLayout
) -> list[tuple[int, str]]:
    """Return entries that are to be left out next, each with its reason; none when all are useful.

    Entries of which the log holds too little go first and together; of those that are confounded
    only the most dispensable kind, since what is left may then be clear.

    Parameters
    ----------
    information : (p, p) array
        The information matrix of all parameters.
    free : (p,) boolean array
        Which are still fitted.
    layout : ParameterLayout
        What they are.
    """
    diagonal = np.diag(information)
    alone = Z / np.sqrt(np.maximum(diagonal, 1e-300))
    weak = np.flatnonzero(free & ~(alone <= layout.useful))
    if weak.size:
        return [(int(p), f"{_LITTLE[layout.names[p][0]]} in the log") for p in weak]
    wide = Z * np.sqrt(variances(information, free))
    confounded = free & ~(wide <= layout.useful)
    for kind in _DISPENSABLE:
        which = np.flatnonzero(confounded & layout.of(kind))
        if which.size:
            return [(int(p), _partner(information, free, int(p), layout)) for p in which]
    return []


_LITTLE = {
    FittedParameter.DEAD_TIME: "too few or too small changes of what robots were told and followed",
    FittedParameter.LAG: "too few or too small changes of what robots were told and followed",
    FittedParameter.SPEED_GAIN: "too little driving forward",
    FittedParameter.TURN_GAIN: "too little turning",
    FittedParameter.TURN_BIAS: "too few rows for so much noise",
}


def covariance(information: Floats, free: Flags) -> Floats:
    """Return the covariance (p, p) of the free parameters; zero for the others.

    Parameters
    ----------
    information : (p, p) array
        The information matrix of all parameters.
    free : (p,) boolean array
        Which were fitted.

    Returns
    -------
    (p, p) array
        In squares of the parameters' units.
    """
    out = np.zeros_like(information)
    size = np.sqrt(np.diag(information)[free])
    scaled = information[np.ix_(free, free)] / np.outer(size, size)
    values, vectors = np.linalg.eigh(scaled)
    inverse = (vectors / np.maximum(values, 1e-14)) @ vectors.T
    out[np.ix_(free, free)] = inverse / np.outer(size, size)
    return out


def variances(information: Floats, free: Flags) -> Floats:
    """Return the variances (p,) of the free parameters; zero for the others.

    Parameters
    ----------
    information : (p, p) array
        The information matrix of all parameters.
    free : (p,) boolean array
        Which were fitted.

    Returns
    -------
    (p,) array
        In squares of the parameters' units.
    """
    out: Floats = np.diag(covariance(information, free)).copy()
    return out


def _partner(information: Floats, free: Flags, entry: int, layout: ParameterLayout) -> str:
    """Name the parameter that does most nearly the same."""
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    likeness = np.abs(information[entry]) / size / size[entry]
    likeness[~free] = 0.0
    likeness[entry] = 0.0
    kind, robot = layout.names[int(np.argmax(likeness))]
    share = math.floor(100 * min(float(likeness.max()), 1.0))
    return f"the log cannot tell it from {name_of(kind, robot)} ({share} % alike)"
