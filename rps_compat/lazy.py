"""Modules that are imported when something in them is first used.

Scripts written for the Robotarium get ``plt`` from star imports, so our modules must offer the
name; a headless run must not pay for matplotlib. A :class:`LazyModule` is both: the name is there,
the import happens at the first attribute.
"""

import importlib
from types import ModuleType
from typing import Any


class LazyModule(ModuleType):
    """Stands for the module `name` and becomes it at the first use of an attribute.

    Parameters
    ----------
    name : str
        Dotted name of the module.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name, f"The module {name}, imported when first used.")

    def __getattr__(self, attribute: str) -> Any:
        if attribute in ("__path__", "__file__", "__wrapped__"):
            raise AttributeError(attribute)  # asked by introspection, which should import nothing
        return getattr(importlib.import_module(self.__name__), attribute)

    def __setattr__(self, attribute: str, value: Any) -> None:
        if attribute.startswith("__"):
            super().__setattr__(attribute, value)
        else:
            setattr(importlib.import_module(self.__name__), attribute, value)

    def __dir__(self) -> list[str]:
        return dir(importlib.import_module(self.__name__))
