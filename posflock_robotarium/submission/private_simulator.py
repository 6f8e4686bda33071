"""The simulator under names of its own, for an environment in which ours must not be found."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

#: Our packages, and how they are called there.
PRIVATE = {"rps_compat": "_rehearsal_rps", "barrier_certificates": "_rehearsal_certificates"}


def lay_simulator(folder: Path) -> None:
    """Copy the simulator into a folder under private names.

    The bundle brings its own ``barrier_certificates`` and must find those, not the simulator's.

    Parameters
    ----------
    folder : Path
        Where the copies are put; it will be on Python's path.
    """
    import barrier_certificates
    import rps_compat

    for package in (rps_compat, barrier_certificates):
        home = Path(str(package.__file__)).parent
        target = folder / PRIVATE[package.__name__]
        for path in sorted(home.rglob("*")):
            if path.is_dir() or "__pycache__" in path.parts or "import_paths" in path.parts:
                continue
            copy = target / path.relative_to(home)
            copy.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".py":
                copy.write_text(_renamed(path.read_text(encoding="utf-8")), encoding="utf-8")
            else:
                shutil.copyfile(path, copy)


def _renamed(source: str) -> str:
    """Return source in which our two packages go by their private names.

    ``rps.utilities.barrier_certificates`` is a module of the API and keeps its name: only what is
    imported as a top-level name, or named so in a string, is renamed.
    """
    for name, private in PRIVATE.items():
        source = re.sub(rf"(?m)^(\s*(?:from|import)\s+){name}\b", rf"\g<1>{private}", source)
        source = re.sub(rf"(f?[\"']){name}(?=[.\"'])", rf"\g<1>{private}", source)
    return source
