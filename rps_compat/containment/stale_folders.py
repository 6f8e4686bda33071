"""Temporary folders that are in use are locked; those that are not are removed by the next start.

A lock (``flock``) ends with the last process that has it, however that ends, and holds for other
containers that share the disk. So whether somebody still uses a folder is certain, where process
ids would not be.
"""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import time
from pathlib import Path

from barrier_certificates.file_lock import locks

#: What temporary folders are called, and nothing that anybody would make by hand.
_NAME = re.compile(r"posflock-[a-z]+-[0-9a-f]{16}")
#: Seconds of age below which a folder may have been made but not yet been locked.
_YOUNG = 60.0


def new_name(purpose: str) -> str:
    """Return a name for a temporary folder that no other has.

    Parameters
    ----------
    purpose : str
        What it is for, one word in small letters.
    """
    return f"posflock-{purpose}-{secrets.token_hex(8)}"


def hold(folder: Path) -> int | None:
    """Lock a folder as in use; return the descriptor that does, None where that is not possible.

    Several processes may hold a folder.

    Parameters
    ----------
    folder : Path
        What is in use until the descriptor is closed.
    """
    if locks is None:
        return None
    held = os.open(folder, os.O_RDONLY)
    with contextlib.suppress(OSError):  # not every disk knows locks
        locks.flock(held, locks.LOCK_SH)
    return held


def sweep(place: Path, young: float = _YOUNG) -> None:
    """Remove temporary folders that nobody uses any more.

    Parameters
    ----------
    place : Path
        Folder of temporary folders.
    young : float
        Seconds of age below which a folder is left alone.
    """
    if locks is None:  # Windows: what is in use is not known there
        return
    for folder in [path for path in place.iterdir() if _NAME.fullmatch(path.name)]:
        with contextlib.suppress(OSError):  # in use, another user's, or on a disk without locks
            found = folder.lstat()
            if found.st_uid != os.getuid() or time.time() - found.st_mtime < young:
                continue
            held = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                locks.flock(held, locks.LOCK_EX | locks.LOCK_NB)
                shutil.rmtree(folder, ignore_errors=True)
            finally:
                os.close(held)
