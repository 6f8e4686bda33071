"""What a metric is, and the one table of all metrics that everything downstream goes through.

One entry says what a metric is called, what it means, how it is computed, which numbers are taken
from it and where it is drawn. JSON, CSV, LaTeX table, page and figures iterate over the table:
whoever registers a metric finds it in all of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from posflock_robotarium.alignment.measured_run import CurveFunction, Floats, MeasuredRun
from posflock_robotarium.alignment.panels import Panel, in_reading_order
from posflock_robotarium.flocking.errors import ParameterError

Reduction = Literal["mean", "smallest", "largest"]
REDUCTIONS: tuple[Reduction, ...] = get_args(Reduction)
NumberFunction = Callable[[MeasuredRun], float | None]

OWN_GROUP = "Own metrics"
"""Heading of the metrics of a user's own files, before all others."""

GROUPS = (
    *("Formation", "Coverage", "Run", "Alignment", "Motion", "Cohesion"),
    *("Safety", "Certificate", "Confidence"),
)
"""Headings of the table of numbers, in reading order: first what is told only where it is asked. A
heading that is new follows them."""


@dataclass(frozen=True)
class Number:
    """One scalar of the summary of a run.

    Attributes
    ----------
    label : str
        Words for people.
    value : float
        NaN where undefined.
    unit : str
        Empty for pure numbers; ``share`` is shown in per cent.
    definition : str
        Exactly what was taken.
    group : str
        Heading in the table of numbers.
    """

    label: str
    value: float
    unit: str
    definition: str
    group: str


@dataclass(frozen=True)
class Scalar:
    """What a number of every run is called, what it means and how it is computed.

    Attributes
    ----------
    key : str
        Its name in JSON.
    label : str
        Words for people. In the label and the definition, ``{run.since}`` stands for when the
        settled part begins, ``{run.options.threshold:g}`` for a threshold, and so on with every
        attribute of a `MeasuredRun`.
    unit : str
        Empty for pure numbers; ``share`` is shown in per cent.
    definition : str
        Exactly what was taken.
    group : str
        Heading in the table of numbers, most often one of `GROUPS`.
    value : callable
        Of the `MeasuredRun`. NaN where undefined, None where the recording has no data for it.
    latex : bool
        Whether it is a row of the LaTeX table.
    column : str
        Head of its column in the page's table of several runs; empty for none.
    """

    key: str
    label: str
    unit: str
    definition: str
    group: str
    value: NumberFunction
    latex: bool = False
    column: str = ""

    def of(self, run: MeasuredRun) -> Number | None:
        """Return the number of one run; None where the recording has no data for it.

        Parameters
        ----------
        run : MeasuredRun
            What the value is taken of, and whose attributes fill the braces of the words.

        Raises
        ------
        ParameterError
            When label or definition name what a run does not have.
        """
        value = self.value(run)
        if value is None:
            return None
        try:
            label, definition = (text.format(run=run) for text in (self.label, self.definition))
        except (AttributeError, IndexError, KeyError, ValueError) as error:
            raise ParameterError(
                f"metric {self.key!r}: braces in label and definition hold attributes of the run, "
                f"as in {{run.since}}; write others twice ({error!r})"
            ) from error
        return Number(label, value, self.unit, definition, self.group)


@dataclass(frozen=True)
class Metric:
    """One curve over time, and the numbers that are taken from it.

    Attributes
    ----------
    key : str
        Its column in the CSV, its name in JSON.
    label, unit, definition : str
        Words for people; the unit is empty for pure numbers.
    curve : callable
        Of the `MeasuredRun`: shape (T,), NaN where undefined; None where the recording has no data.
    of_interest : {'mean', 'smallest', 'largest'}
        Which summary of the curve a reader looks for first, and what a coarser drawing keeps.
    panel : Panel, optional
        Plot of the page in which it is drawn, one of `panels` or a new one; by default none.
    figure : str
        File name of the figure for print in which it is drawn; empty for none.
    legend : str
        A shorter label for that figure; the label by default.
    beside_replay : bool
        Whether the page shows its value beside the replay.
    numbers : tuple of Scalar
        What is taken from it.
    band : pair of str, optional
        Keys of the metrics that are the lower and the upper end of its 95 % band, shaded where it
        is drawn; by default it has none.

    Raises
    ------
    ParameterError
        When key or figure are no plain names, or `of_interest` is none of its values.
    """

    key: str
    label: str
    unit: str
    definition: str
    curve: CurveFunction
    of_interest: Reduction = "mean"
    panel: Panel | None = None
    figure: str = ""
    legend: str = ""
    beside_replay: bool = False
    numbers: tuple[Scalar, ...] = ()
    band: tuple[str, str] | None = None

    def __post_init__(self) -> None:
        if not re.fullmatch(r"\w+", self.key):
            raise ParameterError(f"key {self.key!r}; expected letters, digits and underscores")
        if not re.fullmatch(r"[\w-]*", self.figure) or self.figure in _OTHER_FIGURES:
            raise ParameterError(
                f"metric {self.key!r}: figure {self.figure!r}; expected a plain file name without "
                f"ending, other than {', '.join(_OTHER_FIGURES)}"
            )
        if self.of_interest not in REDUCTIONS:
            raise ParameterError(
                f"metric {self.key!r}: of_interest is {self.of_interest!r}; expected one of "
                f"{', '.join(REDUCTIONS)}"
            )

    def unjoined(self, curve: Floats) -> Floats:
        """Return a curve to be drawn: of an angle, the sample at which it jumps by a turn is NaN.

        Else a line would be drawn from top to bottom where it passes from π to -π.

        Parameters
        ----------
        curve : (T,) array
            Of this metric.

        Returns
        -------
        (T,) array
            In the same unit.
        """
        if self.unit != "rad":
            return curve
        jump = np.abs(np.diff(curve, prepend=curve[:1])) > np.pi
        return np.where(jump, np.nan, curve)


_OTHER_FIGURES = ("snapshots", "runs", "sightings")
"""Figures of a report that draw no metric of one run over time."""

_METRICS: dict[str, Metric] = {}
_SCALARS: dict[str, Scalar] = {}


def register(*entries: Metric | Scalar) -> None:
    """Make metrics known, or numbers that are taken from no curve.

    Parameters
    ----------
    *entries : Metric or Scalar
        A metric brings its numbers with it. The order is that of tables, columns and plots.

    Raises
    ------
    ParameterError
        Where another has the key already, or two numbers of one metric share theirs.
    """
    for entry in entries:
        numbers = {scalar.key: scalar for scalar in _numbers(entry)}
        taken = [key for key in numbers if key in _SCALARS]
        if isinstance(entry, Metric) and entry.key in _METRICS:
            taken.append(entry.key)
        if taken:
            raise ParameterError(f"metric {taken[0]!r} is registered already; choose another key")
        if len(numbers) < len(_numbers(entry)):
            raise ParameterError(f"metric {entry.key!r}: two of its numbers have one key")
        if isinstance(entry, Metric):
            _METRICS[entry.key] = entry
        _SCALARS.update(numbers)


def forget(*entries: Metric | Scalar) -> None:
    """Take out again what was registered.

    Parameters
    ----------
    *entries : Metric or Scalar
        The very objects that were given to `register`; the numbers of a metric go with it.

    Raises
    ------
    ParameterError
        Where one was not registered.
    """
    for entry in entries:
        known = _METRICS if isinstance(entry, Metric) else _SCALARS
        if known.get(entry.key) is not entry:
            raise ParameterError(f"metric {entry.key!r} is not registered")
        if isinstance(entry, Metric):
            del _METRICS[entry.key]
        for scalar in _numbers(entry):
            del _SCALARS[scalar.key]


def _numbers(entry: Metric | Scalar) -> tuple[Scalar, ...]:
    return entry.numbers if isinstance(entry, Metric) else (entry,)


def metrics() -> dict[str, Metric]:
    """Return every metric by its key, in the order of registration."""
    return dict(_METRICS)


def scalars() -> dict[str, Scalar]:
    """Return every number by its key, in the order of the summary's table."""
    groups = list(
        dict.fromkeys([OWN_GROUP, *GROUPS, *(scalar.group for scalar in _SCALARS.values())])
    )
    ordered = sorted(_SCALARS.items(), key=lambda item: groups.index(item[1].group))
    return dict(ordered)


def panels() -> list[tuple[Panel, list[Metric]]]:
    """Return the plots of the page in reading order, each with its metrics."""
    drawn = [metric for metric in _METRICS.values() if metric.panel is not None]
    order = in_reading_order(metric.panel for metric in drawn if metric.panel is not None)
    return [(panel, [metric for metric in drawn if metric.panel == panel]) for panel in order]


def figures() -> dict[str, list[Metric]]:
    """Return the figures for print by file name, each with its metrics."""
    drawn: dict[str, list[Metric]] = {}
    for metric in _METRICS.values():
        if metric.figure:
            drawn.setdefault(metric.figure, []).append(metric)
    return drawn
