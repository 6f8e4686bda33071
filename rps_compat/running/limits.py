"""What a process may use: for one that a script has to itself, and uses up."""

from __future__ import annotations

import contextlib
import mmap
import signal

#: Bytes that any one file may have.
_FILE = 1 << 30


def limit_memory(amount: int) -> None:
    """Limit what this process may allocate beyond what it has now, and what it may write.

    Systems without such limits have none.

    Parameters
    ----------
    amount : int
        Bytes.
    """
    try:
        import resource
    except ImportError:
        return
    try:
        with open("/proc/self/statm") as file:
            used = int(file.read().split()[0]) * mmap.PAGESIZE
    except OSError:
        used = 1 << 30
    for kind, most in (
        (resource.RLIMIT_AS, used + amount),
        (resource.RLIMIT_FSIZE, _FILE),
        (resource.RLIMIT_CORE, 0),
    ):
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(kind, (most, resource.getrlimit(kind)[1]))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
