"""Which functions are compiled, by what, and where compiled code is kept: the one place.

A kernel is a plain Python function on numbers and arrays. Where numba is installed it is compiled
at its first call and kept on disk, so that the next process starts at once; elsewhere it stays what
it is, and whoever asks for compiled code is told which extra brings it. No kernel asks for
``fastmath``: the order of operations stays as it is written.

numba notices when the file of a kernel changes, but not when that of another kernel does which it
calls. So compiled code is kept under a digest of all the sources that went into it.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, TypeVar, cast, get_args

from barrier_certificates.certificate_errors import EngineNotInstalledError, ParameterError

Function = TypeVar("Function", bound=Callable[..., Any])
Result = TypeVar("Result")

Engine = Literal["auto", "numba", "numpy"]
"""Who computes: compiled code, numpy, or the first of the two that is installed."""

_PARTS: dict[int, Callable[..., Any]] = {}
"""Kernels that kernels call: by the identity of what is compiled, what it is compiled from."""


@cache
def numba_is_installed() -> bool:
    """Whether kernels are compiled here."""
    return find_spec("numba") is not None


def _numba() -> Any:
    """Return numba, of whose types nothing is known where it is not installed."""
    return import_module("numba")


def is_compiled(engine: str) -> bool:
    """Whether an engine is compiled code.

    Parameters
    ----------
    engine : {"auto", "numba", "numpy"}
        What was asked for.

    Raises
    ------
    ParameterError
        If there is no such engine.
    EngineNotInstalledError
        If numba is asked for but not installed; the message says what brings it.
    """
    if engine not in get_args(Engine):
        raise ParameterError(f"engine is {engine!r}; expected one of {', '.join(get_args(Engine))}")
    if engine == "numba" and not numba_is_installed():
        raise EngineNotInstalledError(
            "engine 'numba' needs numba, which is not installed: pip install "
            "'posflock-robotarium[fast]'; engine 'numpy' needs nothing"
        )
    return engine != "numpy" and numba_is_installed()


def entered(function: Function) -> Function:
    """Compile a kernel that Python calls, where numba is installed, and keep it on disk.

    Named tuples are handed over as plain ones, and given their names inside: numba looks up the
    class of each at every call, which takes four times as long as the arrays in it.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and tuples of them, which calls only such, and kernels.
    """
    if not numba_is_installed():
        return function
    numba = _numba()
    folder, before = _folder(_digest(function)), numba.config.CACHE_DIR
    try:
        numba.config.CACHE_DIR = folder or before
        return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy")(function))
    except RuntimeError:  # no place to keep it: compiled anew in each process
        return cast(Function, numba.njit(nogil=True, error_model="numpy")(function))
    finally:
        numba.config.CACHE_DIR = before


def compiled(function: Function) -> Function:
    """Compile a kernel that only kernels call, where numba is installed, into each of these.

    A call would hand over an array as seven numbers, which takes longer than many a loop. Nor does
    such a kernel count who refers to an array, an eighth of a robot's step each time: it makes none
    that lives on, and its callers hold those that it is given.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and tuples of them, which calls only such, and kernels, and
        makes no arrays.
    """
    return _inlined(function, _nrt=False)


def makes_arrays(function: Function) -> Function:
    """Compile a kernel that makes arrays for its caller, into each kernel that calls it.

    Parameters
    ----------
    function : callable
        A function as for `compiled`.
    """
    return _inlined(function)


def _inlined(function: Function, **more: bool) -> Function:
    if not numba_is_installed():
        return function
    options = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "forceinline": True}
    kernel = _numba().njit(nogil=True, error_model="numpy", **options, **more)(function)
    _PARTS[id(kernel)] = function
    return cast(Function, kernel)


def over_teams(
    kernel: Callable[..., Result], teams: int, threads: int | None, *arguments: Any
) -> list[Result]:
    """Call a kernel for all teams, in parts side by side where that pays.

    Parameters
    ----------
    kernel : callable
        Takes the first team, the last but one, and the arguments; teams do not touch each other.
    teams : int
        Number of teams, B.
    threads : int, optional
        How many parts at most; one for each processor of this process if None.
    *arguments : (...) array
        What the kernel takes besides: arrays, numbers, and plain tuples of them.

    Returns
    -------
    list
        What the kernel returned for each part.
    """
    parts = teams // _TEAMS_A_THREAD
    if parts > 1:  # asking for the processors takes longer than a team's step
        parts = min(threads or _processors(), parts)
    if parts <= 1:
        return [kernel(0, teams, *arguments)]
    edges = [teams * part // parts for part in range(parts + 1)]
    waiting = [
        _pool().submit(kernel, first, last, *arguments) for first, last in pairwise(edges[1:])
    ]
    mine = kernel(0, edges[1], *arguments)
    return [mine, *(other.result() for other in waiting)]


_TEAMS_A_THREAD = 32  # fewer are done before another thread has been woken


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(1, _processors() - 1), "teams")


if hasattr(os, "register_at_fork"):  # a fork copies no threads
    os.register_at_fork(after_in_child=_pool.cache_clear)


def _processors() -> int:
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def _digest(function: Callable[..., Any]) -> str:
    """Return a digest of the files of a kernel and of all that it calls, and of their constants."""
    files, constants, seen, waiting = {__file__}, set(), set(), [function]
    while waiting:
        part = waiting.pop()
        seen.add(part)
        files.add(part.__code__.co_filename)
        for name in part.__code__.co_names:
            value = part.__globals__.get(name)
            called = _PARTS.get(id(value))
            if called is not None and called not in seen:
                waiting.append(called)
            if isinstance(value, (int, float)):
                constants.add(f"{name}={value!r}")
    digest = hashlib.blake2b("\n".join(sorted(constants)).encode(), digest_size=8)
    for file in sorted(files):
        digest.update(_digest_of(file))
    return digest.hexdigest()


@cache
def _digest_of(file: str) -> bytes:
    return hashlib.blake2b(Path(file).read_bytes(), digest_size=16).digest()


@cache
def _folder(digest: str) -> str:
    """Return where compiled code is kept; empty where numba knows better."""
    numba = _numba()
    cached = Path(__file__).parent / "__pycache__"
    place = Path(numba.config.CACHE_DIR) if numba.config.CACHE_DIR else cached
    try:
        place.mkdir(exist_ok=True)
    except OSError:
        return ""
    return str(place / f"kernels-{digest}") if os.access(place, os.W_OK) else ""


__all__: Sequence[str] = [
    "Engine",
    "compiled",
    "entered",
    "is_compiled",
    "makes_arrays",
    "numba_is_installed",
    "over_teams",
]
