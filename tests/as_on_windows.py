"""Commands of posflock in a Python from which is taken away what Windows lacks.

    python tests/as_on_windows.py demo --duration 3 --then report results/nine_robots.npy

Modules that only POSIX has cannot be imported; their functions are missing from `os` and `signal`;
a folder cannot be opened, a file that is open cannot be replaced or removed, nothing but sockets
can be waited for by `select`; and text files that name no encoding are cp1252.
What is left of Linux shows in what Python's own library does: this finds our mistakes, not
Python's.
"""

import builtins
import io
import os
import select
import signal
import stat
import sys

MODULES = "fcntl grp posix_ipc pty pwd resource syslog termios tty"
FUNCTIONS = (
    "fork forkpty getuid geteuid getgid getegid getpgid killpg mkfifo pidfd_open setpgid"
    " set_blocking"
    " setsid wait wait3 wait4 unshare sched_getaffinity fchmod fchown chown pread pwrite"
    " sysconf nice getloadavg O_DIRECTORY O_NOFOLLOW O_NONBLOCK statvfs"
)
SIGNALS = (
    "SIGALRM SIGBUS SIGCHLD SIGCONT SIGHUP SIGPIPE SIGQUIT SIGSTOP SIGTSTP SIGTTIN SIGTTOU SIGUSR1"
    " SIGUSR2 SIGXCPU SIGXFSZ alarm pause pthread_kill setitimer getitimer sigwait siginterrupt"
)


def _keep_open_files() -> None:
    """Let nobody replace or remove a file that this process has open."""
    open_file, replaced, removed = os.open, os.replace, os.unlink

    def refuse_open(path: object) -> None:
        try:
            told = os.stat(path)
        except OSError:
            return
        for name in os.listdir("/proc/self/fd"):
            try:
                held = os.stat(f"/proc/self/fd/{name}")
            except OSError:
                continue
            if (held.st_dev, held.st_ino) == (told.st_dev, told.st_ino):
                raise PermissionError(13, "used by another process", str(path))

    def replace(source: object, target: object, **options: object) -> None:
        refuse_open(source)
        refuse_open(target)
        replaced(source, target, **options)

    def unlink(path: object, **options: object) -> None:
        if not options:
            refuse_open(path)
        removed(path, **options)

    def opened(path: object, flags: int, *rest: int, **options: object) -> int:
        if isinstance(path, (str, os.PathLike)) and os.path.isdir(path):
            raise PermissionError(13, "Permission denied", str(path))
        return open_file(path, flags, *rest, **options)

    os.replace = os.rename = replace
    os.unlink = os.remove = unlink
    os.open = opened


def _select_sockets_alone() -> None:
    """Let nobody wait for pipes, nor for nothing."""
    plain = select.select

    def selected(*lists: object) -> object:
        watched = [file for some in lists[:3] for file in some]
        if not watched:
            raise OSError(10022, "An invalid argument was supplied")
        if not all(stat.S_ISSOCK(os.fstat(_number(file)).st_mode) for file in watched):
            raise OSError(10038, "An operation was attempted on something that is not a socket")
        return plain(*lists)

    select.select = selected


def _number(file: object) -> int:
    return file if isinstance(file, int) else file.fileno()


def _open_as_cp1252() -> None:
    plain = builtins.open

    def opened(file: object, mode: str = "r", buffering: int = -1, encoding: str | None = None, *rest: object, **options: object) -> object:  # fmt: skip  # noqa: E501
        if encoding is None and "b" not in mode:
            encoding = "cp1252"
        return plain(file, mode, buffering, encoding, *rest, **options)

    builtins.open = io.open = opened


def main() -> None:
    import multiprocessing.util  # noqa: F401  # what Python's own library needs of POSIX
    import shutil
    import subprocess
    import tempfile  # noqa: F401

    for name in MODULES.split():
        sys.modules[name] = None
    for owner, names in ((os, FUNCTIONS), (signal, SIGNALS)):
        for name in names.split():
            if hasattr(owner, name):
                delattr(owner, name)
    shutil._use_fd_functions = False
    _keep_open_files()
    _select_sockets_alone()
    _open_as_cp1252()
    assert subprocess
    from posflock_robotarium.cli import main as posflock

    for words in " ".join(sys.argv[1:]).split(" --then "):
        sys.argv = ["posflock", *words.split()]
        try:
            posflock()
        except SystemExit as end:
            print(f"{words}: ended with {end.code or 0}")


if __name__ == "__main__":
    main()
