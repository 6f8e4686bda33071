"""What scripts call the arrays and the columns in which they keep a run."""

from __future__ import annotations

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
MILLISECONDS = re.compile(
    rf"(?P<name>{'|'.join(TIME_NAMES)})[\s_]*[\[(]?(?:ms|msec|milliseconds)[\])]?"
)
_ROBOT_FIRST = re.compile(
    r"(?:robot|agent|r)?[\s_.\-]*(?P<robot>\d+)[\s_.\-:/]*(?P<state>[a-zθ_]+)"
)


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
    known = word in TIME_NAMES or word in STATE_OF or word in ROBOT_NAMES
    return known or numbered(word) is not None
