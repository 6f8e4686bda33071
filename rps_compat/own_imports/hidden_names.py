"""Answers the imports of hidden names by who imports; see :mod:`rps_compat.own_imports`."""

import builtins
import os
import sys
from _frozen_importlib_external import PathFinder
from _imp import is_frozen

from rps_compat.own_imports.loading import after_loading
from rps_compat.own_imports.script_modules import ScriptModules
from rps_compat.own_imports.watched_path import WatchedPath
from rps_compat.own_imports.whose import (
    OPTIONAL,
    OURS,
    add_script_folder,
    asks_for_itself,
    find_environments,
    forget_script_folders,
    is_environments,
    is_environments_code,
    is_environments_module,
    is_installation,
    modules_in,
)

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from types import FrameType, ModuleType
    from typing import Any

#: Modules that no file of a script can hide: Python has them before it looks for any.
_FIRST = frozenset(sys.builtin_module_names) | frozenset(
    {
        "_collections_abc", "_sitebuiltins", "abc", "codecs", "encodings", "genericpath", "io",
        "ntpath", "os", "posixpath", "site", "stat", "zipimport", "__main__",
    }
)  # fmt: skip
#: What looks classes up by the name of their module, which may have to be imported for that.
_UNPICKLERS = ("pickle", "_pickle", "copyreg", "multiprocessing", "concurrent")


class HiddenNames:
    """Answers every import of a hidden name by who imports.

    Parameters
    ----------
    folder
        Folder of the script; by default that of ``__main__``.

    Attributes
    ----------
    files : dict of str
        Modules of the environment that are hidden, and the files of the script that do so.
    claimed : set of str
        Those of them that the environment has asked for: ``sys.modules`` has the environment's.
    asked : set of str
        Those of them that the script has asked for.
    """

    def __init__(self, folder: "str | None" = None) -> None:
        self.files: dict[str, str] = {}
        self.claimed: set[str] = set()
        self.asked: set[str] = set()
        self._scripts = ScriptModules()
        self._lent: dict[str, Any] = {}
        self._absent: set[str] = set()
        self._before: tuple[Any, Any] | None = None
        self._environments: frozenset[str] | None = None
        if folder is None:
            # A process that `multiprocessing` starts has the script under another name.
            script = sys.modules.get("__mp_main__") or sys.modules.get("__main__")
            main = getattr(script, "__file__", None)
            folder = os.path.dirname(os.path.abspath(main)) if main else os.getcwd()
        self._seen: set[str] = set()
        self._folder = folder
        add_script_folder(folder)
        self._path = sys.path
        self.look([folder, *sys.path])

    def watch(self) -> None:
        """Look at ``sys.path``, now and whenever the script adds to it."""
        if not isinstance(sys.path, WatchedPath):
            sys.path = WatchedPath(sys.path, self.look)
        self.look(sys.path)

    def look(self, path: "Iterable[str]") -> None:
        """See what modules in new folders of the script hide.

        Parameters
        ----------
        path : iterable of str
            Folders, as on ``sys.path``.
        """
        found: set[str] = set()
        path = list(path)
        for entry in path:
            folder = os.path.abspath(entry)
            if folder in self._seen or is_installation(folder):
                continue
            self._seen.add(folder)
            add_script_folder(folder)
            found |= self._names() & modules_in(folder)
        self._hide(
            {name: file for name in found - self.files.keys() if (file := _hiding(name, path))}
        )

    def _names(self) -> "frozenset[str]":
        """Names of the environment's modules."""
        if self._environments is None:
            names = {*sys.stdlib_module_names, *OURS, *OPTIONAL}
            for folder in map(os.path.abspath, sys.path):
                if is_installation(folder):
                    names |= modules_in(folder)
            self._environments = frozenset(names) - _FIRST
        return self._environments

    def _hide(self, names: "dict[str, str]") -> None:
        if not names:
            return
        self.files |= names
        for name in names.keys() & sys.modules.keys():
            if is_environments_module(sys.modules[name]):
                self._claim(name)
            else:
                self.asked.add(name)
        if self._before is None:
            self._begin()
        for name in names.keys() - self.claimed:
            if find_environments(name) is None:
                # Another system's, or not installed: who tries whether it is there finds nothing.
                self._claim(name)
                sys.modules[name] = None  # type: ignore[assignment]
                self._absent.add(name)

    def _begin(self) -> None:
        python = builtins.__import__
        sys.meta_path.insert(0, self)
        builtins.__import__ = self._import_statement(python)
        import importlib  # the environment's, from here on

        self._before = (python, importlib.import_module)
        importlib.import_module = self._import_call(importlib.import_module)

    def _import_statement(self, python: "Callable[..., ModuleType]") -> "Callable[..., ModuleType]":
        def __import__(  # noqa: N807 - Python's own name
            name: str,
            globals: "dict[str, Any] | None" = None,
            locals: "dict[str, Any] | None" = None,
            fromlist: "Sequence[str] | None" = (),
            level: int = 0,
        ) -> "ModuleType":
            full = _absolute(name, level, globals) if level else name
            top = full.partition(".")[0]
            # C code imports with an empty list, and looks into sys.modules afterwards.
            if (
                top in self.files
                and fromlist != []
                and self._is_scripts(top, globals, sys._getframe(1))
            ):
                return self._scripts.answer(full, fromlist)
            return python(name, globals, locals, fromlist, level)

        return __import__

    def _import_call(self, python: "Callable[..., ModuleType]") -> "Callable[..., ModuleType]":
        def import_module(name: str, package: "str | None" = None) -> "ModuleType":
            """Import a module; see Python's own ``importlib.import_module``."""
            level = len(name) - len(name.lstrip("."))
            full = _absolute(name[level:], level, {"__package__": package}) if level else name
            top, caller = full.partition(".")[0], sys._getframe(1)
            if top in self.files and self._is_scripts(top, caller.f_globals, caller):
                return self._scripts.load(full)
            return python(name, package)

        return import_module

    def _is_scripts(self, top: str, variables: "dict[str, Any] | None", frame: "FrameType") -> bool:
        """Whether the script's module stands aside and is to answer this import."""
        if is_environments_code(variables, frame):
            self._claim(top)
            return False
        self.asked.add(top)
        return top in self.claimed  # if not, Python finds the script's by itself

    def _claim(self, name: str) -> None:
        """Let ``sys.modules`` have the environment's module, from its next import on."""
        if name not in self.claimed:
            self.claimed.add(name)
            module = sys.modules.get(name)
            if module is not None and not is_environments_module(module):
                self._scripts.take(name)
        self._lend(name)

    def keep_aside(self, module: "ModuleType") -> None:
        """Take over a module of the script that stood in the place of one of ours.

        Parameters
        ----------
        module : module
            The script's module.
        """
        self._scripts.modules[module.__name__] = module

    def find_spec(self, name: str, path: "Any" = None, target: "Any" = None) -> "Any":
        """Find the environment's module of a hidden name, unless the script asks for its own.

        Parameters
        ----------
        name : str
            Dotted name of the module.
        path : iterable of str or None
            Folders of its package; None for a top-level module.
        target : module, optional
            Python's; nothing depends on it.
        """
        if path is not None or name not in self.files:
            return None
        if name not in self.claimed:
            if not asks_for_itself(nobody=True):
                return None
            self._claim(name)
        spec = find_environments(name)
        if spec is not None:
            after_loading(spec.loader, lambda module: self._lend(name))
        return spec

    def _lend(self, name: str) -> None:
        """Let the environment's module answer for classes and functions of the script's own.

        They say that they are of module `name`, and who looks them up there, as `pickle` does,
        must find them.
        """
        module = sys.modules.get(name)
        if module is None or name in self._lent or not is_environments_module(module):
            return
        before = self._lent[name] = vars(module).get("__getattr__")

        def __getattr__(attribute: str) -> "Any":  # noqa: N807 - Python's own name
            if before is not None:
                try:
                    return before(attribute)
                except AttributeError:
                    pass
            if not attribute.startswith("__"):
                own = self._scripts.modules.get(name)
                if own is None and _unpickles(sys._getframe(1)):
                    own = self._scripts.load(name)
                found = None if own is None else vars(own).get(attribute)
                if getattr(found, "__module__", "") == name and hasattr(found, "__qualname__"):
                    return found
            raise AttributeError(f"module {name!r} has no attribute {attribute!r}")

        vars(module)["__getattr__"] = __getattr__

    def end(self) -> None:
        """Leave imports and ``sys.path`` as they were."""
        sys.path = self._path
        forget_script_folders(self._seen | {self._folder})
        if self._before is None:
            return
        sys.meta_path[:] = [finder for finder in sys.meta_path if finder is not self]
        import importlib

        builtins.__import__, importlib.import_module = self._before
        self._before = None
        for name in self._absent:
            if sys.modules.get(name, self) is None:
                del sys.modules[name]
        for name, before in self._lent.items():
            module = sys.modules.get(name)
            if module is not None:
                vars(module).pop("__getattr__", None)
                if before is not None:
                    vars(module)["__getattr__"] = before
        self._lent.clear()


def _hiding(name: str, path: "list[str]") -> "str | None":
    """Return the script's file that comes before the environment's module on `path`, if any."""
    if is_frozen(name):  # Python brings it in itself
        return None
    spec = PathFinder.find_spec(name, path)
    if spec is None or spec.loader is None or is_environments(spec.origin):
        return None
    return spec.origin


def _absolute(name: str, level: int, variables: "dict[str, Any] | None") -> str:
    """Resolve a relative import of code with these global `variables`; empty if it has no place."""
    if variables is None:
        return ""
    package = variables.get("__package__")
    if package is None:
        package = str(variables.get("__name__", ""))
        if "__path__" not in variables:
            package = package.rpartition(".")[0]
    base = package.split(".")
    return ".".join([*base[: len(base) - level + 1], *([name] if name else [])])


def _unpickles(frame: "FrameType") -> bool:
    """Whether `frame` looks for classes by name, rather than asks what a library can do."""
    if str(frame.f_globals.get("__name__", "")).partition(".")[0] in _UNPICKLERS:
        return True
    return not is_environments_code(frame.f_globals, frame)
