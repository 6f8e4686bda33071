"""Who imports decides: a file beside the script hides nothing from the libraries, nor from us.

Python looks for modules beside the script first. There, numpy would find a ``random.py`` and this
package a ``barrier_certificates.py``, where they want Python's own and ours. And in a process that
has loaded those already, the script would be given them instead of its own file. So a module that
lies beside the script and has the name of one of the *environment* (the standard library,
installed libraries, this project) is kept twice:

- In ``sys.modules`` stands the environment's. Libraries, threads and C code find what they always
  find, at no cost.
- The script's own stands aside, in :class:`~.script_modules.ScriptModules`. Imports written in the
  script, or in any other file that is not the environment's, are answered from there.

The file in which an import is written tells the two apart (:mod:`~.whose`), for ``import`` as for
``importlib.import_module``. As long as the environment does not ask for a name (nobody imports
Python's package ``test``), the script's module stands in ``sys.modules`` as usual. Where nothing is
hidden, nothing is changed.

These modules are the first of ours to be loaded, when nothing yet keeps the script's files away.
They import only what no file can hide: what is built in, and what Python loads before any script.
"""

import os
import sys

from rps_compat.own_imports.hidden_names import HiddenNames
from rps_compat.own_imports.last_resort import LastResort
from rps_compat.own_imports.whose import HOME, OURS

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from types import TracebackType

__all__ = ["HiddenNames", "KeptApart", "keep_apart", "leave_current_folder"]

_names: "HiddenNames | None" = None


def keep_apart(folder: "str | None" = None) -> HiddenNames:
    """Keep the script's modules and the environment's apart, from now on.

    Parameters
    ----------
    folder
        Folder of the script; by default that of ``__main__``.
    """
    global _names
    if _names is None:
        _names = HiddenNames(folder)
    _names.watch()
    LastResort.stand_by()
    return _names


class KeptApart:
    """:func:`keep_apart` for a ``with`` block; what was before it is back after it.

    Parameters
    ----------
    folder
        Folder of the script.
    """

    def __init__(self, folder: str) -> None:
        self._folder = folder

    def __enter__(self) -> HiddenNames:
        global _names
        self._before, _names = _names, None
        return keep_apart(self._folder)

    def __exit__(
        self,
        kind: "type[BaseException] | None",
        error: "BaseException | None",
        trace: "TracebackType | None",
    ) -> None:
        global _names
        if _names is not None:
            _names.end()
        _names = self._before


def leave_current_folder() -> None:
    """Take the current folder off the path where ``python -m`` runs a command of ours.

    Python has put it there, before everything else, and what lies in it is the user's.
    """
    words = ["", *sys.orig_argv]
    ours = any(
        words[k].startswith("-") and words[k].endswith("m") and word.partition(".")[0] in OURS
        for k, word in enumerate(sys.orig_argv)
    )
    if ours and sys.path[:1] == [os.getcwd()] and sys.path[0] != HOME:
        del sys.path[0]
