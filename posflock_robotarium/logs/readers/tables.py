"""A rectangle of numbers in a text file, and the names of its columns where there are any.

Whatever separates the cells, wherever comments stand: damage is told with file, line and reason.
Spreadsheets quote numbers, end rows with a comma and write in UTF-16 or Latin-1; a column may hold
words, such as robots' names; a cell may be empty, which is an unknown number; and the last row of a
log that was cut off is short, and left out.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import parameters
from posflock_robotarium.logs.readers.alphabets import text_of, without_zero_bytes
from posflock_robotarium.logs.readers.bounds import BOUNDS, LONGEST_LINE, Bounds
from posflock_robotarium.logs.readers.names import names_a_column
from posflock_robotarium.logs.readers.number_spellings import (
    commas_in_both_roles,
    separated_by_blanks,
    why_no_number,
    with_decimal_points,
)
from posflock_robotarium.logs.readers.spreadsheet_habits import (
    declared_delimiter,
    plain_line,
    row_of_units,
    with_units,
    without_prose,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Table:
    """Numbers of a text file, and what it says about them.

    Attributes
    ----------
    path : Path
        Where it was read from, for messages.
    values : (rows, columns) array
        Its numbers as they stand, a row a line, in whatever units the file has.
    names : tuple of str
        The header: a name a column, or none at all.
    delimiter : str
        What separates the cells; a blank stands for any white space.
    parameters : mapping
        What a comment above the table says about the run.
    decimal_comma : bool
        Whether commas between digits were read as decimal points.
    promised : int, optional
        Rows that the file says were written into it.
    torn : bool
        Whether the last line has no end: it may be half of one.
    words : mapping of int to tuple of str
        Columns that hold words, by their place; their values are NaN.
    notes : tuple of str
        How its text was read, where that is worth a sentence.
    """

    path: Path
    values: Floats
    names: tuple[str, ...]
    delimiter: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    decimal_comma: bool = False
    promised: int | None = None
    torn: bool = False
    words: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def read_table(path: Path, bounds: Bounds = BOUNDS) -> Table:
    """Read a rectangular table of numbers.

    Parameters
    ----------
    path : Path
        Comma, semicolon, tab or blank separated; ``#`` and ``%`` start comments.
    bounds : Bounds
        How much memory its reading may take.

    Returns
    -------
    Table
        Values of shape (rows, columns).

    Raises
    ------
    LogError
        With file, line and reason, when a cell is not a number or rows differ in length.
    """
    text, notes = text_of(path, bounds)
    lines, damaged = without_zero_bytes(text.splitlines())
    notes += damaged
    _refuse_long_lines(path, lines)
    start = next((i for i, line in enumerate(lines) if _content(line)), None)
    if start is None:
        raise LogError(f"{path}: empty, no row of numbers in it")
    said = _parameters(path, lines[:start])
    promised = parameters.rows_promised(said)
    torn = not text.endswith(("\n", "\r"))
    if torn and promised is not None:  # a writer of ours ends every line
        del lines[-1]
        if start == len(lines):
            raise LogError(f"{path}: cut off before its first row")
    lines = [plain_line(line) for line in lines]
    delimiter = declared_delimiter(lines[start])
    if delimiter is not None:
        start = next((i for i in range(start + 1, len(lines)) if _content(lines[i])), start)
    start, above = without_prose(lines, start, _content, _split, _delimiter)
    delimiter = delimiter or _delimiter(_content(lines[start]))
    # With no point in any row, a comma beside other separators is a decimal one (Excel in Europe).
    head = 1 if start + 1 < len(lines) else 0
    pointed = with_decimal_points([_content(line) for line in lines[start + head :]], delimiter)
    if pointed is not None:
        first = (
            [lines[start].replace(",", ".")] if head and delimiter != "," else lines[start:][:head]
        )
        lines = [*lines[:start], *first, *pointed]
    names: tuple[str, ...] = ()
    cells = _split(_content(lines[start]), delimiter)
    if not any(_is_number(cell.strip().strip('"')) for cell in cells):
        names = tuple(cell.strip().strip("\"'").strip() for cell in cells)
        start += 1
        if start < len(lines) and (units := row_of_units(_split(lines[start], delimiter))):
            names = with_units(names, units)
            start += 1
    elif (comment := _commented_header(lines, start, delimiter)) is not None:
        names = comment
    _refuse_commas_in_both_roles(path, lines[start : start + 100], delimiter, len(names))
    values, words, told = _cells(path, lines, start, delimiter)
    if names and len(names) == values.shape[1] + 1 and not names[-1]:
        names = names[:-1]
    if names and len(names) != values.shape[1]:
        raise LogError(
            f"{path}: the header names {len(names)} columns, the rows have {values.shape[1]}"
        )
    notes += (*above, *told)
    torn = torn and not told and not (damaged and not lines[-1])
    comma = pointed is not None
    return Table(path, values, names, delimiter, said, comma, promised, torn, words, notes)


def _refuse_commas_in_both_roles(path: Path, rows: list[str], delimiter: str, columns: int) -> None:
    contents = [content for row in rows if (content := _content(row))]
    if delimiter == "," and commas_in_both_roles(
        contents, lambda row: _split(row, delimiter), columns
    ):
        raise LogError(
            f"{path}: commas stand within numbers and between them, too; export it with "
            "semicolons between cells, or with decimal points"
        )


def _refuse_long_lines(path: Path, lines: list[str]) -> None:
    """Refuse lines that no table has; the one in which a log carries its parameters may be long."""
    for number, line in enumerate(lines, start=1):
        if len(line) > LONGEST_LINE and not line.startswith(f"# {parameters.NAME}: "):
            raise LogError(
                f"{path}: line {number}: {len(line)} letters, more than the {LONGEST_LINE} that a"
                " line may have"
            )


def _content(line: str) -> str:
    """Return the line without its comment; blank when nothing is left."""
    if line.lstrip().startswith("//"):
        return ""
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
            named = len(words) > 2 and all(map(names_a_column, words))
            # A comment that names t, x, y and theta says in words what the columns are.
            if named and len(words) == len(_split(_content(lines[start]), delimiter)):
                return tuple(cell.strip() for cell in cells)
            return None
    return None


def _delimiter(line: str) -> str:
    if "\t" in line and "," in line and not _BESIDE_DIGITS.search(line):
        return "\t"  # all commas are decimal ones
    if separated_by_blanks(line):
        return " "
    return next((mark for mark in (";", ",", "\t", "|") if mark in line), " ")


_BESIDE_DIGITS = re.compile(r"[.]|(?<!\d),|,(?!\d)")


def _split(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    return next(csv.reader([line], delimiter=delimiter))


_UNKNOWN = {"", "na", "n/a", "#n/a", "null", "none", "nil", "missing", "lost", "-", "--", "?", "."}
"""How spreadsheets and programs write a number that is not known; NaN is a number of its own."""


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _cells(
    path: Path, lines: list[str], start: int, delimiter: str
) -> tuple[Floats, dict[int, tuple[str, ...]], tuple[str, ...]]:
    """Return the numbers, the columns of words, and what had to be left out."""
    body = lines[start:]
    if not any(_content(line) for line in body[:100]):
        body = [line for line in body if _content(line)]
    if not body:
        raise LogError(f"{path}: a header and no row of numbers")
    try:
        values = np.loadtxt(
            body,
            delimiter=None if delimiter == " " else delimiter,
            comments=["#", "%", "//"],
            quotechar='"',
            ndmin=2,
            dtype=np.float64,
        )
    except ValueError as error:
        found = _unusual_cells(body, delimiter)
        if found is None:
            raise LogError(_first_fault(path, lines, start, delimiter, str(error))) from error
        return found
    if values.size == 0:
        raise LogError(f"{path}: empty, no row of numbers in it")
    return values, {}, ()


def _unusual_cells(
    body: list[str], delimiter: str
) -> tuple[Floats, dict[int, tuple[str, ...]], tuple[str, ...]] | None:
    """Return a table with empty cells, words, a comma at the end or a short last row, or None."""
    rows = [_split(content, delimiter) for line in body if (content := _content(line))]
    notes: tuple[str, ...] = ()
    if len(rows) > 2 and len(rows[-1]) < len(rows[0]):
        del rows[-1]
        notes = ("the last row is cut off, and left out",)
    if len({len(row) for row in rows}) != 1 or not rows[0]:
        return None
    columns = [[cell.strip().strip("\"'") for cell in column] for column in zip(*rows, strict=True)]
    if len(columns) > 1 and delimiter != " " and not any(columns[-1]):
        del columns[-1]
    values = np.full((len(rows), len(columns)), np.nan)
    words: dict[int, tuple[str, ...]] = {}
    for index, column in enumerate(columns):
        try:
            values[:, index] = [
                np.nan if cell.lower() in _UNKNOWN else float(cell) for cell in column
            ]
        except ValueError:
            # A column is of words throughout: among numbers, a word is damage.
            if any(_is_number(cell) for cell in column):
                return None
            words[index] = tuple(column)
    return (values, words, notes) if len(words) < len(columns) else None


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
                why = why_no_number(cell.strip())
                return f"{path}: line {number}: column {column} is {shown!r}, not a number{why}"
    return f"{path}: not a table of numbers ({other})"
