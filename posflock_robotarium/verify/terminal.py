"""A verify report for the terminal: a table where there is one, plain lines where not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from barrier_certificates import ties
from posflock_robotarium.verify.findings import Code, Verdict, count, interval_text
from rps_compat.terminal import printable

if TYPE_CHECKING:
    from rich.console import Console

    from posflock_robotarium.verify import Ablation, Report

_COLOURS = {Verdict.PASS: "green", Verdict.RISK: "yellow", Verdict.FAIL: "red", Verdict.NOTE: "dim"}


def print_report(report: Report, console: Console) -> None:
    """Print verdict, figures and findings.

    Parameters
    ----------
    report : Report
        What is printed.
    console : Console
        Where.
    """
    from rich.table import Table

    colour = _COLOURS[report.verdict]
    console.print(
        f"[bold {colour}]{report.verdict.name}[/]  {_shown(report.script.name)}"
        f"  [dim]generation {report.generation}, {count(len(report.trials), 'trial')} under"
        f" {_shown(report.profile)}[/]"
    )
    for name, words in figure_lines(report):
        console.print(f"  {name:<10} {_shown(words)}", highlight=False)
    if not report.findings:
        console.print("  Nothing to mend.")
        return
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False, pad_edge=False)
    for heading in ("", "what", "where", "why, and what to do"):
        table.add_column(heading, overflow="fold")
    for finding in report.findings:
        text = _shown(finding.message)
        if finding.advice:
            text += f"\n[dim]→ {_shown(finding.advice)}[/]"
        shade = _COLOURS[finding.verdict]
        table.add_row(
            f"[{shade}]{finding.verdict.name}[/]", finding.code.value, _shown(finding.where), text
        )
    console.print()
    console.print(table)


def _shown(text: str) -> str:
    """Return text that commands neither rich nor the terminal: it may be a script's."""
    from rich.markup import escape

    return escape(printable(text))


def figure_lines(report: Report) -> list[tuple[str, str]]:
    """Return the figures of a report in words, each with its name.

    Parameters
    ----------
    report : Report
        What verify found, with the ideal run if there was one.
    """
    held = [] if report.containment is None else [("held by", report.containment.about)]
    found = report.figures
    if found is None:
        return held
    lines = [
        (
            "duration",
            f"{found.run_seconds:.0f} s, after a drive to the initial conditions of"
            f" {found.drive}: declare {found.recommended_duration:.0f} s"
            + _declared(report.declared, found.run_seconds + found.drive.most),
        )
    ]
    if (loop := found.loop) is not None:
        lines.append(
            (
                "loop",
                f"p50 {1000 * loop.p50:.1f} ms, p99 {1000 * loop.p99:.1f} ms, longest"
                f" {1000 * loop.longest:.1f} ms of the 33 ms a step has (this machine's CPU time)",
            )
        )
    for label, gap, between in (
        ("gap", found.gap, "centres"),
        ("wall gap", found.wall_gap, "a centre and a wall"),
    ):
        if gap.ideal is not None:
            text = f"at least {gap.ideal:.3f} m between {between} in the ideal run"
            in_trials = "" if gap.trials is None else f", {gap.trials:.3f} m in the trials"
            lines.append((label, text + in_trials))
    for name, runs in ((Code.COLLISION, found.collisions), (Code.BOUNDARY, found.outside)):
        if runs is not None:
            told = "" if runs.interval is None else interval_text(runs.interval)
            lines.append(
                (
                    name.value,
                    f"in {runs.hits} of {count(runs.trials, 'trial')}"
                    + (f" (95 % interval {told} of runs)" if told else ""),
                )
            )
    return [*lines, *held]


def _declared(declared: float | None, longest: float) -> str:
    """Return whether what will be declared is enough, where that is known."""
    if not declared:
        return ""
    verdict = "is enough" if ties.within(longest, declared) else "may be too short"
    return f"; you will declare {declared:.0f} s, which {verdict}"


def print_ablation(rows: Sequence[Ablation], console: Console) -> None:
    """Print how a script fares under each imperfection alone.

    Parameters
    ----------
    rows : sequence of Ablation
        One an imperfection, and one of all of them.
    console : Console
        Where.
    """
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0))
    table.add_column("imperfection alone")
    for heading in ("collisions", "of runs (95 %)", "left arena", "failed", "smallest gap"):
        table.add_column(heading, justify="right")
    for row in rows:
        bad = row.collisions + row.outside + row.failed > 0
        table.add_row(
            f"[red]{row.effect}[/]" if bad else row.effect,
            f"{row.collisions} of {row.trials}",
            interval_text(row.interval),
            *(f"{hits} of {row.trials}" for hits in (row.outside, row.failed)),
            "unknown" if row.gap is None else f"{row.gap:.3f} m",
        )
    console.print(table)
