"""Policy: what a script must not do is stopped where it happens, and reported with the line.

An audit hook hears of writing outside the scratch folder, of starting processes and of using the
network.  That names mistakes with their line, and is no sandbox: native code passes it. What holds
that is `rps_compat.containment`, where the system admits it.
"""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Any

from rps_compat.errors import RobotariumError
from rps_compat.running.audit_events import NETWORK, PROCESSES, called, paths_written
from rps_compat.running.failures import file_in
from rps_compat.running.policy_violations import PolicyKind, PolicyViolation
from rps_compat.running.watching import MOST_VIOLATIONS

#: Where anybody may write: nothing comes of it but what is printed.
_HARMLESS = frozenset(
    ["/dev/null", "/dev/zero", "/dev/full", "/dev/tty", "/dev/stdout", "/dev/stderr"]
)
_NO = {
    PolicyKind.OUTSIDE_WRITE: "a script may write in its own folder only",
    PolicyKind.FORK: "a script may not start or end processes",
    PolicyKind.NETWORK: "there is no network",
}
#: File of the frames that import a module.
_IMPORTING = "<frozen importlib._bootstrap>"
_is_hooked = False


class ForbiddenError(RobotariumError, PermissionError):
    """The script tried what it must not do; the violation is on record."""

    def __str__(self) -> str:
        return str(self.strerror)


class Guard:
    """The audit hook; hooks cannot be removed, so it asks whether it is still on duty.

    Parameters
    ----------
    writable : sequence of str
        Folders in which it may write, without symbolic links; the script's own comes first.
    time : function
        Returns the seconds of the run.
    forbidden : sequence of PolicyKind
        What is forbidden.
    to_libraries : bool
        Whether processes and the network are forbidden to libraries, too.
    tell : callable, optional
        Is told of each violation at once.

    Attributes
    ----------
    violations : list of PolicyViolation
        What was done, each line of the script's once.
    """

    active: Guard | None = None

    def __init__(
        self,
        writable: Sequence[str],
        time: Callable[[], float],
        forbidden: Sequence[PolicyKind],
        to_libraries: bool = False,
        tell: Callable[[PolicyViolation], None] | None = None,
    ) -> None:
        self.scratch = writable[0]
        self.time = time
        self.forbidden = frozenset(forbidden)
        self.to_libraries = to_libraries
        self.violations: list[PolicyViolation] = []
        self._writable = tuple(writable)
        self._tell = tell

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

    def allows(self, path: str) -> bool:
        """Whether the script may write there.

        Parameters
        ----------
        path : str
            Where.
        """
        where = os.path.realpath(path)
        if path in _HARMLESS or where in _HARMLESS:
            return True
        return any(
            where == folder or where.startswith(folder + os.sep) for folder in self._writable
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
        known = any((old.kind, old.line, old.file) == (kind, line, file) for old in self.violations)
        if known or len(self.violations) >= MOST_VIOLATIONS:
            return
        violation = PolicyViolation(kind, what, line, file, self.time())
        self.violations.append(violation)
        if self._tell is not None:
            self._tell(violation)

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
        """Whether the script asks, if by a library, and no library that is just being imported.

        What a library does when it is imported has its own reasons, and may have them.
        """
        if self.to_libraries:
            return True
        frame: FrameType | None = sys._getframe(2)
        while frame is not None:
            name = frame.f_code.co_filename
            if name == _IMPORTING:
                return False
            if file_in(self.scratch, name):
                return True
            frame = frame.f_back
        return True  # in a thread that runs a library's function for the script


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    guard = Guard.active
    if guard is None:
        return
    if PolicyKind.OUTSIDE_WRITE in guard.forbidden:
        for path in paths_written(event, arguments):
            if not guard.allows(path):
                _refuse(guard, PolicyKind.OUTSIDE_WRITE, path)
    if event in PROCESSES and PolicyKind.FORK in guard.forbidden:
        if guard.is_the_scripts():
            _refuse(guard, PolicyKind.FORK, " ".join(str(a) for a in arguments[:2]) or event)
    elif event == "os.kill" and PolicyKind.FORK in guard.forbidden:
        if arguments[0] != os.getpid():
            _refuse(guard, PolicyKind.FORK, f"kill {arguments[0]}")
    elif event in NETWORK and PolicyKind.NETWORK in guard.forbidden:
        whom = called(event, arguments)
        if whom is not None and guard.is_the_scripts():
            _refuse(guard, PolicyKind.NETWORK, whom)


def _refuse(guard: Guard, kind: PolicyKind, what: str) -> None:
    Guard.active = None  # recording opens nothing, but formatting might
    try:
        guard.record(kind, what)
    finally:
        Guard.active = guard
    raise ForbiddenError(errno.EPERM, f"{_NO[kind]}: {what}")
