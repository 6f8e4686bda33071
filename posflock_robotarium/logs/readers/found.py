"""What a reader is told about a file, and what it finds in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.readers.layouts import COLUMN_ORDERS

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ReadOptions:
    """What the user says about a file that does not say it itself.

    Parameters
    ----------
    layout : str, optional
        Axes of the array, one of ``T,3,N``, ``3,N,T``, ``T,N,3``, ``T,3N``, ``3N,T``.
    columns : str, optional
        ``state`` (x1…xN, y1…yN, …), ``robot`` (x1, y1, θ1, x2, …) or the names of all columns.
    dt : float, optional
        Seconds between samples, for files without time.
    array : str, optional
        Which array of a file with several holds the poses.
    drop_damaged : bool
        Leave rows with values that are not finite out, and keep their place as a gap.
    """

    layout: str | None = None
    columns: str | None = None
    dt: float | None = None
    array: str | None = None
    drop_damaged: bool = False

    def __post_init__(self) -> None:
        if self.dt is not None and not (np.isfinite(self.dt) and self.dt > 0):
            raise ParameterError(f"--dt is {self.dt}; expected seconds between samples, above 0")

    @property
    def order(self) -> str | None:
        """The column order, when `columns` is one and not a list of names."""
        return self.columns if self.columns in COLUMN_ORDERS else None


@dataclass(frozen=True)
class Found:
    """Poses as found in a file, before anything is checked."""

    t: Floats | None
    poses: Floats
    notes: tuple[str, ...]
    commands: Floats | None = None
    dt: float | None = None
    steps: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """What the certificate did at each step: ``intervention``, ``clearance``, ``status`` (T,)."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
