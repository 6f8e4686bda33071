"""Curves and values as JSON can say them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def statistics(curve: Floats) -> dict[str, float | int]:
    """Return mean, standard deviation, smallest, largest and how many samples are undefined.

    Parameters
    ----------
    curve : (T,) array
        Values over time, NaN where undefined.
    """
    known = curve[np.isfinite(curve)]
    if not known.size:
        return {key: float("nan") for key in ("mean", "sd", "smallest", "largest")} | {
            "undefined": len(curve)
        }
    return {
        "mean": float(known.mean()),
        "sd": float(known.std()),
        "smallest": float(known.min()),
        "largest": float(known.max()),
        "undefined": int(len(curve) - known.size),
    }


def plain_value(value: Any) -> Any:
    """Turn numpy values into JSON's own, and what JSON cannot say (NaN, infinity) into null.

    Parameters
    ----------
    value : object
        Anything; mappings and sequences are gone through, what JSON has no word for is told as str.
    """
    if isinstance(value, Mapping):
        return {str(key): plain_value(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_value(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain_value(value.tolist())
    if isinstance(value, np.generic):
        return plain_value(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return str(value)
