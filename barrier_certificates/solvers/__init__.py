"""Who solves a small program: a registry, and one module a solver, all with one signature.

Each is a `QpSolver`: it finds the point nearest to a target that satisfies chosen rows. A new
solver is one file, ``solve_NAME.py`` with a class, and one entry below, which says what it needs
and imports it when it is first asked for. `active_set` is the guess that answers most steps before
any of them is asked, and that turns an approximate optimum into the exact one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib.util import find_spec
from typing import NamedTuple

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError, SolverNotInstalledError
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.solvers.qp_solver import QpSolver
from barrier_certificates.solvers.solve_nnls import Nnls

__all__ = ["NAMES", "QpSolver", "check", "choose", "confirm", "installed", "load", "solve"]

LARGE = 120
"""From this number of unknowns on, a sparse solver is chosen where one is installed."""


class _Solver(NamedTuple):
    needs: str
    extra: str
    load: Callable[[], QpSolver]


_SOLVERS: dict[str, _Solver] = {}


def _register(
    name: str, needs: str = "", extra: str = ""
) -> Callable[[Callable[[], QpSolver]], Callable[[], QpSolver]]:
    """Enter a solver: its name, the library it needs, and the extra that brings that.

    The library goes by the solver's name, and comes with the default install, unless said.
    """

    def enter(load: Callable[[], QpSolver]) -> Callable[[], QpSolver]:
        _SOLVERS[name] = _Solver(needs or name, extra, load)
        return load

    return enter


@_register("nnls", needs="scipy")
def _() -> QpSolver:
    return Nnls()  # imported at once: on the testbed, the first hard step must not wait


@_register("daqp", extra="fast")
def _() -> QpSolver:
    from barrier_certificates.solvers.solve_daqp import Daqp

    return Daqp()


@_register("clarabel")
def _() -> QpSolver:
    from barrier_certificates.solvers.solve_clarabel import Clarabel

    return Clarabel()


@_register("piqp", extra="fast")
def _() -> QpSolver:
    from barrier_certificates.solvers.solve_piqp import Piqp

    return Piqp()


@_register("osqp")
def _() -> QpSolver:
    from barrier_certificates.solvers.solve_osqp import Osqp

    return Osqp()


@_register("cvxopt", extra="cvxopt")
def _() -> QpSolver:
    from barrier_certificates.solvers.solve_cvxopt import Cvxopt

    return Cvxopt()


@_register("cvxpy")
def _() -> QpSolver:
    from barrier_certificates.solvers.solve_cvxpy import Cvxpy

    return Cvxpy()


NAMES = tuple(_SOLVERS)
"""The solvers that can be asked for by name."""

_SMALL_FIRST = ("daqp", "nnls")
_LARGE_FIRST = ("piqp", "clarabel", "cvxopt", "daqp", "nnls")
_CONFIRM_LARGE = ("clarabel", "cvxopt", "nnls")


def check(name: str) -> None:
    """Refuse a solver that does not exist or is not installed; ``"auto"`` always passes.

    Parameters
    ----------
    name : str
        Name of a solver, or ``"auto"``.

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
        # What comes with the default install is missing where that was made without it.
        what = f"'posflock-robotarium[{solver.extra}]'" if solver.extra else solver.needs
        raise SolverNotInstalledError(
            f"solver {name!r} needs {solver.needs}, which is not installed: pip install {what}"
        )


@cache
def installed(name: str) -> bool:
    """Whether a solver's library can be imported, and its module was not left out of an upload.

    Parameters
    ----------
    name : str
        Name of a solver.
    """
    try:
        parts = (_SOLVERS[name].needs, f"{__name__}.solve_{name}")
        return all(find_spec(part) is not None for part in parts)
    except ImportError:
        return False


def choose(name: str, size: int) -> str:
    """Return the solver named, or for ``"auto"`` the best there is for so many unknowns.

    Parameters
    ----------
    name : str
        Name of a solver, or ``"auto"``.
    size : int
        Number of unknowns, two a robot.
    """
    if name != "auto":
        return name
    order = _SMALL_FIRST if size < LARGE else _LARGE_FIRST
    return next(name for name in order if installed(name))


def confirm(asked: Iterable[str], size: int) -> str | None:
    """Return who is asked next where the solvers asked so far find no point that satisfies all.

    Parameters
    ----------
    asked : iterable of str
        Solvers that have found none.
    size : int
        Number of unknowns, two a robot.

    Returns
    -------
    str or None
        A solver's name; None where nobody is left to ask.
    """
    order = ("nnls",) if size < LARGE else _CONFIRM_LARGE
    return next((name for name in order if name not in asked and installed(name)), None)


@cache
def load(name: str) -> QpSolver:
    """Return a solver, importing it now.

    Parameters
    ----------
    name : str
        Name of a solver.

    Raises
    ------
    ParameterError
        If there is no solver of this name.
    SolverNotInstalledError
        If it is not installed.
    """
    check(name)
    return _SOLVERS[name].load()


def solve(
    name: str, rows: Rows, which: IntArray, target: FloatArray, options: Mapping[str, float]
) -> FloatArray | None:
    """Ask the solver named; see `QpSolver.solve`.

    Parameters
    ----------
    name : str
        Name of a solver.
    rows : Rows
        All rows.
    which : (k,) integer array
        Indices of the rows to satisfy.
    target : (size,) array
        The point to be projected, m/s.
    options : mapping
        The solver's own options, by its own names.

    Returns
    -------
    (size,) array or None
        The nearest point, m/s; None if there is none.

    Raises
    ------
    ParameterError
        If the options are not what this solver takes; the message has its own words.
    """
    if not options:
        return load(name).solve(rows, which, target, options)
    try:
        return load(name).solve(rows, which, target, options)
    except (AttributeError, TypeError, ValueError) as error:
        raise ParameterError(
            f"options of solver {name!r} are {dict(options)}; expected its own, by its own names: "
            f"{str(error).splitlines()[0]}"
        ) from error
