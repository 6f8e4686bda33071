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
    "pose_history",
    "poses_history",
    "state_history",
    "x_history",
)
COMMAND_NAMES = ("command", "commands", "dxu", "input_data", "inputs")
STEP_NAMES = ("dt", "time_step", "timestep")
_TIMES: tuple[str, ...] = (
    "t",
    "time",
    "timestamp",
    "timestamps",
    "times",
    "seconds",
    "stamp",
    "sec",
    "time_s",
)
_TIMES += ("zeit", "tiempo", "temps", "tempo")
TIME_NAMES = (*_TIMES, "__time", "time_history", "t_history", "time_data", "t_data")
ROBOT_NAMES: tuple[str, ...] = (
    "robot",
    "id",
    "robot_id",
    "agent",
    "agent_id",
    "i",
    "robotid",
    "agentid",
    "name",
)
ROBOT_NAMES += ("robot_name", "agent_name", "robot_index", "body", "rigid_body", "tag", "tag_id")
STATE_NAMES: dict[str, tuple[str, ...]] = {
    "x": ("x", "px", "posx", "pos_x", "xpos", "x_pos", "pose_x", "position_x", "x_m"),
    "y": ("y", "py", "posy", "pos_y", "ypos", "y_pos", "pose_y", "position_y", "y_m"),
    "theta": ("theta", "th", "yaw", "heading", "phi", "angle", "θ", "theta_rad", "psi", "ψ", "φ"),
}
STATE_NAMES["theta"] += ("orientation", "rotation", "pose_theta", "pose_yaw")
#: Parts of a rotation, which stand for a heading where there is none.
QUATERNION = ("qx", "qy", "qz", "qw")
CIRCLE = ("cos", "sin")
_OF_A_QUATERNION: tuple[str, ...] = (
    "q{}",
    "q_{}",
    "q.{}",
    "quat_{}",
    "quaternion_{}",
    "ori_{}",
    "orientation_{}",
)
_OF_A_QUATERNION += ("orientation.{}", "rot_{}", "rotation_{}", "pose_q{}")
_OF_THE_CIRCLE = ("{}", "{}_{}", "{}{}", "{}({})", "{1}_{0}", "{}.{}")
_ANGLE_WORDS = ("theta", "th", "yaw", "heading", "phi", "psi", "angle", "θ", "ψ", "φ")
PART_OF = {way.format(part[1]): part for part in QUATERNION for way in _OF_A_QUATERNION}
PART_OF |= {
    way.format(part, word): part
    for part in CIRCLE
    for way in _OF_THE_CIRCLE
    for word in _ANGLE_WORDS
}
STATE_OF = {name: state for state, names in STATE_NAMES.items() for name in names}
_STATE_FIRST = re.compile(
    r"(?P<state>[a-zθψφ]+?(?:_(?:pos|x|y|m|rad|theta|yaw))?)[\s_.\-]*(?:robot|agent)?[\s_.\-]*"
    r"[\[({]?(?P<robot>\d+)[\])}]?(?:_(?:m|rad))?"
)
_ROBOT_FIRST = re.compile(
    r"(?:robot|agent|r)?[\s_.\-]*(?P<robot>\d+)[\s_.\-:/]*(?P<state>[a-zθψφ_]+)"
)
_PART_FIRST = re.compile(
    r"(?P<part>[a-zθψφ_.()]+?)[\s_.\-]*(?:robot|agent)?[\s_.\-]*[\[({]?(?P<robot>\d+)[\])}]?"
)
_ROBOT_FIRST_PART = re.compile(
    r"(?:robot|agent|r)?[\s_.\-]*(?P<robot>\d+)[\s_.\-:/]*(?P<part>[a-zθψφ_.()]+)"
)
_ROBOT_INSIDE = re.compile(r"(?P<part>cos|sin)\((?P<angle>[a-zθψφ]+)_?(?P<robot>\d+)\)")

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "inch": 0.0254, "ft": 0.3048}
ANGLES = {"rad": 1.0, "deg": math.pi / 180, "degree": math.pi / 180, "degrees": math.pi / 180}
ANGLES["°"] = ANGLES["deg"]
SECONDS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "milliseconds": 1e-3}
SECONDS |= {
    "min": 60.0,
    "minutes": 60.0,
    "us": 1e-6,
    "µs": 1e-6,
    "μs": 1e-6,
    "ns": 1e-9,
    "nsec": 1e-9,
    "nanoseconds": 1e-9,
}
_UNITS = "|".join(sorted({*LENGTHS, *ANGLES, *SECONDS}, key=len, reverse=True))
_UNIT_WITHIN = re.compile(rf"(?P<name>.+?)[\s_]+(?P<unit>{_UNITS})[\s_]*(?P<robot>\d+)")
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
    >>> split_unit("x1 [mm]"), split_unit("theta_deg1"), split_unit("y2")
    (('x1', 'mm'), ('theta1', 'deg'), ('y2', None))
    """
    if within := _UNIT_WITHIN.fullmatch(word):
        return within["name"] + within["robot"], within["unit"]
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
        state = match["state"].strip("_") if match else ""
        if match and state in STATE_OF:
            return STATE_OF[state], match["robot"]
    return None


def part_of_rotation(word: str) -> tuple[str, str] | None:
    """Return which part of a rotation a column holds, and of which robot; None where of none.

    Parameters
    ----------
    word : str
        The column's name, in lower case.

    Returns
    -------
    (str, str), optional
        One of `QUATERNION` or `CIRCLE`, and the digits of the robot's number, "" where none stand.

    Examples
    --------
    >>> part_of_rotation("qw_2"), part_of_rotation("cos(theta)"), part_of_rotation("robot3_sin")
    (('qw', '2'), ('cos', ''), ('sin', '3'))
    """
    if word in PART_OF:
        return PART_OF[word], ""
    for pattern in (_PART_FIRST, _ROBOT_FIRST_PART):
        match = pattern.fullmatch(word)
        if match and (part := PART_OF.get(match["part"].strip("_."))):
            return part, match["robot"]
    inside = _ROBOT_INSIDE.fullmatch(word)
    part = PART_OF.get(f"{inside['part']}({inside['angle']})") if inside else None
    return (part, inside["robot"]) if inside and part else None


def names_a_column(word: str) -> bool:
    """Tell whether a word is what a script calls a time, a robot or a state.

    Parameters
    ----------
    word : str
        A cell of what may be a header, in lower case.
    """
    bare, _ = split_unit(word)
    known = bare in TIME_NAMES or bare in STATE_OF or bare in ROBOT_NAMES
    return known or numbered(bare) is not None or part_of_rotation(word) is not None
