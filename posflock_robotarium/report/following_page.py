"""The section of the page on commanded and achieved motion: drawings as SVG, and a table.

The drawings are made here, not by the page's scripts: they are few points and never change. They
hold numbers and words of ours alone, nothing that a log could smuggle in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from posflock_robotarium.alignment.following import Following, Response
from posflock_robotarium.calibration.estimate import Estimate
from posflock_robotarium.report.following_figure import gain_words

_WIDTH, _HEIGHT = 340, 250
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 20, 8, 40
_ROW = 19
_NONE = "none"


@dataclass(frozen=True)
class RobotRow:
    """One robot in the table.

    Attributes
    ----------
    robot : int
        Its number, from 0.
    speed, turn : str
        Gain and interval, or why there is none.
    """

    robot: int
    speed: str
    turn: str


@dataclass(frozen=True)
class Drawing:
    """One drawing of the section.

    Attributes
    ----------
    title : str
        What people read above it.
    words : str
        What it shows, for those who do not see it.
    svg : str
        The drawing, without any text from a log.
    """

    title: str
    words: str
    svg: str


@dataclass(frozen=True)
class FollowingSection:
    """What the page shows of commanded and achieved motion.

    Attributes
    ----------
    summary : str
        Where the gains come from, in a sentence.
    drawings : tuple of Drawing
        Speed, turn rate and gains.
    rows : tuple of RobotRow
        The gains in numbers, a row a robot.
    notes : tuple of str
        What must be known before the gains are believed.
    """

    summary: str
    drawings: tuple[Drawing, ...]
    rows: tuple[RobotRow, ...]
    notes: tuple[str, ...]

    @property
    def undetermined(self) -> bool:
        """Whether a robot has no gain, so that the table says why."""
        return any(_NONE in (row.speed[:4], row.turn[:4]) for row in self.rows)


def following_section(found: Following | None) -> FollowingSection | None:
    """Return what the page shows; None of a log without commands.

    Parameters
    ----------
    found : Following or None
        How robots followed their commands.
    """
    if found is None:
        return None
    if found.refused:
        return FollowingSection(f"No gains: {found.refused}.", (), (), found.notes)
    late = [
        f"{words} {1e3 * estimate.value:.0f} ms"
        for words, estimate in (("dead time", found.dead_time), ("lag", found.lag))
        if estimate is not None
    ]
    summary = (
        f"Fitted to {found.last - found.first:.0f} s from {found.first:.1f} s on, where commands "
        "vary most"
        + (f": {', '.join(late)}. " if late else "; dead time and lag are not determined. ")
        + "A gain of 1 is what was told, 0.7 means 0.7 of it: slower wheels, or steps that were "
        "longer than the log says. Commands are taken with dead time and lag."
    )
    drawings = (
        _scatter(found.speed, "Speed", "m/s", "c0"),
        _scatter(found.turn, "Turn rate", "rad/s", "c1"),
        _gains(found),
    )
    rows = tuple(
        RobotRow(n, _cell(speed), _cell(turn))
        for n, (speed, turn) in enumerate(zip(found.speed, found.turn, strict=True))
    )
    notes = tuple(f"{note[0].upper()}{note[1:]}." for note in found.notes)
    if notes and found.first > 0:
        summary += f" Times below count from {found.first:.1f} s."
    return FollowingSection(summary, drawings, rows, notes)


def _cell(response: Response) -> str:
    gain = response.gain
    return f"{_NONE}: {response.reason}" if gain is None else _interval(gain)


def _interval(gain: Estimate) -> str:
    return f"{gain.value:.3f} ({gain.low:.3f} to {gain.high:.3f})"


def _scatter(responses: Sequence[Response], title: str, unit: str, tone: str) -> Drawing:
    """Draw achieved over commanded: a thin line a robot, what was told, and the median gain."""
    values = [v for response in responses for v in (*response.commanded, *response.achieved)]
    low, high = min([0.0, *values]), max([1e-3, *values])
    right, bottom = _WIDTH - _RIGHT, _HEIGHT - _BOTTOM

    def x(value: float) -> float:
        return _LEFT + (value - low) / (high - low) * (right - _LEFT)

    def y(value: float) -> float:
        return bottom - (value - low) / (high - low) * (bottom - _TOP)

    parts = []
    for tick in _ticks(low, high):
        parts += [
            f'<line class="rule" x1="{x(tick):.1f}" x2="{x(tick):.1f}" y1="{_TOP}" y2="{bottom}"/>',
            f'<line class="rule" x1="{_LEFT}" x2="{right}" y1="{y(tick):.1f}" y2="{y(tick):.1f}"/>',
            _text(x(tick), bottom + 14, _number(tick), "middle"),
            _text(_LEFT - 5, y(tick) + 4, _number(tick), "end"),
        ]
    ends = f"M{x(low):.1f},{y(low):.1f}L{x(high):.1f},{y(high):.1f}"
    parts.append(f'<path class="told" d="{ends}"/>')
    for response in responses:
        places = [
            f"{x(told):.1f},{y(did):.1f}"
            for told, did in zip(response.commanded, response.achieved, strict=True)
        ]
        if places:
            parts.append(f'<path class="robot {tone}" d="M{"L".join(places)}"/>')
            parts += [
                f'<circle class="{tone}" cx="{place.split(",")[0]}" cy="{place.split(",")[1]}" '
                'r="1.8"/>'
                for place in places
            ]
    gains = [response.gain.value for response in responses if response.gain is not None]
    if gains:
        gain = float(np.median(gains))
        line = f"M{x(low):.1f},{y(gain * low):.1f}L{x(high):.1f},{y(gain * high):.1f}"
        parts.append(f'<path class="gain" d="{line}"/>')
    parts += [
        _text((_LEFT + right) / 2, _HEIGHT - 8, f"commanded ({unit})", "middle"),
        _text(_LEFT + 6, _TOP + 12, f"achieved ({unit})", "start"),
        _text(x(high) - 26, y(high) + 12, "as told", "end"),
    ]
    words = f"{title}: achieved over commanded, {gain_words(responses)}; dashed, as told."
    return Drawing(f"{title}: {gain_words(responses)}", words, _svg(parts, _HEIGHT, words))


def _gains(found: Following) -> Drawing:
    """Draw the gains and their intervals, a row a robot."""
    estimates = [r.gain for r in (*found.speed, *found.turn) if r.gain is not None]
    low = min([0.6, *(gain.low for gain in estimates)])
    high = max([1.2, *(gain.high for gain in estimates)])
    robots, right = len(found.speed), _WIDTH - _RIGHT
    bottom = _TOP + _ROW * robots
    height = bottom + _BOTTOM

    def x(value: float) -> float:
        return _LEFT + (value - low) / (high - low) * (right - _LEFT)

    parts = []
    for tick in _ticks(low, high):
        kind = "told" if tick == 1 else "rule"
        parts += [
            f'<line class="{kind}" x1="{x(tick):.1f}" x2="{x(tick):.1f}" y1="{_TOP}" '
            f'y2="{bottom}"/>',
            _text(x(tick), bottom + 14, _number(tick), "middle"),
        ]
    for row in range(robots):
        middle = _TOP + _ROW * (row + 0.5)
        parts.append(_text(_LEFT - 8, middle + 4, str(row), "end"))
        for response, tone, above in ((found.speed[row], "c0", -4), (found.turn[row], "c1", 4)):
            if response.gain is None:
                continue
            gain, at = response.gain, middle + above
            parts += [
                f'<path class="robot wide {tone}" d="M{x(gain.low):.1f},{at}H{x(gain.high):.1f}"/>',
                f'<circle class="{tone}" cx="{x(gain.value):.1f}" cy="{at}" r="3"/>'
                if tone == "c0"
                else f'<rect class="{tone}" x="{x(gain.value) - 2.6:.1f}" y="{at - 2.6}" '
                'width="5.2" height="5.2"/>',
            ]
    parts.append(_text((_LEFT + right) / 2, height - 8, "gain, 99 % interval", "middle"))
    words = "The gain of every robot with its 99 % interval; the table holds the numbers."
    return Drawing("Gain of each robot: ● speed, ■ turn rate", words, _svg(parts, height, words))


def _svg(parts: Sequence[str], height: float, words: str) -> str:
    return (
        f'<svg viewBox="0 0 {_WIDTH} {height}" role="img" aria-label="{words}">'
        f"{''.join(parts)}</svg>"
    )


def _text(x: float, y: float, words: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>'


def _ticks(low: float, high: float) -> list[float]:
    """Return round numbers within two ends, three to seven of them."""
    step = 10 ** np.floor(np.log10(high - low))
    step *= next(part for part in (2.0, 1.0, 0.5, 0.2) if (high - low) / (part * step) >= 3)
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return [float(np.round(k * step, 10)) for k in np.arange(first, last + 1)]


def _number(value: float) -> str:
    return f"{value + 0.0:.4g}".replace("-", "−")
