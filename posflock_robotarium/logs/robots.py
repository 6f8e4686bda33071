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

from posflock_robotarium.flocking.errors import ParameterError
from rps_compat.testbed import GRITSBOT_X, GTERNAL, RobotModel

GIVEN = "given"
"""Name among a log's parameters under which the user's own words on robot and arena stand."""


@dataclass(frozen=True)
class GivenRobot:
    """What a user says of robot and arena, which counts more than what a log says.

    Parameters
    ----------
    arena : (4,) tuple, optional
        Left, right, bottom, top, m.
    collision_diameter : float, optional
        Distance of two collision points below which robots collide, m.

    Raises
    ------
    ParameterError
        Where the arena is no rectangle, or the diameter no length.
    """

    arena: tuple[float, float, float, float] | None = None
    collision_diameter: float | None = None

    def __post_init__(self) -> None:
        if self.arena is not None and _edges(list(self.arena)) is None:
            raise ParameterError(
                f"--arena {self.arena}; expected left,right,bottom,top in metres, for example "
                "-1.6,1.6,-1,1"
            )
        if self.collision_diameter is not None and not _is_length(self.collision_diameter):
            raise ParameterError(
                f"--collision-diameter is {self.collision_diameter}; expected metres, 0 or more"
            )

    def among(self, parameters: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the parameters of a log with this among them.

        Parameters
        ----------
        parameters : mapping
            What the log says about its run.
        """
        said = {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in dataclasses.asdict(self).items()
            if value is not None
        }
        return {**parameters, GIVEN: said} if said else parameters

    @property
    def words(self) -> str:
        """What is given, in a sentence; empty where nothing is."""
        parts = []
        if self.arena is not None:
            left, right, bottom, top = self.arena
            parts.append(f"arena from {left:g} to {right:g} m and {bottom:g} to {top:g} m")
        if self.collision_diameter is not None:
            parts.append(f"collision diameter {self.collision_diameter:g} m")
        return f"{' and '.join(parts)}, as asked" if parts else ""


NOTHING_GIVEN = GivenRobot()
"""The user says nothing: the log's own word counts."""


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
        does, and what the user says instead (`GIVEN`).  A value that is none is passed over.
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
    asked = parameters.get(GIVEN)
    given: Mapping[str, Any] = asked if isinstance(asked, Mapping) else {}
    if _is_length(diameter := given.get("collision_diameter")):
        own["collision_diameter"] = float(diameter)
    edges = (
        _edges(given.get("arena"))
        or _edges(constants.get("boundaries"))
        or _edges(parameters.get("arena"))
    )
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
