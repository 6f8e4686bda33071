"""What a process may use: for one that a script has to itself, and uses up."""

from __future__ import annotations

import contextlib
import mmap
import signal


def limit_process(memory: int | None, file: int | None) -> None:
    """Limit what this process may allocate beyond what it has now, and what it may write.

    No process can raise its limits again. Systems without such limits have none.

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
