"""Which code computes an experiment: loading it from a file, and telling when it changes.

A run is decided by its parameters, its random stream and the code.  The code's part is a
digest of source files: those of the functions that an experiment names, and every file that
they import, directly or not, from this package and from the folder of a user's own module.
A comment counts as much as a sign does; libraries such as numpy do not count.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import CodeType
from typing import Any

from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.sweep.experiments import Experiment
from rps_compat.scripts.import_graph import imports
from rps_compat.scripts.source import read_script

_OURS = ("posflock_robotarium", "rps_compat", "barrier_certificates")
#: Where these packages lie: beside one another.
_HOME = Path(__file__).resolve().parents[2]


class ModuleError(PosflockError):
    """A module that a study names cannot be imported."""


def load(path: Path) -> None:
    """Import a Python file, which registers experiments, once in this process.

    Parameters
    ----------
    path : Path
        The file; modules beside it can be imported by it.

    Raises
    ------
    ModuleError
        Where there is no such file, or it fails.
    """
    name = f"posflock_study_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    if name in sys.modules:
        return
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise ModuleError(f"module: expected a Python file, got {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    # Bytecode is taken for that of a file of the same size and second: after a quick edit of one
    # digit, for another file's.
    bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise ModuleError(f"{path} fails: {type(error).__name__}: {error}") from error
    finally:
        sys.dont_write_bytecode = bytecode


def code_of(experiment: Experiment, module: Path | None = None) -> str:
    """Return the digest of all code that decides an experiment's results.

    Parameters
    ----------
    experiment : Experiment
        What is run.
    module : Path, optional
        The file that registered it.

    Returns
    -------
    str
        16 hexadecimal digits, the same on every machine; that of the first call in a process,
        whose modules stay as they were loaded, too.
    """
    functions = (experiment.run, *experiment.sources)
    files = {_file_of(function) for function in functions} | {module}
    loose = tuple(_text_of(function) for function in functions if _file_of(function) is None)
    return _digest(tuple(sorted(file for file in files if file)), loose)


def sources(*roots: Path) -> dict[str, Path]:
    """Return the files that decide what `roots` do, by dotted name: themselves and their imports.

    Parameters
    ----------
    *roots : Path
        Python files.

    Raises
    ------
    ScriptError
        Where a file cannot be read as Python.
    """
    found: dict[str, Path] = {}
    queue = [(_name_of(root), root, root.parent) for root in roots]
    while queue:
        name, path, beside = queue.pop()
        if name in found:
            continue
        found[name] = path
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        for statement in imports(read_script(path).tree, package):
            parts = statement.module.split(".")
            # Packages on the way run too.
            asked = [".".join(parts[: k + 1]) for k in range(len(parts))]
            asked += [f"{statement.module}.{n}" for n in statement.names]
            queue += [(n, file, beside) for n in asked for file in _files(n, beside)]
    return found


@cache
def _digest(files: tuple[Path, ...], loose: tuple[str, ...]) -> str:
    found = sources(*files)
    digest = hashlib.sha256("\n".join(loose).encode())
    for name in sorted(found):
        # Line ends are the checkout's, not the code's.
        text = found[name].read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{name} {hashlib.sha256(text).hexdigest()}\n".encode())
    return digest.hexdigest()[:16]


def _files(name: str, beside: Path) -> Iterator[Path]:
    """Yield the file of a dotted name, where it is one of ours or lies beside the user's."""
    home = _HOME if name.partition(".")[0] in _OURS else beside
    place = home.joinpath(*name.split("."))
    for path in (place.with_name(f"{place.name}.py"), place / "__init__.py"):
        if path.is_file():
            yield path
            return


def _name_of(path: Path) -> str:
    if not path.is_relative_to(_HOME) or path.relative_to(_HOME).parts[0] not in _OURS:
        return path.stem
    return ".".join(path.relative_to(_HOME).with_suffix("").parts)


def _file_of(function: Any) -> Path | None:
    """Return the file that defines a function, or None for one typed in a shell or notebook."""
    path = getattr(sys.modules.get(function.__module__), "__file__", None)
    return Path(path).resolve() if path and Path(path).is_file() else None


def _text_of(function: Any) -> str:
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        return _instructions(function.__code__)


def _instructions(code: CodeType) -> str:
    constants = [_instructions(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return f"{code.co_code.hex()} {code.co_names} {constants}"
