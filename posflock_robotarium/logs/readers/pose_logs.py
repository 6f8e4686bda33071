"""Our own pose log: rows up to the last one reached, and the description beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.flocking.pose_log import log_paths, row_type
from posflock_robotarium.flocking.row_file import digest_of
from posflock_robotarium.logs.readers.beside import strangers_beside
from posflock_robotarium.logs.readers.bounds import BOUNDS, Bounds
from posflock_robotarium.logs.readers.forms import Form, Sign
from posflock_robotarium.logs.readers.found import ReadOptions
from posflock_robotarium.logs.readers.named_arrays import floats
from posflock_robotarium.logs.readers.numpy_arrays import SIGNATURE, read_header, read_npy
from posflock_robotarium.logs.readers.parameters import LARGEST, from_json, rows_promised
from posflock_robotarium.logs.real_time import believed
from posflock_robotarium.logs.run import Ending, How, Run, ending_of, missing_rows
from rps_compat.bounded_files import read_bounded

Floats = NDArray[np.float64]

FIELDS = row_type(1).names or ()
_EARLIER = tuple(name for name in FIELDS if name != "real_time")
"""Fields of format 2, which knew no real time."""


def _recognises(file: Path, start: bytes) -> bool:
    if not start.startswith(SIGNATURE):
        return False
    with file.open("rb") as stream:
        shape, kind = read_header(stream, str(file))
    return kind.names in (FIELDS, _EARLIER) and len(shape) == 1


def _read(file: Path, options: ReadOptions) -> Run:
    # It says all else itself: no other option is asked.
    return run_of(file, read_npy(file, options.bounds), options.bounds)


POSE_LOG = Form(
    name="pose log",
    label="our pose log",
    summary="`NAME.npy` with `NAME.json`, also of a run that was killed, interrupted or still goes "
    "on",
    told_by=Sign.CONTENT,
    recognises=_recognises,
    read=_read,
    endings=(".npy",),
)


def run_of(file: Path, rows: NDArray[Any], bounds: Bounds = BOUNDS) -> Run:
    """Read our own log, whether the run ended well, was killed, or still goes on.

    Parameters
    ----------
    file : Path
        The log's file; its description lies beside it.
    rows : (T,) array
        Rows of a pose log, a structured array.
    bounds : Bounds
        How many robots there may be.

    Raises
    ------
    LogError
        When the rows are not those of a pose log, or none was reached.
    """
    if rows["pose"].ndim != 3 or rows["t"].ndim != 1 or rows.dtype["pose"].base.kind != "f":
        raise LogError(f"{file}: fields of a pose log with other shapes, {rows.dtype}")
    robots = rows["pose"].shape[2]
    bounds.require_robots(robots, str(file))
    if rows.dtype.fields is None or rows["command"].shape[1:] != (2, robots):
        raise LogError(f"{file}: {robots} robots and commands of shape {rows['command'].shape[1:]}")
    # A copy: the file may be that of a run that still goes on, and grow while it is read.
    t = floats(np.array(rows["t"]), str(file))
    empty = np.flatnonzero(np.isnan(t))
    reached = int(empty[0]) if empty.size else len(t)
    if reached < len(t) and not np.isnan(t[reached:]).all():
        again = reached + int(np.flatnonzero(~np.isnan(t[reached:]))[0])
        raise LogError(f"{file}: row {reached} has no time, but row {again} has: a damaged log")
    if reached < 2:
        raise LogError(f"{file}: the run reached {reached} step(s); an analysis needs at least 2")
    parameters = _sidecar(log_paths(file)[1])
    notes = [f"pose log, {reached} of {len(t)} rows reached"]
    if not parameters:
        notes.append(f"no {file.with_suffix('.json').name} beside it: parameters unknown")
    elif (ending := ending_of(parameters)) is not None:
        notes += _how_it_ended(ending)
    doubts, sound = _doubts(parameters, rows[:reached], file.with_suffix(".json").name)
    notes += [*sound, *strangers_beside(file, parameters)]
    columns = {
        name: floats(rows[name][:reached], f"{file}: {name}").copy()
        for name in ("pose", "command", "intervention", "clearance")
    }
    real_time, why = _real_time(rows[:reached], t[:reached], parameters, str(file))
    return Run(
        name=_called(file, parameters),
        t=t[:reached].copy(),
        poses=columns["pose"],
        commands=columns["command"],
        intervention=columns["intervention"],
        clearance=columns["clearance"],
        status=_words(rows["status"][:reached]),
        real_time=real_time,
        parameters=parameters,
        notes=(*notes, *why),
        sources=(str(file),),
        doubts=doubts,
    )


def _doubts(
    parameters: dict[str, Any], rows: NDArray[Any], beside: str
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what data and description disagree on, and a note where they agree."""
    doubts = missing_rows(len(rows), rows_promised(parameters))
    digest = parameters.get("rows_digest")
    if doubts or digest is None:
        return doubts, ()
    if digest != digest_of([np.ascontiguousarray(rows).view(np.uint8).data]):
        return (f"the rows are not those that {beside} was written for",), ()
    return (), ("every row is as it was written",)


def _real_time(
    rows: NDArray[Any], t: Floats, parameters: dict[str, Any], where: str
) -> tuple[Floats | None, tuple[str, ...]]:
    """Return the real time of each row, and why there is none where rows hold one."""
    if "real_time" not in (rows.dtype.names or ()):
        return None, ()
    logged = floats(rows["real_time"], f"{where}: real_time").copy()
    if logged.shape != t.shape:
        raise LogError(f"{where}: real_time has shape {logged.shape}, expected {t.shape}")
    found, why = believed(logged, t, parameters.get("simulated") is True)
    return found, (why,) if why else ()


def _how_it_ended(ending: Ending) -> list[str]:
    """Return a note on a run that did not end by itself."""
    if ending.how is How.FINISHED:
        return []
    if ending.how is How.RUNNING:
        return ["never closed: the run was killed, or still goes on"]
    return [f"the run {ending.how.value}: {ending.reason or 'no reason recorded'}"]


def _called(file: Path, parameters: dict[str, Any]) -> str:
    """Return what a run is called: its file, or its script where the recorder named the file.

    The recorder calls every log ``poses``, with what tells it from others of the run: ``poses-2``.
    """
    script, (name, dash, rest) = parameters.get("script"), file.stem.partition("-")
    called = Path(script).stem if isinstance(script, str) else ""
    return f"{called}{dash}{rest}" if name == "poses" and called else file.stem


def _words(status: NDArray[Any]) -> NDArray[np.str_] | None:
    try:
        return np.asarray(status, dtype=np.str_)
    except (ValueError, UnicodeError):
        return None


def _sidecar(path: Path) -> dict[str, Any]:
    try:
        text = read_bounded(path, LARGEST).decode("utf-8")
    except FileNotFoundError:
        return {}
    except OSError as error:
        reason = error.strerror or error
        raise LogError(f"{path}: cannot be read as a description ({reason})") from error
    except ValueError as error:
        raise LogError(f"{path}: not readable as JSON ({error})") from error
    return from_json(text, str(path))
