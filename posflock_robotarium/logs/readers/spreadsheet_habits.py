"""What spreadsheets and loggers write into a table beside its numbers, and how it is taken.

``sep=;`` in the first line, titles above the header, a row of units below it, ``#N/A`` for a number
that is not known, and names such as ``"Robot #1"`` within quotes.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from posflock_robotarium.logs.readers.names import ANGLES, LENGTHS, SECONDS
from posflock_robotarium.logs.readers.number_spellings import as_python

#: What a spreadsheet writes where a formula failed.
_FAILED = re.compile(r"#(?:N/A|DIV/0!|VALUE!|REF!|NUM!|NAME\?|NULL!)", re.IGNORECASE)
_QUOTED = re.compile(r'"[^"]*"')
#: Lines above a header that may be titles, and notes.
_MOST_ABOVE = 50


def plain_line(line: str) -> str:
    """Return a line without marks that only look like the beginning of a comment.

    Parameters
    ----------
    line : str
        As it stands in the file.
    """
    line = as_python(line)
    if "#" not in line:
        return line
    line = _FAILED.sub("nan", line)
    return _QUOTED.sub(lambda quoted: quoted.group().replace("#", ""), line)


def declared_delimiter(line: str) -> str | None:
    """Return the delimiter that a line ``sep=;`` tells Excel; None where it is another line.

    Parameters
    ----------
    line : str
        The first of the file.
    """
    told = re.fullmatch(r"sep=([;,|\t])", line.strip().strip('"') or line)
    return told[1] if told else None


def row_of_units(cells: list[str]) -> list[str]:
    """Return the units in a row below the header; none where it is another row.

    Parameters
    ----------
    cells : list of str
        The row's.
    """
    plain = [cell.strip().strip("\"'[]()").strip().lower() for cell in cells]
    known = {*LENGTHS, *ANGLES, *SECONDS, "", "-", "1"}
    told = sum(unit in LENGTHS or unit in ANGLES for unit in plain)
    return plain if told >= 2 and all(unit in known for unit in plain) else []


def with_units(names: tuple[str, ...], units: list[str]) -> tuple[str, ...]:
    """Return columns' names with the units that stand below them.

    Parameters
    ----------
    names : tuple of str
        Of the columns.
    units : list of str
        Of as many, "" or "-" where a column has none.
    """
    if len(names) != len(units):
        return names
    pairs = zip(names, units, strict=True)
    return tuple(name if unit in ("", "-", "1") else f"{name} [{unit}]" for name, unit in pairs)


def without_prose(
    lines: list[str],
    start: int,
    content: Callable[[str], str],
    split: Callable[[str, str], list[str]],
    delimiter: Callable[[str], str],
) -> tuple[int, tuple[str, ...]]:
    """Return where the header stands below titles and notes, and what is to be said of these.

    Parameters
    ----------
    lines : list of str
        Of the whole file.
    start : int
        The first that is no comment.
    content, split, delimiter : callable
        How a line is taken without its comment, cut into cells, and by which mark.

    Returns
    -------
    start : int
        The line of the header, or of the first row.
    notes : tuple of str
        What was left out above it.
    """
    there = [i for i in range(start, min(start + _MOST_ABOVE, len(lines))) if content(lines[i])]
    for place, at in enumerate(there):
        cells = split(content(lines[at]), delimiter(content(lines[at])))
        numbers = sum(_is_number(cell) for cell in cells)
        if numbers < 2 or numbers < len(cells) / 2:
            continue
        # The header is the last line above the numbers that has as many cells, units aside.
        mark = delimiter(content(lines[at]))
        for above in reversed(there[:place]):
            heading = split(content(lines[above]), mark)
            wide = len(heading) in (len(cells), len(cells) + 1)
            if wide and not row_of_units(heading) and not any(map(_is_number, heading)):
                skipped = there.index(above)
                if not skipped:
                    return start, ()
                return above, (f"{skipped} line(s) above the header are left out",)
        return start, ()
    return start, ()


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().strip("\"'").replace(",", "."))
    except ValueError:
        return False
    return True
