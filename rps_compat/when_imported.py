"""Something to do to a module as soon as it is there, which may be never.

A run changes matplotlib and gives libraries back what they dropped. Importing them all for that
would cost every script their seconds; so this waits until somebody does.
"""

from __future__ import annotations

import contextlib
import importlib.abc
import importlib.machinery
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from types import ModuleType

from rps_compat.own_imports.loading import after_loading


class _Listener(importlib.abc.MetaPathFinder):
    """Finds modules as Python would, and hears of it when they have been imported."""

    def __init__(self, names: Collection[str], then: Callable[[ModuleType], None]) -> None:
        self._names, self._then = names, then

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname not in self._names:
            return None
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            if spec := finder.find_spec(fullname, path, target):
                after_loading(spec.loader, self._then)
                return spec
        return None


@contextlib.contextmanager
def when_imported(names: Collection[str], then: Callable[[ModuleType], None]) -> Iterator[None]:
    """Call `then` with each module of `names`, as soon as it is there, within the ``with`` block.

    Parameters
    ----------
    names
        Dotted paths of modules.
    then
        Is called at once with those that are there.
    """
    listener = _Listener(names, then)
    for name in names:
        if name in sys.modules:
            then(sys.modules[name])
    sys.meta_path.insert(0, listener)
    try:
        yield
    finally:
        sys.meta_path.remove(listener)
