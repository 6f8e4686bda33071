"""A comparison as texts: its rows, and plain lines for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from posflock_robotarium.alignment.comparison import Comparison, Row
from posflock_robotarium.alignment.reference_errors import ErrorStatistics
from posflock_robotarium.report.words import difference_text, numbers_text

WIDEST = 22
"""Letters of a run's name that a column shows."""


@dataclass(frozen=True)
class RowText:
    """A row of a comparison as people read it: one unit, one number of decimals.

    Attributes
    ----------
    values : list of str
        Of each run.
    means, intervals : dict of str
        By label; an interval is empty where there are too few runs for one.
    difference : str
        Second label less first; empty but for two labels.
    """

    values: list[str]
    means: dict[str, str]
    intervals: dict[str, str]
    difference: str


def row_texts(row: Row, labels: Sequence[str]) -> RowText:
    """Return the texts of a row.

    Parameters
    ----------
    row : Row
        One number in every run.
    labels : sequence of str
        The different labels, in order.
    """
    spreads = [row.by_label[label] for label in labels]
    numbers = [*row.values, *(n for s in spreads for n in (s.mean, s.low, s.high))]
    texts = numbers_text(numbers, row.unit)
    means, intervals = {}, {}
    for k, (label, spread) in enumerate(zip(labels, spreads, strict=True)):
        mean, low, high = texts[len(row.values) + 3 * k :][:3]
        means[label] = mean
        intervals[label] = f"{low}, {high}" if spread.low == spread.low else ""
    difference = ""
    if len(labels) == 2:
        first, second = spreads
        difference = difference_text(second.mean - first.mean, numbers, row.unit)
    return RowText(texts[: len(row.values)], means, intervals, difference)


def comparison_table(comparison: Comparison) -> Iterator[str]:
    """Yield the lines of a table: a row a number, a column a run, then the mean of each label.

    Runs are columns up to six of them; beyond that only the means are shown.

    Parameters
    ----------
    comparison : Comparison
        Runs side by side, with their labels.
    """
    several = len(comparison.analyses) > 6
    names = [] if several else [_short(analysis.name) for analysis in comparison.analyses]
    counted = [
        label for label in comparison.groups if several or comparison.labels.count(label) > 1
    ]
    difference = len(comparison.groups) == 2
    heads = ["", *names, *(f"{label}, mean [95 %]" for label in counted)]
    heads += [f"{comparison.groups[1]} − {comparison.groups[0]}"] if difference else []
    rows: list[list[str]] = []
    for row in comparison.rows:
        told = row_texts(row, comparison.groups)
        cells = [row.label, *([] if several else told.values)]
        for label in counted:
            interval = told.intervals[label]
            cells.append(told.means[label] + (f" [{interval}]" if interval else ""))
        if difference:
            cells.append(told.difference)
        rows.append(cells)
    widths = [max(len(cells[k]) for cells in [heads, *rows]) for k in range(len(heads))]
    for cells in [heads, *rows]:
        padded = [cells[0].ljust(widths[0])]
        padded += [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True)]
        yield "  ".join(padded).rstrip()
    yield ""
    for outcome, count in comparison.outcomes.items():
        yield f"{count} of {len(comparison.analyses)} runs: {outcome}"


def reference_table(comparison: Comparison) -> Iterator[str]:
    """Yield the lines of the tables of errors against the reference, a row a robot; none without.

    Parameters
    ----------
    comparison : Comparison
        Runs side by side.
    """
    for errors in comparison.errors:
        yield ""
        yield (
            f"{errors.run} against {errors.reference}, root mean square (largest); "
            f"RPE over {errors.delta:.3g} s, {errors.frames} samples"
        )
        heads = ["robot", "APE position", "APE heading", "RPE motion", "RPE turning"]
        rows = [heads]
        for robot in errors.robots:
            kinds = ((robot.position, "m"), (robot.heading, "rad"), (robot.motion, "m"))
            cells = [_error(of, unit) for of, unit in (*kinds, (robot.turning, "rad"))]
            rows.append([str(robot.robot), *cells])
        widths = [max(len(row[k]) for row in rows) for k in range(len(heads))]
        for row in rows:
            padded = (cell.rjust(width) for cell, width in zip(row, widths, strict=True))
            yield "  " + "  ".join(padded)


def _error(of: ErrorStatistics | None, unit: str) -> str:
    if of is None:
        return "–"
    if unit == "rad":
        return f"{math.degrees(of.rmse):.2f}° ({math.degrees(of.largest):.2f}°)"
    return f"{of.rmse:.4f} m ({of.largest:.4f} m)"


def _short(name: str) -> str:
    return name if len(name) <= WIDEST else f"…{name[1 - WIDEST :]}"
