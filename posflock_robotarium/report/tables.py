"""A comparison as plain lines for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator

from posflock_robotarium.alignment.comparison import Comparison
from posflock_robotarium.alignment.reference_errors import ErrorStatistics
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
