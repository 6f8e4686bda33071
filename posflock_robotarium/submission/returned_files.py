"""What a rehearsal brings back, and what is found on opening it."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from barrier_certificates.word_enum import WordEnum
from rps_compat.whole_files import write_whole, written_together


class FileState(WordEnum):
    """What a file that came back is found to be."""

    POSE_LOG = "pose log"
    READABLE = "readable"
    UNREADABLE = "unreadable"


@dataclass(frozen=True)
class ReturnedFile:
    """What was found on opening a file.

    Attributes
    ----------
    state : FileState
        What it is.
    about : str
        How much is in it, in words.
    """

    state: FileState
    about: str

    def __str__(self) -> str:
        return f"{self.state.value}, {self.about}"


def bring_back(scratch: Path, out: Path, uploaded: set[str], said: str) -> list[str]:
    """Copy what the script wrote, as the testbed returns it; return the files' names.

    Parameters
    ----------
    scratch : Path
        Folder in which the script ran.
    out : Path
        Where the files are put.
    uploaded : set of str
        Names of files that were there before.
    said : str
        What the script printed, for ``log.txt``.
    """
    back = ["log.txt"]
    with written_together(out) as draft:
        write_whole(draft / "log.txt", said.encode(errors="replace"))
        for path in sorted(scratch.rglob("*")):
            name = str(path.relative_to(scratch))
            # A link leads to a file of this machine, not of the testbed.
            plain = path.is_file() and not path.is_symlink()
            if plain and name not in uploaded and "__pycache__" not in path.parts:
                (draft / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, draft / name)
                back.append(name)
    return back


def describe_file(path: Path) -> ReturnedFile:
    """Open a returned file and say what it is.

    Parameters
    ----------
    path : Path
        A file that came back.
    """
    from posflock_robotarium.flocking.errors import LogError
    from posflock_robotarium.logs.readers import read_pose_log
    from posflock_robotarium.verify.data_files import read_back

    if path.suffix == ".npy":
        try:
            log = read_pose_log(path)
        except LogError:
            pass
        else:
            end = "unknown" if log.ending is None else log.ending.how.value
            last = f"{log.t[-1]:.1f} s" if len(log.t) else "nothing"
            about = f"{log.robots} robots, {len(log.t)} rows until {last}, {end}"
            return ReturnedFile(FileState.POSE_LOG, about)
    content = read_back(path)
    state = FileState.READABLE if content.readable else FileState.UNREADABLE
    return ReturnedFile(state, f"{content.size} bytes")
