"""Numbers as programs and countries write them, spelled as Python reads them.

Fortran writes ``1.0D+00``, Microsoft's C library ``1.#QNAN`` and ``-nan(ind)``, half of Europe
``0,5``. What commas and points mean is told by the table as a whole, never guessed cell by cell:
``1.234`` and ``1,234`` may be about one or above a thousand.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

_FORTRAN = re.compile(r"(?<![\w.])([+-]?(?:\d+\.\d*|\.\d+))[dD]([+-]?\d{1,3})(?![\w.])")
_NO_NUMBER = re.compile(r"[+-]?(?:1\.#(?:INF|QNAN|SNAN|IND)\d*|nan\((?:ind|snan)\))", re.IGNORECASE)
_QUOTED = re.compile(r'"[^"]*"')
_WITH_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_WHOLE = re.compile(r"[+-]?\d+")
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:([.,' ])\d{3})(?:\1\d{3})*(?:[.,]\d+)?")


def as_python(line: str) -> str:
    """Return a line whose numbers have exponents after an e, and nan where they are none.

    Parameters
    ----------
    line : str
        As it stands in the file.
    """
    if "D" in line or "d" in line:
        line = _FORTRAN.sub(r"\1e\2", line)
    return _NO_NUMBER.sub("nan", line) if "#" in line or "(" in line else line


def separated_by_blanks(line: str) -> bool:
    """Tell whether a line is numbers with decimal commas and blanks between them.

    Parameters
    ----------
    line : str
        Without its comment.
    """
    cells = line.split()
    if len(cells) < 2 or "," not in line or "." in line:
        return False
    return all(_WITH_COMMA.fullmatch(cell) or _WHOLE.fullmatch(cell) for cell in cells)


def with_decimal_points(lines: list[str], delimiter: str) -> list[str] | None:
    """Return the rows of a table with points in the place of decimal commas; None without these.

    Parameters
    ----------
    lines : list of str
        The rows, without comments.
    delimiter : str
        What separates the cells. Beside commas, decimal ones stand within quotes.
    """
    commas = any("," in line for line in lines)
    if not commas or any("." in line for line in lines):
        return None
    if delimiter in (";", "\t", " "):
        return [line.replace(",", ".") for line in lines]
    if delimiter != "," or not any('"' in line for line in lines):
        return None
    cells = {cell[1:-1].strip() for line in lines for cell in _QUOTED.findall(line)}
    decimal = [cell for cell in cells if "," in cell]
    # Three digits behind every comma may be thousands as well.
    if not decimal or not all(map(_WITH_COMMA.fullmatch, decimal)) or all(map(_thousands, decimal)):
        return None
    return [_QUOTED.sub(lambda cell: cell.group().replace(",", "."), line) for line in lines]


def why_no_number(cell: str) -> str:
    """Return what a cell is that is no number, where that can be said, and what to do.

    Parameters
    ----------
    cell : str
        As it stands in the file.
    """
    if _thousands(cell):
        return ": write numbers without marks between thousands, and with a decimal point"
    if _WITH_COMMA.fullmatch(cell):
        return ": write all numbers with a decimal point, or all with a comma, between semicolons"
    return ""


def _thousands(cell: str) -> bool:
    return _GROUPED.fullmatch(cell) is not None


def commas_in_both_roles(
    rows: Iterable[str], split: Callable[[str], list[str]], columns: int
) -> bool:
    """Tell whether commas separate cells and are decimal ones, too, so that nobody can tell.

    Parameters
    ----------
    rows : iterable of str
        Rows of a table whose delimiter is a comma.
    split : callable
        Cuts one into cells.
    columns : int
        Columns that the header names; 0 where there is none.
    """
    cut = [[cell.strip() for cell in split(row)] for row in rows]
    if not cut or not all(map(_WHOLE.fullmatch, (cell for row in cut for cell in row))):
        return False
    width = len(cut[0])
    if columns:
        return columns < width <= 2 * columns
    fractions = [cell for row in cut for cell in row[1::2]]
    evenly = len({len(cell) for cell in fractions}) == 1 and len(fractions[0]) > 2
    return width % 2 == 0 and evenly and all(map(str.isdigit, fractions))
