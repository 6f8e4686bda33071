"""Which solvers there are, which is chosen when, and what to install for one that is missing.

All share one signature, one module each::

    solve(rows, which, target, options) -> point or None

the point nearest to the target that satisfies the chosen rows (`Rows` and the indices of those to
satisfy), or None if there is none. Options are the solver's own, by their own names, and hold for
the one call.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib.util import find_spec
from typing import NamedTuple

from barrier_certificates.certificate_errors import ParameterError, SolverNotInstalledError
from barrier_certificates.rows import FloatArray, IntArray, Rows
from barrier_certificates.solve_nnls import solve as _solve_nnls

Solve = Callable[[Rows, IntArray, FloatArray, Mapping[str, float]], "FloatArray | None"]

LARGE = 120
"""From this number of unknowns on, a sparse solver is chosen where one is installed."""


class _Solver(NamedTuple):
    needs: str
    extra: str
    load: Callable[[], Solve]


def _daqp() -> Solve:
    from barrier_certificates.solve_daqp import solve

    return solve


def _clarabel() -> Solve:
    from barrier_certificates.solve_clarabel import solve

    return solve


def _piqp() -> Solve:
    from barrier_certificates.solve_piqp import solve

    return solve


def _osqp() -> Solve:
    from barrier_certificates.solve_osqp import solve

    return solve


def _cvxopt() -> Solve:
    from barrier_certificates.solve_cvxopt import solve

    return solve


def _cvxpy() -> Solve:
    from barrier_certificates.solve_cvxpy import solve

    return solve


_SOLVERS = {
    "nnls": _Solver("scipy", "", lambda: _solve_nnls),
    "daqp": _Solver("daqp", "fast", _daqp),
    "clarabel": _Solver("clarabel", "", _clarabel),
    "piqp": _Solver("piqp", "fast", _piqp),
    "osqp": _Solver("osqp", "", _osqp),
    "cvxopt": _Solver("cvxopt", "cvxopt", _cvxopt),
    "cvxpy": _Solver("cvxpy", "", _cvxpy),
}

NAMES = tuple(_SOLVERS)
"""The solvers that can be asked for by name."""

_SMALL_FIRST = ("daqp", "nnls")
_CONFIRM_LARGE = ("clarabel", "cvxopt", "nnls")
_LARGE_FIRST = ("piqp", "clarabel", "cvxopt", "daqp", "nnls")


def check(name: str) -> None:
    """Refuse a solver that does not exist or is not installed; ``"auto"`` always passes.

    Raises
    ------
    ParameterError
        If there is no solver of this name.
    SolverNotInstalledError
        If it is not installed; the message says what brings it.
    """
    if name == "auto":
        return
    if name not in NAMES:
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
    try:
        return find_spec(_SOLVERS[name].needs) is not None
    except ImportError:
        return False


def choose(name: str, size: int) -> str:
    """Return the solver named, or for ``"auto"`` the best there is for so many unknowns."""
    if name != "auto":
        return name
    order = _SMALL_FIRST if size < LARGE else _LARGE_FIRST
    return next(name for name in order if installed(name))


def confirm(name: str, size: int) -> str:
    """Return the solver whose word counts when another one finds no point that satisfies all."""
    if size < LARGE:
        return "nnls"
    return next(other for other in _CONFIRM_LARGE if other != name and installed(other))


@cache
def load(name: str) -> Solve:
    """Return the ``solve`` of a solver, importing it now."""
    check(name)
    return _SOLVERS[name].load()


def solve(
    name: str, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
) -> FloatArray | None:
    """Ask the solver named for the point nearest to the target, see the top of this module.

    Raises
    ------
    ParameterError
        If the options are not what this solver takes; the message has its own words.
    """
    if not options:
        return load(name)(rows, which, target, options)
    try:
        return load(name)(rows, which, target, options)
    except (AttributeError, TypeError, ValueError) as error:
        raise ParameterError(
            f"options of solver {name!r} are {dict(options)}; expected its own, by its own names: "
            f"{str(error).splitlines()[0]}"
        ) from error
