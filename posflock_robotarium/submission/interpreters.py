"""Other Pythons on this machine, found the ways people install them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path


def find_python(version: tuple[int, int]) -> Path | None:
    """Return an interpreter of exactly that minor version, or None.

    Parameters
    ----------
    version : (int, int)
        Major and minor version: (3, 10).
    """
    if sys.version_info[:2] == version:
        return Path(sys.executable)
    # Asking takes as long as a Python takes to start: those that are called so come first.
    called = re.compile(rf"(?<![\d.]){version[0]}\.{version[1]}(?!\d)")
    candidates = sorted(_candidates(), key=lambda path: not called.search(str(path)))
    return next((path for path in candidates if _version(path) == version), None)


def installed_pythons() -> dict[tuple[int, int], Path]:
    """Return interpreters by minor version: this one, those on the PATH, pyenv's and uv's."""
    found = {sys.version_info[:2]: Path(sys.executable)}
    for candidate in _candidates():
        version = _version(candidate)
        if version is not None:
            found.setdefault(version, candidate)
    return found


def _candidates() -> list[Path]:
    out = [
        Path(path)
        for minor in range(8, 15)
        if (path := shutil.which(f"python3.{minor}")) is not None
    ]
    data = Path(os.environ.get("XDG_DATA_HOME", Path.home() / ".local/share"))
    folders = [
        Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions",
        Path(os.environ.get("UV_PYTHON_INSTALL_DIR", data / "uv/python")),
        Path.home() / ".local/pyenv/versions",
    ]
    for folder in folders:
        if folder.is_dir():
            out += [f / "bin/python3" for f in sorted(folder.iterdir(), reverse=True)]
    return [path for path in out if path.is_file()]


@cache
def _version(python: Path) -> tuple[int, int] | None:
    """Ask an interpreter for its version; shims that lead nowhere give None."""
    try:
        said = subprocess.run(
            [str(python), "-I", "-S", "-c", "import sys; print(*sys.version_info[:2])"],
            capture_output=True,
            text=True,
            timeout=20,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    match = re.fullmatch(r"(\d+) (\d+)\s*", said.stdout)
    return (int(match[1]), int(match[2])) if match and said.returncode == 0 else None
