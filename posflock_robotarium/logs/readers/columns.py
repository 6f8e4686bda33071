"""What the columns of a table hold, by their names: times, robots, states, and in which units.

*Wide* tables have one row a sample and columns for each robot, *long* ones a row for each robot
and sample. Without headings, they are unknown, and everything but them is known. Rows of a long
table that are missing leave a robot's pose unknown at that time; where every robot has times of its
own, they are brought to a common clock.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.clocks import Track, joined
from posflock_robotarium.logs.readers.dates import seconds_of
from posflock_robotarium.logs.readers.found import Found
from posflock_robotarium.logs.readers.names import (
    ANGLES,
    CIRCLE,
    LENGTHS,
    QUATERNION,
    ROBOT_NAMES,
    SECONDS,
    STATE_NAMES,
    STATE_OF,
    TIME_NAMES,
    numbered,
    part_of_rotation,
    split_unit,
)
from posflock_robotarium.logs.readers.number_spellings import why_no_number
from posflock_robotarium.logs.readers.quaternions import headings_of
from posflock_robotarium.logs.readers.tables import Table
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]

_POSITION = ("x", "y")
_SHARED = 0.5
"""Share of rows at a time that other robots have too, from which on the clock is a common one."""
_NO_CIRCLE = 0.05
"""How far from 1 the length of a cosine and a sine may be, since they are rounded."""
_MANY_AT_A_TIME = 0.2
"""Share of rows at the time of another from which on a table has several rows a sample."""


@dataclass
class _Columns:
    """Which column holds what: indices, and those of each robot where the columns are numbered."""

    time: int | None = None
    second: float = 1.0
    """Seconds in one of the times."""
    robot: int | None = None
    states: dict[str, int] = field(default_factory=dict)
    states_of: dict[tuple[str, str], int] = field(default_factory=dict)
    """By the name of the state and the robot's number."""
    units: dict[int, str | None] = field(default_factory=dict)
    """What the header says of the states' columns."""
    rotations: dict[tuple[str, str], int] = field(default_factory=dict)
    """Parts of rotations, by their name and the robot's number; "" where there is one robot."""
    unused: list[str] = field(default_factory=list)


def by_names(table: Table, names: tuple[str, ...], notes: list[str]) -> Found:
    """Find times and poses in a table by the names of its columns.

    Parameters
    ----------
    table : Table
        Numbers, and words.
    names : tuple of str
        One a column.
    notes : list of str
        How it was read, to be added to.

    Raises
    ------
    LogError, LayoutError
        Where the names do not say where x and y are, or robots and times do not fit together.
    """
    columns = _columns_of(table.path, names, notes)
    if columns.states_of:
        chosen = _of_each_robot(table.path, columns)
    elif set(_POSITION) <= set(columns.states):
        chosen = np.array([[columns.states.get(state, -1)] for state in STATE_NAMES])
    else:
        raise LayoutError(
            f"{table.path}: the columns {', '.join(names[:8])}… do not say where x, y and theta "
            "are; name them all with --columns t,x1,y1,theta1,… (- for one to leave out), "
            "or give their order with --columns state or robot"
        )
    if words := sorted(set(chosen.ravel().tolist()) & set(table.words)):
        word = table.words[words[0]][0]
        raise LogError(
            f"{table.path}: column {names[words[0]]} holds words such as {word[:40]!r}, not numbers"
            + why_no_number(word)
        )
    poses = table.values[:, chosen] * _factors(chosen, columns, notes)
    poses[:, chosen < 0] = np.nan
    if (chosen[2] < 0).all() and columns.rotations:
        chosen[2] = _turned(table, columns, poses, notes)
    if (chosen[2] < 0).any():
        notes.append("positions only: headings are unknown, and drawn along the motion")
    t = None if columns.time is None else _times(table, columns, notes)
    _ask_whose_rows(table, names, columns, t)
    if columns.robot is not None and not columns.states_of:
        found = _long(table, columns.robot, t, poses[:, :, 0], notes)
    else:
        notes.append(f"{poses.shape[2]} robot(s) found by column name{_numbers(columns)}")
        found = Found(t, poses, ())
    told = {columns.units.get(int(index)) for index in chosen[:2].ravel()} <= set(LENGTHS)
    angles = {columns.units.get(int(index)) for index in chosen[2] if index >= 0}
    return Found(
        found.t, found.poses, (), lengths_told=told, angles_told=bool(angles & set(ANGLES))
    )


def _columns_of(path: Path, names: tuple[str, ...], notes: list[str]) -> _Columns:
    """Find out by its name what each column holds."""
    found = _Columns()
    for index, name in enumerate(names):
        word, unit = split_unit(name.lower().strip())
        if word in TIME_NAMES and found.time is None and unit not in LENGTHS:
            found.time, found.second = index, SECONDS.get(unit or "s", 1.0)
            if found.second == 1e-3:
                notes.append(f"{name}: milliseconds, by its name; {word} taken in seconds")
            elif found.second != 1.0:
                notes.append(f"{name}: {unit}, by its name; {word} taken in seconds")
        elif word in ROBOT_NAMES and found.robot is None:
            found.robot = index
        elif (part := part_of_rotation(word)) is not None:
            found.rotations.setdefault(part, index)
        elif word in STATE_OF and STATE_OF[word] not in found.states:
            found.states[STATE_OF[word]] = index
            found.units[index] = unit
        elif (key := numbered(word)) is not None:
            if key in found.states_of:
                raise LayoutError(f"{path}: two columns are {key[0]} of robot {key[1]}")
            found.states_of[key] = index
            found.units[index] = unit
        else:
            found.unused.append(name)
    if found.unused:
        notes.append(f"{len(found.unused)} column(s) not used: {', '.join(found.unused[:8])}")
    return found


def _numbers(columns: _Columns) -> str:
    """Return how the numbers in the columns' names go over into robots counted from 0."""
    numbers = sorted({int(robot) for _, robot in columns.states_of})
    if numbers == list(range(len(numbers))):
        return ""
    if numbers == list(range(numbers[0], numbers[0] + len(numbers))):
        told = f"robot {numbers[0]} of the file is robot 0 here"
    else:
        told = f"robots {', '.join(map(str, numbers[:12]))} of the file are 0, 1, … here"
    return f"; {told}"


def _ask_whose_rows(
    table: Table, names: tuple[str, ...], columns: _Columns, t: Floats | None
) -> None:
    """Ask for the robot's column where rows have one time, and a column tells them apart."""
    if t is None or columns.robot is not None or columns.states_of or len(t) < 3:
        return
    times, sample = np.unique(t, return_inverse=True)
    if len(times) > (1 - _MANY_AT_A_TIME) * len(t):
        return
    for name in columns.unused:
        index = names.index(name)
        kept = table.words.get(index)
        labels, label = np.unique(
            table.values[:, index] if kept is None else np.array(kept), return_inverse=True
        )
        if 1 < len(labels) < len(times) and len(np.unique(sample * len(labels) + label)) == len(t):
            raise LayoutError(
                f"{table.path}: several rows have the same time, and column {name!r} tells them "
                "apart: is it the robot? Name all columns with --columns t,robot,x,y,theta,… "
                "(- for one to leave out)"
            )


def _times(table: Table, columns: _Columns, notes: list[str]) -> Floats:
    """Return the times in seconds, which may stand as dates or times of day."""
    if columns.time is None or columns.time not in table.words:
        return np.asarray(table.values[:, columns.time or 0] * columns.second)
    notes.append("times are dates or times of day, taken in seconds")
    return seconds_of(table.words[columns.time], str(table.path))


def _turned(table: Table, columns: _Columns, poses: Floats, notes: list[str]) -> int:
    """Fill in headings from parts of rotations; return a column of them, or -1 where parts lack."""
    robots = sorted({robot for _, robot in columns.states_of}, key=int) or [""]
    for names in (QUATERNION, CIRCLE, QUATERNION[2:]):
        parts = [[columns.rotations.get((part, robot), -1) for robot in robots] for part in names]
        if min(map(min, parts)) < 0:
            continue
        poses[:, 2], told = _headings(names, np.moveaxis(table.values[:, np.array(parts)], 1, 0))
        notes.append(f"headings from {told}")
        return parts[0][0]
    notes.append(f"parts of rotations not used: {', '.join(p + r for p, r in columns.rotations)}")
    return -1


def _headings(names: tuple[str, ...], parts: Floats) -> tuple[Floats, str]:
    """Return headings (T, N) from the parts of rotations, and from what they are."""
    if names == CIRCLE:
        unit = np.abs(np.hypot(*parts) - 1) < _NO_CIRCLE
        left_out = f", {np.mean(~unit):.0%} of which are none" if not unit.all() else ""
        return np.where(unit, np.arctan2(parts[1], parts[0]), np.nan), "cosine and sine" + left_out
    if len(names) < len(QUATERNION):  # a robot on a floor turns about z alone
        parts = np.concatenate([np.zeros_like(parts), parts])
    heading, told = headings_of(parts)
    return heading, "quaternions" + told


def _of_each_robot(path: Path, columns: _Columns) -> NDArray[np.int_]:
    """Return the columns of numbered robots, (3, N): x, y and theta, -1 for unknown headings."""
    robots = sorted({robot for _, robot in columns.states_of}, key=int)
    headed = any(state == "theta" for state, _ in columns.states_of)
    needed = STATE_NAMES if headed else _POSITION
    missing = [f"{s}{r}" for r in robots for s in needed if (s, r) not in columns.states_of]
    if missing:
        raise LayoutError(
            f"{path}: no column for {', '.join(missing[:6])}; name all columns "
            "with --columns t,x1,y1,theta1,…"
        )
    return np.array([[columns.states_of.get((s, r), -1) for r in robots] for s in STATE_NAMES])


def _factors(chosen: NDArray[np.int_], columns: _Columns, notes: list[str]) -> Floats:
    """Return what brings each of the chosen columns to metres and radians, as the header says."""
    factors = np.ones(chosen.shape)
    for axis, robot in np.ndindex(*chosen.shape):
        known = LENGTHS if axis < 2 else ANGLES
        factors[axis, robot] = known.get(columns.units.get(int(chosen[axis, robot])) or "", 1.0)
    units = {unit for unit in columns.units.values() if unit not in (None, "m", "rad")}
    if units:
        notes.append(f"units by the header: {', '.join(sorted(map(str, units)))}")
    return factors


def _long(table: Table, robot: int, t: Floats | None, states: Floats, notes: list[str]) -> Found:
    """Turn one row a robot and sample into one row a sample."""
    if t is None:
        raise LayoutError(f"{table.path}: a row for each robot needs a time column")
    words = table.words.get(robot)
    labels = table.values[:, robot] if words is None else np.array(words)
    robots, column = np.unique(labels, return_inverse=True)
    if not np.isfinite(t).all() or (words is None and not np.isfinite(robots).all()):
        raise LogError(f"{table.path}: a time or robot number is not a finite number")
    if words is not None:
        notes.append(f"robots by name, in this order: {', '.join(robots[:20])}")
    times, sample, shared = np.unique(t, return_inverse=True, return_counts=True)
    if len(robots) > 1 and np.mean(shared[sample] > 1) < _SHARED:
        tracks = [
            Track(str(name), t[column == n], states[column == n]) for n, name in enumerate(robots)
        ]
        return joined(tracks, str(table.path), notes)
    if len(np.unique(sample * len(robots) + column)) != len(t):
        raise LogError(f"{table.path}: a robot has two rows at one time")
    poses = np.full((len(times), 3, len(robots)), np.nan)
    poses[sample, :, column] = states
    notes.append(f"one row a robot and sample: {len(robots)} robots, sorted by time")
    if missing := len(times) * len(robots) - len(t):
        notes.append(f"{missing} row(s) of single robots are missing: unknown at that time")
    return Found(times, poses, ())
