"""What a file of an upload may be called.

Uploads are flat, lie beside one another on machines of every kind, and are listed in files of
lines. A name from a script, a command line or a `MANIFEST` is therefore no path, has nothing that
could end a line or command a terminal, and differs from every other one in more than its case.
"""

from __future__ import annotations

from collections.abc import Iterable

from posflock_robotarium.flocking.errors import PosflockError
from rps_compat.scripts import libraries
from rps_compat.terminal import printable

#: Bytes of a name that every file system takes, room for a draft's ending left.
_LONGEST = 200
#: What some file system, or the list of files, gives a meaning of its own.
_SPECIAL = '\\/:*?"<>|`'
#: Names that are not those of uploaded files.
_RESERVED = ("manifest", "submit.md")


class BundleError(PosflockError):
    """The script cannot be laid flat as it is; the message says why, and the way out."""


def require_upload_names(names: Iterable[str]) -> None:
    """Refuse names that no file of an upload may have.

    Parameters
    ----------
    names : iterable of str
        All names of one upload.

    Raises
    ------
    BundleError
        Naming the first such name, the reason and what is expected.
    """
    taken: dict[str, str] = {}
    for name in names:
        reason = _fault_of(name)
        if not reason and taken.setdefault(name.casefold(), name) != name:
            other = printable(taken[name.casefold()])
            reason = f"differs from {other!r} in its case alone, which not every machine sees"
        if reason:
            raise BundleError(
                f"a file of an upload cannot be called {printable(name)!r}: it {reason}; rename it"
            )


def _fault_of(name: str) -> str:
    """Return why no file of an upload may have a name; empty where it may."""
    if not name.strip(". "):
        return "is no name"
    if name != name.strip():
        return "begins or ends with a blank"
    if not name.isprintable():
        return "holds characters that cannot be printed"
    special = sorted(set(name) & set(_SPECIAL))
    if special:
        return f"holds {' '.join(special)}, and uploads are flat files of plain names"
    if name.startswith("-"):
        return "begins like an option"
    if name.casefold() in _RESERVED:
        return "is the bundle's own list of files"
    if len(name.encode()) > _LONGEST:
        return f"has more than {_LONGEST} bytes"
    return ""


def hidden_by(name: str) -> str | None:
    """Return what an uploaded file would hide from every import, in words; None if nothing.

    Parameters
    ----------
    name : str
        Of the file.
    """
    stem, dot, ending = name.partition(".")
    if not dot or ending.lower() != "py":
        return None
    if stem.lower() == "main":
        return "the main file, which the testbed runs as main.py"
    return libraries.shadowed_by(stem)
