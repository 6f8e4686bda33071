"""The testbed's Python and its libraries, in an environment that is built once and cached."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.submission.interpreters import find_python, installed_pythons
from rps_compat.containment.caches import cache_folder
from rps_compat.scripts.libraries import IMPORT_NAMES, LIBRARIES, PYTHON
from rps_compat.whole_files import write_whole

#: Always installed; heavier ones only where the bundle imports them.
_BASE = ("numpy", "scipy", "matplotlib", "cvxopt")


class RehearsalError(PosflockError):
    """The rehearsal environment cannot be built or started."""


@dataclass(frozen=True)
class Environment:
    """A cached copy of the testbed's Python.

    Attributes
    ----------
    python : Path
        Interpreter of the environment.
    version : str
        Of that interpreter.
    libraries : dict
        Installed versions of what was asked for.
    note : str
        How it differs from the testbed; empty where it does not.
    """

    python: Path
    version: str
    libraries: dict[str, str]
    note: str = ""


def build_environment(
    libraries: Iterable[str], tell: Callable[[str], None] | None = None
) -> Environment:
    """Return a cached environment that has the testbed's version of these libraries.

    Parameters
    ----------
    libraries : iterable of str
        Import names; those of the standard library do not matter.
    tell : callable, optional
        Is told when one is being built, which takes a minute.

    Raises
    ------
    RehearsalError
        It cannot be built, or does not start.
    """
    wanted = {IMPORT_NAMES[name] for name in libraries if name in IMPORT_NAMES}
    pinned = {n: version for n, version in LIBRARIES.items() if n in wanted or n in _BASE}
    pins = [f"{name}=={version}" if version else name for name, version in pinned.items()]
    folder, note = _folder(PYTHON, pins), ""
    asked = _versions_in(folder, pinned)  # to look for Pythons costs more than to ask this one
    if asked is None:
        base, note = _nearest_python()
        if note:
            folder = _folder(base, pins)
            asked = _versions_in(folder, pinned)
    if asked is None:
        if tell is not None:
            tell(f"building the rehearsal environment, once: {', '.join(pins)}")
        _build(base, folder, _python_of(folder), pins)
        asked = _versions_in(folder, pinned)
    if asked is None:
        raise RehearsalError(
            f"the rehearsal environment in {folder} was built, but its Python does not start or"
            " lacks a library; remove the folder and try again"
        )
    version, installed = asked
    return Environment(_python_of(folder), version, installed, note)


def _folder(base: object, pins: list[str]) -> Path:
    """Where the environment of these libraries on that Python is kept."""
    key = hashlib.sha256("\n".join([str(base), *pins]).encode()).hexdigest()[:16]
    return cache_folder() / f"testbed-{key}"


def _python_of(folder: Path) -> Path:
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def _versions_in(folder: Path, names: Iterable[str]) -> tuple[str, dict[str, str]] | None:
    """Ask an environment for the versions of its Python and libraries; None: not whole."""
    if not (folder / "ready").exists():
        return None
    program = (
        "import json, platform; from importlib.metadata import version;"
        f"print(json.dumps([platform.python_version(), {{n: version(n) for n in"
        f" {list(names)!r}}}]))"
    )
    command = [str(_python_of(folder)), "-I", "-c", program]
    try:
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):  # the Python it was made of is gone
        return None
    version, installed = json.loads(said)
    return version, installed


def _nearest_python() -> tuple[Path, str]:
    """Return the testbed's Python, or the nearest there is with a note that says so."""
    python = find_python(PYTHON)
    if python is not None:
        return python, ""
    pythons = installed_pythons()
    nearest = min((v for v in pythons if v >= (3, 10)), key=lambda v: abs(v[1] - PYTHON[1]))
    return pythons[nearest], (
        f"the testbed runs Python {PYTHON[0]}.{PYTHON[1]}, which is not installed"
        f" here: rehearsed with {nearest[0]}.{nearest[1]}, which accepts newer syntax"
    )


def _build(base: Path, folder: Path, python: Path, pins: list[str]) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    commands = [
        [str(base), "-m", "venv", str(folder)],
        [str(python), "-m", "pip", "install", "-q", "--disable-pip-version-check", *pins],
    ]
    for command in commands:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            shutil.rmtree(folder, ignore_errors=True)
            last = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
            raise RehearsalError(
                f"cannot build the rehearsal environment: `{' '.join(command[1:4])} …` ended with"
                f" {last!r}; it needs the package index once"
            )
    write_whole(folder / "ready", "\n".join(pins) + "\n")
