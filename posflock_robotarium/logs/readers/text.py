"""Text and CSV logs: with or without a header, with or without a time column, wide or long.

*Wide* files have one row a sample, *long* files one row a robot and sample (a column says which
robot). With a header, the columns are found by their names (``t``, ``x1``, ``y_2``,
``robot3_theta``, ``theta[0]``, …); without one, the first column is taken for the time if it
increases from row to row and one column more than three a robot is there. The rest is a flat table
for `layouts`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.layouts import split_time, to_states
from posflock_robotarium.logs.readers.names import (
    MILLISECONDS,
    ROBOT_NAMES,
    STATE_NAMES,
    STATE_OF,
    TIME_NAMES,
    numbered,
)
from posflock_robotarium.logs.readers.tables import Table, read_table
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]


_SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab", " ": "blank"}


def read_text(path: Path, options: ReadOptions) -> Found:
    """Read poses (and times, if there are any) from a text file.

    Parameters
    ----------
    path : Path
        A text or CSV file, in UTF-8.
    options : ReadOptions
        Its ``columns`` may name all columns, separated by commas, as a header would; ``-`` is a
        column to leave out. A layout, or an order of columns, is for tables without header.

    Returns
    -------
    Found
        Seconds, metres and radians, and how they were read.

    Raises
    ------
    LogError, LayoutError
        See `read_table` and `layouts.to_poses`.
    """
    table = read_table(path, options.bounds)
    notes = [f"text, {_SEPARATORS[table.delimiter]} separated, {table.values.shape[0]} rows"]
    if table.decimal_comma:
        notes.append("commas between digits are decimal points")
    by_name = options.layout is None and options.order is None
    names = table.names
    if options.columns is not None and options.order is None:
        names = tuple(name.strip() for name in options.columns.split(","))
        if len(names) != table.values.shape[1]:
            raise LayoutError(
                f"{path}: --columns names {len(names)} columns, the file has "
                f"{table.values.shape[1]}"
            )
        notes.append("columns named by --columns")
    elif names and by_name:
        notes.append("columns found by their names in the header")
    commands: Floats | None = None
    if names and by_name:
        t, poses = _by_name(table, names, notes)
    else:
        t, poses, commands = _without_names(table, options, notes)
    if table.parameters:
        notes.append("parameters of the run came with the file")
    if table.torn:
        notes.append(
            "the last line has no end: "
            + ("it was cut off, and is left out" if table.promised is not None else _PERHAPS_CUT)
        )
    return Found(
        t,
        poses,
        tuple(notes),
        commands,
        parameters=table.parameters,
        promised=_samples(table, len(poses)),
    )


_PERHAPS_CUT = "if the file was cut off there, its last number is wrong"


def _samples(table: Table, samples: int) -> int | None:
    """Return how many samples were promised: a converted file has a row for each."""
    rows_a_sample = len(table.values) // samples if samples else 1
    return table.promised if rows_a_sample == 1 else None


TEXT = Form(
    name="text",
    label="CSV, text",
    summary="with or without header and time; comma, semicolon (decimal commas, too), tab, blank; "
    "`time_ms` is milliseconds; one row a robot, too",
    told_by=Sign.NOTHING,
    recognises=lambda file, start: True,
    read=read_text,
    endings=(".csv", ".txt"),
)


def _without_names(
    table: Table, options: ReadOptions, notes: list[str]
) -> tuple[Floats | None, Floats, Floats | None]:
    notes.append("no header")
    t, values, along = split_time(table.values)
    if along is not None:
        notes.append(f"the first {along} increases throughout: taken for the time")
    samples = None if t is None else len(t)
    poses, commands, how = to_states(
        values, str(table.path), options.layout, options.order, samples=samples
    )
    notes.append(how)
    return t, poses, commands


@dataclass
class _Columns:
    """Which column holds what: indices, and those of each robot where the columns are numbered."""

    time: int | None = None
    unit: float = 1.0
    """Seconds in one of the times."""
    robot: int | None = None
    states: dict[str, int] = field(default_factory=dict)
    states_of: dict[tuple[str, str], int] = field(default_factory=dict)
    """By the name of the state and the robot's number."""
    unused: list[str] = field(default_factory=list)

    def times(self, values: Floats) -> Floats | None:
        """Return the seconds of each row."""
        return None if self.time is None else values[:, self.time] * self.unit


def _columns_of(path: Path, names: tuple[str, ...], notes: list[str]) -> _Columns:
    """Find out by its name what each column holds."""
    found = _Columns()
    for index, name in enumerate(names):
        word = name.lower().strip()
        if (milli := MILLISECONDS.fullmatch(word)) is not None and found.time is None:
            found.time, found.unit = index, 1e-3
            notes.append(f"{name}: milliseconds, by its name; {milli['name']} taken in seconds")
            continue
        bare = re.sub(r"\s*[\[(].*?(?:m|s|rad|sec)[\])]$", "", word)
        if bare in TIME_NAMES and found.time is None:
            found.time = index
        elif bare in ROBOT_NAMES and found.robot is None:
            found.robot = index
        elif bare in STATE_OF and STATE_OF[bare] not in found.states:
            found.states[STATE_OF[bare]] = index
        elif (key := numbered(word)) is not None:
            if key in found.states_of:
                raise LayoutError(f"{path}: two columns are {key[0]} of robot {key[1]}")
            found.states_of[key] = index
        else:
            found.unused.append(name)
    if found.unused:
        notes.append(f"{len(found.unused)} column(s) not used: {', '.join(found.unused[:8])}")
    return found


def _by_name(
    table: Table, names: tuple[str, ...], notes: list[str]
) -> tuple[Floats | None, Floats]:
    columns = _columns_of(table.path, names, notes)
    if columns.states_of:
        chosen = _of_each_robot(table.path, columns)
    elif len(columns.states) == len(STATE_NAMES):
        chosen = np.array([[columns.states[state]] for state in STATE_NAMES])
        if columns.robot is not None:
            return _long(table, columns, columns.robot, chosen[:, 0], notes)
    else:
        raise LayoutError(
            f"{table.path}: the columns {', '.join(names[:8])}… do not say where x, y and theta "
            "are; name them all with --columns t,x1,y1,theta1,… (- for one to leave out), "
            "or give their order with --columns state or robot"
        )
    poses = table.values[:, chosen]
    notes.append(f"{poses.shape[2]} robot(s) found by column name")
    return columns.times(table.values), poses


def _of_each_robot(path: Path, columns: _Columns) -> NDArray[np.int_]:
    """Return the columns of numbered robots, (3, N): x, y and theta, by rising number."""
    robots = sorted({robot for _, robot in columns.states_of}, key=int)
    missing = [f"{s}{r}" for r in robots for s in STATE_NAMES if (s, r) not in columns.states_of]
    if missing:
        raise LayoutError(
            f"{path}: no column for {', '.join(missing[:6])}; name all columns "
            "with --columns t,x1,y1,theta1,…"
        )
    return np.array([[columns.states_of[state, r] for r in robots] for state in STATE_NAMES])


def _long(
    table: Table, columns: _Columns, robot: int, states: NDArray[np.int_], notes: list[str]
) -> tuple[Floats, Floats]:
    """Turn one row a robot and sample into one row a sample."""
    if columns.time is None:
        raise LayoutError(f"{table.path}: a row for each robot needs a time column")
    times, sample = np.unique(table.values[:, columns.time], return_inverse=True)
    robots, column = np.unique(table.values[:, robot], return_inverse=True)
    if not np.isfinite(times).all() or not np.isfinite(robots).all():
        raise LogError(f"{table.path}: a time or robot number is not a finite number")
    rows = len(table.values)
    if len(times) * len(robots) != rows:
        counts = np.bincount(sample, minlength=len(times))
        odd = int(np.flatnonzero(counts != len(robots))[0]) if len(times) * len(robots) else 0
        raise LogError(
            f"{table.path}: {rows} rows are not {len(times)} times of {len(robots)} robots; at "
            f"time {times[odd]:g} s there are {counts[odd]} rows"
        )
    poses = np.full((len(times), 3, len(robots)), np.nan)
    poses[sample, :, column] = table.values[:, states]
    notes.append(f"one row a robot and sample: {len(robots)} robots, sorted by time")
    return times * columns.unit, poses
