"""A log in other tools' formats: MATLAB, CSV, NumPy, and MCAP for Foxglove.

What is written as ``.mat``, ``.csv`` or ``.npz`` is read back by `readers.read` as the same
recording, to the last bit, with its parameters; a CSV holds poses and parameters alone.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.foxglove import write_mcap
from posflock_robotarium.logs.readers import Run, named_arrays, parameters
from rps_compat.whole_files import atomic_write

Floats = NDArray[np.float64]


def convert(recording: Run, path: Path) -> Path:
    """Write a recording in the format that the path's ending names.

    Parameters
    ----------
    recording : Run
        Poses over time.
    path : Path
        Ends in ``.mat``, ``.csv``, ``.npz`` or ``.mcap``.

    Returns
    -------
    Path
        Where the file was written.

    Raises
    ------
    ParameterError
        For another ending.
    OutputError
        When the file cannot be written, or the extra ``mcap`` is not installed.
    """
    writer = WRITERS.get(path.suffix.lower().lstrip("."))
    if writer is None:
        raise ParameterError(f"{path}: expected an ending among {', '.join(WRITERS)}")
    writer(recording, path)
    return path


def write_pose_log(recording: Run, path: Path) -> Path:
    """Write a run as a pose log, ``NAME.npy`` and ``NAME.json``; return the path of the rows.

    Parameters
    ----------
    recording : Run
        What nobody knows of it is written as unknown.
    path : Path
        With or without ``.npy``.

    Raises
    ------
    OutputError
        Where the files cannot be written.
    """
    own = ("ended", "format", "robots", "rows_digest", "units", "versions")
    known = {name: value for name, value in recording.parameters.items() if name not in own}
    samples, _, robots = recording.poses.shape
    unknown = np.full(samples, np.nan)

    def of(column: NDArray[Any] | None, otherwise: NDArray[Any] = unknown) -> NDArray[Any]:
        return otherwise if column is None else column

    commands = of(recording.commands, np.full((samples, 2, robots), np.nan))
    status = of(recording.status, np.full(samples, ""))
    intervention, clearance = of(recording.intervention), of(recording.clearance)
    real_time = of(recording.real_time)
    log = PoseLog(path, robots, samples, known, real_time=False)
    for k, t in enumerate(recording.t.tolist()):
        log.append(
            t,
            recording.poses[k],
            commands[k],
            real_time=float(real_time[k]),
            status=str(status[k]),
            intervention=float(intervention[k]),
            clearance=float(clearance[k]),
        )
    ending = recording.ending
    log.close(*(("finished", "") if ending is None else (ending.how.value, ending.reason)))
    return log.path


def _write_pose_log(recording: Run, path: Path) -> None:
    write_pose_log(recording, path)


def _write_mat(recording: Run, path: Path) -> None:
    """Write t (T, 1) and poses (3, N, T), the shape of MATLAB scripts on the testbed."""
    from scipy.io import savemat

    variables: dict[str, NDArray[Any]] = {
        "t": recording.t[:, np.newaxis],
        "poses": recording.poses.transpose(1, 2, 0),
        **_description(recording),
    }
    for name in ("intervention", "clearance", "real_time"):
        if name in variables:
            variables[name] = variables[name][:, np.newaxis]
    if "status" in variables:  # char(status) in MATLAB; the reader takes numbers alone
        variables["status"] = named_arrays.codes_of(variables["status"])
    if recording.commands is not None:
        variables["command"] = recording.commands.transpose(1, 2, 0)
    with atomic_write(path) as draft:
        savemat(draft, variables, do_compression=True)


def _write_csv(recording: Run, path: Path) -> None:
    """Write the parameters as a comment, then one row a sample: t, x0, y0, theta0, x1 and so on."""
    names = [
        f"{state}{robot}" for robot in range(recording.robots) for state in ("x", "y", "theta")
    ]
    flat = recording.poses.transpose(0, 2, 1).reshape(len(recording.t), -1)
    with atomic_write(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        said = parameters.to_json(recording.parameters, len(recording.t))
        file.write(f"# {parameters.NAME}: {said}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["t", *names])
        table.writerows(map(repr, row) for row in np.column_stack([recording.t, flat]).tolist())


def _write_npz(recording: Run, path: Path) -> None:
    """Write t (T,), poses (T, 3, N) and whatever else is known, command (T, 2, N) first."""
    arrays: dict[str, NDArray[Any]] = {
        "t": recording.t,
        "poses": recording.poses,
        **_description(recording),
    }
    if recording.commands is not None:
        arrays["command"] = recording.commands
    with atomic_write(path) as draft, draft.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def _description(recording: Run) -> dict[str, NDArray[Any]]:
    """Return the parameters, and what the certificate did at each step, where they are known."""
    columns = ("intervention", "clearance", "status", "real_time")
    known = {name: getattr(recording, name) for name in columns}
    known[parameters.NAME] = parameters.to_bytes(recording.parameters, len(recording.t))
    return {name: values for name, values in known.items() if values is not None}


WRITERS: dict[str, Callable[[Run, Path], None]] = {
    "npy": _write_pose_log,
    "mat": _write_mat,
    "csv": _write_csv,
    "npz": _write_npz,
    "mcap": write_mcap,
}
"""Writer by ending."""
