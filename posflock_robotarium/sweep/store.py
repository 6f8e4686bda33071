"""Finished runs on disk: append-only, and whole whatever ends the sweep.

A store is a folder of *segments*, text files with one row a line.  Each process that opens
the store for writing begins a segment of its own and only appends to it.  A line carries a
checksum of its row::

    9ae1b0c2 {"key": "5f0c…", "point": 0, "replication": 3, "gamma_settled": 0.997, …}

What can happen, and what follows:

=============================  =========================================================
the sweep is killed            rows handed to :meth:`Store.append` are with the operating
                               system and stay
the machine loses power        rows of the last second may be lost or torn: everything
                               older has been synchronised to the disk
a line is torn or garbled      its checksum fails, it is left out, and its run is computed
                               again; a later segment never continues a torn line
a run is stored twice          the first counts; both are the same but for their CPU time.
                               After one that failed, the next one counts
a segment is deleted           its runs are computed again; the next segment has a new number
two sweeps want one store      the second is refused
=============================  =========================================================
"""

from __future__ import annotations

import json
import os
import time
import zlib
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any

from barrier_certificates.file_lock import try_lock
from posflock_robotarium.flocking.errors import OutputError, PosflockError

Row = dict[str, Any]

#: Where the row of a run that failed says why; it has no outcomes.
ERROR = "run_error"
#: Where a row says who computed it, where the last bits hang on that.
ENGINE = "engine"

#: Seconds of rows that a loss of power may cost.
_SYNCHRONISE_EVERY = 1.0


class StoreError(PosflockError):
    """A store cannot be used as asked."""


class Store:
    """The finished runs of a study.

    Parameters
    ----------
    folder : Path
        Made where missing.

    Attributes
    ----------
    rows : dict of key to row
        Every finished run; one that failed has its reason under `ERROR`.
    torn : int
        Lines that were left out because their checksum failed.

    Raises
    ------
    OutputError
        Where the folder cannot be made or read.
    StoreError
        Where another process writes to it.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with Store(folder) as store:
    ...     store.append([{"key": "a", "gamma": 0.9}])
    >>> with Store(folder) as store:
    ...     store.rows
    {'a': {'key': 'a', 'gamma': 0.9}}
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.torn = 0
        self.rows: dict[str, Row] = {}
        self._segment: int | None = None
        self._synchronised = time.monotonic()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = os.open(folder / "lock", os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise OutputError(f"cannot write into {folder}: {error.strerror}") from error
        try:
            if not try_lock(self._lock):
                raise StoreError(
                    f"another sweep is writing to {folder}; wait for it, or give another --out"
                )
            for segment in sorted(folder.glob("rows-*.jsonl")):
                self._read(segment)
        except BaseException:
            os.close(self._lock)
            raise

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def append(self, rows: Iterable[Row]) -> None:
        """Add finished runs; when this returns they survive the death of the process.

        Parameters
        ----------
        rows : iterable of dict
            Each with a ``key``; values are numbers and strings.

        Raises
        ------
        OutputError
            Where the disk does not take them.
        """
        new = [row for row in rows if ERROR in self.rows.get(row["key"], (ERROR,))]
        block = b"".join(map(_line, new))
        try:
            if self._segment is None:
                self._segment = self._begin_segment()
            _write_all(self._segment, block)
            if time.monotonic() - self._synchronised > _SYNCHRONISE_EVERY:
                self._synchronise()
        except OSError as error:
            raise OutputError(f"cannot append to {self.folder}: {error.strerror}") from error
        self.rows.update({row["key"]: row for row in new})

    def close(self) -> None:
        """Synchronise with the disk and let others write; a second call does nothing."""
        if self._segment is not None:
            self._synchronise()
            os.close(self._segment)
            self._segment = None
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def _begin_segment(self) -> int:
        """Open the next free segment; the folder must know of it before rows are safe."""
        there = [path.stem.partition("-")[2] for path in self.folder.glob("rows-*.jsonl")]
        number = max((int(digits) for digits in there if digits.isdecimal()), default=-1) + 1
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
        segment = os.open(self.folder / f"rows-{number:06d}.jsonl", flags, 0o644)
        if hasattr(os, "O_DIRECTORY"):
            folder = os.open(self.folder, os.O_RDONLY | os.O_DIRECTORY)
            os.fsync(folder)
            os.close(folder)
        return segment

    def _synchronise(self) -> None:
        assert self._segment is not None
        os.fsync(self._segment)
        self._synchronised = time.monotonic()

    def _read(self, segment: Path) -> None:
        try:
            lines = segment.read_bytes().split(b"\n")
        except OSError as error:
            raise OutputError(f"cannot read {segment}: {error.strerror}") from error
        # What follows the last line end is empty, or the head of a torn line.
        for line in lines:
            if not line:
                continue
            row = _row(line)
            if row is None:
                self.torn += 1
            elif ERROR in self.rows.get(row["key"], (ERROR,)):
                self.rows[row["key"]] = row


def _line(row: Row) -> bytes:
    text = json.dumps(row, ensure_ascii=False, separators=(",", ":")).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _row(line: bytes) -> Row | None:
    """Return the row of a line, or None where the line is not what was written."""
    checksum, _, text = line.partition(b" ")
    if checksum != b"%08x" % zlib.crc32(text):
        return None
    row = json.loads(text)
    return row if isinstance(row, dict) and isinstance(row.get("key"), str) else None


def _write_all(file: int, block: bytes) -> None:
    """Write a block; a disk that takes only part of it is asked again."""
    rest = memoryview(block)
    while rest:
        rest = rest[os.write(file, rest) :]
