"""The folder that a run writes into: one run at a time, so that no file is of two runs."""

import os
from pathlib import Path

from barrier_certificates import file_lock
from rps_compat.errors import ScriptError

#: Folders that this process holds, by their file descriptors.
_HELD: dict[Path, int] = {}


def claimed_folder(out: Path | None, script: Path) -> Path:
    """Make the folder of a run, and hold it until this process ends.

    Parameters
    ----------
    out : Path or None
        The folder that was asked for; None for ``runs/SCRIPT``, or ``runs/SCRIPT-2`` and so on
        where other runs of the script are still writing.
    script : Path
        The script that runs.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    ScriptError
        The folder cannot be made, or another run is writing into the one that was asked for.
    """
    if out is not None:
        if not _claim(out):
            raise ScriptError(
                f"{out}: another run is writing into this folder; choose another (-o), or wait"
                " until it has ended"
            )
        return out
    number, folder = 1, Path("runs") / script.stem
    while not _claim(folder):
        number += 1
        folder = folder.with_name(f"{script.stem}-{number}")
    return folder


def _claim(folder: Path) -> bool:
    """Make `folder`, and lock it for this process; False where another has it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        place = folder.resolve()
        if not file_lock.KNOWN or place in _HELD:
            return True
        held = os.open(place, os.O_RDONLY)
    except OSError as error:
        raise ScriptError(f"cannot write to {folder}: {error.strerror or error}") from error
    if not file_lock.try_lock(held):
        os.close(held)
        return False
    _HELD[place] = held  # the lock ends with the process
    return True
