"""``report.html``: one file, no network, every string escaped, under 3 MB.

Poses are embedded as 16-bit steps of the arena (0.05 mm), curves as 32-bit floats. A run too long
for that is thinned by a whole factor, keeping the smallest of distances and the largest of
speeds in each block, and the page says so. A content policy names the page's own scripts
by their hash: whatever a hostile log might smuggle in could not run.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium import __version__
from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import BY_KEY, Panel, panels
from posflock_robotarium.alignment.comparison import Comparison, compare
from posflock_robotarium.alignment.verdicts import headline
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.report.words import number_text, unbroken

Floats = NDArray[np.float64]

LARGEST = 1_900_000
"""Bytes of embedded data, before base64; the finished page stays below 3 MB."""

COMMON_SAMPLES = 1500
"""Samples of the common time axis on which several runs are overlaid."""

EVENTS_SHOWN = 200


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
    if comparison is None and len(analyses) > 1:
        comparison = compare(analyses)
    scripts = [_asset("uPlot.iife.min.js"), _asset("report.js")]
    title = " · ".join(analysis.name for analysis in analyses[:4])
    if len(analyses) > 4:
        title += f" and {len(analyses) - 4} more"
    return environment.get_template("report.html.j2").render(
        title=title,
        analyses=analyses,
        comparison=comparison,
        groups=_groups(analyses[0]),
        headline=headline(analyses[0].verdicts) if comparison is None else _spoken(comparison),
        events=_events(analyses[0]) if comparison is None else [],
        parameters=[_pretty(a) for a in analyses],
        data=_markup(_json(_data(analyses))),
        scripts=[_markup(script) for script in scripts],
        style=_markup(_asset("uPlot.min.css") + _asset("report.css")),
        policy=_policy(scripts),
        licence=_asset("uPlot.LICENSE"),
        version=__version__,
        definitions=[BY_KEY[key] for panel in panels(0.0) for key in panel.curves],
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
    try:
        path.write_text(render(analyses, comparison), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error
    return path


def _data(analyses: Sequence[Analysis]) -> dict[str, Any]:
    budget = LARGEST // len(analyses)
    runs = [_run(analysis, budget) for analysis in analyses]
    shown = panels(analyses[0].robot.collision_diameter)
    if len(analyses) == 1:
        stride = runs[0]["stride"]
        time = analyses[0].recording.t[::stride]
        drawn = [_panel(panel, analyses[0], stride) for panel in shown]
    else:
        last = max(float(a.recording.t[-1] - a.recording.t[0]) for a in analyses)
        time = np.linspace(0.0, last, COMMON_SAMPLES)
        drawn = [_overlay(panel, analyses, time) for panel in shown]
    first = analyses[0].recording
    gaps = first.t[first.gaps].round(4).tolist() if len(analyses) == 1 else []
    return {
        "runs": runs,
        "time": _b64(np.asarray(time, dtype=np.float32)),
        "gaps": gaps,
        "panels": [panel for panel in drawn if panel["series"]],
    }


def _run(analysis: Analysis, budget: int) -> dict[str, Any]:
    recording = analysis.recording
    samples, _, robots = recording.poses.shape
    # A frame is three 16-bit numbers a robot, and the time and the curves at four bytes each.
    frame = 6 * robots + 4 * (1 + len(analysis.curves))
    stride = max(1, math.ceil(samples * frame / budget))
    poses = recording.poses[::stride]
    low = poses[:, :2].min(axis=(0, 2))
    span = np.maximum(poses[:, :2].max(axis=(0, 2)) - low, 1e-6)
    steps = np.empty(poses.shape, dtype=np.uint16)
    scaled = (poses[:, :2] - low[:, np.newaxis]) / span[:, np.newaxis]
    steps[:, :2] = np.rint(scaled * 65534)
    steps[:, 2] = np.rint(np.remainder(poses[:, 2], 2 * np.pi) / (2 * np.pi) * 65534)
    return {
        "name": analysis.name,
        "robots": robots,
        "stride": stride,
        "start": float(recording.t[0]),
        "t": _b64(recording.t[::stride].astype(np.float32)),
        "poses": _b64(steps),
        "low": low.tolist(),
        "span": span.tolist(),
        "arena": list(analysis.robot.boundaries),
        "collision": [analysis.robot.collision_diameter, analysis.robot.collision_offset],
        "radius": np.broadcast_to(np.asarray(analysis.options.radius, float), robots).tolist(),
        "events": [
            {
                "kind": event.kind,
                "robots": list(event.robots),
                "t": float(recording.t[event.first]),
                "end": float(recording.t[event.last]),
            }
            for event in analysis.events[:EVENTS_SHOWN]
        ],
    }


def _panel(panel: Panel, analysis: Analysis, stride: int) -> dict[str, Any]:
    series = [
        _series(BY_KEY[key].label, key, _thinned(_unjoined(analysis.curves[key], key), key, stride))
        for key in panel.curves
        if key in analysis.curves and np.isfinite(analysis.curves[key]).any()
    ]
    return _described(panel, series)


def _overlay(panel: Panel, analyses: Sequence[Analysis], time: Floats) -> dict[str, Any]:
    key = panel.curves[0]
    series = []
    for analysis in analyses:
        if key not in analysis.curves or not np.isfinite(analysis.curves[key]).any():
            continue
        elapsed = analysis.recording.t - analysis.recording.t[0]
        nearest = np.clip(np.searchsorted(elapsed, time), 0, len(elapsed) - 1)
        values = np.where(time <= elapsed[-1], analysis.curves[key][nearest], np.nan)
        series.append(_series(analysis.name, key, values))
    described = _described(panel, series)
    label = BY_KEY[key].label
    described["title"] = label[0].upper() + label[1:] if label[0].isascii() else label
    return described


def _described(panel: Panel, series: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "key": panel.key,
        "title": panel.title,
        "unit": panel.unit,
        "limits": list(panel.limits),
        "lines": [list(line) for line in panel.lines],
        "series": series,
    }


def _series(label: str, key: str, values: Floats) -> dict[str, Any]:
    known = values[np.isfinite(values)]
    extent = (
        [float(known.min()), float(known.mean()), float(known.max())] if known.size else [None] * 3
    )
    return {
        "label": label,
        "key": key,
        "unit": BY_KEY[key].unit,
        "extent": extent,
        "values": _b64(values.astype(np.float32)),
    }


def _unjoined(curve: Floats, key: str) -> Floats:
    """Take out the sample at which an angle jumps by a turn, lest a line be drawn across."""
    if BY_KEY[key].unit != "rad":
        return curve
    jump = np.abs(np.diff(curve, prepend=curve[:1])) > np.pi
    return np.where(jump, np.nan, curve)


def _thinned(curve: Floats, key: str, stride: int) -> Floats:
    """Keep one value a block: the one that matters for this quantity."""
    if stride == 1:
        return curve
    blocks = math.ceil(len(curve) / stride)
    padded = np.concatenate([curve, np.full(blocks * stride - len(curve), np.nan)])
    table = padded.reshape(blocks, stride)
    how = BY_KEY[key].of_interest
    if how == "mean":
        return table[:, 0]
    filler = np.inf if how == "smallest" else -np.inf
    filled = np.where(np.isnan(table), filler, table)
    best = filled.min(axis=1) if how == "smallest" else filled.max(axis=1)
    return np.where(np.isinf(best), np.nan, best)


def _groups(analysis: Analysis) -> dict[str, list[Any]]:
    groups: dict[str, list[Any]] = {}
    for number in analysis.numbers.values():
        groups.setdefault(number.group, []).append(number)
    return groups


def _events(analysis: Analysis) -> list[dict[str, Any]]:
    t = analysis.recording.t
    return [
        {
            "kind": event.kind,
            "robots": " and ".join(str(robot + 1) for robot in event.robots),
            "start": float(t[event.first]),
            "duration": float(t[event.last] - t[event.first]),
            "worst": event.worst,
        }
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


def _b64(array: NDArray[Any]) -> str:
    little = array.astype(array.dtype.newbyteorder("<"), copy=False)
    return base64.b64encode(np.ascontiguousarray(little).tobytes()).decode()


def _json(data: dict[str, Any]) -> str:
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


def _asset(name: str) -> str:
    return (resources.files("posflock_robotarium.report") / "assets" / name).read_text("utf-8")
