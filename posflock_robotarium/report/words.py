"""Numbers as people read them: three significant figures, the right unit, no false precision."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

LEAST_LENGTH = 5e-6
"""Metres below which a length is as good as none: nothing on the testbed is known so well."""


def number_text(value: float, unit: str = "") -> str:
    """Return a number with its unit, for tables and pages.

    Parameters
    ----------
    value : float
        NaN reads as a dash: undefined.
    unit : str
        ``share`` is shown in per cent; lengths below a centimetre in millimetres, angles in
        degrees too. Of lengths below `LEAST_LENGTH` no digits are told.

    Examples
    --------
    >>> number_text(0.0004871, "m")
    '0.487 mm'
    >>> number_text(7.61e-13, "m"), number_text(7.61e-10, "m/s")
    ('< 0.01 mm', '7.61·10⁻¹⁰ m/s')
    >>> number_text(0.5, "share")
    '50.0 %'
    >>> number_text(float("nan"))
    '–'
    """
    if value is None or math.isnan(value):
        return "–"
    if unit == "share":
        return f"{100 * value:.1f} %"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if unit == "m" and 0 < value < LEAST_LENGTH:
        return "< 0.01 mm"
    if unit == "m" and 0 < abs(value) < 0.01:
        return f"{_significant(1000 * value)} mm"
    if unit == "rad":
        return f"{_significant(value)} rad ({_significant(math.degrees(value))}°)"
    return f"{_significant(value)} {unit}".strip()


def numbers_text(values: Sequence[float], unit: str = "") -> list[str]:
    """Return numbers that are compared, in one unit and with one number of decimals.

    Parameters
    ----------
    values : sequence of float
        A row of a table; NaN reads as a dash.
    unit : str
        As of `number_text`.

    Examples
    --------
    >>> numbers_text([0.5, 0.12345], "m")
    ['0.500 m', '0.123 m']
    >>> numbers_text([3, 12])
    ['3', '12']
    """
    form = _form(values, unit) if len(values) > 1 else None
    return [number_text(v, unit) if form is None else form.text(v) for v in values]


def target_text(limit: float, unit: str) -> str:
    """Return what stands at the line of a target.

    Parameters
    ----------
    limit : float
        What the metric is held against.
    unit : str
        Of the metric; empty for pure numbers.

    Examples
    --------
    >>> target_text(0.05, "m"), target_text(0.9, "share")
    ('target 0.05 m', 'target 90 %')
    """
    value, unit = (100 * limit, "%") if unit == "share" else (limit, unit)
    return f"target {value:g} {unit}".strip()


def difference_text(difference: float, beside: Sequence[float], unit: str = "") -> str:
    """Return how far two numbers of a row are apart, in the unit and decimals of the row.

    Parameters
    ----------
    difference : float
        NaN reads as a dash.
    beside : sequence of float
        The numbers of the row.
    unit : str
        As of `number_text`; shares differ by percentage points.

    Examples
    --------
    >>> difference_text(-0.021, [0.5, 0.479], "share")
    '−2.1 percentage points'
    """
    if math.isnan(difference):
        return "–"
    if unit == "share":
        return f"{_Form('', 100.0, 1).text(difference)} percentage points"
    form = _form(beside, unit)
    return number_text(difference, unit) if form is None else form.text(difference)


@dataclass(frozen=True)
class _Form:
    """How all numbers of a row are written: in which unit, and with how many decimals."""

    unit: str
    scale: float
    decimals: int

    def text(self, value: float) -> str:
        if math.isnan(value):
            return "–"
        if math.isinf(value):
            return "∞" if value > 0 else "−∞"
        text = self._digits(self.scale * value, self.decimals)
        if self.unit == "rad":
            degrees = self._digits(math.degrees(value), max(0, self.decimals - 2))
            return f"{text} rad ({degrees}°)"
        return f"{text} {self.unit}".strip()

    @staticmethod
    def _digits(value: float, decimals: int) -> str:
        text = f"{value:.{decimals}f}"
        return text.lstrip("-") if float(text) == 0 else text.replace("-", "−")


def _form(values: Sequence[float], unit: str) -> _Form | None:
    """Return how to write a row; None where each number is best written for itself."""
    sizes = [abs(float(v)) for v in values if math.isfinite(v) and v != 0]
    if unit == "share" or not sizes or max(sizes) >= 1e5 or max(sizes) < 1e-4:
        return None
    if unit == "m" and max(sizes) < 0.01:
        return _Form("mm", 1e3, _decimals([1e3 * size for size in sizes]))
    return _Form(unit, 1.0, _decimals(sizes))


def _decimals(sizes: Sequence[float]) -> int:
    """Return decimals that show three digits of the least, but hardly more of the greatest."""
    if all(size.is_integer() for size in sizes):
        return 0
    if any(0.9995 <= size < 1 for size in sizes):
        return 6  # γ close to 1: the nines are the message
    least, greatest = (
        max(0, 2 - math.floor(math.log10(size))) for size in (min(sizes), max(sizes))
    )
    return min(least, greatest + 1)


def _significant(value: float) -> str:
    if value == 0:
        return "0"
    if float(value).is_integer() and abs(value) < 1e6:
        return str(int(value)).replace("-", "−")
    if 0.9995 <= abs(value) < 1:
        return f"{value:.6f}".replace("-", "−")  # γ close to 1: the nines are the message
    size = abs(value)
    if size >= 1e5 or size < 1e-4:
        mantissa, exponent = f"{value:.2e}".split("e")
        return f"{mantissa}·10{str(int(exponent)).translate(SUPERSCRIPTS)}".replace("-", "−")
    digits = max(0, 3 - 1 - math.floor(math.log10(size)))
    return f"{value:.{digits}f}".replace("-", "−")


def unbroken(text: str) -> str:
    r"""Return a sentence in which no line ends between a number and its unit.

    Parameters
    ----------
    text : str
        Words with numbers and units in them.

    Examples
    --------
    >>> unbroken("93 % of 120.0 s") == "93\u00a0% of 120.0\u00a0s"
    True
    """
    return re.sub(r"(?<=\d) (?=(?:%|mm|m|s|m/s|rad/s)(?![\w/]))", "\u00a0", text)
