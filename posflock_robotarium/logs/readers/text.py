"""Text and CSV logs: with or without a header, with or without a time column, wide or long.

*Wide* files have one row a sample, *long* files one row a robot and sample (a column says which
robot). With a header, the columns are found by their names (``t``, ``x1``, ``y_2``,
``robot3_theta``, ``theta[0]``, …); without one, the first column is taken for the time if it
increases from row to row and one column more than three a robot is there. The rest is a flat table
for `layouts`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers.columns import by_names
from posflock_robotarium.logs.readers.dates import seconds_of
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import Found, ReadOptions
from posflock_robotarium.logs.readers.layouts import is_clock, split_time, to_states
from posflock_robotarium.logs.readers.rotations import ask_where_rotations
from posflock_robotarium.logs.readers.tables import Table, read_table
from posflock_robotarium.logs.run import LayoutError

_SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", " ": "blank"}


def read_text(path: Path, options: ReadOptions) -> Found:
    """Read poses (and times, if there are any) from a text file.

    Parameters
    ----------
    path : Path
        A text or CSV file, in UTF-8, UTF-16 or Latin-1.
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
        See `read_table` and `layouts.to_states`.
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
    notes += table.notes
    if names and by_name:
        found = by_names(table, names, notes)
    else:
        found = _without_names(table, options, notes)
    if table.parameters:
        notes.append("parameters of the run came with the file")
    if table.torn:
        notes.append(
            "the last line has no end: "
            + ("it was cut off, and is left out" if table.promised is not None else _PERHAPS_CUT)
        )
    return replace(
        found,
        notes=tuple(notes),
        parameters=table.parameters,
        promised=_samples(table, len(found.poses)),
    )


_PERHAPS_CUT = "if the file was cut off there, its last number is wrong"


def _samples(table: Table, samples: int) -> int | None:
    """Return how many samples were promised: a converted file has a row for each."""
    rows_a_sample = len(table.values) // samples if samples else 1
    return table.promised if rows_a_sample == 1 else None


TEXT = Form(
    name="text",
    label="CSV, text",
    summary="with or without header and time; comma, semicolon, tab (decimal commas, too), bar, "
    "blank; `time_ms`, `x1 [mm]`, `theta1_deg` say their units; one row a robot, too; "
    "quaternions, cosine and sine; positions only",
    told_by=Sign.NOTHING,
    recognises=lambda file, start: True,
    read=read_text,
    endings=(".csv", ".txt"),
)


def _without_names(table: Table, options: ReadOptions, notes: list[str]) -> Found:
    notes.append("no header")
    if tuple(table.words) == (0,) and (t := _clock(table)) is not None:
        notes.append("the first column holds dates or times of day: taken for the time")
        poses, commands, how = to_states(
            table.values[:, 1:], str(table.path), options.layout, options.order, samples=len(t)
        )
        notes.append(how)
        return Found(t, poses, (), commands)
    if table.words:
        raise LayoutError(
            f"{table.path}: column {min(table.words) + 1} holds words, and no header says what the "
            "others hold; name all columns with --columns t,robot,x,y,theta,… (- for one to leave "
            "out)"
        )
    if options.layout is None:
        ask_where_rotations(table.values, str(table.path))
    t, values, along = split_time(table.values)
    if t is None and options.layout is None and is_clock(table.values[:, 0]):
        raise LayoutError(
            f"{table.path}: no header, and the first column rises evenly as times do, while the "
            f"other {table.values.shape[1] - 1} are not 3 or 5 a robot: name all columns, as with "
            "--columns t,x1,y1,x2,y2,… or t,x,y,cos,sin (- for one to leave out), or "
            "say --layout T,3N where it is the x of a robot"
        )
    if along is not None:
        notes.append(f"the first {along} increases throughout: taken for the time")
    samples = None if t is None else len(t)
    poses, commands, how = to_states(
        values, str(table.path), options.layout, options.order, samples=samples
    )
    notes.append(how)
    return Found(t, poses, (), commands)


def _clock(table: Table) -> NDArray[np.float64] | None:
    """Return the times in a first column of words; None where they are none."""
    try:
        return seconds_of(table.words[0], str(table.path))
    except LogError:
        return None
