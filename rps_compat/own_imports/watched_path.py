"""A ``sys.path`` that tells of new folders."""

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from typing import Any


class WatchedPath(list["str"]):
    """A list that tells of itself when something is added; copies of it are plain lists.

    Parameters
    ----------
    entries : iterable of str
        Folders.
    look : callable
        Is called with the list after a change.
    """

    def __init__(self, entries: "Iterable[str]", look: "Callable[[Iterable[str]], None]") -> None:
        super().__init__(entries)
        self._look = look

    def insert(self, index: "Any", entry: str) -> None:
        """Add a folder before another.

        Parameters
        ----------
        index : int
            Place of the other.
        entry : str
            Path of the folder.
        """
        super().insert(index, entry)
        self._look(self)

    def append(self, entry: str) -> None:
        """Add a folder at the end.

        Parameters
        ----------
        entry : str
            Path of the folder.
        """
        super().append(entry)
        self._look(self)

    def extend(self, entries: "Iterable[str]") -> None:
        """Add folders at the end.

        Parameters
        ----------
        entries : iterable of str
            Paths of the folders.
        """
        super().extend(entries)
        self._look(self)

    def __iadd__(self, entries: "Iterable[str]") -> "WatchedPath":  # type: ignore[override]
        self.extend(entries)
        return self

    def __add__(self, entries: "Iterable[str]") -> "WatchedPath":  # type: ignore[override]
        return WatchedPath([*self, *entries], self._look)._seen()

    def __radd__(self, entries: "Iterable[str]") -> "WatchedPath":
        return WatchedPath([*entries, *self], self._look)._seen()

    def _seen(self) -> "WatchedPath":
        self._look(self)
        return self

    def __setitem__(self, index: "Any", value: "Any") -> None:
        super().__setitem__(index, value)
        self._look(self)

    def __reduce__(self) -> "tuple[Any, ...]":
        return list, (list(self),)
