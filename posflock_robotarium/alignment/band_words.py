"""What the verdict says of the band around γ: how broad it is, or why there is none."""

from __future__ import annotations

from collections.abc import Mapping

from posflock_robotarium.alignment.estimators import PERSISTENT


def band_sentence(values: Mapping[str, float]) -> str:
    """Return the end of a sentence about γ from motion.

    Parameters
    ----------
    values : mapping of float
        Numbers of the run by their keys.
    """
    if "gamma_band" in values:
        width = values["gamma_band"]
        broad = f"{width:.2g}" if width >= 1e-4 else "less than 0.0001"
        return f"its 95 % band is {broad} broad on average."
    if values.get("noise_persistence", 1.0) > PERSISTENT:
        return (
            "there is no band around it, since noise is carried over from frame to frame: the "
            "poses look filtered or interpolated."
        )
    return "there is no band around it, since noise hides most directions."
