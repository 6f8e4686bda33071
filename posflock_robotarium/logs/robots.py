"""Which robot and arena a log is of: what it says itself, else its generation's.

A log carries its own constants as ``robot`` (the fields of `rps_compat.testbed.RobotModel`), taken
from the Robotarium instance that drove it.  What a log leaves out is the testbed's.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeGuard

from rps_compat.testbed import GRITSBOT_X, GTERNAL, RobotModel


@dataclass(frozen=True)
class LoggedRobot:
    """A robot and its arena, and how they are known.

    Attributes
    ----------
    model : RobotModel
        The robot and the arena.
    words : str
        How they are known.
    """

    model: RobotModel
    words: str


def robot_of(parameters: Mapping[str, Any]) -> LoggedRobot:
    """Return the robot that a log says it was.

    Parameters
    ----------
    parameters : mapping
        What the log says: ``robot``, ``api_generation`` and ``arena`` (4,) in metres, each if it
        does.  A value that is none is passed over.
    """
    generation = parameters.get("api_generation")
    if generation == 1:
        model, words = GRITSBOT_X, "generation 1 (GRITSBot X)"
    else:
        model = GTERNAL
        words = "generation 2 (GTernal)" + ("" if generation == 2 else ", assumed")
    said = parameters.get("robot")
    constants = said if isinstance(said, Mapping) else {}
    own: dict[str, Any] = {}
    for field in dataclasses.fields(RobotModel):
        if field.name != "boundaries" and _is_length(value := constants.get(field.name)):
            own[field.name] = float(value)
    edges = _edges(constants.get("boundaries")) or _edges(parameters.get("arena"))
    if edges is not None:
        own["boundaries"] = edges
    found = dataclasses.replace(model, **own)
    if generation not in (1, 2) and constants:
        words = "robot as the log says"
    elif found != dataclasses.replace(model, boundaries=found.boundaries):
        words += ", with constants of its own"
    return LoggedRobot(found, words)


def _is_length(value: Any) -> TypeGuard[float]:
    return (
        isinstance(value, (int, float))
        and not isinstance(value, bool)
        and math.isfinite(value)
        and value >= 0
    )


def _edges(said: Any) -> tuple[float, float, float, float] | None:
    """Return a rectangle (x_min, x_max, y_min, y_max), or None where it is none."""
    if not isinstance(said, (list, tuple)) or len(said) != 4:
        return None
    try:
        left, right, bottom, top = (float(edge) for edge in said)
    except (TypeError, ValueError):
        return None
    if left < right and bottom < top and math.isfinite(left + right + bottom + top):
        return left, right, bottom, top
    return None
