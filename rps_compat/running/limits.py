"""What a process may use: for one that a script has to itself, and uses up."""

from __future__ import annotations

import contextlib
import mmap
import os
import signal

from rps_compat.containment.processes import everyone

#: Processes and threads that a limited process may add to those which its user has. It is not meant
#: to be met: what there is of them is looked at from outside. It stops what grows faster than that.
TASKS = 512


def limit_process(memory: int | None, file: int | None) -> None:
    """Limit what this process may allocate beyond what it has now, write, and start.

    No process can raise its limits again. Systems without such limits have none. The number of
    processes and threads is limited with any other limit, for their user as a whole, as the kernel
    counts them: in namespaces those there. It holds no process of the superuser.

    Parameters
    ----------
    memory : int or None
        Bytes; None limits nothing.
    file : int or None
        Bytes that any one file may have; None limits nothing.
    """
    try:
        import resource
    except ImportError:
        return
    if memory is not None:
        _set(resource.RLIMIT_AS, _allocated() + memory)
    if file is not None:
        _set(resource.RLIMIT_FSIZE, file)
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # then writing raises an OSError
    if memory is not None or file is not None:
        _set(resource.RLIMIT_CORE, 0)
        if os.path.exists("/proc/self"):  # else nobody tells how many there are
            _set(resource.RLIMIT_NPROC, _tasks() + TASKS)


def _set(kind: int, most: int) -> None:
    import resource

    with contextlib.suppress(ValueError, OSError):
        before = resource.getrlimit(kind)[1]
        allowed = most if before == resource.RLIM_INFINITY else min(most, before)
        resource.setrlimit(kind, (allowed, allowed))


def _allocated() -> int:
    """Return the bytes of address space that this process has."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[0]) * mmap.PAGESIZE
    except OSError:
        return 1 << 30


def _tasks() -> int:
    """Return how many threads the processes of this user have, as far as they can be seen."""
    return sum(process.threads for process in everyone() if process.user == os.getuid())
