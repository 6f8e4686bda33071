"""What the page's scripts draw: poses for the replay and curves for the plots, in few bytes.

Poses are embedded as 16-bit steps of the arena (0.05 mm), curves as 32-bit floats. A run too long
for that is thinned by a whole factor, keeping the smallest of distances and the largest of
speeds in each block, and the page says so.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.catalogue import Metric, Panel, metrics
from posflock_robotarium.figures.look import OF_ESTIMATOR, estimator_of
from posflock_robotarium.report.asked_panels import asked_panels
from posflock_robotarium.report.words import target_text
from rps_compat.violations import FaultKind

Floats = NDArray[np.float64]

LARGEST = 1_900_000
"""Bytes of embedded data, before base64; the finished page stays below 3 MB."""

COMMON_SAMPLES = 1500
"""Samples of the common time axis on which several runs are overlaid."""

EVENTS_SHOWN = 200

UNSEEN_STEP = 65535
"""What stands for a robot that is not seen; the others' steps are smaller."""


@dataclass(frozen=True)
class EventMark:
    """A fault on the time axis of the replay.

    Attributes
    ----------
    kind : FaultKind
        A collision, or a robot outside.
    robots : tuple of int
        Whom it concerns, counted from 0.
    t, end : float
        When it began and when it was over, s.
    """

    kind: FaultKind
    robots: tuple[int, ...]
    t: float
    end: float


@dataclass(frozen=True)
class Replay:
    """One run seen from above.

    Attributes
    ----------
    name : str
        Of the run.
    robots, stride : int
        How many, and every how manieth sample is embedded.
    start : float
        When the experiment began, after the drive to the start, seconds.
    t, poses : str
        Base64 of 32-bit times and of 16-bit poses, `UNSEEN_STEP` where a robot is not seen.
    low, span : list of float
        What the 16-bit positions count from, and over; metres, x and y.
    arena : tuple of float
        Left, right, bottom, top, metres.
    collision : pair of float
        Diameter, and how far ahead of the centre, metres.
    radius : list of float
        Neighbour radius of each robot, metres; empty where it is not known.
    events : tuple of EventMark
        Faults, the first `EVENTS_SHOWN`.
    """

    name: str
    robots: int
    stride: int
    start: float
    t: str
    poses: str
    low: list[float]
    span: list[float]
    arena: tuple[float, ...]
    collision: tuple[float, float]
    radius: list[float]
    events: tuple[EventMark, ...]


@dataclass(frozen=True)
class Series:
    """One line of a plot.

    Attributes
    ----------
    label : str
        Words for the legend; of several runs that are overlaid, the name of the run.
    key : str
        Key of the metric.
    unit : str
        Of the values; empty for pure numbers.
    extent : tuple of float or None
        Least, mean and greatest of the values; None where none is defined.
    values : str
        Base64 of 32-bit values on the time axis of the page, NaN where undefined.
    look : int
        Which colour and dash; the same for one estimator of motion in every plot.
    band : pair of str or None
        The lower and the upper end of its 95 % band, as the values; None where there is no band.
    """

    label: str
    key: str
    unit: str
    extent: tuple[float | None, float | None, float | None]
    values: str
    look: int
    band: tuple[str, str] | None = None


@dataclass(frozen=True)
class Plot:
    """One plot over time, as its `Panel` describes it.

    Attributes
    ----------
    key : str
        What the scripts call the plot.
    title : str
        What people read above it.
    unit : str
        What the vertical axis is in; empty for pure numbers.
    limits : pair of float or None
        Ends of that axis; None where the curves decide.
    lines : tuple of (float, str, bool)
        Levels to hold the curves against, in that unit, what lies there, and whether the axis
        reaches there in any case.
    series : tuple of Series
        The curves; a plot without any is not shown.
    """

    key: str
    title: str
    unit: str
    limits: tuple[float | None, float | None]
    lines: tuple[tuple[float, str, bool], ...]
    series: tuple[Series, ...]


@dataclass(frozen=True)
class Watched:
    """A curve whose value stands beside the replay.

    Attributes
    ----------
    key : str
        Key of the metric, by which the scripts find its `Series`.
    label : str
        Words for people.
    unit : str
        Of the value; empty for pure numbers.
    """

    key: str
    label: str
    unit: str


@dataclass(frozen=True)
class PageData:
    """Everything that the scripts are given.

    Attributes
    ----------
    runs : tuple of Replay
        One, or several that are overlaid.
    time : str
        Base64 of the 32-bit times of all curves, s: as logged of one run, since the start of the
        experiment of several, after the drive to it.
    real_time : str
        Base64 of the 32-bit real times of the samples of one run, s since the first pose; empty
        where it is unknown, and of several runs.
    drive : float or None
        When the drive to the start is over in the log of one run, s; None where none is in it.
    gaps : list of float
        Times at which the log of one run goes on after a gap, s; empty of several runs.
    panels : tuple of Plot
        In reading order, those that have a curve.
    beside_replay : tuple of Watched
        Values that are shown beside the replay of one run; several have none there.
    """

    runs: tuple[Replay, ...]
    time: str
    real_time: str
    drive: float | None
    gaps: list[float]
    panels: tuple[Plot, ...]
    beside_replay: tuple[Watched, ...]


def page_data(analyses: Sequence[Analysis]) -> PageData:
    """Return what is embedded of one run, or of several overlaid.

    Parameters
    ----------
    analyses : sequence of Analysis
        At least one.
    """
    budget = LARGEST // len(analyses)
    runs = tuple(_replay(analysis, budget) for analysis in analyses)
    first = analyses[0]
    gaps: list[float] = []
    real_time, drive = "", None
    if len(analyses) == 1:
        stride = runs[0].stride
        time: Floats = first.recording.t[::stride]
        gaps = first.recording.t[first.recording.gaps].round(4).tolist()
        drive = first.start if first.start > time[0] else None
        if (clock := first.recording.real_time) is not None:
            real_time = _b64((clock - clock[0])[::stride].astype(np.float32))
        drawn = [_plot(panel, shown, first, stride) for panel, shown in asked_panels(analyses)]
    else:
        last = max(float(a.recording.t[-1] - a.start) for a in analyses)
        time = np.linspace(0.0, last, COMMON_SAMPLES, dtype=np.float64)
        drawn = [
            _overlay(panel, shown[0], analyses, time) for panel, shown in asked_panels(analyses)
        ]
    return PageData(
        runs=runs,
        time=_b64(np.asarray(time, dtype=np.float32)),
        real_time=real_time,
        drive=drive,
        gaps=gaps,
        panels=tuple(plot for plot in drawn if plot.series),
        beside_replay=tuple(
            Watched(metric.key, metric.label, metric.unit)
            for metric in metrics().values()
            if metric.beside_replay
        ),
    )


def _courses(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the directions of motion, which stand for headings that nobody logged."""
    ahead = np.diff(positions, axis=0, append=positions[-1:])
    return np.asarray(np.arctan2(ahead[:, 1], ahead[:, 0]))


def _steps_of(poses: Floats, headings: Floats) -> tuple[NDArray[np.uint16], Floats, Floats]:
    """Return poses (T, 3, N) in 16-bit steps, and what these count from and over, m."""
    seen = np.isfinite(poses[:, 0])
    low = np.fmin.reduce(poses[:, :2], axis=(0, 2))
    span = np.maximum(np.fmax.reduce(poses[:, :2], axis=(0, 2)) - low, 1e-6)
    scaled = np.empty(poses.shape)
    scaled[:, :2] = (poses[:, :2] - low[:, np.newaxis]) / span[:, np.newaxis]
    scaled[:, 2] = np.remainder(np.nan_to_num(headings), 2 * np.pi) / (2 * np.pi)
    steps = np.where(seen[:, np.newaxis], np.rint(scaled * (UNSEEN_STEP - 1)), UNSEEN_STEP)
    return steps.astype(np.uint16), low, span


def _replay(analysis: Analysis, budget: int) -> Replay:
    recording, robot = analysis.believed, analysis.robot
    samples, _, robots = recording.poses.shape
    # A frame is three 16-bit numbers a robot, and the time and the curves at four bytes each.
    frame = 6 * robots + 4 * (1 + len(analysis.curves))
    stride = max(1, math.ceil(samples * frame / budget))
    poses = recording.poses[::stride]
    headings = poses[:, 2] if recording.headed else _courses(poses[:, :2])
    steps, low, span = _steps_of(poses, headings)
    return Replay(
        name=analysis.name,
        robots=robots,
        stride=stride,
        start=float(analysis.start),
        t=_b64(recording.t[::stride].astype(np.float32)),
        poses=_b64(steps),
        low=low.tolist(),
        span=span.tolist(),
        arena=tuple(robot.boundaries),
        collision=(robot.collision_diameter, robot.collision_offset),
        radius=[]
        if analysis.options.radius is None
        else np.broadcast_to(np.asarray(analysis.options.radius, float), robots).tolist(),
        events=tuple(
            EventMark(
                event.kind,
                event.robots,
                float(recording.t[event.first]),
                float(recording.t[event.last]),
            )
            for event in analysis.events[:EVENTS_SHOWN]
        ),
    )


def _plot(panel: Panel, shown: Sequence[Metric], analysis: Analysis, stride: int) -> Plot:
    looks = _looks(shown)
    series = [
        replace(
            _series(metric.label, metric, _thinned(metric.unjoined(curve), metric, stride), look),
            band=_band(metric, analysis, stride),
        )
        for metric, look in zip(shown, looks, strict=True)
        if (curve := _known_curve(analysis, metric)) is not None
    ]
    return _described(panel, panel.title, series, analysis, shown)


def _looks(shown: Sequence[Metric]) -> list[int]:
    """Give each curve of a plot a look of its own, those of the estimators the first three."""
    estimators = list(OF_ESTIMATOR)
    known = [estimator_of(metric.key) for metric in shown]
    taken = [estimators.index(name) for name in known if name is not None]
    others = (k for k in count() if k not in taken)
    return [next(others) if name is None else estimators.index(name) for name in known]


def _band(metric: Metric, analysis: Analysis, stride: int) -> tuple[str, str] | None:
    if metric.band is None or not set(metric.band) <= set(analysis.curves):
        return None
    low, high = (
        _b64(_thinned(analysis.curves[end], metric, stride).astype(np.float32))
        for end in metric.band
    )
    return low, high


def _overlay(panel: Panel, metric: Metric, analyses: Sequence[Analysis], time: Floats) -> Plot:
    series = []
    for look, analysis in enumerate(analyses):
        curve = _known_curve(analysis, metric)
        if curve is None:
            continue
        elapsed = analysis.recording.t - analysis.start
        nearest = np.clip(np.searchsorted(elapsed, time), 0, len(elapsed) - 1)
        values = np.where(time <= elapsed[-1], curve[nearest], np.nan)
        series.append(_series(analysis.name, metric, metric.unjoined(values), look))
    label = metric.label
    title = label[0].upper() + label[1:] if label[0].isascii() else label
    return _described(panel, title, series, analyses[0], [metric])


def _known_curve(analysis: Analysis, metric: Metric) -> Floats | None:
    """Return a curve that is defined at some time; None of any other."""
    curve = analysis.curves.get(metric.key)
    return curve if curve is not None and np.isfinite(curve).any() else None


def _described(
    panel: Panel, title: str, series: Sequence[Series], first: Analysis, shown: Sequence[Metric]
) -> Plot:
    lines = tuple((line.level(first.robot), line.label, line.always) for line in panel.lines)
    keys = {metric.key for metric in shown}
    limits = dict.fromkeys((t.limit, t.unit) for t in first.targets if t.metric in keys)
    lines += tuple((limit, target_text(limit, unit), True) for limit, unit in limits)
    return Plot(panel.key, title, panel.unit, panel.limits, lines, tuple(series))


def _series(label: str, metric: Metric, values: Floats, look: int) -> Series:
    known = values[np.isfinite(values)]
    extent = (
        (float(known.min()), float(known.mean()), float(known.max()))
        if known.size
        else (None, None, None)
    )
    return Series(label, metric.key, metric.unit, extent, _b64(values.astype(np.float32)), look)


def _thinned(curve: Floats, metric: Metric, stride: int) -> Floats:
    """Keep one value a block: the one that matters for this metric."""
    if stride == 1:
        return curve
    blocks = math.ceil(len(curve) / stride)
    padded = np.concatenate([curve, np.full(blocks * stride - len(curve), np.nan)])
    table = padded.reshape(blocks, stride)
    if metric.of_interest == "mean":
        first: Floats = table[:, 0]
        return first
    smallest = metric.of_interest == "smallest"
    filled = np.where(np.isnan(table), np.inf if smallest else -np.inf, table)
    best = filled.min(axis=1) if smallest else filled.max(axis=1)
    return np.where(np.isinf(best), np.nan, best)


def _b64(array: NDArray[Any]) -> str:
    little = array.astype(array.dtype.newbyteorder("<"), copy=False)
    return base64.b64encode(np.ascontiguousarray(little).tobytes()).decode()
