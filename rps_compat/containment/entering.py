"""Enter namespaces by system calls alone, and become a command there.

What bubblewrap does where it is installed. The order matters: what is to stay reachable is opened
before the file systems over it are replaced, and capabilities are given up last.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Sequence
from typing import NoReturn

from rps_compat.containment import kernel
from rps_compat.containment.room import PRIVATE_OPTIONS, Room, private_folders

#: What a program may expect in /dev.
_DEVICES = ("null", "zero", "full", "random", "urandom", "tty")
_LINKS = {"fd": "fd", "stdin": "fd/0", "stdout": "fd/1", "stderr": "fd/2"}
_NEW = (
    kernel.NEW_USER
    | kernel.NEW_MOUNTS
    | kernel.NEW_PROCESSES
    | kernel.NEW_NETWORK
    | kernel.NEW_IPC
    | kernel.NEW_NAMES
)


def main(words: Sequence[str]) -> None:
    """Run a command in namespaces of its own, and end as it ends.

    Parameters
    ----------
    words : sequence of str
        The `Room` as JSON, then the command.
    """
    room = Room(**json.loads(words[0]))
    user, group = os.getuid(), os.getgid()
    kernel.unshare(_NEW)
    for name, text in (
        ("setgroups", "deny"),
        ("uid_map", f"{user} {user} 1"),
        ("gid_map", f"{group} {group} 1"),
    ):
        with open(f"/proc/self/{name}", "w") as file:
            file.write(text)
    _replace_file_systems(room)
    init = os.fork()
    if init == 0:
        _begin(room, list(words[1:]))
    _, status = os.waitpid(init, 0)
    code = os.waitstatus_to_exitcode(status)
    os._exit(128 - code if code < 0 else code)


def _replace_file_systems(room: Room) -> None:
    kernel.mount("none", "/", flags=kernel.WITH_SUBMOUNTS | kernel.PRIVATE)
    kept = {path: os.open(path, os.O_PATH) for path in (*room.shown, *room.writable)}
    devices = {
        name: os.open(f"/dev/{name}", os.O_PATH)
        for name in _DEVICES
        if os.path.exists(f"/dev/{name}")
    }
    kernel.set_read_only("/", True, with_submounts=True)
    for place in (*private_folders(), "/dev"):
        kernel.mount("none", place, "tmpfs", kernel.NO_SET_UID | kernel.NO_DEVICES, PRIVATE_OPTIONS)
    for name, opened in devices.items():
        os.close(os.open(f"/dev/{name}", os.O_CREAT | os.O_WRONLY))
        kernel.mount(f"/proc/self/fd/{opened}", f"/dev/{name}", flags=kernel.BIND)
    for name, target in _LINKS.items():
        os.symlink(f"/proc/self/{target}", f"/dev/{name}")
    os.mkdir("/dev/shm", 0o1777)
    for path, opened in kept.items():
        if not os.path.exists(path):
            os.makedirs(path)
        kernel.mount(f"/proc/self/fd/{opened}", path, flags=kernel.BIND | kernel.WITH_SUBMOUNTS)
        kernel.set_read_only(path, path not in room.writable)
    for opened in (*kept.values(), *devices.values()):
        os.close(opened)


def _begin(room: Room, command: list[str]) -> NoReturn:
    """Be the first process there: become the command, or look after it."""
    try:
        kernel.die_with_parent()
        kernel.mount("proc", "/proc", "proc", kernel.NO_SET_UID | kernel.NO_DEVICES)
        kernel.drop_capabilities()
        os.chdir(room.folder)
        child = 0 if room.as_init else os.fork()
        if child == 0:
            os.execvp(command[0], command)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        while True:
            pid, status = os.wait()
            if pid == child:
                code = os.waitstatus_to_exitcode(status)
                os._exit(128 - code if code < 0 else code)
    except OSError as error:
        print(error, file=sys.stderr, flush=True)
    os._exit(127)
