"""Which solvers there are, which is chosen when, and what to install for one that is missing.

All share one signature, ``solve(rows, which, target, options) -> point | None``: the point nearest
to the target that satisfies the chosen rows, or None if there is none. One module each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import NamedTuple

from barrier_certificates.certificate_errors import ParameterError, SolverNotInstalledError
from barrier_certificates.rows import FloatArray, IntArray, Rows

Solve = Callable[[Rows, IntArray, FloatArray, Mapping[str, float]], "FloatArray | None"]


class _Solver(NamedTuple):
    module: str
    needs: str
    extra: str


_SOLVERS = {
    "nnls": _Solver("nnls", "scipy", ""),
}

NAMES = tuple(_SOLVERS)
"""The solvers that can be asked for by name."""


def check(name: str) -> None:
    """Refuse a solver that does not exist or is not installed.

    Raises
    ------
    ParameterError
        If there is no solver of this name.
    SolverNotInstalledError
        If it is not installed; the message says what brings it.
    """
    if name == "auto":
        return
    if name not in _SOLVERS:
        raise ParameterError(f"solver is {name!r}; expected 'auto' or one of {', '.join(NAMES)}")
    if not installed(name):
        solver = _SOLVERS[name]
        extra = f"[{solver.extra}]" if solver.extra else ""
        raise SolverNotInstalledError(
            f"solver {name!r} needs {solver.needs}, which is not installed: "
            f"pip install 'posflock-robotarium{extra}'"
        )


@cache
def installed(name: str) -> bool:
    """Whether a solver's library can be imported."""
    return find_spec(_SOLVERS[name].needs) is not None


def choose(name: str, size: int) -> str:
    """Return the exact solver for a problem of this many unknowns."""
    return "nnls" if name == "auto" else name


@cache
def load(name: str) -> Solve:
    """Import a solver's module and return its ``solve``."""
    module = import_module(f"barrier_certificates.{_SOLVERS[name].module}")
    solve: Solve = module.solve
    return solve
