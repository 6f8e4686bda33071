"""What is kept from one call to the next, and what of it a contained process gets."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import subprocess
from pathlib import Path

#: Seconds that matplotlib may take to look through the fonts of a machine.
_PATIENCE = 120.0


def cache_folder() -> Path:
    """Return the folder of what is kept from one call to the next."""
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "posflock"


def lay_font_list(python: Path, folder: Path) -> None:
    """Give matplotlib a folder of its own, with the list of fonts that takes it seconds to make.

    The list is made outside, once for each matplotlib, and copied: what a script leaves in its
    folder reaches no other.

    Parameters
    ----------
    python : Path
        Interpreter whose matplotlib it is.
    folder : Path
        What will be ``MPLCONFIGDIR``; it is made.
    """
    store = cache_folder() / f"matplotlib-{_key(python)}"
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):  # then it makes one there
        if not list(store.glob("fontlist-*.json")):
            store.mkdir(parents=True, exist_ok=True)
            subprocess.run(
                [str(python), "-I", "-c", "import matplotlib.font_manager"],
                env=os.environ | {"MPLCONFIGDIR": str(store)},
                capture_output=True,
                timeout=_PATIENCE,
                check=False,
            )
        for path in store.glob("fontlist-*.json"):
            shutil.copyfile(path, folder / path.name)


def _key(python: Path) -> str:
    """Return what tells the matplotlib of an interpreter from others, and from an older one."""
    installed = python.absolute().parents[1].glob("lib/python*/site-packages/matplotlib-*")
    told = [str(python.absolute()), *sorted(path.name for path in installed)]
    return hashlib.sha256("\n".join(told).encode()).hexdigest()[:16]
