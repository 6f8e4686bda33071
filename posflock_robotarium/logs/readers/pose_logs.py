"""Our own pose log: rows up to the last one reached, and the description beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.flocking.pose_log import log_paths, row_type
from posflock_robotarium.logs.readers.named_arrays import floats
from posflock_robotarium.logs.readers.parameters import LARGEST, from_json
from posflock_robotarium.logs.run import Run

FIELDS = row_type(1).names or ()


def is_pose_log(array: NDArray[Any]) -> bool:
    """Tell whether an array holds the rows of a pose log.

    Parameters
    ----------
    array : (...) array
        What a file holds.
    """
    return array.dtype.names == FIELDS and array.ndim == 1


def run_of(file: Path, rows: NDArray[Any]) -> Run:
    """Read our own log, whether the run ended well, was killed, or still goes on.

    Parameters
    ----------
    file : Path
        The log's file; its description lies beside it.
    rows : (T,) array
        Rows of a pose log, a structured array.

    Raises
    ------
    LogError
        When the rows are not those of a pose log, or none was reached.
    """
    if rows["pose"].ndim != 3 or rows["t"].ndim != 1 or rows.dtype["pose"].base.kind != "f":
        raise LogError(f"{file}: fields of a pose log with other shapes, {rows.dtype}")
    robots = rows["pose"].shape[2]
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
    ended = parameters.get("ended")
    how = ended.get("how") if isinstance(ended, dict) else None
    if not parameters:
        notes.append(f"no {file.with_suffix('.json').name} beside it: parameters unknown")
    elif how == "running":
        notes.append("never closed: the run was killed, or still goes on")
    elif how is not None and how != "finished":
        notes.append(f"the run {how}: {ended.get('reason') or 'no reason recorded'}")  # type: ignore[union-attr]
    columns = {
        name: floats(rows[name][:reached], f"{file}: {name}").copy()
        for name in ("pose", "command", "intervention", "clearance")
    }
    return Run(
        name=file.stem,
        t=t[:reached].copy(),
        poses=columns["pose"],
        commands=columns["command"],
        intervention=columns["intervention"],
        clearance=columns["clearance"],
        status=_words(rows["status"][:reached]),
        parameters=parameters,
        notes=tuple(notes),
        sources=(str(file),),
    )


def _words(status: NDArray[Any]) -> NDArray[np.str_] | None:
    try:
        return np.asarray(status, dtype=np.str_)
    except (ValueError, UnicodeError):
        return None


def _sidecar(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > LARGEST:
            raise LogError(f"{path}: {path.stat().st_size} bytes, too large for a description")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise LogError(f"{path}: not readable as JSON ({error})") from error
    return from_json(text, str(path))
