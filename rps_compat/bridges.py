"""What libraries dropped, given back while a script runs.

Most public Robotarium scripts were written for numpy 1; ``np.mat`` and ``np.float`` alone stop many
of them. The testbed's versions have dropped less than the newest have: ``np.trapz`` and
``matplotlib.cm.get_cmap`` run there, and so does ``float(array)`` of an array of one element. While
a script runs here it finds such names, with the meaning that they had
(:mod:`rps_compat.scripts.changes` lists them), and such conversions work.
"""

from __future__ import annotations

import builtins
import contextlib
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import math
import warnings
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import numpy as np

from rps_compat.one_element_arrays import one_element_conversions
from rps_compat.own_imports.whose import is_environments_module
from rps_compat.scripts.changes import CHANGES, Change, Kind
from rps_compat.when_imported import when_imported


def _get_cmap(name: Any = None, lut: int | None = None) -> Any:
    from matplotlib import pyplot as plt

    return plt.get_cmap(name, lut)


def _plot_date(x: Any, y: Any, fmt: str = "o", *args: Any, **options: Any) -> Any:
    from matplotlib import pyplot as plt

    for axis in ("x", "y"):
        if options.pop(f"{axis}date", axis == "x"):
            getattr(plt.gca(), f"{axis}axis_date")(options.get("tz"))
    options.pop("tz", None)
    return plt.plot(x, y, fmt, *args, **options)


def _sph_harm(m: Any, n: Any, theta: Any, phi: Any) -> Any:
    from scipy.special import sph_harm_y

    return sph_harm_y(n, m, phi, theta)


def _asfarray(a: Any, dtype: Any = np.float64) -> Any:
    inexact = np.issubdtype(np.dtype(dtype), np.inexact)
    return np.asarray(a, dtype=dtype if inexact else np.float64)


#: Functions of the same meaning where no name can take the old one's place.
_MADE: dict[str, Any] = {
    "matplotlib.cm.get_cmap": _get_cmap,
    "matplotlib.pyplot.plot_date": _plot_date,
    "matplotlib.pyplot.hold": lambda *args, **options: None,
    "scipy.linalg.kron": np.kron,
    "scipy.special.sph_harm": _sph_harm,
    "numpy.asfarray": _asfarray,
    "numpy.asscalar": lambda a: a.item(),
    "numpy.msort": lambda a: np.sort(a, axis=0),
    "numpy.math": math,
    "fractions.gcd": math.gcd,
}


def _missing(module: ModuleType, kinds: frozenset[Kind]) -> dict[str, Any]:
    """Return what `module` has dropped, of these kinds, and what can stand in for it."""
    found = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy has words for some that it dropped
        for change in _of_module().get(module.__name__, ()):
            if change.kind in kinds and not hasattr(module, change.name):
                with contextlib.suppress(ImportError, AttributeError):
                    found[change.name] = _stand_in(module, change)
    return found


def _of_module() -> dict[str, list[Change]]:
    if not _BY_MODULE:
        for path, change in CHANGES.items():
            if change.kind is not Kind.NEWER and (change.code or path in _MADE):
                _BY_MODULE.setdefault(path.rpartition(".")[0], []).append(change)
    return _BY_MODULE


_BY_MODULE: dict[str, list[Change]] = {}


def _stand_in(module: ModuleType, change: Change) -> Any:
    if change.path in _MADE:
        return _MADE[change.path]
    code = change.code
    if code.isidentifier():
        return getattr(builtins, code)
    if "(" in code or code[0].isdigit():  # a number, such as -inf
        return eval(code.replace("{}", "module"), {"module": module})
    value: Any = module
    for part in code.removeprefix("{}").strip(".").split("."):
        if isinstance(value, ModuleType) and not hasattr(value, part):
            importlib.import_module(f"{value.__name__}.{part}")
        value = getattr(value, part)
    return value


@contextlib.contextmanager
def dropped_names(*kinds: Kind) -> Iterator[None]:
    """Let modules have, within the ``with`` block, what they have dropped.

    Parameters
    ----------
    *kinds : Kind
        ``GONE``: what the testbed's versions have not either; ``LATER``: what they have.
    """
    given: list[tuple[ModuleType, str]] = []

    def give(module: ModuleType) -> None:
        if not is_environments_module(module):  # a file of the script's by the same name
            return
        for name, value in _missing(module, frozenset(kinds)).items():
            setattr(module, name, value)
            given.append((module, name))

    try:
        with when_imported(_of_module(), give):
            yield
    finally:
        for module, name in given:
            with contextlib.suppress(AttributeError):
                delattr(module, name)


#: Lasts as long as the process.
FOR_GOOD = contextlib.ExitStack()


def bridge(around: contextlib.ExitStack, *kinds: Kind) -> None:
    """Give back, for as long as `around` lasts, what libraries dropped.

    Parameters
    ----------
    around : contextlib.ExitStack
        What takes it away again when it is closed.
    *kinds : Kind
        As for `dropped_names`; all that a script of any age finds here, if none is given.
    """
    around.enter_context(dropped_names(*(kinds or (Kind.GONE, Kind.LATER))))
    around.enter_context(one_element_conversions())
