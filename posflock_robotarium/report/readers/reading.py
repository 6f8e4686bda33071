"""One entry for all files: look at what it is, read it, and say how.

The kind of a file is told by its first bytes, not by its ending, so a ``.mat`` that is really
version 7.3, or a ``.txt`` with commas, is read for what it is.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.errors import LogError, ParameterError
from posflock_robotarium.poselog import log_paths, row_type
from posflock_robotarium.report.readers.layouts import COLUMN_ORDERS, to_poses
from posflock_robotarium.report.readers.matlab import read_mat
from posflock_robotarium.report.readers.numpy_files import fields_of, read_npy, read_npz
from posflock_robotarium.report.readers.recording import LayoutError, Recording
from posflock_robotarium.report.readers.text import STATE_NAMES, TIME_NAMES, read_text

Floats = NDArray[np.float64]

POSE_NAMES = ("poses", "pose", "states", "state", "x_data", "xdata", "trajectory", "trajectories")
COMMAND_NAMES = ("command", "commands", "dxu")
STEP_NAMES = ("dt", "time_step", "timestep")
POSE_LOG_FIELDS = row_type(1).names
LARGEST_SIDECAR = 16 << 20


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
class _Found:
    """Poses as found in a file, before anything is checked."""

    t: Floats | None
    poses: Floats
    notes: tuple[str, ...]
    command: Floats | None = None
    dt: float | None = None


def read(path: str | os.PathLike[str], options: ReadOptions | None = None) -> Recording:
    """Read one run from one file of any known kind.

    Parameters
    ----------
    path : path
        A pose log (with or without ``.npy``), ``.npy``, ``.npz``, ``.mat``, CSV or text.
    options : ReadOptions, optional
        What the file does not say itself.

    Returns
    -------
    Recording
        Checked poses over time, with notes on how they were read.

    Raises
    ------
    LogError
        When the file is missing, empty, cut off, damaged or runs backwards in time.
    LayoutError
        When the file is sound but could be read in more than one way.
    """
    options = options or ReadOptions()
    file = _existing(Path(path))
    kind = _kind(file)
    if kind == "npy":
        array = read_npy(file)
        if array.dtype.names == POSE_LOG_FIELDS and array.ndim == 1:
            return _pose_log(file, array)
    found = _find(file, kind, options)
    return _recording(found, file.stem, (str(file),), options)


def read_parts(
    paths: Sequence[str | os.PathLike[str]], options: ReadOptions | None = None
) -> Recording:
    """Read one run that was saved in several files.

    The files are either consecutive parts, each with its own poses, in order of time; or they
    complement each other (``poses.npy`` and ``time.npy``; ``x.npy``, ``y.npy``, ``theta.npy``).

    Raises
    ------
    LogError, LayoutError
        As `read`, and when the parts do not fit together.
    """
    options = options or ReadOptions()
    files = [_existing(Path(path)) for path in paths]
    if not files:
        raise ParameterError("no file to read")
    if len(files) == 1:
        return read(files[0], options)
    named = _complementary(files)
    if named is not None:
        sources = tuple(str(file) for file in files)
        found = _pick(named, " + ".join(file.name for file in files), options)
        joined = f"{len(files)} files that complement each other: {', '.join(named)}"
        return _recording(found, files[0].parent.name or "run", sources, options).noted(joined)
    return _concatenate([read(file, options) for file in files])


def _existing(path: Path) -> Path:
    candidates = [path, path.with_name(path.name + ".npy")]
    if path.suffix == ".json":
        candidates.insert(0, log_paths(path)[0])
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    if path.is_dir():
        raise LogError(f"{path}: a folder; name the log file in it")
    raise LogError(f"{path}: no such file")


def _kind(file: Path) -> str:
    try:
        with file.open("rb") as stream:
            start = stream.read(520)
    except OSError as error:
        raise LogError(f"{file}: cannot be read ({error.strerror})") from error
    if not start:
        raise LogError(f"{file}: empty file")
    if start.startswith(b"\x93NUMPY"):
        return "npy"
    if start.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        return "npz"
    if start.startswith(b"MATLAB") or b"\x89HDF\r\n\x1a\n" in (start[:8], start[512:520]):
        return "mat"
    if start[:1] == b"\x80" or file.suffix in (".pkl", ".pickle"):
        raise LogError(f"{file}: a pickle, which can run code when read: refused; save an .npz")
    if file.suffix in (".npy", ".npz", ".mat"):
        raise LogError(f"{file}: not a {file.suffix} file, or its beginning is damaged")
    return "text"


def _find(file: Path, kind: str, options: ReadOptions) -> _Found:
    where = str(file)
    if kind == "text":
        t, poses, notes = read_text(file, options.layout, options.columns)
        return _Found(t, poses, tuple(notes))
    if kind == "npz":
        return _pick(read_npz(file), where, options, "NumPy archive")
    if kind == "mat":
        variables, version = read_mat(file)
        return _pick(variables, where, options, f"{version} file")
    array = read_npy(file)
    if array.dtype.names is not None:
        return _pick(fields_of(array, where), where, options, "structured NumPy array")
    return _plain_array(_floats(array, where), where, options)


def _plain_array(array: Floats, where: str, options: ReadOptions) -> _Found:
    notes = [f"NumPy array of shape {array.shape}"]
    t: Floats | None = None
    layout = options.layout
    if array.ndim == 2 and layout is None and array.size:
        # One row or column more than three a robot, and always increasing: that is the time.
        for axis, name in ((1, "T,3N"), (0, "3N,T")):
            if array.shape[axis] % 3 == 1 and array.shape[axis] > 3 and array.shape[1 - axis] > 1:
                first = array[:, 0] if axis else array[0]
                if np.all(np.diff(first) > 0):
                    t, array, layout = first, array[:, 1:] if axis else array[1:], name
                    notes.append("first row or column increases throughout: taken for the time")
                    break
    poses, how = to_poses(array, where, layout, options.order)
    return _Found(t, poses, (*notes, how))


def _pick(
    arrays: Mapping[str, NDArray[Any]], where: str, options: ReadOptions, kind: str = "arrays"
) -> _Found:
    """Find time, poses and commands among named arrays."""
    names = {name.lower(): name for name in arrays}
    notes = [f"{kind} with {', '.join(arrays)}"]
    t = next((_line(arrays[names[n]], where) for n in TIME_NAMES if n in names), None)
    if t is not None and t.size < 2:
        t = None
    dt = next((_scalar(arrays[names[n]]) for n in STEP_NAMES if n in names), None)
    samples = None if t is None else len(t)
    triple = [
        next((names[n] for n in (state, *STATE_NAMES[state]) if n in names), None)
        for state in STATE_NAMES
    ]
    asked = options.array
    if asked is None and all(name is not None for name in triple):
        poses, how = _stack([arrays[str(name)] for name in triple], where, samples)
        notes.append(f"x, y and heading from {', '.join(map(str, triple))}; {how}")
    else:
        name = _pose_array(arrays, names, where, asked, t)
        array = _floats(arrays[name], f"{where}: {name}")
        poses, how = to_poses(
            array, f"{where}: {name}", options.layout, options.order, samples=samples
        )
        notes.append(f"poses from {name}, shape {array.shape}, {how}")
    command = next((arrays[names[n]] for n in COMMAND_NAMES if n in names), None)
    found = _command(command, poses.shape) if command is not None else None
    if found is not None:
        notes.append("commands were recorded too")
    return _Found(t, poses, tuple(notes), found, dt)


def _pose_array(
    arrays: Mapping[str, NDArray[Any]],
    names: Mapping[str, str],
    where: str,
    asked: str | None,
    t: Floats | None,
) -> str:
    if asked is not None:
        if asked not in arrays:
            raise LayoutError(f"{where}: no array {asked!r}; there are {', '.join(arrays)}")
        return asked
    likely = [names[n] for n in POSE_NAMES if n in names]
    if len(likely) == 1:
        return likely[0]
    fitting = [
        name
        for name, array in arrays.items()
        if array.ndim in (2, 3)
        and array.dtype.kind in "fiu"
        and any(s % 3 == 0 for s in array.shape)
        and array.size >= 6
        and min(array.shape) >= 1
        and array.size != max(array.shape)
        and (t is None or len(t) in array.shape)
    ]
    if len(fitting) == 1:
        return fitting[0]
    shown = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
    raise LayoutError(
        f"{where}: {'several arrays' if fitting else 'no array'} could hold the poses: {shown}; "
        "name the one with --array"
    )


def _stack(parts: list[NDArray[Any]], where: str, samples: int | None) -> tuple[Floats, str]:
    """Put x, y and θ of shape (T, N), (N, T) or (T,) together."""
    states = [_floats(part, where) for part in parts]
    if len({state.shape for state in states}) != 1 or states[0].ndim not in (1, 2):
        raise LayoutError(f"{where}: x, y and heading have shapes {[s.shape for s in states]}")
    stacked = np.stack(states)
    if stacked.ndim == 2:
        return stacked.T[:, :, np.newaxis], "one robot"
    _, first, second = stacked.shape
    if samples is None:
        samples = max(first, second)
    if first == second or samples not in (first, second):
        raise LayoutError(
            f"{where}: x, y and heading of shape {(first, second)} and {samples} times: "
            "which axis is time? Stack them into one array (T, 3, N)"
        )
    if first == samples:
        return stacked.transpose(1, 0, 2), f"shape (T, N) with {second} robots"
    return stacked.transpose(2, 0, 1), f"shape (N, T) with {first} robots"


def _command(array: NDArray[Any], shape: tuple[int, ...]) -> Floats | None:
    samples, _, robots = shape
    if array.dtype.kind not in "fiu":
        return None
    if array.shape == (samples, 2, robots):
        return np.asarray(array, dtype=np.float64)
    if array.shape == (2, robots, samples):
        return np.asarray(array, dtype=np.float64).transpose(2, 0, 1)
    return None


def _line(array: NDArray[Any], where: str) -> Floats:
    values = _floats(array, where)
    if values.size != max(values.shape, default=1):
        raise LayoutError(f"{where}: time has shape {values.shape}, expected one number a sample")
    return values.reshape(-1)


def _scalar(array: NDArray[Any]) -> float | None:
    if array.size == 1 and array.dtype.kind in "fiu":
        value = float(array.reshape(-1)[0])
        return value if np.isfinite(value) and value > 0 else None
    return None


def _floats(array: NDArray[Any], where: str) -> Floats:
    if array.dtype.kind not in "fiu":
        raise LogError(f"{where}: holds {array.dtype}, expected real numbers")
    return np.asarray(array, dtype=np.float64)


def _recording(
    found: _Found, name: str, sources: tuple[str, ...], options: ReadOptions
) -> Recording:
    where = sources[0]
    poses, t, command = found.poses, found.t, found.command
    notes = list(found.notes)
    if t is None:
        dt = options.dt or found.dt
        if dt is None:
            raise LayoutError(
                f"{where}: no time in it; say the seconds between samples, for example "
                "--dt 0.033 (the testbed's step)"
            )
        t = np.arange(len(poses)) * dt
        notes.append(f"no time in the file: samples {dt:g} s apart")
    elif options.dt is not None:
        notes.append("--dt not used: the file has times of its own")
    if len(t) != len(poses):
        raise LogError(f"{where}: {len(t)} times for {len(poses)} poses")
    reached = _reached(poses)
    if reached < len(poses):
        notes.append(f"cut at row {reached} of {len(poses)}: the rest was never filled in")
        poses, t = poses[:reached], t[:reached]
        command = command[:reached] if command is not None else None
    if options.drop_damaged and len(poses):
        sound = np.isfinite(poses).all(axis=(1, 2)) & np.isfinite(t)
        if not sound.all():
            notes.append(f"{int((~sound).sum())} damaged row(s) left out, as asked")
            poses, t = poses[sound], t[sound]
            command = command[sound] if command is not None else None
    if len(t) and np.isfinite(t[0]) and abs(t[0]) > 1e5:
        notes.append(f"time counted from the first pose, recorded as {t[0]:.3f} s")
        t = t - t[0]
    return Recording(
        name=name,
        t=np.ascontiguousarray(t),
        poses=np.ascontiguousarray(poses),
        command=command,
        notes=tuple(notes),
        sources=sources,
    )


def _reached(poses: Floats) -> int:
    """Rows before a tail that was prepared and never filled: all NaN, or all robots at 0, 0, 0."""
    blank = np.isnan(poses).all(axis=(1, 2))
    if poses.shape[2] > 1:
        blank |= (poses == 0).all(axis=(1, 2))
    filled = np.flatnonzero(~blank)
    return int(filled[-1]) + 1 if filled.size else 0


def _pose_log(file: Path, rows: NDArray[Any]) -> Recording:
    """Read our own log, whether the run ended well, was killed, or still goes on."""
    if rows["pose"].ndim != 3 or rows["t"].ndim != 1 or rows.dtype["pose"].base.kind != "f":
        raise LogError(f"{file}: fields of a pose log with other shapes, {rows.dtype}")
    robots = rows["pose"].shape[2]
    if rows.dtype.fields is None or rows["command"].shape[1:] != (2, robots):
        raise LogError(f"{file}: {robots} robots and commands of shape {rows['command'].shape[1:]}")
    t = _floats(rows["t"], str(file))
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
        name: _floats(rows[name][:reached], f"{file}: {name}").copy()
        for name in ("pose", "command", "moved", "smallest_h")
    }
    return Recording(
        name=file.stem,
        t=t[:reached].copy(),
        poses=columns["pose"],
        command=columns["command"],
        moved=columns["moved"],
        smallest_h=columns["smallest_h"],
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
        if path.stat().st_size > LARGEST_SIDECAR:
            raise LogError(f"{path}: {path.stat().st_size} bytes, too large for a description")
        parameters = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise LogError(f"{path}: not readable as JSON ({error})") from error
    if not isinstance(parameters, dict):
        raise LogError(f"{path}: expected an object of parameters, got {type(parameters).__name__}")
    return parameters


def _complementary(files: list[Path]) -> dict[str, NDArray[Any]] | None:
    """Return the files as named arrays when one of them is a time, or they are x, y and θ."""
    if any(_kind(file) != "npy" for file in files):
        return None
    prefix = os.path.commonprefix([file.stem for file in files])
    prefix = prefix[: prefix.rfind("_") + 1]
    named: dict[str, NDArray[Any]] = {}
    for file in files:
        array = read_npy(file)
        if array.dtype.names is not None:
            return None
        named[file.stem.removeprefix(prefix)] = array
    words = {name.lower() for name in named}
    has_time = bool(words & set(TIME_NAMES))
    has_states = all(words & {state, *STATE_NAMES[state]} for state in STATE_NAMES)
    return named if len(named) == len(files) and (has_time or has_states) else None


def _concatenate(parts: list[Recording]) -> Recording:
    robots = {part.robots for part in parts}
    if len(robots) != 1:
        raise LogError(f"parts of one run with different numbers of robots: {sorted(robots)}")
    times: list[Floats] = []
    notes = [f"{len(parts)} files, one after the other"]
    for part in parts:
        t = part.t
        if times and any("no time in the file" in note for note in part.notes):
            t = t + times[-1][-1] + part.step
        if times and t[0] <= times[-1][-1]:
            raise LogError(
                f"{part.sources[0]}: begins at {t[0]:g} s, before the part before it ends "
                f"({times[-1][-1]:g} s); name the parts in order, or report them as several runs"
            )
        times.append(t)
    commands = [part.command for part in parts]
    sound = [command for command in commands if command is not None]
    return Recording(
        name=parts[0].name,
        t=np.concatenate(times),
        poses=np.concatenate([part.poses for part in parts]),
        command=np.concatenate(sound) if len(sound) == len(parts) else None,
        parameters=parts[0].parameters,
        notes=(*notes, *parts[0].notes),
        sources=tuple(source for part in parts for source in part.sources),
    )
