"""The script's modules whose names the environment needs as well: a small import system."""

import sys
from _frozen_importlib import module_from_spec
from _frozen_importlib_external import PathFinder
from _thread import RLock

from rps_compat.own_imports.whose import is_environments, is_environments_module

TYPE_CHECKING = False  # typing's own may be hidden
if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import ModuleType

#: Seconds for which a thread waits until another has imported.
_PATIENCE = 10


class ScriptModules:
    """Modules of the script that do not stand in ``sys.modules``.

    Attributes
    ----------
    modules : dict
        By dotted name, as ``sys.modules`` has them.
    """

    def __init__(self) -> None:
        self.modules: dict[str, ModuleType] = {}
        self._lock = RLock()

    def load(self, name: str) -> "ModuleType":
        """Import a module of the script, as Python would.

        Parameters
        ----------
        name : str
            Its dotted name.

        Raises
        ------
        ModuleNotFoundError
            There is none.
        """
        # As from Python's own imports, of two threads that wait for each other one gets what is
        # there.
        held = self._lock.acquire(timeout=_PATIENCE)
        try:
            return self.modules.get(name) or self._load(name)
        finally:
            if held:
                self._lock.release()

    def _load(self, name: str) -> "ModuleType":
        parent, _, last = name.rpartition(".")
        places = None
        if parent:
            package = self.load(parent)
            if name in self.modules:  # the package has imported it
                return self.modules[name]
            places = getattr(package, "__path__", None)
            if places is None:
                raise _not_found(name, f"; {parent!r} is not a package")
        spec = PathFinder.find_spec(name, places)
        if spec is None:
            raise _not_found(name)
        if not parent and is_environments(spec.origin):
            __import__(name)  # the script has taken its own folder off the path
            return sys.modules[name]
        module = self.modules[name] = module_from_spec(spec)
        stands = sys.modules.get(name)
        try:
            if spec.loader is not None:  # a folder without __init__.py has none
                spec.loader.exec_module(module)
        except BaseException:
            self.modules.pop(name, None)
            raise
        finally:
            self._keep_aside(name, stands)
        module = self.modules[name]
        if parent:
            setattr(self.modules[parent], last, module)
        return module

    def _keep_aside(self, name: str, stands: "ModuleType | None") -> None:
        """Take over what a module has put in its own place in ``sys.modules``, as some do."""
        left = sys.modules.get(name)
        if left is None or left is stands or is_environments_module(left):
            return
        del sys.modules[name]
        if stands is not None:
            sys.modules[name] = stands
        if name in self.modules:
            self.modules[name] = left

    def answer(self, name: str, wanted: "Sequence[str] | None") -> "ModuleType":
        """Answer an import statement.

        Parameters
        ----------
        name : str
            Dotted name of the module.
        wanted : sequence of str or None
            What the statement takes from it; None or empty for the module itself.
        """
        module = self.load(name)
        if not wanted:
            return self.modules.get(name.partition(".")[0], module)
        if hasattr(module, "__path__"):
            for submodule in getattr(module, "__all__", ()) if "*" in wanted else wanted:
                if not hasattr(module, submodule):
                    full = f"{module.__name__}.{submodule}"
                    try:
                        self.load(full)
                    except ModuleNotFoundError as error:
                        if error.name != full:
                            raise
        return module

    def take(self, name: str) -> None:
        """Take a module, and what lies below it, out of ``sys.modules``.

        Parameters
        ----------
        name : str
            Its dotted name.
        """
        for full in [n for n in sys.modules if n == name or n.startswith(f"{name}.")]:
            self.modules[full] = sys.modules.pop(full)


def _not_found(name: str, why: str = "") -> ModuleNotFoundError:
    return ModuleNotFoundError(f"No module named {name!r}{why}", name=name)
