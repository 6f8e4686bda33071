"""Rows on disk that no end of the process, and no full disk, takes back.

A `RowFile` is a NumPy file of one structured array. Its space is taken when it is opened, filled
with rows that hold nothing, and each row is written over one of these when it is appended: so a row
is in the operating system's hands at once, a disk that fills up costs no finished row, and a kill
at any moment leaves a file that ``numpy.load`` reads. `close` cuts off what was not reached.

A file has one writer. While it is open, a second run is refused its name; a process that was forked
cannot append; and should the folder be removed meanwhile, `close` writes the rows again.
"""

from __future__ import annotations

import hashlib
import io
import os
import weakref
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy

from barrier_certificates.file_lock import KNOWN, try_lock
from posflock_robotarium.flocking.errors import LogError, OutputError

#: Rows that are written at once where a file is made or grows.
_CHUNK = 1024


class RowFile:
    """Write rows to a NumPy file, one by one.

    Parameters
    ----------
    path : Path
        Where, NAME.npy; the folder is made where there is none, an earlier run's file replaced, and
        NAME.json, which describes that, removed just before.
    unreached : (1,) structured array
        A row that holds nothing, and so the structure of all.
    room : int
        Rows to take space for; more may be appended.

    Attributes
    ----------
    path : Path
        Where the rows are.
    rows : int
        How many were appended.

    Raises
    ------
    OSError
        The file cannot be written. Nothing has happened by then.
    OutputError
        Another run is writing it.
    """

    def __init__(self, path: Path, unreached: Any, room: int) -> None:
        self.path, self.rows = path, 0
        self._unreached, self._room = unreached.copy(), room
        self._bytes_a_row = int(unreached.dtype.itemsize)
        self._offset = len(self._header(room))
        self._open()
        _OPEN.add(self)

    @property
    def is_open(self) -> bool:
        """Whether rows may be appended: false once closed, and in a forked process."""
        return self._close.alive

    def append(self, row: Any) -> None:
        """Write the next row.

        Parameters
        ----------
        row : (M,) array of bytes
            All fields of the row.

        Raises
        ------
        OSError
            The disk takes no more; the rows before are kept.
        LogError
            The file is closed, or another process's.
        """
        if not self._close.alive:
            raise LogError(
                f"{self.path}: closed, or opened by the process that this one was forked from;"
                " a process that drives robots opens a log of its own"
            )
        if self.rows == self._room:
            self._grow()
        self._write(self._offset + self.rows * self._bytes_a_row, row)
        self.rows += 1

    def finish(self) -> None:
        """Cut off the rows that were not reached, and see that the file has its name.

        Raises
        ------
        OSError
            The disk does not take that; the rows are kept.
        """
        if not self._is_in_place():
            self._write_again()
        # First the header, then the file: a kill between the two leaves bytes that nobody reads.
        self._write(0, self._header(self.rows))
        os.ftruncate(self._file, self._offset + self.rows * self._bytes_a_row)
        os.fsync(self._file)

    def digest(self) -> str:
        """Return the digest of the rows that were appended, as `digest_of` makes it."""
        return digest_of(self._chunks())

    def _chunks(self) -> Iterator[bytes]:
        os.lseek(self._file, self._offset, os.SEEK_SET)
        left = self.rows * self._bytes_a_row
        while left and (chunk := os.read(self._file, min(left, 1 << 20))):
            left -= len(chunk)
            yield chunk

    def close(self) -> None:
        """Close the file, which lets others have its name; a second call changes nothing."""
        self._close()

    def _open(self) -> None:
        """Make the file with all its rows, and put it in the place of an earlier run's."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        draft = self.path.with_name(f"{self.path.name}.{os.getpid()}.part")
        with _claimed(self.path):
            self._hold(draft, os.O_CREAT | os.O_TRUNC)
            try:
                self._write(0, self._header(self._room))
                self._write_unreached(0, self._room)
                try_lock(self._file)
                self.path.with_suffix(".json").unlink(missing_ok=True)
                if not KNOWN:  # Windows moves no open file
                    self._close()
                os.replace(draft, self.path)
                if not KNOWN:
                    self._hold(self.path)
            except BaseException:
                self._close()
                draft.unlink(missing_ok=True)
                raise

    def _hold(self, path: Path, more: int = 0) -> None:
        self._file = os.open(path, os.O_RDWR | getattr(os, "O_BINARY", 0) | more, 0o666)
        self._close = weakref.finalize(self, os.close, self._file)

    def _grow(self) -> None:
        """Double the file: first the rows, then the header that admits to them."""
        header = self._header(2 * self._room)
        # NumPy pads its headers so that the row count may gain digits in place.
        if len(header) != self._offset:
            raise LogError(f"{self.path}: cannot grow beyond {self._room} rows; ask for more")
        self._write_unreached(self._room, self._room)
        self._write(0, header)
        self._room *= 2

    def _write_unreached(self, first: int, count: int) -> None:
        chunk = np.repeat(self._unreached, min(count, _CHUNK)).view(np.uint8)
        for row in range(first, first + count, _CHUNK):
            size = min(first + count - row, _CHUNK) * self._bytes_a_row
            self._write(self._offset + row * self._bytes_a_row, chunk[:size])

    def _write(self, offset: int, data: Any) -> None:
        written = _write_at(self._file, data, offset)
        while written < len(data):  # the disk is full: the next call fails, and says so
            written += _write_at(self._file, memoryview(data)[written:], offset + written)

    def _header(self, rows: int) -> bytes:
        kind = npy.dtype_to_descr(self._unreached.dtype)
        out = io.BytesIO()
        npy.write_array_header_1_0(out, {"descr": kind, "fortran_order": False, "shape": (rows,)})
        return out.getvalue()

    def _is_in_place(self) -> bool:
        """Whether the file that is written to is the one that has the name."""
        try:
            return os.path.samestat(os.stat(self.path), os.fstat(self._file))
        except OSError:
            return False

    def _write_again(self) -> None:
        """Write all rows anew, since the folder was removed, or another run took the name."""
        stem, number = self.path.stem, 1
        while self.path.exists():
            number += 1
            self.path = self.path.with_name(f"{stem}-{number}.npy")
        lost, close_lost = self._file, self._close
        self._room = max(self.rows, 1)
        self._open()
        os.lseek(lost, self._offset, os.SEEK_SET)
        for row in range(self.rows):
            place = self._offset + row * self._bytes_a_row
            self._write(place, os.read(lost, self._bytes_a_row))
        close_lost()


def digest_of(chunks: Iterable[Any]) -> str:
    """Return what tells the rows of one run from those of every other: 16 hexadecimal digits.

    Parameters
    ----------
    chunks : iterable of bytes
        The rows as they lie in the file, in parts of any size.
    """
    digest = hashlib.sha256()
    for chunk in chunks:
        digest.update(chunk)
    return digest.hexdigest()[:16]


def _seek_and_write(file: int, data: Any, offset: int) -> int:
    os.lseek(file, offset, os.SEEK_SET)
    return os.write(file, data)


_write_at = getattr(os, "pwrite", _seek_and_write)

#: Files that this process is writing.
_OPEN: weakref.WeakSet[RowFile] = weakref.WeakSet()


def _leave_to_parent() -> None:
    """Close the files that a forked process inherits: a row of both would be a row of neither."""
    for file in list(_OPEN):
        file.close()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


@contextmanager
def _claimed(path: Path) -> Iterator[None]:
    """Hold the lock of an earlier run's file, so that nobody else replaces it meanwhile."""
    try:
        file = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        yield
        return
    try:
        if not try_lock(file):
            raise OutputError(
                f"cannot write {path}: another run is writing it; choose another folder, or wait"
                " until it has ended"
            )
        yield
    finally:
        os.close(file)
