"""Which axis of an array is time, which is the robots: recognised from the shape, or asked for.

Robotarium scripts save poses as they please: ``(T, 3, N)``, ``(3, N, T)``, ``(T, N, 3)``, or flat
tables ``(T, 3N)`` and ``(3N, T)`` with the columns grouped by state (x1…xN, y1…yN, θ1…θN) or by
robot (x1, y1, θ1, x2, …), and the testbed's MATLAB interface keeps five numbers a robot, with the
commands (``(5N, T)``: x1, y1, θ1, v1, ω1, x2, …). A shape often fits one reading only; that a count
can be divided by three says nothing. Where it fits several, the data are asked one physical
question that has a clear answer, *do the wheels roll where the heading points?* (a
differential-drive robot cannot slide sideways), and where even that does not decide, the reader
raises `LayoutError` and lists the readings. It never picks one silently.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.rolling import FAR, ROLLING, moved_far, sideways_share
from posflock_robotarium.logs.readers.rotations import ask_where_rotations
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]

MOST_ROBOTS = 50
"""More robots than the testbed's simulator holds are only read when the layout is named."""


@dataclass(frozen=True)
class Layout:
    """One way to read an array, and how to bring it to (T, 3, N).

    Attributes
    ----------
    name : str
        What it is called on the command line.
    axes : int
        Number of the array's axes, 2 or 3.
    columns : str
        Order of the columns of a flat table; empty for three axes.
    robots : callable
        From a shape to the number of robots, 0 where the layout does not fit.
    turn : callable
        From the array to poses (T, 3, N), or states (T, 5, N).
    each : int
        Numbers of each robot: 3, 5 with its commands, or 2 without its heading.
    """

    name: str
    axes: int
    columns: str
    robots: Callable[[tuple[int, ...]], int]
    turn: Callable[[Floats], Floats]
    each: int = 3

    @property
    def label(self) -> str:
        """The layout as a user would name it."""
        return f"({self.name})" + (f" by {self.columns}" if self.columns else "")


def _stacked(order: str, each: int) -> Layout:
    """Return a layout of three axes, which are called in order: T, N and the number of states."""
    axes = order.split(",")
    time, states, robots = axes.index("T"), axes.index(str(each)), axes.index("N")
    return Layout(
        order,
        3,
        "",
        lambda shape: shape[robots] if shape[states] == each else 0,
        lambda array: array.transpose(time, states, robots),
        each,
    )


def _flat(axis: int, each: int) -> Callable[[tuple[int, ...]], int]:
    return lambda shape: shape[axis] // each if shape[axis] % each == 0 else 0


def _by_state(each: int, along: int) -> Callable[[Floats], Floats]:
    def turn(table: Floats) -> Floats:
        rows = table if along else table.T
        return np.asarray(rows.reshape(len(rows), each, -1))

    return turn


def _by_robot(each: int, along: int) -> Callable[[Floats], Floats]:
    def turn(table: Floats) -> Floats:
        rows = table if along else table.T
        return np.asarray(rows.reshape(len(rows), -1, each).transpose(0, 2, 1))

    return turn


LAYOUTS: tuple[Layout, ...] = (
    *(
        _stacked(order.format(each), each)
        for each in (3, 5, 2)
        for order in ("T,{},N", "{},N,T", "T,N,{}", "N,{},T", "N,T,{}", "{},T,N")
    ),
    *(
        Layout(name.format(each), 2, order, _flat(axis, each), turn(each, axis), each)
        for each in (3, 5)
        for name, axis in (("T,{}N", 1), ("{}N,T", 0))
        for order, turn in (("state", _by_state), ("robot", _by_robot))
    ),
)
USUAL = ("T,3,N", "3,N,T", "T,N,3")
"""What scripts save, and is not asked whether robots roll in it."""
NAMES = tuple(dict.fromkeys(layout.name for layout in LAYOUTS))
COLUMN_ORDERS = ("state", "robot")
_SLIDING = 0.25
"""Share of the motion across the headings that no wheels do."""
_NUMBERS_OF_A_POSE = 5
_FEW = 6
"""Samples of which rising numbers may be anything."""
_LONGER_THAN_ARENAS = 10.0
"""Seconds of a run that are no metres of an arena."""
MATLABS_OWN = "robotarium_data"
"""What the testbed's MATLAB interface calls its log, 5N numbers at each time, by robot."""


def is_clock(values: Floats) -> bool:
    """Tell whether values are times and no places: regular as no robot drives, or a long way on.

    Parameters
    ----------
    values : (T,) array
        A column or row without a name.
    """
    if len(values) < _FEW or not increases(values):
        return False
    steps = np.diff(values)
    return bool(np.ptp(values) > _LONGER_THAN_ARENAS or np.ptp(steps) < 1e-3 * np.mean(steps))


def to_states(
    array: Floats,
    where: str,
    layout: str | None = None,
    columns: str | None = None,
    *,
    samples: int | None = None,
) -> tuple[Floats, Floats | None, str]:
    """Bring an array to poses and, where it has some, commands, and say which layout it had.

    Parameters
    ----------
    array : two or three axes, (...) array
        Poses in any of `LAYOUTS`, m and rad.
    where : str
        File (and variable) name for messages.
    layout : str, optional
        One of `NAMES`; when given, only this one is tried.
    columns : {'state', 'robot'}, optional
        Order of the columns of a flat table.
    samples : int, optional
        How many times there are, where the file says so: only layouts with that T fit.

    Returns
    -------
    poses : (T, 3, N) array
        A view where possible.
    commands : (T, 2, N) array, optional
        Speeds, m/s, and turn rates, rad/s.
    label : str
        The sentence for the report.

    Raises
    ------
    LayoutError
        When no layout fits, or more than one does.
    LogError
        When the array is empty, or not of two or three axes.
    """
    layout = _known(layout, NAMES, "layout")
    columns = _known(columns, COLUMN_ORDERS, "columns")
    if array.ndim not in (2, 3):
        raise LayoutError(
            f"{where}: an array of shape {array.shape} is not poses over time; "
            f"expected one of {', '.join(NAMES)}"
        )
    if array.size == 0:
        raise LogError(f"{where}: empty, shape {array.shape}")
    if layout is None:
        ask_where_rotations(array, where)
    fits = _fitting(array.shape, layout, columns, samples)
    if not fits:
        raise LayoutError(_no_fit(array.shape, where, layout, samples))
    if len(fits) == 1:
        how = "as asked" if layout is not None else "the only one that fits the shape"
        chosen, label = fits[0], f"layout {fits[0].label}, {how}"
        if layout is None and chosen.each > 2 and chosen.name not in USUAL:
            _ask_where_robots_slide(chosen, array, where)
    else:
        chosen, label = _decide_by_rolling(array, where, fits)
    states = chosen.turn(array)
    if chosen.each == 3:
        return states, None, label
    if chosen.each == 2:
        unknown = np.full((len(states), 1, states.shape[2]), np.nan)
        poses = np.concatenate([states, unknown], axis=1)
        return poses, None, f"{label}; positions only: headings are unknown"
    return states[:, :3], states[:, 3:], f"{label}; five numbers a robot: x, y, heading, v and ω"


def _no_fit(shape: tuple[int, ...], where: str, layout: str | None, samples: int | None) -> str:
    """Say that no layout fits, and what to do."""
    known = dict.fromkeys(each.name for each in LAYOUTS if each.axes == len(shape))
    asked = f"layout {layout}" if layout is not None else "any known layout " + " ".join(known)
    most = "" if layout is not None else f", at most {MOST_ROBOTS} robots"
    how = " (or all columns with --columns t,x1,y1,…)" if len(shape) == 2 else ""
    return (
        f"{where}: shape {shape} does not fit {asked} (2, 3 or 5 numbers a robot{most}, "
        f"{'at least 2' if samples is None else samples} samples); name one with --layout{how}"
    )


def _fitting(
    shape: tuple[int, ...], layout: str | None, columns: str | None, samples: int | None
) -> list[Layout]:
    """Return the layouts that an array of this shape may have."""
    named, size = layout is not None, math.prod(shape)
    fits = [
        candidate
        for candidate in LAYOUTS
        if candidate.axes == len(shape)
        and (not named or candidate.name == layout)
        and (columns is None or candidate.columns in ("", columns))
        and 0 < candidate.robots(shape) <= (size if named else MOST_ROBOTS)
    ]
    lengths = {id(c): size // (c.each * c.robots(shape)) for c in fits}
    # A few samples of many robots with commands are what any short table looks like.
    least = {3: 2, 5: 2 if named else 6, 2: 2 if named else 6}
    fits = [
        c for c in fits if lengths[id(c)] >= least[c.each] and samples in (None, lengths[id(c)])
    ]
    # Positions alone are what is left when nothing else fits, or what is asked for.
    if not named and any(c.each > 2 for c in fits):
        fits = [c for c in fits if c.each > 2]
    # With one robot, both orders of columns are the same columns.
    return [
        c for c in fits if not (c.columns == "robot" and columns is None and c.robots(shape) == 1)
    ]


def may_be_poses(shape: tuple[int, ...], samples: int | None = None) -> bool:
    """Tell whether an array of this shape can be read as poses over time at all.

    Parameters
    ----------
    shape : tuple of int
        Of the array.
    samples : int, optional
        How many times there are, where that is known.
    """
    return bool(_fitting(shape, None, None, samples))


def split_time(table: Floats) -> tuple[Floats | None, Floats, str | None]:
    """Take the time off a table without names: the first column or row, if it increases throughout.

    Parameters
    ----------
    table : (rows, columns) array
        With one row or column more than whole robots need, where it has a time.

    Returns
    -------
    t : (T,) array, optional
        The times, None where there are none.
    rest : (rows, columns) array
        What is left.
    along : str, optional
        ``row`` or ``column``, whichever the time was.
    """
    for axis, along in ((1, "column"), (0, "row")):
        more = table.shape[axis] - 1
        first = table[:, 0] if axis == 1 else table[0]
        # A row of times stands above the few rows of robots, and is longer than a pose.
        if axis == 0 and (more > 5 * MOST_ROBOTS or len(first) <= _NUMBERS_OF_A_POSE):
            continue
        if more > 0 and (more % 3 == 0 or more % 5 == 0) and len(first) > 1:
            # x of a robot may increase as well, where the table needs no time to be whole.
            whole = (more + 1) % 3 == 0 or (more + 1) % 5 == 0
            if increases(first) and (not whole or is_clock(first)):
                return first, table[:, 1:] if axis == 1 else table[1:], along
    return None, table, None


def _known(name: str | None, names: tuple[str, ...], option: str) -> str | None:
    if name is None:
        return None
    plain = name.replace(" ", "").strip("()")
    for known in names:
        if plain.lower() == known.lower():
            return known
    raise LayoutError(f"--{option} {name!r} is none of {', '.join(names)}")


def increases(values: Floats) -> bool:
    """Tell whether values could be times: finite, and each later than the one before.

    Parameters
    ----------
    values : (T,) array
        What may be times.
    """
    return bool(np.isfinite(values).all() and (np.diff(values) > 0).all())


def only_transposed_rolls(table: Floats) -> bool:
    """Tell whether a table of MATLAB's is (T, 5N), since robots slide in (5N, T) and here do not.

    Parameters
    ----------
    table : (rows, columns) array
        Both of which are multiples of five.
    """
    with np.errstate(all="ignore"):
        across, along = (
            sideways_share(_by_robot(5, axis)(table)[:, :3]) if min(table.shape) > 5 else math.nan
            for axis in (0, 1)
        )
    return along < ROLLING and across > 5 * along + 0.1


def _ask_where_robots_slide(chosen: Layout, array: Floats, where: str) -> None:
    """Refuse the only reading of a flat table if robots drive across their headings in it."""
    poses = chosen.turn(array)[:, :3]
    with np.errstate(all="ignore"):
        far, share = moved_far(poses), sideways_share(poses)
    if far > FAR and share > _SLIDING:
        raise LayoutError(
            f"{where}: shape {array.shape} fits {chosen.label} with {chosen.robots(array.shape)} "
            f"robots, but then {share:.0%} of their motion is sideways: are these other numbers, "
            "positions only, or headings in degrees? Name all columns in a header or with "
            f"--columns t,x1,y1,…, or say --layout {chosen.name} if it is right (with --degrees)"
        )


def _decide_by_rolling(array: Floats, where: str, fits: list[Layout]) -> tuple[Layout, str]:
    readings = ", ".join(f"{c.label} with {c.robots(array.shape)} robots" for c in fits)
    with np.errstate(all="ignore"):
        shares = [sideways_share(c.turn(array)) for c in fits]
    order = np.argsort(shares, kind="stable")
    best, second = shares[order[0]], shares[order[1]]
    if not (
        np.isfinite(best) and np.isfinite(second) and best < ROLLING and second > 5 * best + 0.1
    ):
        options = " or ".join(dict.fromkeys(f"--layout {c.name}" for c in fits))
        raise LayoutError(
            f"{where}: shape {array.shape} can be read as {readings}; say which with {options} "
            "(and --columns state or robot for a flat table)"
        )
    chosen = fits[order[0]]
    return chosen, (
        f"layout {chosen.label}: the shape also fits {len(fits) - 1} other(s), but only so do the "
        f"robots roll where they head ({100 * best:.1f} % of the motion is sideways, "
        f"against {100 * second:.0f} %)"
    )
