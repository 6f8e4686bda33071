"""Policy: what a script must not do is stopped where it happens, and reported with the line.

An audit hook hears of writing outside the scratch folder, of starting processes and of using the
network.  That is a net for mistakes, not a sandbox: native code passes it.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from types import FrameType
from typing import Any

from rps_compat.errors import RobotariumError
from rps_compat.running.failures import file_in
from rps_compat.running.policy_violations import PolicyKind, PolicyViolation

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


_NO = {
    PolicyKind.OUTSIDE_WRITE: "a script may write in its own folder only",
    PolicyKind.FORK: "a script may not start or end processes",
    PolicyKind.NETWORK: "there is no network",
}
_is_hooked = False


class ForbiddenError(RobotariumError, PermissionError):
    """The script tried what it must not do; the violation is on record."""


class Guard:
    """The audit hook; hooks cannot be removed, so it asks whether it is still on duty.

    Parameters
    ----------
    scratch : str
        The script's folder, in which it may write.
    time : function
        Returns the seconds of the run.
    forbidden : sequence of PolicyKind
        What is forbidden.
    to_libraries : bool
        Whether processes and the network are forbidden to libraries, too.
    record : path, optional
        File that keeps the record, a line of JSON each, for another process.

    Attributes
    ----------
    violations : list of PolicyViolation
        What was done.
    """

    active: Guard | None = None

    def __init__(
        self,
        scratch: str,
        time: Callable[[], float],
        forbidden: Sequence[PolicyKind],
        to_libraries: bool = False,
        record: Path | None = None,
    ) -> None:
        self.scratch = scratch
        self.time = time
        self.forbidden = frozenset(forbidden)
        self.to_libraries = to_libraries
        self.violations: list[PolicyViolation] = []
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        self._record = None if record is None else os.open(record, flags)

    @contextlib.contextmanager
    def on_duty(self) -> Iterator[None]:
        """Be on duty within the ``with`` block."""
        global _is_hooked
        before, Guard.active = Guard.active, self
        if not _is_hooked:
            sys.addaudithook(_audit)
            _is_hooked = True
        try:
            yield
        finally:
            Guard.active = before

    def allows(self, path: Any) -> bool:
        """Whether the script may write there.

        Parameters
        ----------
        path : path, int or None
            Where; a number is a descriptor that is open already.
        """
        if isinstance(path, int) or path is None:
            return True
        where = os.path.realpath(os.fsdecode(path))
        return where == self.scratch or where.startswith(
            (self.scratch + os.sep, "/dev/", "/proc/self/")
        )

    def record(self, kind: PolicyKind, what: str) -> None:
        """Put on record what the script did, and which of its lines.

        Parameters
        ----------
        kind : PolicyKind
            What is forbidden.
        what : str
            What it did, in words.
        """
        line, file = self.blame()
        violation = PolicyViolation(kind, what, line, file, self.time())
        self.violations.append(violation)
        if self._record is not None:
            os.write(self._record, (json.dumps(asdict(violation)) + "\n").encode())

    def asked(self) -> None:
        """Be told that the script asks somebody: nobody is there, which goes on record."""
        self.record(PolicyKind.BLOCKING_CALL, "input()")

    def blame(self) -> tuple[int | None, str]:
        """Return the innermost line of the script's own files that is being run."""
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            file = file_in(self.scratch, frame.f_code.co_filename)
            if file:
                return frame.f_lineno, file
            frame = frame.f_back
        return None, ""

    def is_the_scripts(self) -> bool:
        """Whether the script asks, not a library that has its own reasons and may have them."""
        if self.to_libraries:
            return True
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            name = frame.f_code.co_filename
            if file_in(self.scratch, name):
                return True
            if "site-packages" in name or "dist-packages" in name:
                return False
            frame = frame.f_back
        return False


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    guard = Guard.active
    if guard is None:
        return
    if event == "open" and PolicyKind.OUTSIDE_WRITE in guard.forbidden:
        path, mode, flags = arguments[0], arguments[1], arguments[2]
        if isinstance(mode, str):
            writes = any(letter in mode for letter in "wax+")
        else:
            writes = isinstance(flags, int) and bool(flags & _WRITE_FLAGS)
        if writes and not guard.allows(path):
            _refuse(guard, PolicyKind.OUTSIDE_WRITE, os.fsdecode(path))
    elif event in _PATH_EVENTS and PolicyKind.OUTSIDE_WRITE in guard.forbidden:
        for path in arguments[:2]:
            if isinstance(path, (str, bytes, os.PathLike)) and not guard.allows(path):
                _refuse(guard, PolicyKind.OUTSIDE_WRITE, os.fsdecode(path))
    elif event in _PROCESS_EVENTS and PolicyKind.FORK in guard.forbidden and guard.is_the_scripts():
        _refuse(guard, PolicyKind.FORK, " ".join(str(a) for a in arguments[:2]) or event)
    elif (
        event in _NETWORK_EVENTS
        and PolicyKind.NETWORK in guard.forbidden
        and guard.is_the_scripts()
    ):
        _refuse(guard, PolicyKind.NETWORK, _address(event, arguments))
    elif event == "os.kill" and PolicyKind.FORK in guard.forbidden and arguments[0] != os.getpid():
        _refuse(guard, PolicyKind.FORK, f"kill {arguments[0]}")


def _address(event: str, arguments: tuple[Any, ...]) -> str:
    """Return whom a network event is about; sockets come first where there are any."""
    about = arguments[:2] if event == "socket.getaddrinfo" else arguments[1:]
    return " ".join(str(part) for part in about) or event


def _refuse(guard: Guard, kind: PolicyKind, what: str) -> None:
    Guard.active = None  # recording opens nothing, but formatting might
    try:
        guard.record(kind, what)
    finally:
        Guard.active = guard
    raise ForbiddenError(f"{_NO[kind]}: {what}")
