"""One entry for all files: look at what it is, read it, and say how.

The kind of a file is told by its first bytes, not by its ending, so a ``.mat`` that is really
version 7.3, or a ``.txt`` with commas, is read for what it is.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError, ParameterError, PosflockError
from posflock_robotarium.flocking.pose_log import log_paths
from posflock_robotarium.logs.plausibility import without_exchanges
from posflock_robotarium.logs.printed_log import printed_beside
from posflock_robotarium.logs.readers.bounds import Bounds
from posflock_robotarium.logs.readers.bundles import files_of, is_bundle
from posflock_robotarium.logs.readers.clocks import Track, joined
from posflock_robotarium.logs.readers.forms import form_of
from posflock_robotarium.logs.readers.found import Found, LogClock, ReadOptions
from posflock_robotarium.logs.readers.named_arrays import poses_among
from posflock_robotarium.logs.readers.names import STATE_NAMES, TIME_NAMES
from posflock_robotarium.logs.readers.numpy_arrays import NPY, read_npy
from posflock_robotarium.logs.readers.order import in_order, one_row_a_frame, one_row_a_time
from posflock_robotarium.logs.readers.pose_logs import FIELDS, POSE_LOG, run_of
from posflock_robotarium.logs.readers.timing import SINCE_1970, timed
from posflock_robotarium.logs.readers.units import SAME_FRAME, in_metres, without_repeats
from posflock_robotarium.logs.real_time import believed, over_real_time
from posflock_robotarium.logs.run import GAP_FACTOR, Run, missing_rows
from posflock_robotarium.logs.start import with_printed

Floats = NDArray[np.float64]


def read(path: str | os.PathLike[str], options: ReadOptions | None = None) -> Run:
    """Read one run from one file of any known kind.

    Parameters
    ----------
    path : path
        A pose log (with or without ``.npy``), or a file of any form in the registry; a folder or a
        ``.zip`` with the files of one run.
    options : ReadOptions, optional
        What the file does not say itself.

    Returns
    -------
    Run
        Checked poses over time, with notes on how they were read.

    Raises
    ------
    LogError
        When the file is missing, empty, cut off, damaged or runs backwards in time.
    LayoutError
        When the file is sound but could be read in more than one way.
    """
    options = options or ReadOptions()
    if is_bundle(Path(path)):
        with files_of(Path(path), options.bounds) as files:
            run = replace(_parts(files, options), name=Path(path).stem, sources=(str(path),))
            run = run if run.printed else with_printed(run, printed_beside(files[0]))
    else:
        run = _file(_existing(Path(path)), options)
    return _as_asked(run, options)


def _file(file: Path, options: ReadOptions) -> Run:
    with _named(file):
        found = form_of(file).read(file, options)
        if isinstance(found, Run):
            found = replace(found, parameters=options.given.among(found.parameters))
        else:
            found = _recording(found, file.stem, (str(file),), options)
        found = with_printed(found, printed_beside(file))
        return over_real_time(found) if options.clock is LogClock.REAL else found


def _as_asked(run: Run, options: ReadOptions) -> Run:
    """Do to a run that has been read what the user asks to be done."""
    if options.given.words:
        run = run.noted(options.given.words)
    return without_exchanges(run) if options.fix_swaps else run


def read_pose_log(path: str | os.PathLike[str]) -> Run:
    """Read a pose log, and nothing else.

    Parameters
    ----------
    path : path
        With or without ``.npy``.

    Raises
    ------
    LogError
        When the file is missing, damaged or no pose log, or holds fewer than two rows.
    """
    file = _existing(Path(path))
    with _named(file):
        if form_of(file) is POSE_LOG:
            return run_of(file, read_npy(file))
    raise LogError(f"{file}: not a pose log; expected rows with the fields {', '.join(FIELDS)}")


def read_parts(paths: Sequence[str | os.PathLike[str]], options: ReadOptions | None = None) -> Run:
    """Read one run that was saved in several files.

    The files are consecutive parts, each with its own poses, in order of time; or they complement
    each other (``poses.npy`` and ``time.npy``; ``x.npy``, ``y.npy``, ``theta.npy``); or each is one
    robot over the same time, on a clock of its own.

    Parameters
    ----------
    paths : sequence of path
        Files of one run; consecutive parts in order of time.
    options : ReadOptions, optional
        What the user says.

    Raises
    ------
    LogError, LayoutError
        As `read`, and when the parts do not fit together.
    ParameterError
        When there is no file.
    """
    options = options or ReadOptions()
    files = [_existing(Path(path)) for path in paths]
    if not files:
        raise ParameterError("no file to read")
    if len(files) == 1:
        return read(files[0], options)
    run = _parts(files, options)
    run = run if run.printed else with_printed(run, printed_beside(files[0]))
    return _as_asked(run, options)


def _parts(files: list[Path], options: ReadOptions) -> Run:
    if len(files) == 1:
        return _file(files[0], options)
    named = _complementary(files, options.bounds)
    if named is not None:
        sources = tuple(str(file) for file in files)
        found = poses_among(named, " + ".join(file.name for file in files), options)
        joined = f"{len(files)} files that complement each other: {', '.join(named)}"
        return _recording(found, files[0].parent.name or "run", sources, options).noted(joined)
    robots = _one_robot_each(files, options)
    if robots is not None:
        return _recording(robots, files[0].parent.name or "run", tuple(map(str, files)), options)
    return _concatenate([_file(file, options) for file in files])


def _one_robot_each(files: list[Path], options: ReadOptions) -> Found | None:
    """Join files of one robot each that were logged at the same time; None where they are not."""
    tracks, told = [], []
    for file in files:
        with _named(file):
            found = form_of(file).read(file, options)
            if isinstance(found, Run) or found.t is None or found.poses.shape[2] != 1:
                return None
            found = timed(without_repeats(found), str(file), options)
            found = without_repeats(found, SAME_FRAME)
        tracks.append(Track(file.stem, np.asarray(found.t), found.poses[:, :, 0]))
        told.append((found.lengths_told, found.angles_told))
        notes = [f"{len(files)} files of one robot each, the first: {found.notes[0]}"]
    ends = min(track.t[-1] for track in tracks), max(track.t[-1] for track in tracks)
    starts = min(track.t[0] for track in tracks), max(track.t[0] for track in tracks)
    if not starts[1] < ends[0]:
        return None  # one after the other
    found = joined(tracks, str(files[0].parent), notes)
    lengths, angles = (all(each) for each in zip(*told, strict=True))
    return replace(found, notes=tuple(notes), lengths_told=lengths, angles_told=angles)


@contextmanager
def _named(file: Path) -> Iterator[None]:
    """Let whatever a reader did not expect be an error that names the file."""
    try:
        yield
    except PosflockError:
        raise
    except Exception as error:
        raise LogError(f"{file}: cannot be read ({type(error).__name__}: {error})") from error


def _existing(path: Path) -> Path:
    candidates = [path, path.with_name(path.name + ".npy")]
    if path.suffix == ".json":
        candidates.insert(0, log_paths(path)[0])
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise LogError(f"{path}: no such file")


def _recording(found: Found, name: str, sources: tuple[str, ...], options: ReadOptions) -> Run:
    """Time what was found, leave out what is none, and check it."""
    options.bounds.require_robots(found.poses.shape[2], sources[0])
    found = replace(found, parameters=options.given.among(found.parameters))
    recorded, doubts = found.t is not None, missing_rows(len(found.poses), found.promised)
    found = in_metres(_without_ends(found), sources[0], options)
    # Equal times must go before times are judged, nearly equal ones need seconds.
    found = timed(one_row_a_time(without_repeats(in_order(found))), sources[0], options)
    found = without_repeats(found, SAME_FRAME)
    lasted = found.t
    found = one_row_a_frame(found)
    doubts += _stopped_tracking(lasted, found.t)
    if options.drop_damaged:
        found = _without_damage(found)
    t = np.asarray(found.t)
    if len(t) and np.isfinite(t[0]) and abs(t[0]) > 1e5:
        found = found.noted(f"time counted from the first pose, recorded as {t[0]:.3f} s")
        if t[0] >= SINCE_1970:
            found = replace(found, parameters={"first_pose_at": float(t[0]), **found.parameters})
        t = t - t[0]
    real_time = None
    if found.real_time is not None:
        simulated = found.parameters.get("simulated") is True
        real_time, why = believed(found.real_time, t, simulated)
        found = found.noted(why) if why else found
    return Run(
        name=name,
        t=np.ascontiguousarray(t),
        poses=np.ascontiguousarray(found.poses),
        commands=found.commands,
        intervention=found.intervention,
        clearance=found.clearance,
        status=found.status,
        real_time=real_time,
        parameters=found.parameters,
        notes=found.notes,
        sources=sources,
        timed=recorded,
        doubts=doubts,
    )


def _stopped_tracking(lasted: Floats | None, told: Floats | None) -> tuple[str, ...]:
    """Say that a log goes on after the last new frame of the camera."""
    if lasted is None or told is None or len(told) < 2:
        return ()
    more = float(lasted[-1] - told[-1])
    if not more > max(1.0, GAP_FACTOR * float(np.median(np.diff(told)))):
        return ()
    return (f"its last {more:.1f} s hold one frame of the camera, and no news",)


def _without_ends(found: Found) -> Found:
    """Cut off rows in which no robot is yet, and those that were prepared and never filled."""
    first, reached = _filled(found.poses)
    rows = len(found.poses)
    if reached < rows:
        found = found.noted(f"cut at row {reached} of {rows}: the rest was never filled in")
    if first > 0:
        found = found.noted(f"begins at row {first}: no robot is in the rows before")
    return found if reached == rows and first == 0 else found.rows(slice(first, reached))


def _without_damage(found: Found) -> Found:
    """Leave out rows that are not finite; their place in time is a gap."""
    headed = not np.isnan(found.poses[:, 2]).all()
    seen = found.poses if headed else found.poses[:, :2]
    sound = np.asarray(np.isfinite(seen).all(axis=(1, 2)))
    if found.t is not None:
        sound &= np.isfinite(found.t)
    if sound.all():
        return found
    return found.noted(f"{int((~sound).sum())} damaged row(s) left out, as asked").rows(sound)


def _filled(poses: Floats) -> tuple[int, int]:
    """Return the first row and the row after the last that hold robots: not all NaN, or all 0."""
    blank = np.isnan(poses).all(axis=(1, 2))
    zeros = (poses == 0).all(axis=(1, 2)) & (poses.shape[2] > 1)
    filled = np.flatnonzero(~(blank | zeros))
    if not filled.size:
        return 0, 0
    # One row of zeros is how some scripts begin; robots are not all in one place for longer.
    first = int(filled[0]) if zeros[: filled[0]].sum() != 1 else int(np.flatnonzero(~blank)[0])
    return first, int(filled[-1]) + 1


def _complementary(files: list[Path], bounds: Bounds) -> dict[str, NDArray[Any]] | None:
    """Return the files as named arrays when one of them is a time, or they are x, y and θ."""
    if any(form_of(file) is not NPY for file in files):
        return None
    # run3_x, run3_y and run3_theta are x, y and theta.
    starts = {file.stem.rpartition("_")[0] + "_" for file in files}
    prefix = starts.pop() if len(starts) == 1 else ""
    named: dict[str, NDArray[Any]] = {}
    for file in files:
        array = read_npy(file, bounds)
        if array.dtype.names is not None:
            return None
        named[file.stem.removeprefix(prefix)] = array
    words = {name.lower() for name in named}
    has_time = bool(words & set(TIME_NAMES))
    has_states = all(words & {state, *STATE_NAMES[state]} for state in STATE_NAMES)
    return named if len(named) == len(files) and (has_time or has_states) else None


def _concatenate(parts: list[Run]) -> Run:
    robots = {part.robots for part in parts}
    if len(robots) != 1:
        raise LogError(f"parts of one run with different numbers of robots: {sorted(robots)}")
    times: list[Floats] = []
    notes = [f"{len(parts)} files, one after the other"]
    for part in parts:
        t = part.t
        if times and not part.timed:
            t = t + times[-1][-1] + part.step
        if times and t[0] <= times[-1][-1]:
            raise LogError(
                f"{part.sources[0]}: begins at {t[0]:g} s, before the part before it ends "
                f"({times[-1][-1]:g} s); name the parts in order, or report them as several runs"
            )
        times.append(t)
    return Run(
        name=parts[0].name,
        t=np.concatenate(times),
        poses=np.concatenate([part.poses for part in parts]),
        commands=None
        if any(part.commands is None for part in parts)
        else _joined([part.commands for part in parts], parts, np.nan),
        intervention=_joined([part.intervention for part in parts], parts, np.nan),
        clearance=_joined([part.clearance for part in parts], parts, np.nan),
        status=_joined([part.status for part in parts], parts, ""),
        parameters=parts[0].parameters,
        notes=(*notes, *parts[0].notes),
        sources=tuple(source for part in parts for source in part.sources),
        doubts=tuple(doubt for part in parts for doubt in part.doubts),
    )


def _joined(columns: Sequence[NDArray[Any] | None], parts: list[Run], unknown: Any) -> Any:
    """Return one column of all parts, unknown in the parts that have none."""
    if all(column is None for column in columns):
        return None
    return np.concatenate(
        [
            np.full(len(part.t), unknown) if column is None else column
            for column, part in zip(columns, parts, strict=True)
        ]
    )
