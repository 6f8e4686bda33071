"""The keeper: a process that outlives the command beside which it runs, and cleans up after it.

There are two kinds. The keeper of a folder stands aside: when the command has ended without having
said that all is well, it ends everything that has to do with the folder, and removes it. The keeper
of a process stands between: it is the parent of what the command starts, adopts all orphans below,
holds limits, and ends all of them with the process, or with the command.

Both hear of the command's end from the kernel, whatever signal it was, and of its wishes by a
pipe.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import signal
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rps_compat.containment import kernel
from rps_compat.containment.processes import descendants, end_descendants, kill_users_of
from rps_compat.containment.usage import Allowance, FolderWatch

#: What the command writes into the pipe when it needs its keeper no more.
DONE = b"."
#: Seconds between two looks, where nothing is waited for or the kernel does not tell.
_LOOK = 0.05
#: Least share of the time in which a keeper does nothing: to look costs more, the more processes a
#: machine has.
_IDLE = 0.98
#: What ends the command is the command's affair; Windows, which has no keepers, lacks some of them.
_IGNORED = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP")
    if hasattr(signal, name)
)


@dataclass(frozen=True)
class ProcessOrder:
    """What a process is started as, and what holds it.

    Attributes
    ----------
    command : sequence of str
        The program and its arguments.
    seconds : float, optional
        Of real time, after which it is killed.
    folder, printed : str, optional
        In which it may write, and the file of what it prints: where they are limited.
    allowance : dict, optional
        What it may use, as `usage.Allowance`; None limits nothing.
    """

    command: Sequence[str]
    seconds: float | None = None
    folder: str = ""
    printed: str = ""
    allowance: dict[str, int] | None = None


@dataclass(frozen=True)
class ProcessEnd:
    """How a process ended.

    Attributes
    ----------
    code : int
        Its exit code; below 0 where a signal ended it.
    timed_out : bool
        Whether its time was over.
    surplus : str
        What it used too much of, in words; empty where it was not ended for that.
    left : bool
        Whether it left other processes running, which have been ended.
    """

    code: int
    timed_out: bool = False
    surplus: str = ""
    left: bool = False


def main(words: Sequence[str]) -> None:
    """Be the keeper that the command line says.

    Parameters
    ----------
    words : sequence of str
        ``folder OWNER PIPE PATH`` or ``process OWNER PIPE ANSWER ORDER``: process id of the
        command, descriptors of the pipes that it wishes and is answered by, and the rest.
    """
    kind, owner, pipe, *rest = words
    command = _Command(int(owner), int(pipe))
    for number in _IGNORED:
        signal.signal(number, signal.SIG_IGN)
    if kind == "folder":
        _keep_folder(command, rest[0])
    else:
        _keep_process(command, int(rest[0]), ProcessOrder(**json.loads(rest[1])))


class _Command:
    """The command that the keeper looks after.

    Parameters
    ----------
    number : int
        Its process id.
    pipe : int
        Where it says what it wants.
    """

    def __init__(self, number: int, pipe: int) -> None:
        self._number = number
        self._pipe: int | None = pipe
        self._end = _open_process(number)

    def wait(self, seconds: float, *others: int | None) -> None:
        """Wait until something of it, or of other descriptors, is to be told, or time is over."""
        watched = [pipe for pipe in (self._pipe, self._end, *others) if pipe is not None]
        select.select(watched, [], [], min(seconds, _LOOK) if self._end is None else seconds)

    def is_done(self) -> bool:
        """Whether it has said that it needs its keeper no more."""
        if self._pipe is None or not select.select([self._pipe], [], [], 0)[0]:
            return False
        if os.read(self._pipe, 1) == DONE:
            return True
        self._pipe = None  # it has closed it without a word: it is about to end
        return False

    def has_ended(self) -> bool:
        """Whether it has ended, however."""
        if self._end is not None:
            return bool(select.select([self._end], [], [], 0)[0])
        try:
            os.kill(self._number, 0)
        except ProcessLookupError:
            return True
        except PermissionError:
            pass
        return False


def _open_process(number: int) -> int | None:
    """Return a descriptor that can be read when a process has ended; None where there is none."""
    try:
        return os.pidfd_open(number)
    except (AttributeError, OSError):
        return None


# --- A folder ------------------------------------------------------------------------------------


def _keep_folder(command: _Command, folder: str) -> None:
    os.chdir("/")
    while True:
        command.wait(60.0)
        if command.is_done():
            return
        if command.has_ended():
            kill_users_of(folder)
            _remove(folder)
            return


def _remove(folder: str) -> None:
    """Remove a folder into which somebody who is just ending may still be writing."""
    for _ in range(100):
        shutil.rmtree(folder, ignore_errors=True)
        if not os.path.lexists(folder):
            return
        time.sleep(_LOOK)


# --- A process -----------------------------------------------------------------------------------


def _keep_process(command: _Command, answer: int, order: ProcessOrder) -> None:
    os.set_inheritable(answer, False)
    with contextlib.suppress(OSError):
        kernel.adopt_orphans()
    child = os.fork()
    if child == 0:
        _become(order.command)
    for standard in range(3):  # whoever reads what the process says is to see its end
        os.dup2(os.open(os.devnull, os.O_RDWR), standard)
    end = _watched(command, child, order)
    left = end_descendants()
    with contextlib.suppress(ProcessLookupError, PermissionError):  # where /proc tells of nobody
        os.killpg(child, signal.SIGKILL)
    if end is not None:
        told = asdict(end) | {"left": left and not end.timed_out and not end.surplus}
        with contextlib.suppress(OSError):
            os.write(answer, json.dumps(told).encode())


def _become(command: Sequence[str]) -> None:
    """Become the program in this process, which ends with the keeper."""
    try:
        with contextlib.suppress(OSError):
            kernel.die_with_parent()
        os.setsid()
        for number in _IGNORED:
            signal.signal(number, signal.SIG_DFL)
        os.execvp(command[0], list(command))
    finally:
        os._exit(127)


def _watched(command: _Command, child: int, order: ProcessOrder) -> ProcessEnd | None:
    """Wait for the end of a process, and bring it about where that is due; None: nobody asks."""
    handle = _open_process(child)
    watch = _Watch(order)
    timed_out, surplus = False, ""
    deadline = time.monotonic() + (order.seconds or float("inf"))
    while True:
        command.wait(min(watch.pause, max(0.0, deadline - time.monotonic())), handle)
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            return ProcessEnd(os.waitstatus_to_exitcode(status), timed_out, surplus)
        if command.is_done() or command.has_ended():
            return None
        timed_out = timed_out or time.monotonic() >= deadline
        surplus = surplus or watch.surplus()
        if timed_out or surplus:
            deadline = float("inf")
            end_descendants(spared=(child,))
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)


class _Watch:
    """Looks whether a process and what it has started use more than they may."""

    def __init__(self, order: ProcessOrder) -> None:
        self.pause = 1.0
        self._allowance: Allowance | None = None
        self._folder: FolderWatch | None = None
        if order.allowance is not None:
            self.pause = _LOOK
            allowance = self._allowance = Allowance(**order.allowance)
            self._folder = FolderWatch(Path(order.folder), Path(order.printed), allowance)

    def surplus(self) -> str:
        """Say in words what there is too much of; empty where nothing."""
        if self._allowance is None or self._folder is None:
            return ""
        begun = time.thread_time()
        running = [process for process in descendants(os.getpid()) if not process.ended]
        found = self._allowance.surplus(running) or self._folder.surplus()
        self.pause = max(_LOOK, (time.thread_time() - begun) / (1.0 - _IDLE))
        return "" if found is None else found.words
