"""Which containment a script gets here, and the command line that gives it.

With bubblewrap, or by the same system calls where that is not installed (:mod:`~.entering`), a
script runs in namespaces of its own:

- no network, not even this machine's own; no other process to be seen or signalled;
- every file readable, none writable but those of its folder; ``/tmp``, ``/run`` and ``/dev`` are
  its own, so that nothing listens there;
- no capability, even for root.

What works is found by trying, since kernels, containers and security modules refuse in many ways.
"""

from __future__ import annotations

import enum
import functools
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from rps_compat.containment.bare_python import bare_python
from rps_compat.containment.room import PRIVATE_SIZE, Room, private_folders
from rps_compat.errors import RobotariumError

#: Names one containment, for those who want no better one.
VARIABLE = "POSFLOCK_CONTAINMENT"
#: Seconds that a trial of a containment may take.
_PATIENCE = 10.0


class ContainmentError(RobotariumError, ValueError):
    """There is no such containment, or not here."""


class Containment(str, enum.Enum):
    """What keeps a script to its own folder, the best first."""

    BUBBLEWRAP = "bubblewrap"
    UNSHARE = "unshare"
    HOOK = "hook"

    @property
    def about(self) -> str:
        """What it does, in words."""
        return _ABOUT[self]

    @property
    def has_namespaces(self) -> bool:
        """Whether native code is held, too."""
        return self is not Containment.HOOK


_NAMESPACES = "no network, a /tmp and a /dev of its own, no file writable outside its folder"
_ABOUT = {
    Containment.BUBBLEWRAP: f"namespaces by bubblewrap: {_NAMESPACES}",
    Containment.UNSHARE: f"namespaces: {_NAMESPACES}",
    Containment.HOOK: "no namespaces here: what Python does is watched, native code is not held",
}


def contained(how: Containment, room: Room, command: Iterable[str]) -> list[str]:
    """Return the command that runs another one contained.

    Parameters
    ----------
    how : Containment
        What keeps it.
    room : Room
        What it finds.
    command : iterable of str
        The program and its arguments.
    """
    if how is Containment.BUBBLEWRAP:
        return [*_bubblewrap(room), *command]
    if how is Containment.UNSHARE:
        return [*bare_python("entering", json.dumps(asdict(room))), *command]
    return list(command)


def _bubblewrap(room: Room) -> list[str]:
    size = ["--size", str(PRIVATE_SIZE)]
    words = ["bwrap", "--ro-bind", "/", "/", "--dev", "/dev", *size, "--tmpfs", "/dev/shm"]
    words += ["--proc", "/proc"]
    for place in private_folders():
        words += [*size, "--tmpfs", place]
    for path in room.shown:
        words += ["--ro-bind", path, path]
    for path in room.writable:
        words += ["--bind", path, path]
    words += ["--unshare-user", "--unshare-ipc", "--unshare-pid", "--unshare-net", "--unshare-uts"]
    words += ["--die-with-parent", "--cap-drop", "ALL", "--chdir", room.folder]
    return [*words, *(["--as-pid-1"] if room.as_init else []), "--"]


def containment_here() -> Containment:
    """Return the best containment that works here, or the one that `VARIABLE` names.

    Raises
    ------
    ContainmentError
        Where it names one that does not exist or does not work here.
    """
    asked = os.environ.get(VARIABLE, "")
    if not asked:
        return next(how for how in Containment if works(how))
    if asked not in [how.value for how in Containment]:
        raise ContainmentError(
            f"{VARIABLE}: expected {', '.join(how.value for how in Containment)}, got {asked!r}"
        )
    if not works(Containment(asked)):
        raise ContainmentError(
            f"{VARIABLE} asks for {asked}, which does not work here; leave it empty for the best"
            " containment that does"
        )
    return Containment(asked)


@functools.cache
def works(how: Containment) -> bool:
    """Try whether a containment can be had here.

    Parameters
    ----------
    how : Containment
        Which.
    """
    if how is Containment.HOOK:
        return True
    if sys.platform != "linux" or (how is Containment.BUBBLEWRAP and shutil.which("bwrap") is None):
        return False
    here = str(Path(__file__).parent)
    room = Room((here,), folder=here, readable=python_folders(sys.executable))
    command = contained(how, room, [sys.executable, "-I", "-S", "-c", "pass"])
    try:
        done = subprocess.run(command, capture_output=True, timeout=_PATIENCE, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def python_folders(python: Path | str) -> tuple[str, ...]:
    """Return the folders that an interpreter of ours or of an environment needs.

    Parameters
    ----------
    python : path
        The interpreter, in ``bin`` of its environment.
    """
    environment = Path(python).absolute().parents[1]
    return (str(environment), str(Path(python).resolve().parents[1]), sys.prefix, sys.base_prefix)


def own_folders() -> tuple[str, ...]:
    """Return the folders that a process needs which is to import what this one can."""
    # Where the installation is editable, only a hook knows where our packages lie: no path says it.
    ours = Path(__file__).resolve().parents[2]
    return (*python_folders(sys.executable), *filter(None, sys.path), str(ours))
