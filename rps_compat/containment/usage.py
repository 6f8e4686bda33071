"""What a script may use, and a look from outside at what it does.

The kernel limits single processes and single files (`rps_compat.running.limits`), and tells the
script where it asks for more. What several processes or files use together is looked at from
outside, a few times a second, and a run that uses too much is ended.
"""

from __future__ import annotations

import enum
import os
import stat
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rps_compat.containment.processes import Process

#: Seconds between two looks at a folder: it may hold thousands of files.
_LOOK = 0.1
#: Bytes that a file, however small, takes of what a folder may hold.
_ENTRY = 4096


class Resource(str, enum.Enum):
    """What there can be too much of."""

    PROCESSES = "processes"
    MEMORY = "memory"
    DISK = "disk"


@dataclass(frozen=True)
class Surplus:
    """Too much of something.

    Attributes
    ----------
    resource : Resource
        Of what.
    words : str
        How much, and how much there may be.
    """

    resource: Resource
    words: str


@dataclass(frozen=True)
class Allowance:
    """What one run of a script may use.

    Attributes
    ----------
    memory : int
        Bytes of memory that its processes may allocate.
    disk : int
        Bytes that its folder may hold; every file counts as 4 KiB or more.
    output : int
        Bytes that it may print.
    processes : int
        Processes at a time.
    """

    memory: int = 2 << 30
    disk: int = 512 << 20
    output: int = 64 << 20
    processes: int = 32

    def surplus(self, running: Sequence[Process]) -> Surplus | None:
        """Return what running processes use too much of; None where nothing.

        Parameters
        ----------
        running : sequence of Process
            Those of one run.
        """
        if len(running) > self.processes:
            words = f"{len(running)} processes at once, at most {self.processes}"
            return Surplus(Resource.PROCESSES, words)
        memory = sum(process.memory for process in running)
        if len(running) > 1 and memory > self.memory:  # one alone is told so by the kernel
            words = f"{memory >> 20} MiB of memory, at most {self.memory >> 20}"
            return Surplus(Resource.MEMORY, words)
        return None


class FolderWatch:
    """Looks now and then whether a run writes more than it may.

    Parameters
    ----------
    folder : Path
        In which the script writes.
    printed : Path
        File that its output goes to.
    allowance : Allowance
        What it may use.
    """

    def __init__(self, folder: Path, printed: Path, allowance: Allowance) -> None:
        self._folder, self._printed, self._allowance = folder, printed, allowance
        self._next = 0.0

    def surplus(self) -> Surplus | None:
        """Return what there is too much of; None where nothing, or it is not yet time to look."""
        if time.monotonic() < self._next:
            return None
        allowed, words = self._allowance, ""
        if _bytes_of(self._printed) > allowed.output:
            words = f"prints more than {allowed.output >> 20} MiB"
        elif bytes_in(self._folder, allowed.disk) > allowed.disk:
            words = f"files of more than {allowed.disk >> 20} MiB"
        self._next = time.monotonic() + _LOOK
        return Surplus(Resource.DISK, words) if words else None


def bytes_in(folder: Path, enough: int) -> int:
    """Return what the files in a folder take on disk; where it is more than enough, at least that.

    Parameters
    ----------
    folder : Path
        Looked through with all below it, but no link is followed.
    enough : int
        Bytes beyond which nothing more is counted.
    """
    total, left = 0, [os.fspath(folder)]
    while left and total <= enough:
        try:
            entries = os.scandir(left.pop())
        except OSError:  # gone, or closed to us
            continue
        with entries:
            for entry in entries:
                total += max(_bytes_of(entry), _ENTRY)
                if total > enough:
                    break
                if entry.is_dir(follow_symlinks=False):
                    left.append(entry.path)
    return total


def _bytes_of(entry: os.DirEntry[str] | Path) -> int:
    """Return what a file takes on disk: less than its size where it has holes."""
    try:
        found = entry.stat(follow_symlinks=False)
    except OSError:
        return 0
    return found.st_blocks * 512 if stat.S_ISREG(found.st_mode) else 0
