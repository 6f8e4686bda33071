"""What the environment imports is found even if the script has changed ``sys.path``."""

import os
import sys
from _frozen_importlib_external import PathFinder

from rps_compat.own_imports.whose import (
    HOME,
    OURS,
    asks_for_itself,
    is_installation,
)

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from typing import Any


class LastResort:
    """The finder that is asked last: for our packages, and for what they and the libraries need."""

    def __init__(self) -> None:
        self._path = [entry for entry in sys.path if is_installation(os.path.abspath(entry))]

    @classmethod
    def stand_by(cls) -> None:
        """Be asked last, once."""
        if not any(isinstance(finder, cls) for finder in sys.meta_path):
            sys.meta_path.append(cls())

    def find_spec(self, name: str, path: "Any" = None, target: "Any" = None) -> "Any":
        """Find a top-level module that is on no folder of ``sys.path`` any more.

        Parameters
        ----------
        name : str
            Dotted name of the module.
        path : iterable of str or None
            Folders of its package; None for a top-level module.
        target : module, optional
            Python's; nothing depends on it.
        """
        if path is not None:
            return None
        if name in OURS:
            return PathFinder.find_spec(name, [HOME])
        if not asks_for_itself(nobody=False):
            return None
        return PathFinder.find_spec(name, self._path)
