"""Which study the tables and figures of a folder are of: ``study.json``, written last.

The store of a folder may hold runs of many studies, its tables and figures are of one. When another
one begins, or the same one in other words, those of the earlier go before anything is computed: so
whatever ends a sweep, nothing in its folder is another's.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from posflock_robotarium.sweep.study import Study
from rps_compat.bounded_files import read_bounded
from rps_compat.whole_files import listed_in, remove_earlier, remove_listed, write_whole

LISTING = "study.json"
"""The study as its file says it, the digest of its code, and the files that are of it."""


def forget_other_study(study: Study, folder: Path) -> None:
    """Remove tables and figures of any other study than this one.

    Parameters
    ----------
    study : Study
        The one that begins.
    folder : Path
        Where its tables and figures will be; it need not be there. What no listing names stays,
        and so does all where there is no listing.

    Raises
    ------
    OutputError
        Where an earlier listing cannot be removed.
    """
    listing = folder / LISTING
    try:
        said = json.loads(read_bounded(listing))["study"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return
    if said != _identity(study):
        remove_listed(folder, listed_in(listing))
        remove_earlier(folder, [LISTING])


def list_files(study: Study, folder: Path, files: Sequence[Path]) -> Path:
    """Write which study the files of a folder are of; remove those that it no longer has.

    Parameters
    ----------
    study : Study
        The one whose runs they show.
    folder : Path
        Where all its tables and figures are.
    files : sequence of Path
        All of them.

    Returns
    -------
    Path
        The listing.

    Raises
    ------
    OutputError
        Where it cannot be written.
    """
    listing = folder / LISTING
    names = [path.relative_to(folder).as_posix() for path in files]
    remove_listed(folder, set(listed_in(listing)) - set(names))
    told = {"study": _identity(study), "files": names}
    return write_whole(listing, json.dumps(told, indent=1) + "\n")


def _identity(study: Study) -> object:
    """Return what a study and its code are told by, as JSON gives it back."""
    said: object = json.loads(json.dumps({**study.said, "code": study.code}))
    return said
