"""What a script must not do is stopped where it happens, and reported with the line.

An audit hook hears of writing outside the scratch folder, of starting processes and of using the
network.  That is a net for mistakes, not a sandbox: native code passes it.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

from posflock_robotarium.flocking.errors import PosflockError

_WRITE_FLAGS = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_TRUNC
_PATH_EVENTS = frozenset(
    [
        "os.remove",
        "os.rename",
        "os.mkdir",
        "os.rmdir",
        "os.link",
        "os.symlink",
        "os.chmod",
        "os.truncate",
        "os.chown",
        "shutil.rmtree",
    ]
)
_PROCESS_EVENTS = frozenset(
    [
        "subprocess.Popen",
        "os.system",
        "os.fork",
        "os.forkpty",
        "os.posix_spawn",
        "os.exec",
        "os.spawn",
        "pty.spawn",
    ]
)
_NETWORK_EVENTS = frozenset(
    ["socket.connect", "socket.getaddrinfo", "socket.sendto", "socket.bind"]
)


class ForbiddenError(PosflockError, PermissionError):
    """The script tried what it must not do; the violation is on record."""


class Guard:
    """The audit hook; hooks cannot be removed, so it asks whether it is still on duty.

    Parameters
    ----------
    scratch : str
        The folder in which the script may write.
    violations : int
        Descriptor of the file that keeps the record, a line of JSON each.
    steps : function
        How many steps the script has taken.
    """

    active: Guard | None = None

    def __init__(self, scratch: str, violations: int, steps: Callable[[], int]) -> None:
        self.scratch = scratch
        self.violations = violations
        self.steps = steps

    def install(self) -> None:
        """Go on duty."""
        Guard.active = self
        sys.addaudithook(_audit)

    def allows(self, path: Any) -> bool:
        """Whether the script may write there."""
        if isinstance(path, int) or path is None:
            return True
        where = os.path.realpath(os.fsdecode(path))
        return where == self.scratch or where.startswith(
            (self.scratch + os.sep, "/dev/", "/proc/self/")
        )

    def record(self, kind: str, what: str) -> None:
        """Put on record what the script did, and which of its lines."""
        line, file = self.blame()
        violation = {"kind": kind, "what": what, "line": line, "file": file, "step": self.steps()}
        os.write(self.violations, (json.dumps(violation) + "\n").encode())

    def answer(self, prompt: object = "") -> str:
        """Stand in for ``input()``: nobody is there, which goes on record."""
        self.record("blocking-call", "input()")
        return ""

    def blame(self) -> tuple[int | None, str]:
        """Return the innermost line of the script's own files that is being run."""
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            name = frame.f_code.co_filename
            if name.startswith(self.scratch):
                return frame.f_lineno, os.path.basename(name)
            frame = frame.f_back
        return None, ""

    def is_the_scripts(self) -> bool:
        """Whether the script asks, not a library that has its own reasons."""
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            name = frame.f_code.co_filename
            if name.startswith(self.scratch):
                return True
            if "site-packages" in name or "dist-packages" in name:
                return False
            frame = frame.f_back
        return False


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    guard = Guard.active
    if guard is None:
        return
    if event == "open":
        path, mode, flags = arguments[0], arguments[1], arguments[2]
        if isinstance(mode, str):
            writes = any(letter in mode for letter in "wax+")
        else:
            writes = isinstance(flags, int) and bool(flags & _WRITE_FLAGS)
        if writes and not guard.allows(path):
            _refuse(guard, "outside-write", os.fsdecode(path))
    elif event in _PATH_EVENTS:
        for path in arguments[:2]:
            if isinstance(path, (str, bytes, os.PathLike)) and not guard.allows(path):
                _refuse(guard, "outside-write", os.fsdecode(path))
    elif event in _PROCESS_EVENTS and guard.is_the_scripts():
        _refuse(guard, "fork", " ".join(str(a) for a in arguments[:2]) or event)
    elif event in _NETWORK_EVENTS and guard.is_the_scripts():
        _refuse(guard, "network", _address(event, arguments))
    elif event == "os.kill" and arguments[0] != os.getpid():
        _refuse(guard, "fork", f"kill {arguments[0]}")


def _address(event: str, arguments: tuple[Any, ...]) -> str:
    """Return whom a network event is about; sockets come first where there are any."""
    about = arguments[:2] if event == "socket.getaddrinfo" else arguments[1:]
    return " ".join(str(part) for part in about) or event


def _refuse(guard: Guard, kind: str, what: str) -> None:
    Guard.active = None  # recording opens nothing, but formatting might
    try:
        guard.record(kind, what)
    finally:
        Guard.active = guard
    raise ForbiddenError(f"{kind}: {what}")
