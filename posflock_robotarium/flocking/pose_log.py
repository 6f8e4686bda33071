"""The pose log: what every robot did at every step, safe against any end of the process.

A run of T steps and N robots is two files.  ``NAME.npy`` is a structured array of T rows,
written through a memory map, so that a row is in the operating system's hands the moment
it is appended: a process killed at any step has lost nothing before that step.  Rows not
reached have ``t`` = NaN.  ``NAME.json`` says everything needed to understand or repeat the
run: parameters, seed, versions, and how it ended.

Any program that reads NumPy files reads the log, ``numpy.load("NAME.npy")``; pickles are
never needed.  This module needs numpy alone, because it goes to the testbed.

======================  ============  ====================================================
field of a row          type          meaning
======================  ============  ====================================================
``t``                   float64       seconds since the start, when the poses were read
``pose``                (3, N)        x, y in metres and θ in radians, as read
``command``             (2, N)        v in m/s and ω in rad/s, as sent after reading
``status``              string        what the certificate said: trivial, optimal, relaxed or
                                      failed; empty where unknown, as without a certificate
``intervention``        float64       how far it changed a velocity at most, m/s; NaN unknown
``clearance``           float64       how far the team is from being unsafe, m: the least distance
                                      beyond what the certificate keeps; NaN unknown
======================  ============  ====================================================
"""

from __future__ import annotations

import io
import json
import math
import os
import platform
from importlib import metadata as installed
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike

from posflock_robotarium.flocking.errors import LogError, OutputError, ParameterError

FORMAT = "posflock pose log 2"

#: m/s by which a certificate must change a velocity to count as an intervention.
INTERVENED = 1e-3

_STATUS = "U8"


def row_type(robots: int) -> np.dtype[np.void]:
    """Return the structure of one row.

    Parameters
    ----------
    robots : int
        Number of robots.
    """
    return np.dtype(
        [
            ("t", "f8"),
            ("pose", "f8", (3, robots)),
            ("command", "f8", (2, robots)),
            ("status", _STATUS),
            ("intervention", "f8"),
            ("clearance", "f8"),
        ]
    )


class PoseLog:
    """Write the log of one run, row by row.

    Parameters
    ----------
    path : path
        Where to write, with or without ``.npy``; the folder is made where there is none.
    robots : int
        N, at least 1.
    steps : int
        Rows to make room for.  More may be appended: the file then grows.
    metadata : dict, optional
        Whatever JSON can hold: parameters, seed, time step, API generation.

    Raises
    ------
    OutputError
        Where the files cannot be written; nothing has happened by then.
    ParameterError
        Where `robots` or `steps` is not a positive whole number.

    Examples
    --------
    >>> import numpy as np, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "run"
    >>> with PoseLog(path, robots=2, steps=100) as log:
    ...     log.append(0.0, pose=np.zeros((3, 2)), command=np.zeros((2, 2)))
    >>> np.load(path.with_suffix(".npy"))["t"][: log.rows]
    array([0.])
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        robots: int,
        steps: int,
        metadata: dict[str, Any] | None = None,
    ) -> None:
        for name, value in (("robots", robots), ("steps", steps)):
            if not isinstance(value, (int, np.integer)) or value < 1:
                raise ParameterError(f"{name}: expected a whole number from 1, got {value!r}")
        self.path, self.sidecar = log_paths(path)
        self.rows = 0
        self._robots = int(robots)
        self._metadata = {
            "format": FORMAT,
            "robots": int(robots),
            "units": {"t": "s", "pose": ["m", "m", "rad"], "command": ["m/s", "rad/s"]}
            | {"intervention": "m/s", "clearance": "m"},
            "versions": versions(),
            **(metadata or {}),
        }
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._map = npy.open_memmap(
                self.path, mode="w+", dtype=row_type(self._robots), shape=(int(steps),)
            )
            self._map["t"] = math.nan
            self._describe("running", "")
        except OSError as error:
            raise OutputError(
                f"cannot write the pose log {self.path}: {error.strerror or error};"
                " choose a folder that can be written to"
            ) from error

    def append(
        self,
        t: float,
        pose: ArrayLike,
        command: ArrayLike,
        *,
        status: str = "",
        intervention: float = math.nan,
        clearance: float = math.nan,
    ) -> None:
        """Write the next row.

        Parameters
        ----------
        t : float
            Seconds since the start.
        pose : (3, N) array
            As read, metres and radians.
        command : (2, N) array
            As sent, m/s and rad/s.
        status : str
            What the certificate said; "" unknown.
        intervention, clearance : float
            How far it changed a velocity at most (m/s); how far the team is from being unsafe (m).
            NaN unknown.
        """
        if self.rows == len(self._map):
            self._grow()
        row = self._map[self.rows]
        row["pose"] = pose
        row["command"] = command
        row["status"] = status
        row["intervention"] = intervention
        row["clearance"] = clearance
        row["t"] = t  # last: a row whose time is a number is whole
        self.rows += 1

    def annotate(self, **values: Any) -> None:
        """Add what became known during the run to the description beside the log.

        Parameters
        ----------
        **values
            What to say, by name; anything that JSON can hold.
        """
        self._metadata.update(values)
        ended = self._metadata["ended"]
        self._describe(ended["how"], ended["reason"])

    def close(self, how: str = "finished", reason: str = "") -> None:
        """Flush the rows and record how the run ended; a second call changes nothing.

        Parameters
        ----------
        how : str
            ``finished``, ``interrupted`` or ``failed``.
        reason : str
            In words, for the reader of the report.
        """
        if self._metadata["ended"]["how"] == "running":
            self._map.flush()
            self._describe(how, reason)

    def __enter__(self) -> PoseLog:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.close()
        elif issubclass(kind, KeyboardInterrupt):
            self.close("interrupted", "KeyboardInterrupt: the run was stopped from outside")
        else:
            self.close("failed", f"{kind.__name__}: {error}")

    def _describe(self, how: str, reason: str) -> None:
        """Replace the description in one move, so that no reader ever sees half of it."""
        self._metadata["ended"] = {"how": how, "reason": reason, "rows": self.rows}
        draft = self.sidecar.with_name(self.sidecar.name + ".part")
        draft.write_text(
            json.dumps(self._metadata, indent=1, default=_plain) + "\n", encoding="utf-8"
        )
        os.replace(draft, self.sidecar)

    def _grow(self) -> None:
        """Double the file: first the rows, then the header that admits to them."""
        self._map.flush()
        kind, old = self._map.dtype, len(self._map)
        offset = self._map.offset
        with open(self.path, "r+b") as file:
            file.truncate(offset + 2 * old * kind.itemsize)
        added = np.memmap(
            self.path, dtype=kind, mode="r+", offset=offset + old * kind.itemsize, shape=(old,)
        )
        added["t"] = math.nan
        added.flush()
        header = {"descr": npy.dtype_to_descr(kind), "fortran_order": False, "shape": (2 * old,)}
        draft = io.BytesIO()
        npy.write_array_header_1_0(draft, header)
        # NumPy pads its headers so that the row count may gain digits in place.
        if draft.tell() != offset:
            raise LogError(f"{self.path}: cannot grow beyond {old} rows; ask for more `steps`")
        with open(self.path, "r+b") as file:
            file.write(draft.getvalue())
        self._map = npy.open_memmap(self.path, mode="r+")


def log_paths(path: str | os.PathLike[str]) -> tuple[Path, Path]:
    """Return the paths of the rows and of their description, NAME.npy and NAME.json.

    Parameters
    ----------
    path : path
        NAME, NAME.npy or NAME.json.
    """
    stem = Path(path)
    if stem.suffix in (".npy", ".json"):
        stem = stem.with_suffix("")
    return stem.with_name(stem.name + ".npy"), stem.with_name(stem.name + ".json")


def versions() -> dict[str, str]:
    """Return the versions that a result may depend on: Python and what is installed of ours."""
    found = {"python": platform.python_version()}
    for name in ("posflock-robotarium", "numpy", "scipy"):
        try:
            found[name] = installed.version(name)
        except installed.PackageNotFoundError:
            continue
    return found


def _plain(value: Any) -> Any:
    """Turn numpy's numbers and arrays into what JSON knows."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"metadata: JSON cannot hold {value!r} of type {type(value).__name__}")
