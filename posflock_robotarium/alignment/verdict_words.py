"""Numbers in the sentences of verdicts: no more digits than are known."""

from __future__ import annotations

import math


def gamma_text(gamma: float) -> str:
    """Return γ in words.

    Parameters
    ----------
    gamma : float
        From -1 to 1; NaN reads as undefined.
    """
    if math.isnan(gamma):
        return "undefined"
    # 0.9996 must not read as a perfect 1.000.
    return f"{gamma:.5f}" if 0.9995 <= gamma < 0.999995 else f"{gamma:.3f}"


def share_text(share: float) -> str:
    """Return a share in per cent; what is nearly nothing or nearly all is said to be so.

    Parameters
    ----------
    share : float
        From 0 to 1.
    """
    percent = 100.0 * share
    if 0 < percent < 1 or 99 < percent < 100:
        return (
            f"{percent:.1f} %"
            if 0.05 <= percent < 99.95
            else ("under 0.1 %" if percent < 1 else "over 99.9 %")
        )
    return f"{percent:.0f} %"


def since_text(seconds: float, drive: float) -> str:
    """Return since when something holds, and from where that is counted.

    Parameters
    ----------
    seconds : float
        Since the experiment began.
    drive : float
        Seconds of the log before that, in which robots drove to the start; 0 where there are none.
    """
    return f"from {seconds:.1f} s {'after the drive to the start' if drive else 'on'}"


def bias_text(bias: float) -> str:
    """Return by how much γ is under-read, in one digit.

    Parameters
    ----------
    bias : float
        Of γ.
    """
    return f"about {bias:.1g}" if bias >= 1e-4 else "less than 0.0001"


def angle_text(radians: float) -> str:
    """Return a small angle in degrees, in two digits.

    Parameters
    ----------
    radians : float
        The angle, rad.
    """
    degrees = math.degrees(radians)
    return f"{degrees:.2g}°" if degrees >= 0.001 else "less than 0.001°"


def length_text(metres: float) -> str:
    """Return a small length in millimetres.

    Parameters
    ----------
    metres : float
        The length, m.
    """
    return f"{1000 * metres:.2f} mm" if metres >= 5e-6 else "below 0.01 mm"
