"""Hearing of it when a module has been loaded."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType
    from typing import Any


def after_loading(loader: "Any", then: "Callable[[ModuleType], Any]") -> None:
    """Hear of it when a loader has loaded its module.

    Loaders that are classes, Python's own of what is built in, serve all modules and stay as they
    are.

    Parameters
    ----------
    loader : loader
        Of the module's spec.
    then : callable
        Is called with the module.
    """
    execute = getattr(loader, "exec_module", None)
    if execute is None or isinstance(loader, type):
        return

    def exec_module(module: "ModuleType") -> None:
        execute(module)
        then(module)

    loader.exec_module = exec_module
