"""Numbers as people read them: three significant figures, the right unit, no false precision."""

from __future__ import annotations

import math
import re


def number_text(value: float, unit: str = "") -> str:
    """Return a number with its unit, for tables and pages.

    Parameters
    ----------
    value : float
        NaN reads as a dash: undefined.
    unit : str
        ``share`` is shown in per cent; lengths below a centimetre in millimetres, angles in
        degrees too.

    Examples
    --------
    >>> number_text(0.0004871, "m")
    '0.487 mm'
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
    if unit == "m" and 0 < abs(value) < 0.01:
        return f"{_significant(1000 * value)} mm"
    if unit == "rad":
        return f"{_significant(value)} rad ({_significant(math.degrees(value))}°)"
    return f"{_significant(value)} {unit}".strip()


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
        return f"{mantissa}·10^{int(exponent)}".replace("-", "−")
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
