"""Other processes, as ``/proc`` tells of them; where there is none, none is found."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Collection, Iterator
from dataclasses import dataclass

#: Seconds for which processes that are being killed are waited for.
_PATIENCE = 5.0


@dataclass(frozen=True)
class Process:
    """One process at one moment.

    Attributes
    ----------
    number, parent : int
        Its process id and its parent's.
    ended : bool
        Whether it has ended and only waits for its parent to take note.
    seconds : float
        Seconds that it has computed.
    memory : int
        Bytes of it that are in memory.
    threads : int
        Its threads, 1 or more.
    user : int
        Whose it is.
    """

    number: int
    parent: int
    ended: bool
    seconds: float
    memory: int
    threads: int
    user: int


def look_at(number: int) -> Process | None:
    """Return what is known of a process; None where there is none, or nobody tells.

    Parameters
    ----------
    number : int
        Its process id.
    """
    try:
        with open(f"/proc/{number}/stat", "rb") as file:
            fields = file.read().rpartition(b")")[2].split()
            user = os.fstat(file.fileno()).st_uid
    except OSError:
        return None
    seconds = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    memory = int(fields[21]) * os.sysconf("SC_PAGE_SIZE")
    threads = int(fields[17])
    return Process(number, int(fields[1]), fields[0] in b"ZX", seconds, memory, threads, user)


def everyone() -> Iterator[Process]:
    """Yield every process that can be seen from here."""
    try:
        names = os.listdir("/proc")
    except OSError:
        return
    for name in names:
        if name.isdigit():
            found = look_at(int(name))
            if found is not None:
                yield found


def descendants(ancestor: int, spared: Collection[int] = ()) -> list[Process]:
    """Return all processes below one, parents before their children, ended ones among them.

    Parameters
    ----------
    ancestor : int
        Process id of the one.
    spared : collection of int
        Processes that are left out, with all below them.
    """
    children: dict[int, list[Process]] = {}
    for process in everyone():
        children.setdefault(process.parent, []).append(process)
    found: list[Process] = []
    left = [ancestor]
    while left:
        below = [child for child in children.get(left.pop(), []) if child.number not in spared]
        found += below
        left += [process.number for process in below]
    return found


def end_descendants(spared: Collection[int] = ()) -> bool:
    """End all processes below this one, and take note of their ends; return whether any still ran.

    Parameters
    ----------
    spared : collection of int
        Processes that are left alone, with all below them.
    """
    ran, deadline = False, time.monotonic() + _PATIENCE
    while (found := descendants(os.getpid(), spared)) and time.monotonic() < deadline:
        running = [process.number for process in found if not process.ended]
        ran = ran or bool(running)
        for sent in (signal.SIGSTOP, signal.SIGKILL):  # one that goes on could start others
            for number in running:
                _signal(number, sent)
        for process in found:
            if process.parent == os.getpid():
                with contextlib.suppress(ChildProcessError):
                    os.waitpid(process.number, 0 if process.ended else os.WNOHANG)
        if running:
            time.sleep(0.002)
    return ran


def kill_users_of(folder: str) -> None:
    """End every process that was told of a folder when it was started, or has it open.

    Parameters
    ----------
    folder : str
        Absolute path, of which nobody else has reason to know.
    """
    deadline = time.monotonic() + _PATIENCE
    while (left := list(_users_of(folder))) and time.monotonic() < deadline:
        for number in left:
            _signal(number, signal.SIGKILL)
        time.sleep(0.01)


def _users_of(folder: str) -> Iterator[int]:
    """Yield processes other than this one: by environment, by open files, by working folder."""
    for process in everyone():
        if process.number == os.getpid() or process.ended:
            continue
        home = f"/proc/{process.number}"
        with contextlib.suppress(OSError):  # it has ended, or is another user's
            with open(f"{home}/environ", "rb") as file:
                told = os.fsencode(folder) in file.read()
            links = [f"{home}/cwd", *(f"{home}/fd/{name}" for name in os.listdir(f"{home}/fd"))]
            if told or any(_leads_into(link, folder) for link in links):
                yield process.number


def _leads_into(link: str, folder: str) -> bool:
    try:
        target = os.readlink(link)
    except OSError:
        return False
    return target == folder or target.startswith(folder + os.sep)


def _signal(number: int, sent: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(number, sent)
