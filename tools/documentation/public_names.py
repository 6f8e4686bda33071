"""What is public: everything that `__all__` leads to from the three packages, and nothing else.

A package lists its public modules there, a module its public names. A listed module that has no
`__all__` means its functions, its classes and its CONSTANTS that have no leading underscore. A
package that has none means those of its modules that have one: that is so for the two faces of the
Robotarium's API alone, since ``from rps.utilities import *`` brings no modules in the published
packages, either.

An object may be handed on by several modules; its entry stands in the one that defines it, where
that is public, else in the first that lists it.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from types import ModuleType, UnionType
from typing import get_origin

from rps_compat.deferred import Deferred

PACKAGES = ("barrier_certificates", "rps_compat", "posflock_robotarium")


@dataclass(frozen=True)
class PublicName:
    """A name, the module that lists it, and what it stands for.

    Attributes
    ----------
    module, name : str
        Where it is listed, and how it is called there.
    value : object
        The function, class, constant or name of a type.
    """

    module: str
    name: str
    value: object

    @property
    def path(self) -> str:
        """The dotted path by which it is imported."""
        return f"{self.module}.{self.name}"

    @property
    def origin(self) -> str:
        """The dotted path of its definition."""
        if isinstance(self.value, type) or inspect.isroutine(self.value):
            return f"{self.value.__module__}.{self.value.__qualname__}"
        return _assigned_at(self.module, self.name)

    @property
    def kind(self) -> str:
        """Which directive documents it, of autodoc's but for ``type``, a name of a type."""
        if isinstance(self.value, type):
            return "exception" if issubclass(self.value, BaseException) else "class"
        if inspect.isroutine(self.value):
            return "function"
        names_a_type = get_origin(self.value) is not None or isinstance(self.value, UnionType)
        return "type" if names_a_type else "data"


@dataclass(frozen=True)
class PublicSurface:
    """Every public module, with the names and modules that it lists.

    Attributes
    ----------
    modules : dict of ModuleType
        By dotted path, packages before what is in them.
    names : tuple of PublicName
        Every name of every module, those that are handed on included.
    """

    modules: dict[str, ModuleType]
    names: tuple[PublicName, ...]

    @cached_property
    def entries(self) -> dict[str, str]:
        """Every path of a name → the path under which it is documented."""
        first: dict[str, str] = {}
        for name in self.names:
            if name.path == name.origin or name.origin not in first:
                first[name.origin] = name.path
        return {name.path: first[name.origin] for name in self.names}

    @cached_property
    def documented(self) -> dict[str, PublicName]:
        """The names that have an entry of their own, by the path of that."""
        return {name.path: name for name in self.names if self.entries[name.path] == name.path}

    def children(self, module: str) -> list[str]:
        """Return the paths of the public modules directly below one.

        Parameters
        ----------
        module : str
            Its dotted path.
        """
        return [path for path in self.modules if self._parent(path) == module]

    def _parent(self, path: str) -> str | None:
        """Return the nearest public module above; of a face's there may be none in between."""
        while "." in path:
            path = path.rpartition(".")[0]
            if path in self.modules:
                return path
        return None


def public_surface() -> PublicSurface:
    """Import all that is public, and return it.

    Raises
    ------
    AttributeError
        A module lists a name that it does not have.
    """
    modules: dict[str, ModuleType] = {}
    names: list[PublicName] = []
    waiting = list(PACKAGES)
    while waiting:
        path = waiting.pop(0)
        module = modules[path] = importlib.import_module(path)
        below: list[str] = []
        for name in _listed(module):
            if _is_module(module, name):
                below.append(f"{path}.{name}")
            elif _is_ours(module, name):
                names.append(PublicName(path, name, getattr(module, name)))
        waiting[:0] = below
    return PublicSurface(modules, tuple(names))


def _listed(module: ModuleType) -> list[str]:
    listed = getattr(module, "__all__", None)
    if listed is not None:
        return list(listed)
    if hasattr(module, "__path__"):
        return list(_with_a_list(module))
    constants, _ = _bindings(module.__name__)
    return [
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and (
            name in constants and name.isupper()
            if not isinstance(value, type) and not inspect.isroutine(value)
            else value.__module__ == module.__name__
        )
    ]


def _with_a_list(package: ModuleType) -> Iterator[str]:
    """Yield the modules of a package, and of packages in it, that list their names."""
    prefix = f"{package.__name__}."
    for found in pkgutil.walk_packages(package.__path__, prefix):
        if not found.ispkg and hasattr(importlib.import_module(found.name), "__all__"):
            yield found.name.removeprefix(prefix)


def _is_module(parent: ModuleType, name: str) -> bool:
    """Return whether a listed name is a module of the project; `parent` may not have it yet."""
    value = getattr(parent, name, None)
    if isinstance(value, ModuleType):
        return value.__name__ == f"{parent.__name__}.{name}"
    return not hasattr(parent, name)


def _is_ours(module: ModuleType, name: str) -> bool:
    """Return whether a listed object is the project's: faces hand numpy and others on, too."""
    value = getattr(module, name)
    if isinstance(value, ModuleType | Deferred):
        return False
    if isinstance(value, type) or inspect.isroutine(value):
        return str(value.__module__).partition(".")[0] in PACKAGES
    return _assigned_at(module.__name__, name).partition(".")[0] in PACKAGES


def _assigned_at(module: str, name: str) -> str:
    """Return the path of a constant where it is assigned, following imports within the project."""
    constants, imported = _bindings(module)
    if name in constants or name not in imported:
        return f"{module}.{name}"
    home, there = imported[name]
    return _assigned_at(home, there) if home.partition(".")[0] in PACKAGES else f"{home}.{there}"


@cache
def _bindings(module: str) -> tuple[set[str], dict[str, tuple[str, str]]]:
    """Return what a module assigns at its top, and what it imports: name → module and name."""
    assigned: set[str] = set()
    imported: dict[str, tuple[str, str]] = {}
    for line in ast.parse(inspect.getsource(importlib.import_module(module))).body:
        if isinstance(line, ast.Assign):
            assigned |= {target.id for target in line.targets if isinstance(target, ast.Name)}
        elif isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
            assigned.add(line.target.id)
        elif isinstance(line, ast.ImportFrom) and line.module is not None:
            for name in line.names:
                imported[name.asname or name.name] = (line.module, name.name)
    return assigned, imported
