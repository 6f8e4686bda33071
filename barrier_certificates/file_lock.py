"""One writer a file: the lock by which a run, a log and a study keep a second one out.

It stands here, below everything, because logs fly with the script and the simulator does not.
"""

from types import ModuleType

locks: ModuleType | None
try:
    import fcntl as locks
except ImportError:  # Windows, which lets nobody replace a file that is open
    locks = None

#: Whether this system knows such locks; where it does not, a folder cannot even be opened.
KNOWN = locks is not None


def try_lock(file: int) -> bool:
    """Lock a file or folder for this process, until its descriptor is closed.

    Not every system and every disk knows locks: where one does not, nobody is kept out.

    Parameters
    ----------
    file : int
        Descriptor, as `os.open` returns it.

    Returns
    -------
    bool
        False where another process has it.
    """
    if locks is None:
        return True
    try:
        locks.flock(file, locks.LOCK_EX | locks.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True
