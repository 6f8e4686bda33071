"""Files that are whole or absent: nobody ever finds half of one under its name.

What is written goes into a *draft* beside its place, is handed to the disk, and then takes the
name in one move. A kill or a full disk leaves what was there before, and at most a draft,
``.posflock.PROCESS-NUMBER.part``, which the next write into that folder removes.

Two kinds of files are written otherwise, each with more to promise: pose logs, whose every row
must outlive a kill, and the segments of a sweep's store, which are appended to.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import os
import re
import shutil
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from barrier_certificates.certificate_errors import OutputError
from rps_compat.bounded_files import read_bounded

_DRAFT = re.compile(r"\.posflock\.(\d+)-\d+\.part")
#: Numbers the drafts of this process.
_NUMBERS = itertools.count()


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield where to write; what is there when the block ends well becomes `path` at once.

    An error within the block leaves `path` as it was. A symbolic link is followed, a device or a
    pipe is written to as it is, and an earlier file's permissions are kept.

    Parameters
    ----------
    path : Path
        The file's name, whose folder is made where there is none. What is yielded has the same
        ending, by which libraries choose a format.

    Raises
    ------
    OutputError
        Where the file cannot be written; it names the file.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "numbers.txt"
    >>> with atomic_write(path) as draft:
    ...     _ = draft.write_text("1 2 3")
    >>> path.read_text()
    '1 2 3'
    """
    with _told(path):
        place = Path(os.path.realpath(path))
        if place.is_dir():
            raise OutputError(f"{path}: cannot be written (it is a folder)")
        if place.exists() and not place.is_file():
            yield place
            return
        place.parent.mkdir(parents=True, exist_ok=True)
        draft = _draft_in(place.parent, place.suffix)
        os.close(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _mode_for(place)))
        try:
            yield draft
            _hand_to_disk(draft)
            os.replace(draft, place)
        finally:
            draft.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> Path:
    """Write a file at once, whole or not at all, and return its path.

    Parameters
    ----------
    path : Path
        The file's name; see `atomic_write`.
    content : str or bytes
        All of it; text becomes UTF-8, its line ends kept.
    """
    with atomic_write(path) as draft:
        draft.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@contextmanager
def written_together(folder: Path) -> Iterator[Path]:
    """Yield an empty folder; all files that are in it when the block ends well go into `folder`.

    So files that belong together are those of one call, even where a later call fails. Whatever
    else is in `folder` stays.

    Parameters
    ----------
    folder : Path
        Made where there is none.

    Raises
    ------
    OutputError
        Where the files cannot be written.
    """
    with _told(folder):
        folder.mkdir(parents=True, exist_ok=True)
        draft = _draft_in(folder)
        draft.mkdir()
        try:
            with _named_after(folder, draft):
                yield draft
            files = _handed_to_disk(draft)
            for path in files:
                place = folder / path.relative_to(draft)
                place.parent.mkdir(parents=True, exist_ok=True)
                os.replace(path, os.path.realpath(place))
        finally:
            shutil.rmtree(draft, ignore_errors=True)


def listed_in(report: Path) -> list[str]:
    """Return the files that an earlier call wrote, as its own report in JSON lists them.

    Parameters
    ----------
    report : Path
        It need not be there; what is no such report lists nothing.
    """
    try:
        listed = json.loads(read_bounded(report))["files"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return []
    return [str(name) for name in listed] if isinstance(listed, list) else []


def sum_of(path: Path) -> str:
    """Return the sha256 sum of a file, by which a file beside it tells whether it means this one.

    Parameters
    ----------
    path : Path
        The file, of any size.

    Raises
    ------
    OSError
        Where it cannot be read.
    """
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def remove_earlier(folder: Path, names: Iterable[str]) -> None:
    """Remove what an earlier call told of itself: it is not what the one that begins will tell.

    Parameters
    ----------
    folder : Path
        Where both write; it need not be there.
    names : iterable of str
        Files of that folder, which need not be there either.

    Raises
    ------
    OutputError
        Where one cannot be removed.
    """
    try:
        for name in names:
            (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: an earlier {name} cannot be removed: {error}") from error


def remove_listed(folder: Path, names: Iterable[str]) -> None:
    """Remove files of an earlier call from a folder, as a list that it left names them.

    Parameters
    ----------
    folder : Path
        Where that call wrote. What lies elsewhere stays, whatever the list says.
    names : iterable of str
        Paths from there.
    """
    for name in names:
        with contextlib.suppress(OSError, ValueError):
            file = folder / name
            if file.is_file() and file.parent.resolve().is_relative_to(folder.resolve()):
                file.unlink()


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """Yield an empty folder, which becomes `folder` at once when the block ends well.

    An error within the block leaves `folder` as it was. What is in it then goes: whether that may
    be is for the caller to find out.

    Parameters
    ----------
    folder : Path
        The folder's name; a symbolic link is followed.

    Raises
    ------
    OutputError
        Where the folder cannot be written.
    """
    with _told(folder):
        place = Path(os.path.realpath(folder))
        place.parent.mkdir(parents=True, exist_ok=True)
        draft = _draft_in(place.parent)
        earlier = place.with_name(f".{place.name}.earlier")
        _put_back(earlier, place)
        draft.mkdir()
        try:
            with _named_after(folder, draft):
                yield draft
            _handed_to_disk(draft)
            if place.exists():
                os.replace(place, earlier)
            try:
                os.replace(draft, place)
            except OSError:
                _put_back(earlier, place)
                raise
            shutil.rmtree(earlier, ignore_errors=True)
        finally:
            shutil.rmtree(draft, ignore_errors=True)


def _put_back(earlier: Path, place: Path) -> None:
    """Undo a move that a kill or an error has cut in two."""
    if earlier.exists():
        if place.exists():
            shutil.rmtree(earlier)
        else:
            os.replace(earlier, place)


def remove_drafts(folder: Path) -> None:
    """Remove what writes that were killed have left in a folder.

    Parameters
    ----------
    folder : Path
        It need not be there; drafts of processes that still run stay.
    """
    with contextlib.suppress(OSError):
        for name in os.listdir(folder):
            found = _DRAFT.match(name)
            if found and not _runs(int(found[1])):
                left = folder / name
                if left.is_dir():
                    shutil.rmtree(left, ignore_errors=True)
                else:
                    left.unlink(missing_ok=True)


def _draft_in(folder: Path, ending: str = "") -> Path:
    """Return a free name in a folder, which is rid of older drafts."""
    remove_drafts(folder)
    return folder / f".posflock.{os.getpid()}-{next(_NUMBERS)}.part{ending}"


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Tell of a failure to write in words."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror or error})") from error


@contextmanager
def _named_after(folder: Path, draft: Path) -> Iterator[None]:
    """Let errors name the files as they would have been called in the end."""
    try:
        yield
    except OutputError as error:
        raise OutputError(str(error).replace(str(draft), str(folder))) from error


def _mode_for(place: Path) -> int:
    """Return the permissions of a file that takes this place: those of the one that is there."""
    if not place.exists():
        return 0o666
    if not os.access(place, os.W_OK):
        raise PermissionError(None, "the file that is there is write-protected")
    return stat.S_IMODE(place.stat().st_mode)


def _runs(process: int) -> bool:
    """Whether there is a process of this number; where that cannot be asked, there is."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True


def _handed_to_disk(folder: Path) -> list[Path]:
    """Return all files of a folder in order, each with its content on the disk."""
    files = sorted(path for path in folder.rglob("*") if not path.is_dir())
    for file in files:
        _hand_to_disk(file)
    return files


def _hand_to_disk(file: Path) -> None:
    """See that a loss of power after the move finds the content, too."""
    held = os.open(file, os.O_RDWR)
    try:
        os.fsync(held)
    finally:
        os.close(held)
