"""The files of one run in a folder, or in a ``.zip`` of one."""

from __future__ import annotations

import re
import shutil
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path, PurePosixPath

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.printed_log import read_printed
from posflock_robotarium.logs.readers.bounds import Bounds
from rps_compat.containment.kept import KeptFolder

_LOGS = (".npy", ".npz", ".mat", ".csv", ".txt", ".tsv", ".dat", ".mcap", ".db3")
MOST_FILES = 200
"""Files of one run: more than robots that a testbed has."""


def is_bundle(path: Path) -> bool:
    """Tell whether a path is a folder or a ``.zip``.

    Parameters
    ----------
    path : Path
        What the user names as a log.
    """
    return path.is_dir() or (path.suffix.lower() == ".zip" and path.is_file())


@contextmanager
def files_of(path: Path, bounds: Bounds) -> Iterator[list[Path]]:
    """Give the logs in a folder or ``.zip``, by name, for a ``with`` block.

    Parameters
    ----------
    path : Path
        A folder, of which folders within are left out, or a ``.zip``.
    bounds : Bounds
        To how much a ``.zip`` may unpack.

    Raises
    ------
    LogError
        Where there is no log in it, or more than a run has, or a ``.zip`` is damaged or too large.
        Whatever is wrong with a log is told by its name in there.
    """
    if path.is_dir():
        with _named_after(path, path):
            yield _logs(list(path.iterdir()), path)
        return
    with KeptFolder("unpack") as place, _named_after(path, place):
        yield _logs(_unpacked(path, place, bounds), path)


@contextmanager
def _named_after(path: Path, place: Path) -> Iterator[None]:
    """Let errors name the folder or ``.zip``, and not the place where it was unpacked."""
    try:
        yield
    except LogError as error:
        words = str(error).replace(str(place), str(path))
        raise type(error)(words if str(path) in words else f"{path}: {words}") from error


def _logs(files: list[Path], path: Path) -> list[Path]:
    logs = sorted(file for file in files if file.suffix.lower() in _LOGS and file.is_file())
    words = {f for f in logs if f.suffix == ".txt" and (read_printed(f) or _is_prose(f))}
    logs = [file for file in logs if file not in words] or logs
    if not logs:
        what = "a folder" if path.is_dir() else "a .zip"
        raise LogError(f"{path}: {what} with no log in it; expected files {', '.join(_LOGS)}")
    if len(logs) > MOST_FILES:
        raise LogError(f"{path}: {len(logs)} logs, more than the {MOST_FILES} of one run")
    return logs


def _is_prose(file: Path) -> bool:
    """Whether no line of a text begins with two numbers: notes, a README, what `run` reports."""
    with file.open(encoding="utf-8", errors="replace") as lines:
        return not any(map(_NUMBERS.match, islice(lines, _FIRST_LINES)))


_NUMBERS = re.compile(r"\s*[\"']?[-+]?\.?\d[^\s,;|]*[\s,;|]+[\"']?[-+]?\.?\d")
_FIRST_LINES = 200


def _unpacked(path: Path, place: Path, bounds: Bounds) -> list[Path]:
    """Unpack the logs of a ``.zip`` flat, whatever paths it claims."""
    files: list[Path] = []
    try:
        with zipfile.ZipFile(path) as archive:
            members = [
                info
                for info in archive.infolist()
                if PurePosixPath(info.filename).suffix.lower() in _LOGS
                and "__MACOSX" not in info.filename
            ]
            bounds.require_size(sum(info.file_size for info in members), f"{path}: unpacked")
            for info in members[: MOST_FILES + 1]:
                target = place / PurePosixPath(info.filename.replace("\\", "/")).name
                if target.exists():
                    raise LogError(f"{path}: two files are called {target.name}; unpack it first")
                with archive.open(info) as packed, target.open("wb") as out:
                    shutil.copyfileobj(packed, out)
                files.append(target)
    except LogError:
        raise
    except Exception as error:  # zipfile passes on whatever its parts report
        raise LogError(f"{path}: not a readable .zip ({error})") from error
    return files
