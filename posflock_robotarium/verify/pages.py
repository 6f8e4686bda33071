"""A verify report as files: ``verify.json`` for programs, ``verify.html`` for people."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.logs.readers.beside import VERDICT
from posflock_robotarium.verify.findings import count
from posflock_robotarium.verify.terminal import figure_lines
from rps_compat.testbed import GTERNAL
from rps_compat.violations import FaultKind
from rps_compat.whole_files import remove_earlier, write_whole, written_together

if TYPE_CHECKING:
    from posflock_robotarium.verify import Report

#: Names of the two files.
NAMES = (VERDICT, "verify.html")

#: Centres this near are a collision when robots face each other.
_COLLISION = GTERNAL.collision_diameter + 2 * GTERNAL.collision_offset


def write_report(report: Report, folder: Path) -> list[Path]:
    """Write ``verify.json`` and ``verify.html`` and return their paths.

    Parameters
    ----------
    report : Report
        What is written.
    folder : Path
        Where; made if it is not there.

    Raises
    ------
    OutputError
        Where that is not possible.
    """
    data = json.dumps(report.as_dict(), indent=1, allow_nan=False) + "\n"
    with written_together(folder) as draft:
        for name, content in zip(NAMES, (data, html(report)), strict=True):
            write_whole(draft / name, content)
    return [folder / name for name in NAMES]


def forget_report(folder: Path) -> None:
    """Remove the report of an earlier call: its verdict is not that of the one that begins.

    Parameters
    ----------
    folder : Path
        Where `write_report` wrote; it need not be there.

    Raises
    ------
    OutputError
        Where an earlier report cannot be removed.
    """
    remove_earlier(folder, NAMES)


def html(report: Report) -> str:
    """Return the report as one self-contained page.

    Parameters
    ----------
    report : Report
        What the page shows.
    """
    from jinja2 import Environment, PackageLoader

    environment = Environment(
        loader=PackageLoader("posflock_robotarium.verify", "assets"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("verify.html.j2").render(
        report=report,
        findings=[(finding, finding.code.about) for finding in report.findings],
        figures=figure_lines(report),
        trials=count(len(report.trials), "trial"),
        strip=_strip(report),
    )


@dataclass(frozen=True)
class _Dot:
    """The smallest gap of one run: where it is drawn, in pixels, and what is told of it."""

    x: float
    y: int
    name: str
    gap: float
    hit: bool


@dataclass(frozen=True)
class _Strip:
    """The smallest gap of every run on a line, with the collision distance; pixels."""

    dots: list[_Dot]
    limit: float
    ticks: list[tuple[float, str]]


def _strip(report: Report) -> _Strip | None:
    """Lay the smallest gaps on a line; None where no run has one."""
    runs = [ran.outcome for ran in [report.ideal, *report.trials] if ran is not None]
    gaps = [(run, run.smallest_gap.metres) for run in runs if run.smallest_gap is not None]
    if not gaps:
        return None
    right = max(0.40, max(gap for _, gap in gaps) * 1.1)

    def across(metres: float) -> float:
        return round(float(20 + 600 * metres / right), 1)

    return _Strip(
        dots=[
            _Dot(
                across(gap), 66 - 9 * (k % 4), run.name, gap, bool(run.faults(FaultKind.COLLISION))
            )
            for k, (run, gap) in enumerate(gaps)
        ],
        limit=across(_COLLISION),
        ticks=[(across(k / 10), f"{k / 10:.1f}") for k in range(int(right * 10) + 1)],
    )
