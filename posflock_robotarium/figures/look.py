"""What tells one curve from another: colour, dash and marker, so that print needs no colour."""

from __future__ import annotations

from dataclasses import dataclass

Dash = str | tuple[int, tuple[float, ...]]
"""A line style as matplotlib takes it; "" draws no line."""


@dataclass(frozen=True)
class Look:
    """How a curve is drawn.

    Attributes
    ----------
    colour : str
        One of `figures.style`.
    dash : str or (offset, on and off lengths)
        Line style as matplotlib takes it; "" draws markers alone.
    marker : str
        At its points, as matplotlib names it.
    """

    colour: str
    dash: Dash = "-"
    marker: str = ""
