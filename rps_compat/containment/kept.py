"""What a command keeps only as long as it lives: a temporary folder, a process.

However the command ends, by itself, by an exception, by Ctrl-C or by a signal that gives it no time
at all, nothing of it stays: what it cannot clean up its keeper does (:mod:`~.keeper`).
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import IO

from rps_compat.containment.bare_python import bare_python
from rps_compat.containment.keeper import DONE, ProcessEnd, ProcessOrder
from rps_compat.containment.namespaces import ContainmentError
from rps_compat.containment.stale_folders import hold, new_name, sweep

#: Seconds between two calls of what is to be done meanwhile.
_OFTEN = 0.05


class KeptFolder:
    """A temporary folder; use it in a ``with`` block, or close it.

    Parameters
    ----------
    purpose : str
        What it is for, one word in small letters; a part of its name.

    Attributes
    ----------
    path : Path
        Where it is, without symbolic links.
    """

    def __init__(self, purpose: str) -> None:
        place = Path(tempfile.gettempdir()).resolve()
        sweep(place)
        self.path = place / new_name(purpose)
        self._owner = os.getpid()
        self._line = _Line()
        words = (str(self._owner), str(self._line.ours), str(self.path))
        if hasattr(os, "fork"):  # Windows has no keepers; the next start sweeps
            with contextlib.suppress(OSError):  # no room for a process; the next start sweeps
                subprocess.run(
                    bare_python("keeper", "folder", *words, owner=self._owner, apart=True),
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    pass_fds=(self._line.ours,),
                    start_new_session=True,
                    check=False,
                )
        self._line.close_ours()
        self.path.mkdir(mode=0o700, exist_ok=True)
        self._held = hold(self.path)

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Remove the folder; a second call, or one in a fork of this process, does nothing."""
        if os.getpid() != self._owner or self._line.closed:
            return
        shutil.rmtree(self.path, ignore_errors=True)
        if self._held is not None:
            os.close(self._held)
        self._line.say_done()


class KeptProcess:
    """A process that ends with this one, and with which all ends that it has started.

    Parameters
    ----------
    order : ProcessOrder
        What is started, and what holds it.
    cwd : path
        Folder in which it starts.
    env : mapping
        Its environment's variables, all of them.
    stdin, stdout, stderr : int or file
        As `subprocess.Popen` takes them.
    pass_fds : tuple of int
        Further descriptors that it gets.

    Raises
    ------
    ContainmentError
        Where processes cannot be forked.
    """

    def __init__(
        self,
        order: ProcessOrder,
        *,
        cwd: Path | str,
        env: Mapping[str, str],
        stdin: int | IO[bytes] = subprocess.DEVNULL,
        stdout: int | IO[bytes] = subprocess.DEVNULL,
        stderr: int | IO[bytes] = subprocess.DEVNULL,
        pass_fds: tuple[int, ...] = (),
    ) -> None:
        if not hasattr(os, "fork"):
            raise ContainmentError(
                "verify and rehearse hold a script in forked processes, which this system does not"
                " have: use Linux, macOS or, on Windows, WSL; posflock run needs none"
            )
        self._line = _Line()
        self._answer, answer = os.pipe()
        words = (str(os.getpid()), str(self._line.ours), str(answer), json.dumps(asdict(order)))
        try:
            self._keeper = subprocess.Popen(
                bare_python("keeper", "process", *words, owner=os.getpid()),
                stdin=stdin,
                stdout=stdout,
                stderr=stderr,
                cwd=cwd,
                env=dict(env),
                pass_fds=(self._line.ours, answer, *pass_fds),
                start_new_session=True,
                text=True,
            )
        finally:
            os.close(answer)
            self._line.close_ours()

    @property
    def stdin(self) -> IO[str]:
        """Its standard input, where that is a pipe."""
        assert self._keeper.stdin is not None
        return self._keeper.stdin

    @property
    def stdout(self) -> IO[str]:
        """Its standard output, where that is a pipe."""
        assert self._keeper.stdout is not None
        return self._keeper.stdout

    def is_running(self) -> bool:
        """Whether it, or anything that it has started, still runs."""
        return self._keeper.poll() is None

    def wait(self, meanwhile: Callable[[], None] = lambda: None) -> ProcessEnd:
        """Wait until it, and all that it has started, has ended; return how.

        Parameters
        ----------
        meanwhile : callable
            Is called every now and then, and once more at the end.
        """
        while not select.select([self._answer], [], [], _OFTEN)[0]:
            meanwhile()
        meanwhile()
        with open(self._answer, "rb", closefd=False) as answer:
            told = answer.read()
        self.end()
        return ProcessEnd(**json.loads(told)) if told else ProcessEnd(127)

    def end(self) -> None:
        """End it with all that it has started; a second call does nothing."""
        if self._line.closed:
            return
        self._line.say_done()
        os.close(self._answer)
        for pipe in (self._keeper.stdin, self._keeper.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        self._keeper.wait()


class _Line:
    """A pipe to a keeper, in which it is told that it is not needed any more."""

    def __init__(self) -> None:
        self.ours, self._command = os.pipe()
        self.closed = False

    def close_ours(self) -> None:
        """Leave the keeper's end to the keeper, which has it now."""
        os.close(self.ours)

    def say_done(self) -> None:
        """Tell the keeper, and close the line."""
        with contextlib.suppress(OSError):  # it is gone
            os.write(self._command, DONE)
        os.close(self._command)
        self.closed = True
