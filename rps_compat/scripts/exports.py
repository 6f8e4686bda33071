"""What modules hand on: the API's own, generation by generation, and the libraries scripts use.

Scripts live on ``from rps.utilities.misc import *``, which brings ``np`` and in generation 1
``plt`` along.
"""

from __future__ import annotations

import importlib
from functools import cache

from rps_compat.scripts.faces import face
from rps_compat.scripts.generation_names import OLD_FUNCTIONS, ROBOTARIUM
from rps_compat.scripts.libraries import IMPORT_NAMES, STANDARD_LIBRARY

#: Modules and their names that the API's modules hand on, under their own paths.
_HANDED_ON = {
    "np": "numpy",
    "plt": "matplotlib.pyplot",
    "patches": "matplotlib.patches",
    "Line2D": "matplotlib.lines.Line2D",
    "PathPatch": "matplotlib.patches.PathPatch",
    "Path": "pathlib.Path",
    "dataclass": "dataclasses.dataclass",
    "NDArray": "numpy.typing.NDArray",
    "comb": "scipy.special.comb",
    "matrix": "cvxopt.matrix",
    "sparse": "cvxopt.sparse",
    "solvers": "cvxopt.solvers",
    "dot": "cvxopt.blas.dot",
    "qp": "cvxopt.solvers.qp",
    "misc": "rps.utilities.misc",
    "Robotarium": ROBOTARIUM,
    "ARobotarium": "rps.robotarium_abc.ARobotarium",
    "RobotariumABC": "rps.robotarium_abc.RobotariumABC",
    "math": "math",
    "time": "time",
    "random": "random",
    "datetime": "datetime",
    "itertools": "itertools",
    "warnings": "warnings",
    "ABC": "abc.ABC",
    "abstractmethod": "abc.abstractmethod",
    "Optional": "typing.Optional",
}
#: What ``import pylab`` is.
_SAME = {"pylab": "matplotlib.pylab"}
#: Modules whose star brings pyplot's names and numpy's.
_PYLAB = "matplotlib.pylab"
#: Modules of the standard library that do something when they are imported.
_NOT_TO_IMPORT = frozenset({"antigravity", "this", "turtle", "turtledemo", "tkinter", "idlelib"})


def handed_on(name: str) -> str | None:
    """Return the dotted path of what the API's modules hand on; None of their own names.

    Parameters
    ----------
    name : str
        What they call it.
    """
    home = _HANDED_ON.get(name)
    return None if home is None or home.startswith("rps.robotarium") else home


def canonical(path: str) -> str:
    """Return the dotted path under which something is known, whoever hands it on.

    Parameters
    ----------
    path : str
        Dotted path.
    """
    top, dot, rest = path.partition(".")
    if top in _SAME:
        return _SAME[top] + dot + rest
    if top == "rps" and "(" not in path:
        module, _, name = path.rpartition(".")
        if name in _HANDED_ON and path != _HANDED_ON[name]:
            return _HANDED_ON[name] if module.count(".") else path
    if path.startswith(_PYLAB + "."):
        name = path.removeprefix(_PYLAB + ".").partition(".")[0]
        home = "matplotlib.pyplot" if _has("matplotlib.pyplot", name) else "numpy"
        return home + path.removeprefix(_PYLAB)
    return path


def exports(path: str, name: str) -> bool | None:
    """Return whether ``from path import *`` brings a name; None where that cannot be known.

    Of the API whether it does in any generation.

    Parameters
    ----------
    path : str
        Dotted path.
    name : str
        Name without dots.
    """
    if path == "rps" or path.startswith("rps."):
        faces = [found for generation in (1, 2) if (found := face(path, generation))]
        old = OLD_FUNCTIONS.get(name)
        if old is not None and path.endswith(f".{old[0]}"):
            return True
        return any(name in found.star for found in faces) if faces else None
    from rps_compat.scripts.changes import change_of

    if change_of(canonical(f"{path}.{name}")) is not None:
        return True
    top = path.partition(".")[0]
    readable = top in STANDARD_LIBRARY or top in IMPORT_NAMES
    if not readable or top in _NOT_TO_IMPORT:
        return None
    return _has(canonical(path), name)


@cache
def _has(path: str, name: str) -> bool | None:
    """Return whether a library's module has a public name, None where it is not installed."""
    try:
        module = importlib.import_module(path)
    except Exception:  # whatever a library's import does
        return None
    listed = getattr(module, "__all__", None)
    return name in listed if listed is not None else hasattr(module, name)
