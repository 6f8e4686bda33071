"""What a contained process finds: which folders it may write in, which are its own."""

from __future__ import annotations

import os
from dataclasses import dataclass

#: Folders that are the script's own there: whatever others have in them is not to be seen.
PRIVATE = ("/tmp", "/var/tmp", "/run")
#: Bytes that such a folder may hold, all of them in memory.
PRIVATE_SIZE = 64 << 20
#: The same, and who may use it, as the kernel wants to be told.
PRIVATE_OPTIONS = f"size={PRIVATE_SIZE},mode=1777"


@dataclass(frozen=True)
class Room:
    """What a contained process finds.

    Attributes
    ----------
    writable : tuple of str
        Folders that it may write in.
    readable : tuple of str
        Folders that must be there even if they lie in one of the `PRIVATE` ones; one that does not
        exist is passed over, since Python's path may have such.
    folder : str
        Where it starts.
    as_init : bool
        Whether it is the first process there, which no other can end or stop; then all that the
        others leave is its children, and signals that it does not handle do nothing to it.
    """

    writable: tuple[str, ...]
    readable: tuple[str, ...] = ()
    folder: str = "/"
    as_init: bool = False

    @property
    def shown(self) -> list[str]:
        """The readable folders that would be hidden otherwise, where there are any; each once."""
        hidden = tuple(f"{place}/" for place in PRIVATE)
        paths = dict.fromkeys(os.path.realpath(path) for path in self.readable)
        return [path for path in paths if path.startswith(hidden) and os.path.exists(path)]


def private_folders() -> list[str]:
    """Return those of the `PRIVATE` folders that there are here."""
    return [place for place in PRIVATE if os.path.isdir(place) and not os.path.islink(place)]
