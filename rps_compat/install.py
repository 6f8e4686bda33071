"""Let ``import rps`` mean this package, in this process.

A meta-path finder answers every import of ``rps`` and what lies below it with the module of the
same name under :mod:`rps_compat.v1` or :mod:`rps_compat.v2`. It is the very same module object,
not a copy, so a class has one identity whichever name it was imported by.
"""

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from rps_compat.errors import RobotariumError
from rps_compat.generations import Generation
from rps_compat.session import Session, use


class UnknownGenerationError(RobotariumError, ValueError):
    """There are two generations of the API, 1 and 2."""


class ExampleScriptError(RobotariumError, ModuleNotFoundError):
    """A published example is imported as a module, which would run it."""


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def __init__(self, generation: Generation) -> None:
        self.generation = generation

    def _target(self, name: str) -> str:
        return f"rps_compat.v{self.generation}" + name.removeprefix("rps")

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname != "rps" and not fullname.startswith("rps."):
            return None
        ours = importlib.util.find_spec(self._target(fullname))
        if ours is None:
            if fullname.startswith("rps.examples."):
                raise ExampleScriptError(
                    f"there is no module {fullname!r} here: the published examples are scripts, "
                    "which run when they are imported; save the one that you want as a file and "
                    "run it",
                    name=fullname,
                )
            return None
        return importlib.machinery.ModuleSpec(
            fullname, self, is_package=ours.submodule_search_locations is not None
        )

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        module = importlib.import_module(self._target(spec.name))
        spec.loader_state = module.__spec__  # importlib overwrites it before exec_module
        return module

    def exec_module(self, module: ModuleType) -> None:
        alias = module.__spec__
        assert alias is not None
        module.__spec__ = alias.loader_state


def installed() -> Generation | None:
    """Which generation ``import rps`` means in this process; None when it is not ours."""
    return next((f.generation for f in sys.meta_path if isinstance(f, _Finder)), None)


def install(generation: int = 2, session: Session | None = None) -> None:
    """Make ``import rps`` mean this generation in this process, from the next import on.

    Modules of another generation, or of another simulator, that were imported as ``rps`` before
    are forgotten; names that were already taken from them stay what they were.

    Parameters
    ----------
    generation
        Generation 1 or 2.
    session
        How instances are built from now on; None leaves that as it is.

    Raises
    ------
    UnknownGenerationError
        It is neither 1 nor 2.

    Examples
    --------
    >>> import rps_compat
    >>> rps_compat.install(generation=2)
    >>> from rps.robotarium import Robotarium
    >>> Robotarium.TIME_STEP
    0.033
    >>> rps_compat.uninstall()
    """
    if generation not in (1, 2):
        raise UnknownGenerationError(
            f"generation={generation!r}: the generations of the API are 1 and 2"
        )
    if session is not None:
        use(session)
    uninstall()
    sys.meta_path.insert(0, _Finder(1 if generation == 1 else 2))
    importlib.invalidate_caches()


def uninstall() -> None:
    """Undo :func:`install`: ``import rps`` looks on ``sys.path`` again."""
    sys.meta_path[:] = [f for f in sys.meta_path if not isinstance(f, _Finder)]
    for name in [n for n in sys.modules if n == "rps" or n.startswith("rps.")]:
        del sys.modules[name]


def import_path(generation: int) -> Path:
    """Return the folder that, on ``PYTHONPATH``, makes ``import rps`` mean a generation.

    Parameters
    ----------
    generation : int
        Of the API: 1 or 2.

    Raises
    ------
    UnknownGenerationError
        If there is no such generation.
    """
    if generation not in (1, 2):
        raise UnknownGenerationError(
            f"generation={generation!r}: the generations of the API are 1 and 2"
        )
    return Path(__file__).parent / "import_paths" / f"generation{generation}"
