"""Text and CSV logs: with or without a header, with or without a time column, wide or long.

*Wide* files have one row a sample, *long* files one row a robot and sample (a column says which
robot). With a header, the columns are found by their names (``t``, ``x1``, ``y_2``,
``robot3_theta``, ``theta[0]``, …); without one, the first column is taken for the time if it
increases from row to row and one column more than three a robot is there. The rest is a flat table
for `layouts`.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import parameters
from posflock_robotarium.logs.readers.layouts import COLUMN_ORDERS, increases, to_poses
from posflock_robotarium.logs.run import LayoutError

Floats = NDArray[np.float64]

LARGEST = 1 << 30
"""Bytes of text beyond which a file is refused (900 s of 50 robots are 60 MB)."""

TIME_NAMES = ("t", "time", "timestamp", "timestamps", "times", "seconds", "stamp", "sec", "time_s")
ROBOT_NAMES = ("robot", "id", "robot_id", "agent", "agent_id", "i")
STATE_NAMES = {
    "x": ("x", "px", "posx", "pos_x", "x_m"),
    "y": ("y", "py", "posy", "pos_y", "y_m"),
    "theta": ("theta", "th", "yaw", "heading", "phi", "angle", "θ", "theta_rad", "psi"),
}
_STATE_OF = {name: state for state, names in STATE_NAMES.items() for name in names}
_STATE_FIRST = re.compile(
    r"(?P<state>[a-zθ]+(?:_(?:m|rad))?)[\s_.\-]*[\[({]?(?P<robot>\d+)[\])}]?(?:_(?:m|rad))?"
)
_MILLISECONDS = re.compile(
    rf"(?P<name>{'|'.join(TIME_NAMES)})[\s_]*[\[(]?(?:ms|msec|milliseconds)[\])]?"
)
_ROBOT_FIRST = re.compile(
    r"(?:robot|agent|r)?[\s_.\-]*(?P<robot>\d+)[\s_.\-:/]*(?P<state>[a-zθ_]+)"
)


@dataclass(frozen=True)
class Table:
    """A text file of numbers.

    Attributes
    ----------
    values : (rows, columns) array
        Its numbers, a row a line.
    names : tuple of str
        Names of the columns; empty where it has none.
    delimiter : str
        What stands between two columns.
    first_line : int
        Line of the first row, counted from 1.
    parameters : mapping
        What a comment in front says about the run.
    decimal_comma : bool
        Whether commas between digits are decimal points.
    """

    values: Floats
    names: tuple[str, ...]
    delimiter: str
    first_line: int
    parameters: Mapping[str, Any] = field(default_factory=dict)
    decimal_comma: bool = False


def read_table(path: Path) -> Table:
    """Read a rectangular table of numbers.

    Parameters
    ----------
    path : Path
        Comma, semicolon, tab or blank separated; ``#`` and ``%`` start comments.

    Returns
    -------
    Table
        Values of shape (rows, columns).

    Raises
    ------
    LogError
        With file, line and reason, when a cell is not a number or rows differ in length.
    """
    size = path.stat().st_size
    if size > LARGEST:
        raise LogError(f"{path}: {size / 1e9:.1f} GB of text; convert it to .npy first")
    raw = path.read_bytes()
    if b"\0" in raw[:4096]:
        raise LogError(f"{path}: a binary file, not text; expected .npy, .npz, .mat or CSV")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise LogError(f"{path}: line {line}: not UTF-8 text") from error
    lines = text.splitlines()
    start = next((i for i, line in enumerate(lines) if _content(line)), None)
    if start is None:
        raise LogError(f"{path}: empty, no row of numbers in it")
    delimiter = _delimiter(_content(lines[start]))
    # Between semicolons, and with no point in any row, a comma is a decimal one (Excel in Europe).
    rows = lines[start + 1 :] or lines[start:]
    decimal_comma = (
        delimiter == ";"
        and any("," in _content(line) for line in rows)
        and not any("." in _content(line) for line in rows)
    )
    if decimal_comma:
        lines = lines[:start] + [line.replace(",", ".") for line in lines[start:]]
    names: tuple[str, ...] = ()
    cells = _split(_content(lines[start]), delimiter)
    if not any(_is_number(cell) for cell in cells):
        names = tuple(cell.strip().strip("\"'").strip() for cell in cells)
        start += 1
    elif (comment := _commented_header(lines, start, delimiter)) is not None:
        names = comment
    values = _numbers(path, lines, start, delimiter)
    if names and len(names) != values.shape[1]:
        raise LogError(
            f"{path}: the header names {len(names)} columns, the rows have {values.shape[1]}"
        )
    return Table(
        values, names, delimiter, start + 1, _parameters(path, lines[:start]), decimal_comma
    )


def read_text(
    path: Path, layout: str | None = None, columns: str | None = None
) -> tuple[Floats | None, Floats, list[str], Mapping[str, Any]]:
    """Read poses (and times, if there are any) from a text file.

    Parameters
    ----------
    path : Path
        A text or CSV file.
    layout : str, optional
        For a table without header: one of `layouts.NAMES`.
    columns : str, optional
        ``state`` or ``robot`` (order of the columns without header), or the names of all columns,
        separated by commas, as a header would give them; ``-`` is a column to leave out.

    Returns
    -------
    t : (T,) array or None
        Seconds.
    poses : (T, 3, N) array
        Metres and radians.
    notes : list of str
        How it was read.
    parameters : mapping
        What a comment in front of the table says about the run, if one does.

    Raises
    ------
    LogError, LayoutError
        See `read_table` and `layouts.to_poses`.
    """
    table = read_table(path)
    separator = {",": "comma", ";": "semicolon", "\t": "tab", " ": "blank"}[table.delimiter]
    notes = [f"text, {separator} separated, {table.values.shape[0]} rows"]
    if table.decimal_comma:
        notes.append("commas between digits are decimal points")
    names = table.names
    order = columns if columns is None or columns in COLUMN_ORDERS else None
    if columns is not None and order is None:
        names = tuple(name.strip() for name in columns.split(","))
        if len(names) != table.values.shape[1]:
            raise LayoutError(
                f"{path}: --columns names {len(names)} columns, the file has "
                f"{table.values.shape[1]}"
            )
        notes.append("columns named by --columns")
    elif names and layout is None and order is None:
        notes.append("columns found by their names in the header")
    if names and layout is None and order is None:
        t, poses = _by_name(path, table, names, notes)
    else:
        t, poses = _without_names(path, table.values, layout, order, notes)
    if table.parameters:
        notes.append("parameters of the run came with the file")
    return t, poses, notes, table.parameters


def _without_names(
    path: Path, values: Floats, layout: str | None, order: str | None, notes: list[str]
) -> tuple[Floats | None, Floats]:
    notes.append("no header")
    t: Floats | None = None
    for axis, along in ((1, "column"), (0, "row")):
        if values.shape[axis] % 3 == 1 and values.shape[axis] > 3 and values.shape[1 - axis] > 1:
            first = values[:, 0] if axis == 1 else values[0]
            if increases(first):
                t, values = first, values[:, 1:] if axis == 1 else values[1:]
                notes.append(f"the first {along} increases throughout: taken for the time")
                if layout is None:
                    layout = "T,3N" if axis == 1 else "3N,T"
                break
    poses, how = to_poses(values, str(path), layout, order)
    notes.append(how)
    return t, poses


def _by_name(
    path: Path, table: Table, names: tuple[str, ...], notes: list[str]
) -> tuple[Floats | None, Floats]:
    time_column: int | None = None
    robot_column: int | None = None
    plain: dict[str, int] = {}
    numbered: dict[tuple[str, str], int] = {}
    unused: list[str] = []
    unit = 1.0
    for index, name in enumerate(names):
        word = name.lower().strip()
        if (milli := _MILLISECONDS.fullmatch(word)) is not None and time_column is None:
            time_column, unit = index, 1e-3
            notes.append(f"{name}: milliseconds, by its name; {milli['name']} taken in seconds")
            continue
        bare = re.sub(r"\s*[\[(].*?(?:m|s|rad|sec)[\])]$", "", word)
        if bare in TIME_NAMES and time_column is None:
            time_column = index
        elif bare in ROBOT_NAMES and robot_column is None:
            robot_column = index
        elif bare in _STATE_OF and _STATE_OF[bare] not in plain:
            plain[_STATE_OF[bare]] = index
        elif (key := _numbered(word)) is not None:
            if key in numbered:
                raise LayoutError(f"{path}: two columns are {key[0]} of robot {key[1]}")
            numbered[key] = index
        else:
            unused.append(name)
    if unused:
        notes.append(f"{len(unused)} column(s) not used: {', '.join(unused[:8])}")
    values = table.values
    if numbered:
        robots = sorted({robot for _, robot in numbered}, key=int)
        missing = [f"{s}{r}" for r in robots for s in STATE_NAMES if (s, r) not in numbered]
        if missing:
            raise LayoutError(
                f"{path}: no column for {', '.join(missing[:6])}; name all columns "
                "with --columns t,x1,y1,theta1,…"
            )
        chosen = np.array([[numbered[state, robot] for robot in robots] for state in STATE_NAMES])
        poses = values[:, chosen]
    elif len(plain) == 3:
        chosen = np.array([[plain[state]] for state in STATE_NAMES])
        if robot_column is not None:
            times, poses = _long(path, table, time_column, robot_column, chosen[:, 0], notes)
            return times * unit, poses
        poses = values[:, chosen]
    else:
        raise LayoutError(
            f"{path}: the columns {', '.join(names[:8])}… do not say where x, y and theta are; "
            "name them all with --columns t,x1,y1,theta1,… (- for one to leave out), "
            "or give their order with --columns state or robot"
        )
    t = values[:, time_column] * unit if time_column is not None else None
    notes.append(f"{poses.shape[2]} robot(s) found by column name")
    return t, poses


def _long(
    path: Path,
    table: Table,
    time_column: int | None,
    robot_column: int,
    index: NDArray[np.int_],
    notes: list[str],
) -> tuple[Floats, Floats]:
    """Turn one row a robot and sample into one row a sample."""
    if time_column is None:
        raise LayoutError(f"{path}: a row for each robot needs a time column")
    times, sample = np.unique(table.values[:, time_column], return_inverse=True)
    robots, column = np.unique(table.values[:, robot_column], return_inverse=True)
    if not np.isfinite(times).all() or not np.isfinite(robots).all():
        raise LogError(f"{path}: a time or robot number is not a finite number")
    rows = len(table.values)
    if len(times) * len(robots) != rows:
        counts = np.bincount(sample, minlength=len(times))
        odd = int(np.flatnonzero(counts != len(robots))[0]) if len(times) * len(robots) else 0
        raise LogError(
            f"{path}: {rows} rows are not {len(times)} times of {len(robots)} robots; at time "
            f"{times[odd]:g} s there are {counts[odd]} rows"
        )
    poses = np.full((len(times), 3, len(robots)), np.nan)
    poses[sample, :, column] = table.values[:, index]
    notes.append(f"one row a robot and sample: {len(robots)} robots, sorted by time")
    return times, poses


def _numbered(word: str) -> tuple[str, str] | None:
    for pattern in (_STATE_FIRST, _ROBOT_FIRST):
        match = pattern.fullmatch(word)
        if match and match["state"].strip("_") in _STATE_OF:
            return _STATE_OF[match["state"].strip("_")], match["robot"]
    return None


def _content(line: str) -> str:
    """Return the line without its comment; blank when nothing is left."""
    for mark in "#%":
        line = line.split(mark, 1)[0]
    return line.strip()


def _parameters(path: Path, above: list[str]) -> dict[str, Any]:
    """Read the comment in which a converted log carries its parameters."""
    mark = f"# {parameters.NAME}: "
    for number, line in enumerate(above, start=1):
        if line.startswith(mark):
            return parameters.from_json(line[len(mark) :], f"{path}: line {number}")
    return {}


def _commented_header(lines: list[str], start: int, delimiter: str) -> tuple[str, ...] | None:
    """``numpy.savetxt(header=…)`` writes the header as a comment: use it if it names columns."""
    for line in reversed(lines[:start]):
        stripped = line.strip()
        if stripped[:1] in ("#", "%"):
            cells = _split(stripped.lstrip("#% "), delimiter)
            words = [cell.strip().lower() for cell in cells]
            if len(words) > 2 and all(
                word in TIME_NAMES or word in _STATE_OF or word in ROBOT_NAMES or _numbered(word)
                for word in words
            ):
                return tuple(cell.strip() for cell in cells)
            return None
    return None


def _delimiter(line: str) -> str:
    return next((mark for mark in (";", ",", "\t") if mark in line), " ")


def _split(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    return next(csv.reader([line], delimiter=delimiter))


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(path: Path, lines: list[str], start: int, delimiter: str) -> Floats:
    body = "\n".join(lines[start:])
    if not any(_content(line) for line in lines[start : start + 100]):
        body = "\n".join(line for line in lines[start:] if _content(line))
    if not body:
        raise LogError(f"{path}: a header and no row of numbers")
    try:
        values = np.loadtxt(
            io.StringIO(body),
            delimiter=None if delimiter == " " else delimiter,
            comments=["#", "%"],
            ndmin=2,
            dtype=np.float64,
        )
    except ValueError as error:
        raise LogError(_first_fault(path, lines, start, delimiter, str(error))) from error
    if values.size == 0:
        raise LogError(f"{path}: empty, no row of numbers in it")
    return values


def _first_fault(path: Path, lines: list[str], start: int, delimiter: str, other: str) -> str:
    """Say which line is wrong, and why, in the file's own counting."""
    width: int | None = None
    for number, line in enumerate(lines[start:], start=start + 1):
        content = _content(line)
        if not content:
            continue
        cells = _split(content, delimiter)
        width = len(cells) if width is None else width
        if len(cells) != width:
            return f"{path}: line {number}: {len(cells)} columns, the lines before have {width}"
        for column, cell in enumerate(cells, start=1):
            if not _is_number(cell.strip()):
                shown = cell.strip()[:40] or "(empty)"
                return f"{path}: line {number}: column {column} is {shown!r}, not a number"
    return f"{path}: not a table of numbers ({other})"
