"""What scripts call the arrays and the columns in which they keep a run."""

from __future__ import annotations

import math
import re

POSE_NAMES = (
    "poses",
    "pose",
    "pose_data",
    "states",
    "state",
    "x_data",
    "xdata",
    "trajectory",
    "trajectories",
    "robotarium_data",
)
COMMAND_NAMES = ("command", "commands", "dxu", "input_data", "inputs")
STEP_NAMES = ("dt", "time_step", "timestep")
TIME_NAMES = ("t", "time", "timestamp", "timestamps", "times", "seconds", "stamp", "sec", "time_s")
ROBOT_NAMES = ("robot", "id", "robot_id", "agent", "agent_id", "i")
STATE_NAMES = {
    "x": ("x", "px", "posx", "pos_x", "x_m"),
    "y": ("y", "py", "posy", "pos_y", "y_m"),
    "theta": ("theta", "th", "yaw", "heading", "phi", "angle", "θ", "theta_rad", "psi"),
}
STATE_OF = {name: state for state, names in STATE_NAMES.items() for name in names}
_STATE_FIRST = re.compile(
    r"(?P<state>[a-zθ]+(?:_(?:m|rad))?)[\s_.\-]*[\[({]?(?P<robot>\d+)[\])}]?(?:_(?:m|rad))?"
)
_ROBOT_FIRST = re.compile(
    r"(?:robot|agent|r)?[\s_.\-]*(?P<robot>\d+)[\s_.\-:/]*(?P<state>[a-zθ_]+)"
)


LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
ANGLES = {"rad": 1.0, "deg": math.pi / 180, "degree": math.pi / 180, "degrees": math.pi / 180}
ANGLES["°"] = ANGLES["deg"]
SECONDS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "milliseconds": 1e-3}
SECONDS |= {"us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9, "nsec": 1e-9, "nanoseconds": 1e-9}
_UNITS = "|".join(sorted({*LENGTHS, *ANGLES, *SECONDS}, key=len, reverse=True))
_WITH_UNIT = re.compile(
    rf"(?P<name>.+?)(?:[\s_]*[\[(]\s*(?P<inside>{_UNITS})\s*[\])]|[\s_]+(?P<after>{_UNITS}))"
)


def split_unit(word: str) -> tuple[str, str | None]:
    """Take the unit off a column's name, if it has one.

    Parameters
    ----------
    word : str
        The column's name, in lower case.

    Returns
    -------
    name : str
        The rest of it.
    unit : str, optional
        A key of `LENGTHS`, `ANGLES` or `SECONDS`.

    Examples
    --------
    >>> split_unit("x1 [mm]"), split_unit("theta1_deg"), split_unit("y2")
    (('x1', 'mm'), ('theta1', 'deg'), ('y2', None))
    """
    match = _WITH_UNIT.fullmatch(word)
    return (match["name"], match["inside"] or match["after"]) if match else (word, None)


def numbered(word: str) -> tuple[str, str] | None:
    """Return which state of which robot a column of this name holds; None where it does not say.

    Parameters
    ----------
    word : str
        The column's name, in lower case.

    Returns
    -------
    (str, str), optional
        The state, one of `STATE_NAMES`, and the digits of the robot's number.

    Examples
    --------
    >>> numbered("y_2"), numbered("robot3_yaw"), numbered("battery")
    (('y', '2'), ('theta', '3'), None)
    """
    for pattern in (_STATE_FIRST, _ROBOT_FIRST):
        match = pattern.fullmatch(word)
        if match and match["state"].strip("_") in STATE_OF:
            return STATE_OF[match["state"].strip("_")], match["robot"]
    return None


def names_a_column(word: str) -> bool:
    """Tell whether a word is what a script calls a time, a robot or a state.

    Parameters
    ----------
    word : str
        A cell of what may be a header, in lower case.
    """
    bare, _ = split_unit(word)
    known = bare in TIME_NAMES or bare in STATE_OF or bare in ROBOT_NAMES
    return known or numbered(bare) is not None
