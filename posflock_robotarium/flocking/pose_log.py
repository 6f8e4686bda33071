"""The pose log: what every robot did at every step, safe against any end of the process.

A run of T steps and N robots is two files.  ``NAME.npy`` is a structured array of T rows, each of
which is in the operating system's hands the moment it is appended: a process killed at any step
has lost nothing before that step, and a disk that fills up costs no row that is finished (see
`row_file`).  Of a run that was killed, rows not reached are NaN in every number; otherwise they
are cut off.  ``NAME.json`` says everything needed to understand or repeat the run: parameters,
seed, versions, and how it ended with how many rows; a digest of these tells a reader whether both
files are of one run.

Any program that reads NumPy files reads the log, ``numpy.load("NAME.npy")``; pickles are
never needed.  This module needs numpy alone, because it goes to the testbed.

======================  ============  ====================================================
field of a row          type          meaning
======================  ============  ====================================================
``t``                   float64       seconds since the start, when the poses were read; most
                                      scripts count their steps
``pose``                (3, N)        x, y in metres and θ in radians, as read
``command``             (2, N)        v in m/s and ω in rad/s, as sent after reading
``status``              string        what the certificate said: trivial, optimal, relaxed or
                                      failed; empty where unknown, as without a certificate
``intervention``        float64       how far it changed a velocity at most, m/s; NaN unknown
``clearance``           float64       how far the team is from being unsafe, m: the least distance
                                      beyond what the certificate keeps; NaN unknown
``real_time``           float64       seconds since the log was opened, when the row was written,
                                      on a clock that nobody sets; NaN unknown, as in simulation
======================  ============  ====================================================
"""

from __future__ import annotations

import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import metadata as installed
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.flocking.row_file import RowFile

FORMAT = "posflock pose log 3"

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
            ("real_time", "f8"),
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
    real_time : bool
        Whether rows get the real time at which they are written, and the description the one at
        which the log was opened. Never in simulation, where it would be this computer's; then
        the description says that the run was simulated.

    Raises
    ------
    OutputError
        Where the files cannot be written, or another run is writing them; nothing has happened
        by then.
    ParameterError
        Where `robots` or `steps` is not a positive whole number.

    Examples
    --------
    >>> import numpy as np, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "run"
    >>> with PoseLog(path, robots=2, steps=100) as log:
    ...     log.append(0.0, pose=np.zeros((3, 2)), command=np.zeros((2, 2)))
    >>> rows = np.load(path.with_suffix(".npy"))
    >>> rows["t"], bool(rows["real_time"] >= 0)
    (array([0.]), True)
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        robots: int,
        steps: int,
        metadata: dict[str, Any] | None = None,
        *,
        real_time: bool = True,
    ) -> None:
        for name, value in (("robots", robots), ("steps", steps)):
            if not isinstance(value, (int, np.integer)) or value < 1:
                raise ParameterError(f"{name}: expected a whole number from 1, got {value!r}")
        self.path, self.sidecar = log_paths(path)
        simulated = in_simulation()
        real_time = real_time and not simulated
        self._robots = int(robots)
        self._metadata = {
            "format": FORMAT,
            "robots": int(robots),
            "units": {"t": "s", "real_time": "s", "pose": ["m", "m", "rad"]}
            | {"command": ["m/s", "rad/s"], "intervention": "m/s", "clearance": "m"},
            "versions": versions(),
            **({"opened_at": round(time.time(), 3)} if real_time else {}),
            **({"simulated": True} if simulated else {}),
            **(metadata or {}),
        }
        self._row = _unreached(self._robots)
        self._bytes = self._row.view(np.uint8)
        # Views of its fields: to write through them costs a third of writing to the row.
        self._times, self._real_times = self._row["t"], self._row["real_time"]
        self._statuses = self._row["status"]
        self._pose, self._command = self._row["pose"][0], self._row["command"][0]
        self._interventions, self._clearances = self._row["intervention"], self._row["clearance"]
        self._clock = _stopwatch() if real_time else _no_clock
        with self._told("choose a folder that can be written to"):
            self._file = RowFile(self.path, self._row, int(steps))
            self._describe("running", "")

    @property
    def rows(self) -> int:
        """How many rows were appended."""
        return self._file.rows

    def append(
        self,
        t: float,
        pose: ArrayLike,
        command: ArrayLike,
        *,
        real_time: float | None = None,
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
        real_time : float, optional
            Seconds on another clock; by default the log reads its own.
        status : str
            What the certificate said; "" unknown.
        intervention, clearance : float
            How far it changed a velocity at most (m/s); how far the team is from being unsafe (m).
            NaN unknown.

        Raises
        ------
        OutputError
            The disk takes no more; all rows before are kept.
        LogError
            The log is closed, or was opened by the process that this one was forked from.
        """
        self._times[0], self._statuses[0] = t, status
        self._real_times[0] = self._clock() if real_time is None else real_time
        self._pose[:], self._command[:] = pose, command
        self._interventions[0], self._clearances[0] = intervention, clearance
        try:
            self._file.append(self._bytes)
        except OSError as error:  # without `_told`: this is called in every step
            raise self._failure(error, "the rows before are kept") from error

    def annotate(self, **values: Any) -> None:
        """Add what became known during the run to the description beside the log.

        Parameters
        ----------
        **values
            Whatever JSON can hold, by its name.

        Raises
        ------
        OutputError
            The description cannot be written.
        """
        self._metadata.update(values)
        ended = self._metadata["ended"]
        with self._told("the rows that were appended are kept"):
            self._describe(ended["how"], ended["reason"])

    def close(self, how: str = "finished", reason: str = "") -> None:
        """Keep the rows there are, and record how the run ended; a second call changes nothing.

        Parameters
        ----------
        how : str
            ``finished``, ``interrupted`` or ``failed``.
        reason : str
            In words, for the reader of the report.

        Raises
        ------
        OutputError
            The description cannot be written; the rows are kept.
        """
        if not self._file.is_open:
            return
        try:
            with self._told("the rows that were appended are kept"):
                self._file.finish()
                self.path, self.sidecar = log_paths(self._file.path)
                self._metadata["rows_digest"] = self._file.digest()
                self._describe(how, reason)
        finally:
            self._file.close()

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
        text = json.dumps(self._metadata, indent=1, default=_plain) + "\n"
        self.sidecar.parent.mkdir(parents=True, exist_ok=True)
        draft = self.sidecar.with_name(f"{self.sidecar.name}.{os.getpid()}.part")
        try:
            draft.write_text(text, encoding="utf-8")
            os.replace(draft, self.sidecar)
        except BaseException:
            draft.unlink(missing_ok=True)
            raise

    @contextmanager
    def _told(self, advice: str) -> Iterator[None]:
        """Tell of a failure to write in words."""
        try:
            yield
        except OutputError:
            raise
        except OSError as error:
            raise self._failure(error, advice) from error

    def _failure(self, error: OSError, advice: str) -> OutputError:
        reason = error.strerror or error
        return OutputError(f"cannot write the pose log {self.path}: {reason}; {advice}")


def in_simulation() -> bool:
    """Tell whether the robots of this process are our simulator's: what ``import rps`` means here.

    Of other simulators, and on the testbed, only the one who started the run knows.
    """
    modules = (sys.modules.get("rps.robotarium"), sys.modules.get("rps"))
    return any(getattr(module, "__name__", "").startswith("rps_compat.") for module in modules)


def _unreached(robots: int) -> NDArray[np.void]:
    """Return one row that holds nothing: NaN in every number."""
    row = np.zeros(1, row_type(robots))
    for name in row.dtype.names or ():
        if name != "status":
            row[name] = math.nan
    return row


def _stopwatch() -> Callable[[], float]:
    """Return a clock that tells the seconds since now, to microseconds."""
    # Whole numbers first: the clock counts since the computer's start, and seconds of that would be
    # rounded otherwise on each day.
    began = time.monotonic_ns() - 500
    return lambda: (time.monotonic_ns() - began) // 1000 / 1e6


def _no_clock() -> float:
    return math.nan


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
