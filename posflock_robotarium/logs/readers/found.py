"""What a reader is told about a file, and what it finds in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.layouts import COLUMN_ORDERS
from posflock_robotarium.logs.robots import NOTHING_GIVEN, GivenRobot

Floats = NDArray[np.float64]


class LogClock(Enum):
    """Which times are used: the file's own, none of it, or its real time beside them."""

    FILE = "file"
    NONE = "none"
    REAL = "real"


class Lengths(Enum):
    """What lengths may be in."""

    M = "m"
    CM = "cm"
    MM = "mm"


@dataclass(frozen=True)
class ReadOptions:
    """What the user says about a file that does not say it itself.

    Parameters
    ----------
    layout : str, optional
        Axes of the array, one of ``T,3,N``, ``3,N,T``, ``T,N,3``, ``T,3N``, ``3N,T``,
        ``T,5N``, ``5N,T``.
    columns : str, optional
        ``state`` (x1…xN, y1…yN, …), ``robot`` (x1, y1, θ1, x2, …) or the names of all columns.
    dt : float, optional
        Seconds between samples, for files without time or with times that are none.
    array : str, optional
        Which array of a file with several holds the poses.
    drop_damaged : bool
        Leave rows with values that are not finite out, and keep their place as a gap.
    bounds : Bounds
        How large the file may be.
    clock : LogClock
        Whether the file's own times are used, or its real time in their place.
    units : Lengths, optional
        What lengths are in, where the file does not say it.
    degrees : bool
        Whether angles are in degrees, where the file does not say it.
    given : GivenRobot
        What the user says of robot and arena, whatever the log says.
    fix_swaps : bool
        Whether robots that are taken for each other get their own poses back.

    Raises
    ------
    ParameterError
        Where `dt` is not finite, or not above 0.
    """

    layout: str | None = None
    columns: str | None = None
    dt: float | None = None
    array: str | None = None
    drop_damaged: bool = False
    bounds: Bounds = BOUNDS
    clock: LogClock = LogClock.FILE
    units: Lengths | None = None
    degrees: bool = False
    given: GivenRobot = NOTHING_GIVEN
    fix_swaps: bool = False

    def __post_init__(self) -> None:
        if self.dt is not None and not (np.isfinite(self.dt) and self.dt > 0):
            raise ParameterError(f"--dt is {self.dt}; expected seconds between samples, above 0")

    @property
    def order(self) -> str | None:
        """The column order, when `columns` is one and not a list of names."""
        return self.columns if self.columns in COLUMN_ORDERS else None


@dataclass(frozen=True)
class Found:
    """Poses as found in a file, before they are checked.

    Attributes
    ----------
    t : (T,) array, optional
        Seconds; None where the file has no times.
    poses : (T, 3, N) array
        x, y in metres and heading in radians.
    notes : tuple of str
        How the file was read, one sentence a decision.
    commands : (T, 2, N) array, optional
        Commanded linear (m/s) and angular (rad/s) velocity.
    dt : float, optional
        Seconds between samples, where the file says it instead of times.
    intervention, clearance : (T,) array, optional
        What the certificate changed (m/s), and how far the team was from being unsafe (m), at each
        step, as `Run` has them.
    status : (T,) array of str, optional
        What the certificate answered at each step, as `Run` has it.
    real_time : (T,) array, optional
        Seconds by the clock at which each row was written, NaN where unknown.
    parameters : mapping
        What the file says about the run.
    promised : int, optional
        Rows that the file says were written into it.
    lengths_told, angles_told : bool
        Whether the file itself says what its lengths and angles are in, and they were converted.
    """

    t: Floats | None
    poses: Floats
    notes: tuple[str, ...]
    commands: Floats | None = None
    dt: float | None = None
    intervention: Floats | None = None
    clearance: Floats | None = None
    status: NDArray[np.str_] | None = None
    real_time: Floats | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    promised: int | None = None
    lengths_told: bool = False
    angles_told: bool = False

    def noted(self, note: str) -> Found:
        """Return the same with one more note.

        Parameters
        ----------
        note : str
            How the file was read: one sentence, one decision.
        """
        return replace(self, notes=(*self.notes, note))

    def rows(self, chosen: slice | NDArray[np.bool_] | NDArray[np.intp]) -> Found:
        """Return some of the samples, of every column.

        Parameters
        ----------
        chosen : slice, (T,) boolean array or (k,) integer array
            Which samples stay, and in which order.
        """

        def of(column: NDArray[Any] | None) -> Any:
            return None if column is None else column[chosen]

        return replace(
            self,
            t=of(self.t),
            poses=self.poses[chosen],
            commands=of(self.commands),
            intervention=of(self.intervention),
            clearance=of(self.clearance),
            status=of(self.status),
            real_time=of(self.real_time),
        )
