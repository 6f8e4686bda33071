"""``report.html``: one file, no network, every string escaped, under 3 MB.

A content policy names the page's own scripts by their hash: whatever a hostile log might smuggle in
could not run. What those scripts draw is in `page_data`.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from posflock_robotarium import __version__
from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import Number, panels, scalars
from posflock_robotarium.alignment.comparison import Comparison, compare
from posflock_robotarium.alignment.metric_registry import OWN_GROUP
from posflock_robotarium.alignment.target_outcomes import TARGET_GROUP
from posflock_robotarium.alignment.verdicts import headline
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.pages import SHARED_SCRIPTS, SHARED_STYLE, asset
from posflock_robotarium.report.asked_panels import of_flocks
from posflock_robotarium.report.following_page import following_section
from posflock_robotarium.report.page_data import EVENTS_SHOWN, page_data
from posflock_robotarium.report.tables import row_texts
from posflock_robotarium.report.words import number_text, unbroken
from rps_compat.whole_files import write_whole

#: Headings of the table of numbers that are open at first: what somebody looks for.
_OPENED = ("Formation", "Coverage", "Safety", OWN_GROUP, TARGET_GROUP)


def render(analyses: Sequence[Analysis], comparison: Comparison | None = None) -> str:
    """Return the page of one run, or of several overlaid.

    Parameters
    ----------
    analyses : sequence of Analysis
        At least one.
    comparison : Comparison, optional
        Of these runs, when they are several and labels have been given.

    Returns
    -------
    str
        HTML that needs no other file.

    Raises
    ------
    ParameterError
        When there is no run.
    """
    if not analyses:
        raise ParameterError("no run to report")
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("posflock_robotarium.report", "assets"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = number_text
    environment.filters["unbroken"] = unbroken
    environment.filters["drawing"] = _markup
    if comparison is None and len(analyses) > 1:
        comparison = compare(analyses)
    if comparison is not None:
        analyses = comparison.analyses
    shared = [asset(name) for name in SHARED_SCRIPTS]
    scripts = [_own("uPlot.iife.min.js"), *shared, _own("recorded.js"), _own("report.js")]
    title = " · ".join(analysis.name for analysis in analyses[:4])
    if len(analyses) > 4:
        title += f" and {len(analyses) - 4} more"
    return environment.get_template("report.html.j2").render(
        title=title,
        analyses=analyses,
        comparison=comparison,
        groups=_groups(analyses[0]),
        headline=headline(analyses[0].verdicts) if comparison is None else _spoken(comparison),
        faults=_faults(analyses[0]) if comparison is None else [],
        following=following_section(analyses[0].following) if comparison is None else None,
        left_out=analyses[0].sightings.unbelieved[:EVENTS_SHOWN] if comparison is None else (),
        parameters=[_pretty(a) for a in analyses],
        data=_markup(_json(asdict(page_data(analyses)))),
        scripts=[_markup(script) for script in scripts],
        style=_markup(_own("uPlot.min.css") + asset(SHARED_STYLE) + _own("report.css")),
        policy=_policy(scripts),
        licence=_own("uPlot.LICENSE"),
        version=__version__,
        definitions=[
            metric
            for _, drawn in panels()
            for metric in drawn
            if any(metric.key in analysis.curves for analysis in analyses)
        ],
        columns=[
            scalar
            for scalar in scalars().values()
            if scalar.column and any(scalar.key in analysis.numbers for analysis in analyses)
        ],
        opened=(*_OPENED, *(["Alignment"] if of_flocks(analyses) else [])),
        has_neighbours=any(analysis.options.radius is not None for analysis in analyses),
        rows=[]
        if comparison is None
        else [(row.label, row_texts(row, comparison.groups)) for row in comparison.rows],
        intervals=[]
        if comparison is None
        else [
            name
            for name in comparison.groups
            if any(row.by_label[name].low == row.by_label[name].low for row in comparison.rows)
        ],
    )


def write_page(
    analyses: Sequence[Analysis], path: Path, comparison: Comparison | None = None
) -> Path:
    """Write the page.

    Parameters
    ----------
    analyses : sequence of Analysis
        What was computed of each run.
    path : Path
        Where the HTML file is written.
    comparison : Comparison, optional
        Of several runs; None for one.

    Raises
    ------
    OutputError
        When the file cannot be written.
    """
    return write_whole(path, render(analyses, comparison))


def _groups(analysis: Analysis) -> dict[str, list[Number]]:
    groups: dict[str, list[Number]] = {}
    for number in analysis.numbers.values():
        groups.setdefault(number.group, []).append(number)
    return groups


@dataclass(frozen=True)
class _Fault:
    """A row of the page's table of faults; times in seconds, `worst` in metres."""

    kind: str
    robots: str
    start: float
    duration: float
    worst: float


def _faults(analysis: Analysis) -> list[_Fault]:
    t = analysis.recording.t
    return [
        _Fault(
            event.kind,
            " and ".join(map(str, event.robots)),
            float(t[event.first]),
            float(t[event.last] - t[event.first]),
            event.worst,
        )
        for event in analysis.events[:EVENTS_SHOWN]
    ]


def _spoken(comparison: Comparison) -> str:
    outcomes = comparison.outcomes.items()
    if len(outcomes) == 1:
        return f"all {next(iter(comparison.outcomes))}"
    return "; ".join(f"{count} {short}" for short, count in outcomes)


def _pretty(analysis: Analysis) -> str:
    text = json.dumps(dict(analysis.recording.parameters), indent=2, default=str)
    return text if len(text) < 20_000 else text[:20_000] + "\n… (cut)"


def _json(data: object) -> str:
    """Serialise for a script element: nothing in it may end the element or open a comment."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _policy(scripts: Sequence[str]) -> str:
    hashes = " ".join(
        f"'sha256-{base64.b64encode(hashlib.sha256(s.encode()).digest()).decode()}'"
        for s in scripts
    )
    return f"default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src {hashes}"


def _markup(text: str) -> Any:
    from markupsafe import Markup

    # Only for our own assets and for JSON that `_json` has made safe.
    return Markup(text)


def _own(name: str) -> str:
    return asset(name, "posflock_robotarium.report")
