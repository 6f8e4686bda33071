"""The constants of the robots and the arena that a script drives, asked of its Robotarium.

They belong into the log: whoever judges the run judges it by the robot and the arena that it had.
The two generations of the API name them differently, and the testbed's own package need not have
all of them: what it does not tell stays unknown.
"""

from __future__ import annotations

import math
from typing import Any

#: Names of generation 1; those of generation 2 are the same in capitals.
NAMES = (
    "wheel_radius",
    "base_length",
    "max_wheel_velocity",
    "collision_diameter",
    "collision_offset",
    "time_step",
)


def constants_of(robotarium: Any) -> dict[str, Any]:
    """Return the constants of a Robotarium instance, ready for a log; none that it does not tell.

    Parameters
    ----------
    robotarium : Robotarium
        An instance of either generation.

    Returns
    -------
    dict
        Lengths in metres and wheel speeds in rad/s under `NAMES`; ``boundaries`` is a list, least
        x, greatest x, least y and greatest y in metres.
    """
    found: dict[str, Any] = {}
    for name in NAMES:
        for spelling in (name, name.upper()):
            value = _numbers(getattr(robotarium, spelling, None), 1)
            if value is not None:
                found[name] = value[0]
    edges = _numbers(getattr(robotarium, "BOUNDARIES", None), 4)
    corner = _numbers(getattr(robotarium, "boundaries", None), 4)
    if edges is not None:
        found["boundaries"] = edges
    elif corner is not None:  # generation 1 gives a corner, a width and a height
        x, y, width, height = corner
        found["boundaries"] = [x, x + width, y, y + height]
    return found


def _numbers(value: Any, count: int) -> list[float] | None:
    """Return so many finite numbers, or None where that is not what `value` holds."""
    try:
        numbers = [float(number) for number in (value if count > 1 else [value])]
    except (TypeError, ValueError):
        return None
    return numbers if len(numbers) == count and all(map(math.isfinite, numbers)) else None
