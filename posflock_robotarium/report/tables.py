"""A comparison as plain lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from posflock_robotarium.alignment.comparison import Comparison
from posflock_robotarium.report.words import number_text

WIDEST = 22
"""Letters of a run's name that a column shows."""


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
        cells = [row.label]
        cells += [] if several else [number_text(value, row.unit) for value in row.values]
        for label in counted:
            spread = row.by_label[label]
            interval = (
                f" [{number_text(spread.low, row.unit)}, {number_text(spread.high, row.unit)}]"
                if spread.low == spread.low
                else ""
            )
            cells.append(number_text(spread.mean, row.unit) + interval)
        if difference:
            first, second = (row.by_label[label].mean for label in comparison.groups)
            cells.append(number_text(second - first, row.unit))
        rows.append(cells)
    widths = [max(len(cells[k]) for cells in [heads, *rows]) for k in range(len(heads))]
    for cells in [heads, *rows]:
        padded = [cells[0].ljust(widths[0])]
        padded += [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True)]
        yield "  ".join(padded).rstrip()
    yield ""
    for outcome, count in comparison.outcomes.items():
        yield f"{count} of {len(comparison.analyses)} runs: {outcome}"


def _short(name: str) -> str:
    return name if len(name) <= WIDEST else f"…{name[1 - WIDEST :]}"
