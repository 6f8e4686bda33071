"""What Python's audit events say that a program is about to do: write where, start what, call whom.

Not everything is told. Native code writes, starts and connects unheard: C libraries (HDF5, OpenCV,
dbm), SQL's ``ATTACH``, `os.mkfifo`, everything by ctypes. SECURITY.md lists what follows.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any
from urllib.parse import unquote

_WRITE_FLAGS = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_TRUNC
#: Events of a path that is changed: how many paths there are, and where the descriptors of the
#: folders stand that these are relative to.
_PATHS: dict[str, tuple[int, tuple[int, ...]]] = {
    "os.remove": (1, (1,)),
    "os.rmdir": (1, (1,)),
    "os.mkdir": (1, (2,)),
    "os.chmod": (1, (2,)),
    "os.chown": (1, (3,)),
    "os.utime": (1, (3,)),
    "os.truncate": (1, ()),
    "os.setxattr": (1, ()),
    "os.removexattr": (1, ()),
    "os.chflags": (1, ()),
    "os.rename": (2, (2, 3)),
    "os.link": (2, (2, 3)),
    "shutil.rmtree": (1, (1,)),
}
#: Events of processes that are started or ended.
PROCESSES = frozenset(
    [
        "subprocess.Popen",
        "os.system",
        "os.fork",
        "os.forkpty",
        "os.posix_spawn",
        "os.exec",
        "os.spawn",
        "os.startfile",
        "os.killpg",
        "pty.spawn",
    ]
)
#: Events of the network, and which of their arguments say whom is called.
NETWORK: dict[str, slice] = {
    "socket.connect": slice(1, 2),
    "socket.sendto": slice(1, 2),
    "socket.sendmsg": slice(1, 2),
    "socket.bind": slice(1, 2),
    "socket.getaddrinfo": slice(0, 2),
    "socket.getnameinfo": slice(0, 1),
    "socket.gethostbyname": slice(0, 1),
    "socket.gethostbyaddr": slice(0, 1),
    "urllib.Request": slice(0, 1),
    "http.client.connect": slice(1, 3),
    "ftplib.connect": slice(1, 3),
    "smtplib.connect": slice(1, 3),
    "poplib.connect": slice(1, 3),
    "imaplib.open": slice(1, 3),
    "webbrowser.open": slice(0, 1),
}


def paths_written(event: str, arguments: tuple[Any, ...]) -> Iterator[str]:
    """Yield the paths that an event is about to write to or change.

    Parameters
    ----------
    event : str
        Its name, as Python's documentation lists them.
    arguments : tuple
        What it tells.
    """
    if event == "open":
        path, mode, flags = arguments[:3]
        if isinstance(mode, str):
            writes = any(letter in mode for letter in "wax+")
        else:
            writes = isinstance(flags, int) and bool(flags & _WRITE_FLAGS)
        if writes and _is_path(path):
            yield os.fsdecode(path)
    elif event == "sqlite3.connect":
        if _is_path(arguments[0]) and (path := _database(os.fsdecode(arguments[0]))):
            yield path
    elif event == "os.symlink":  # where it leads to is looked at when it is written through
        yield from _relative_to(arguments[1], arguments[2:3])
    elif event in _PATHS:
        count, folders = _PATHS[event]
        for number in range(count):
            place = folders[number] if number < len(folders) else len(arguments)
            yield from _relative_to(arguments[number], arguments[place : place + 1])


def called(event: str, arguments: tuple[Any, ...]) -> str | None:
    """Return whom an event of the network is about, in words; None where it is about nobody.

    Parameters
    ----------
    event : str
        One of `NETWORK`.
    arguments : tuple
        What it tells.
    """
    about = [part for part in arguments[NETWORK[event]] if part is not None]
    if not about:  # as when something is sent where a connection is already
        return None
    return " ".join(str(part) for part in about)


def _is_path(path: Any) -> bool:
    return isinstance(path, (str, bytes, os.PathLike))


def _relative_to(path: Any, folder: tuple[Any, ...]) -> Iterator[str]:
    """Yield a path, with the folder before it whose descriptor it is relative to, if it is to any.

    A number in place of a path is a file that is open already.
    """
    if not _is_path(path):
        return
    name = os.fsdecode(path)
    if folder and isinstance(folder[0], int) and folder[0] >= 0:
        name = os.path.join(f"/proc/self/fd/{folder[0]}", name)
    yield name


def _database(name: str) -> str:
    """Return the file that a name of sqlite3 means; empty where it is none."""
    if name.startswith("file:"):
        if "mode=memory" in name:
            return ""
        name = unquote(name[5:].partition("?")[0].partition("#")[0])
        name = "/" + name.lstrip("/") if name.startswith("//") else name
    return "" if name in ("", ":memory:") else name
