"""Reading files of which nothing is known yet: plain files only, and no larger than expected.

A pipe that nobody writes to, a device without an end, or a file of gigabytes under a harmless name
is an error before it costs time or memory.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

#: Bytes of a file that a person writes: a script, a study, a profile, a manifest.
WRITTEN_BY_HAND = 16 << 20


def read_bounded(path: Path, largest: int = WRITTEN_BY_HAND) -> bytes:
    """Return what a plain file holds.

    Parameters
    ----------
    path : Path
        The file; a symbolic link is followed.
    largest : int
        Bytes that it may have.

    Raises
    ------
    OSError
        Where it cannot be read, is a pipe, a device or a folder, or is larger. `strerror` says
        which, without the file's name.
    """
    # Opening a pipe would wait for somebody who writes to it.
    file = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(file, "rb") as stream:
        found = os.fstat(file)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(None, f"expected a plain file, got {kind_of(found.st_mode)}")
        if found.st_size > largest:
            raise OSError(
                None,
                f"{found.st_size} bytes, more than the {largest} that such a file may have",
            )
        return stream.read(largest)


def kind_of(mode: int) -> str:
    """Return what a file is, in words.

    Parameters
    ----------
    mode : int
        As `os.stat` gives it.
    """
    for is_kind, words in (
        (stat.S_ISREG, "a plain file"),
        (stat.S_ISDIR, "a folder"),
        (stat.S_ISFIFO, "a pipe"),
        (stat.S_ISSOCK, "a socket"),
    ):
        if is_kind(mode):
            return words
    return "a device"
