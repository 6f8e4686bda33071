"""Names that the published modules re-export, imported when a script uses them.

Scripts that star-import a certificate module find ``matrix``, ``qp`` and ``sparse`` there. CVXOPT
is not installed by default (it is under the GPL), and it takes its time to import, as parts of
SciPy do; these stand-ins import what they stand for when it is first used.
"""

import importlib
from typing import Any

from rps_compat.errors import RobotariumError


class MissingExtraError(RobotariumError, ImportError):
    """An optional package is used that is not installed; the message says how to install it."""


class Deferred:
    """Stands for the object `name` of the module `module` of `package`, imported when used.

    Parameters
    ----------
    package : str
        What has to be installed.
    module : str
        The module, by its dotted name.
    name : str
        The object in it; empty for the module itself.
    """

    def __init__(self, package: str, module: str, name: str = "") -> None:
        self._package, self._module, self._name = package, module, name

    def _object(self) -> Any:
        try:
            module = importlib.import_module(self._module)
        except ImportError as error:
            raise MissingExtraError(
                f"{self._name or self._module} belongs to {self._package}, which is not installed: "
                f"pip install {self._package}"
            ) from error
        return getattr(module, self._name) if self._name else module

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call what it stands for.

        Parameters
        ----------
        *args, **kwargs
            Handed on unchanged to what it stands for.
        """
        return self._object()(*args, **kwargs)

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("__"):  # asked by introspection, which should import nothing
            raise AttributeError(attribute)
        return getattr(self._object(), attribute)

    def __instancecheck__(self, instance: object) -> bool:
        """Let ``isinstance(x, matrix)`` ask the real class."""
        return isinstance(instance, self._object())


matrix: Any = Deferred("cvxopt", "cvxopt", "matrix")
sparse: Any = Deferred("cvxopt", "cvxopt", "sparse")
qp: Any = Deferred("cvxopt", "cvxopt.solvers", "qp")
solvers: Any = Deferred("cvxopt", "cvxopt.solvers")
quadprog: Any = Deferred("quadprog", "quadprog")
comb: Any = Deferred("scipy", "scipy.special", "comb")
