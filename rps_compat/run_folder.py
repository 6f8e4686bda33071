"""The folder that a run writes into: one run at a time, so that no file is of two runs."""

import os
from pathlib import Path

from barrier_certificates import file_lock
from rps_compat.errors import ScriptError
from rps_compat.whole_files import listed_in, remove_earlier, remove_listed

#: How a run went, as text and as data: files of its folder.
REPORT_TEXT, REPORT_DATA = "report.txt", "report.json"

#: Folders that this process holds, by their file descriptors.
_HELD: dict[Path, int] = {}


def asked_folder(out: Path | None, script: Path) -> Path:
    """Return where a run writes if no other run is in the way.

    Parameters
    ----------
    out : Path or None
        The folder that was asked for; None for ``runs/SCRIPT``.
    script : Path
        The script that runs.
    """
    return Path("runs") / script.stem if out is None else out


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
    number, folder = 1, asked_folder(out, script)
    while not _claim(folder):
        number += 1
        folder = folder.with_name(f"{script.stem}-{number}")
    return folder


def forget_report(folder: Path) -> None:
    """Remove what an earlier run told of itself: it is not what the next one will tell.

    Parameters
    ----------
    folder : Path
        Of the run; it need not be there.

    Raises
    ------
    OutputError
        Where an earlier report cannot be removed.
    """
    remove_earlier(folder, (REPORT_TEXT, REPORT_DATA))


def forget_run(folder: Path) -> None:
    """Remove all files of an earlier run, as its report lists them, and the report.

    Parameters
    ----------
    folder : Path
        Of both runs. What lies elsewhere stays, whatever the report says.

    Raises
    ------
    OutputError
        Where the report cannot be removed.
    """
    remove_listed(folder, listed_in(folder / REPORT_DATA))
    forget_report(folder)


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
