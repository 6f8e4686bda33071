"""A user's file and function: imported and called so that their failure is one plain sentence.

Whatever they raise is told by file and line, never by a traceback through this package; what they
print goes to standard error, so that a program can read what a command prints.
"""

from __future__ import annotations

import contextlib
import importlib.util
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any

from posflock_robotarium.flocking.errors import PosflockError


class MetricError(PosflockError):
    """A metric of the user's cannot be had, fails, or returns what is no metric."""


def imported(path: Path) -> ModuleType:
    """Import a Python file anew, with the modules beside it within its reach.

    Parameters
    ----------
    path : Path
        The file, as the user named it.

    Raises
    ------
    MetricError
        When there is no such file, or it fails.
    """
    if not path.is_file():
        raise MetricError(f"{path}: no such file")
    name = f"posflock_own_{re.sub(r'[^A-Za-z0-9_]', '_', path.stem)}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise MetricError(f"{path}: expected a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        with _told(path, "", str(path)):
            spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


@contextlib.contextmanager
def said_by(function: Callable[..., Any], name: str, file: str) -> Iterator[None]:
    """Turn whatever a function of the user's raises within the block into one plain sentence.

    Parameters
    ----------
    function : callable
        Whose code is run.
    name : str
        What it is called.
    file : str
        The user's file, as he named it.

    Raises
    ------
    MetricError
        When the block raises anything but an interrupt.
    """
    defined = where_defined(function, file)
    with _told(Path(file), f"{name}: ", defined):
        yield


def where_defined(function: Callable[..., Any], file: str) -> str:
    """Return file and line of a function's ``def``; the file alone where that is not known.

    Parameters
    ----------
    function : callable
        What is looked for.
    file : str
        The user's file, as he named it.
    """
    code = getattr(function, "__code__", None)
    if code is None or Path(code.co_filename).resolve() != Path(file).resolve():
        return file
    line = code.co_firstlineno
    with contextlib.suppress(OSError, UnicodeDecodeError):
        # A decorated function's code begins with its decorators.
        for number, text in enumerate(Path(file).read_text(encoding="utf-8").splitlines(), 1):
            if number >= line and re.match(
                rf"\s*(async\s+)?def\s+{re.escape(code.co_name)}\b", text
            ):
                return f"{file}:{number}"
    return f"{file}:{line}"


@contextlib.contextmanager
def _told(path: Path, who: str, otherwise: str) -> Iterator[None]:
    """Let code of a user's file run: what lies beside it can be imported, its words are no data."""
    beside, before = str(path.resolve().parent), set(sys.modules)
    # Last, so that a file of the user's never hides a library.
    sys.path.append(beside)
    # Bytecode is taken for that of a file of the same size and second: after a quick edit of one
    # digit, for another file's.
    bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        with contextlib.redirect_stdout(sys.stderr):
            yield
    except (KeyboardInterrupt, MetricError):
        raise
    except SyntaxError as error:
        where = f"{error.filename or path}:{error.lineno}" if error.lineno else str(path)
        where = f"{path}:{error.lineno}" if _same(error.filename, path) else where
        raise MetricError(f"{where}: {who}{type(error).__name__}: {error.msg}") from error
    except BaseException as error:
        where = _innermost(error.__traceback__, path) or otherwise
        words = " ".join(str(error).split()) or "no reason given"
        raise MetricError(f"{where}: {who}{type(error).__name__}: {words}") from error
    finally:
        sys.dont_write_bytecode = bytecode
        if beside in sys.path:
            sys.path.remove(beside)
        # What lies beside it is imported anew the next time: another folder may have such names.
        for new in set(sys.modules) - before:
            file = getattr(sys.modules[new], "__file__", None)
            if file and str(Path(file).resolve().parent) == beside:
                del sys.modules[new]


def _innermost(trace: TracebackType | None, path: Path) -> str | None:
    """Return the last line of the user's file that was being run; else of a file beside it."""
    frames = [(frame.filename, frame.lineno) for frame in traceback.extract_tb(trace)]
    own = [f"{path}:{line}" for name, line in frames if _same(name, path)]
    if own:
        return own[-1]
    folder = path.resolve().parent
    beside = [f"{name}:{line}" for name, line in frames if Path(name).resolve().parent == folder]
    return beside[-1] if beside else None


def _same(name: str | None, path: Path) -> bool:
    return name is not None and Path(name).resolve() == path.resolve()
