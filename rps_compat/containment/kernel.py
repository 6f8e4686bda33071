"""System calls of Linux that Python has no functions for, called by ctypes.

Each raises OSError where the kernel refuses, and where there is no Linux.
"""

from __future__ import annotations

import ctypes
import errno
import os
import signal
import struct
import sys

# Numbers from <linux/prctl.h>, <linux/sched.h>, <linux/mount.h> and <linux/capability.h>.
_SET_PARENT_DEATH_SIGNAL, _SET_DUMPABLE, _SET_CHILD_SUBREAPER = 1, 4, 36
_DROP_BOUNDING_CAPABILITY, _SET_NO_NEW_PRIVILEGES = 24, 38
_MOUNT_SETATTR, _HERE, _RECURSIVE, _READ_ONLY = 442, -100, 0x8000, 1
_CAPABILITY_VERSION = 0x20080522

NEW_MOUNTS, NEW_NAMES, NEW_IPC = 0x00020000, 0x04000000, 0x08000000
NEW_USER, NEW_PROCESSES, NEW_NETWORK = 0x10000000, 0x20000000, 0x40000000
NO_SET_UID, NO_DEVICES, BIND, WITH_SUBMOUNTS, PRIVATE = 2, 4, 4096, 16384, 1 << 18

_libc = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


def _call(name: str, *arguments: object) -> None:
    """Call a function of the C library that says failure by a value below 0."""
    function = getattr(_libc, name, None)
    if function is None:
        raise OSError(errno.ENOSYS, f"no {name}() here")
    if function(*arguments) < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{name}: {os.strerror(number)}")


def _prctl(option: int, value: int) -> None:
    _call("prctl", option, *(ctypes.c_ulong(number) for number in (value, 0, 0, 0)))


def die_with_parent() -> None:
    """Have the kernel kill this process when the thread that started it ends.

    Raises
    ------
    OSError
        Where the kernel has no such thing.
    """
    _prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)


def adopt_orphans() -> None:
    """Become the parent of every descendant whose own parent ends, whatever session it is in.

    Raises
    ------
    OSError
        Where the kernel has no such thing.
    """
    _prctl(_SET_CHILD_SUBREAPER, 1)


def keep_private(private: bool) -> None:
    """Keep other processes of this user from this one's memory and open files, or no more.

    Parameters
    ----------
    private : bool
        Which of the two; a fork is what its parent was.

    Raises
    ------
    OSError
        Where the kernel has no such thing.
    """
    _prctl(_SET_DUMPABLE, int(not private))


def drop_capabilities() -> None:
    """Give up everything that distinguishes root within its namespace, for this process and after.

    Raises
    ------
    OSError
        Where the kernel refuses.
    """
    _prctl(_SET_NO_NEW_PRIVILEGES, 1)
    for number in range(64):
        try:
            _prctl(_DROP_BOUNDING_CAPABILITY, number)
        except OSError:
            break  # no more of them
    header = struct.pack("Ii", _CAPABILITY_VERSION, 0)
    _call("capset", header, bytes(24))


def unshare(flags: int) -> None:
    """Move this process, or its next child, into namespaces of their own.

    Parameters
    ----------
    flags : int
        Of which kinds: a sum of the ``NEW_`` constants.

    Raises
    ------
    OSError
        Where the kernel refuses.
    """
    _call("unshare", flags)


def mount(source: str, target: str, kind: str = "", flags: int = 0, data: str = "") -> None:
    """Mount a file system, or bind a folder to another place.

    Parameters
    ----------
    source, target : str
        What is mounted where.
    kind : str
        Of file system; empty for a bind.
    flags : int
        A sum of the constants for mounts.
    data : str
        Options of the file system.

    Raises
    ------
    OSError
        Where the kernel refuses.
    """
    words = (source.encode(), target.encode(), kind.encode() or None)
    _call("mount", *words, ctypes.c_ulong(flags), data.encode() or None)


def set_read_only(path: str, read_only: bool, with_submounts: bool = False) -> None:
    """Make a mount read-only, or writable again.

    Parameters
    ----------
    path : str
        Where it is mounted.
    read_only : bool
        Which of the two.
    with_submounts : bool
        Whether all that is mounted below it is changed, too.

    Raises
    ------
    OSError
        Where the kernel refuses, or is older than 5.12.
    """
    change = (_READ_ONLY, 0) if read_only else (0, _READ_ONLY)
    attributes = struct.pack("QQQQ", *change, 0, 0)
    depth = _RECURSIVE if with_submounts else 0
    number, size = ctypes.c_long(_MOUNT_SETATTR), ctypes.c_size_t(len(attributes))
    _call("syscall", number, _HERE, path.encode(), depth, attributes, size)
