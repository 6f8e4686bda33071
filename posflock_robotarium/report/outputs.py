"""Everything a report leaves in its folder: page, figures, numbers, and the analysis itself."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import scalars
from posflock_robotarium.alignment.comparison import Comparison, compare, labelled
from posflock_robotarium.alignment.fewest_runs import FEWEST_RUNS
from posflock_robotarium.alignment.reference_errors import ErrorStatistics, ReferenceErrors
from posflock_robotarium.report.page import write_page
from posflock_robotarium.report.words import SUPERSCRIPTS, numbers_text
from rps_compat.whole_files import (
    atomic_write,
    listed_in,
    remove_listed,
    write_whole,
    written_together,
)

_SUMMARY = "summary.json"
#: Files of which one report may have more or fewer than another; nothing else is ever removed.
_MANY = re.compile(
    r"[^/]+\.analysis\.npz|table\.tex|reference_errors\.csv|figures/[^/]+\.(png|pdf)"
)


def write_report(
    analyses: Sequence[Analysis],
    folder: Path,
    *,
    latex: bool = False,
    figures: bool = True,
    labels: Sequence[str] | None = None,
    comparison: Comparison | None = None,
) -> list[Path]:
    """Write the whole report.

    Parameters
    ----------
    analyses : sequence of Analysis
        One run, or several side by side.
    folder : Path
        Made when it is not there; nothing is written outside it.
    latex : bool
        Also write ``table.tex``.
    figures : bool
        Also draw ``figures/``.
    labels : sequence of str, optional
        What each of several runs counts as (see `comparison.compare`).
    comparison : Comparison, optional
        Of these runs, where they have been compared already; then `labels` are its own.

    Returns
    -------
    list of Path
        What was written, the page first.

    Raises
    ------
    OutputError
        When the folder cannot be written; an earlier report in it then stays as it was.
    """
    if comparison is None and len(analyses) > 1:
        if labels is not None:
            analyses = labelled(analyses, labels)
        comparison = compare(analyses, labels)
    earlier = set(filter(_MANY.fullmatch, listed_in(folder / _SUMMARY)))
    with written_together(folder) as draft:
        written = [
            write_page(analyses, draft / "report.html", comparison),
            write_curves(analyses, draft / "metrics.csv"),
        ]
        for analysis, name in zip(analyses, _file_names(analyses), strict=True):
            written.append(analysis.save(draft / f"{name}.analysis.npz"))
        if latex:
            written.append(write_whole(draft / "table.tex", latex_table(analyses, comparison)))
        if figures:
            from posflock_robotarium.report.curve_figures import draw

            written += draw(analyses, draft / "figures")
        if comparison is not None and comparison.errors:
            written.append(write_errors(comparison.errors, draft / "reference_errors.csv"))
        names = [path.relative_to(draft).as_posix() for path in written]
        write_summary(analyses, comparison, draft / _SUMMARY, [*names, _SUMMARY])
    remove_listed(folder, earlier - set(names))
    return [folder / name for name in [*names, _SUMMARY]]


def write_curves(analyses: Sequence[Analysis], path: Path) -> Path:
    """Write every metric over time as CSV, numbers in full precision, undefined ones empty.

    Several runs are told apart by a first column ``run``.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    path : Path
        Where the CSV file is written.

    Raises
    ------
    OutputError
        Where it cannot be written.
    """
    keys = list(dict.fromkeys(key for analysis in analyses for key in analysis.curves))
    several = len(analyses) > 1
    with atomic_write(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*(["run"] if several else []), "t", *keys])
        for analysis in analyses:
            missing = np.full(len(analysis.recording.t), np.nan)
            columns = [analysis.recording.t, *(analysis.curves.get(k, missing) for k in keys)]
            prefix = [_cell(analysis.name)] if several else []
            for row in np.stack(columns, axis=1).tolist():
                table.writerow([*prefix, *("" if value != value else repr(value) for value in row)])
    return path


def write_errors(errors: Sequence[ReferenceErrors], path: Path) -> Path:
    """Write the errors of runs against a reference as CSV, a row for each robot of each run.

    Parameters
    ----------
    errors : sequence of ReferenceErrors
        One a run.
    path : Path
        Where the CSV file is written.

    Raises
    ------
    OutputError
        Where it cannot be written.
    """
    kinds = {
        "ape_position_m": "position",
        "ape_heading_rad": "heading",
        "rpe_motion_m": "motion",
        "rpe_turning_rad": "turning",
    }
    names = [part.name for part in fields(ErrorStatistics)]
    with atomic_write(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        heads = [f"{kind}_{name}" for kind in kinds for name in names]
        table.writerow(["run", "reference", "robot", "samples", "pairs", *heads])
        for run in errors:
            for robot in run.robots:
                found = (getattr(robot, kind) for kind in kinds.values())
                cells = [repr(getattr(of, name)) if of else "" for of in found for name in names]
                first = [_cell(run.run), _cell(run.reference), robot.robot]
                table.writerow([*first, robot.samples, robot.pairs, *cells])
    return path


def write_summary(
    analyses: Sequence[Analysis],
    comparison: Comparison | None,
    path: Path,
    files: Sequence[str] = (),
) -> Path:
    """Write all numbers with units, definitions, estimators and parameters as JSON.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    comparison : Comparison or None
        Of several runs; None for one.
    path : Path
        Where the JSON file is written.
    files : sequence of str
        All files of the report, by their paths in its folder: the next one removes what it does
        not write again.

    Raises
    ------
    OutputError
        Where it cannot be written.
    """
    summary: dict[str, Any]
    if comparison is None:
        summary = analyses[0].summary()
    else:
        summary = {
            "runs": [analysis.summary() for analysis in analyses],
            "comparison": comparison.summary(),
        }
    if files:
        summary = {**summary, "files": list(files)}
    text = json.dumps(summary, indent=1, ensure_ascii=False, allow_nan=False)
    return write_whole(path, text + "\n")


def latex_table(analyses: Sequence[Analysis], comparison: Comparison | None = None) -> str:
    """Return the main numbers as a LaTeX ``tabular`` (needs the package booktabs).

    Parameters
    ----------
    analyses : sequence of Analysis
        A column each; with a comparison also mean and interval.
    comparison : Comparison, optional
        Of the same runs.
    """
    names = [_latex(analysis.name) for analysis in analyses]
    interval = comparison is not None and len(analyses) >= FEWEST_RUNS
    lines = [
        "% Means are over the settled part of a run; definitions are in summary.json.",
        rf"\begin{{tabular}}{{l{'r' * (len(analyses) + interval)}}}",
        r"\toprule",
        " & ".join(["", *names, *(["mean [95\\,\\%]"] if interval else [])]) + r" \\",
        r"\midrule",
    ]
    rows = {row.key: row for row in comparison.rows} if comparison is not None else {}
    for key in [key for key, scalar in scalars().items() if scalar.latex]:
        known = [analysis.numbers.get(key) for analysis in analyses]
        example = next((number for number in known if number is not None), None)
        if example is None:
            continue
        spread = rows[key].overall if interval else None
        ends = (spread.mean, spread.low, spread.high) if spread else ()
        values = [math.nan if n is None else n.value for n in known]
        texts = [_latex(text) for text in numbers_text([*values, *ends], example.unit)]
        cells = ["--" if n is None else text for n, text in zip(known, texts, strict=False)]
        if interval:
            mean, low, high = texts[-3:]
            cells.append(
                mean if spread is None or math.isnan(spread.low) else f"{mean} [{low}, {high}]"
            )
        lines.append(" & ".join([_latex(example.label), *cells]) + r" \\")
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


_LATEX = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\,\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "γ": r"$\gamma$",
    "<": "$<$",
    ">": "$>$",
    "≥": r"$\geq$",
    "−": r"$-$",
    "–": "--",
    "°": r"\textdegree{}",
    "²": r"$^2$",
    "·": r"$\cdot$",
    "∞": r"$\infty$",
    "σ": r"$\sigma$",
}


#: A number as `words.number_text` writes it that has an exponent.
_POWER = re.compile("(−?)([0-9.]+)·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)")
_PLAIN = {raised: letter for letter, raised in SUPERSCRIPTS.items()}


def _latex(text: str) -> str:
    power = _POWER.search(text)
    if power is not None:
        sign, mantissa, exponent = power.groups()
        number = rf"${sign and '-'}{mantissa}\cdot10^{{{exponent.translate(_PLAIN)}}}$"
        return _latex(text[: power.start()]) + number + _latex(text[power.end() :])
    return re.sub(" (\\\\,)", r"\1", "".join(_LATEX.get(letter, letter) for letter in text))


def _cell(text: str) -> str:
    """Keep a name from being taken for a formula by a spreadsheet."""
    return "'" + text if text[:1] in "=+-@\t\r" else text


def _file_names(analyses: Sequence[Analysis]) -> list[str]:
    """Return a file name for each run: its own name made harmless, numbered where needed."""
    names: list[str] = []
    for analysis in analyses:
        plain = re.sub(r"[^\w.-]+", "_", analysis.name).strip("._")[:80] or "run"
        name, count = plain, 2
        while name in names:
            name, count = f"{plain}-{count}", count + 1
        names.append(name)
    return names
