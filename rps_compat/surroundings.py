"""What stands around a script while it runs, and is put back when it ends.

A matplotlib that draws on demand, prepared answers to ``input()``, a limit of real time: each is
a context manager, so that a script that fails leaves the process as it found it.
"""

import builtins
import contextlib
import math
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from types import FrameType

from rps_compat.errors import ScriptError


class OutOfTime(BaseException):
    """The time limit of a run is over; not an Exception, so that scripts do not swallow it."""


def has_display() -> bool:
    """Whether a window could be opened here."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


@contextlib.contextmanager
def headless_matplotlib() -> Iterator[None]:
    """Draw on demand, whatever window system the script asks matplotlib for."""
    import matplotlib as mpl
    from matplotlib import pyplot as plt

    figures, backend, use, switch = (
        plt.get_fignums(),
        mpl.get_backend(),
        mpl.use,
        plt.switch_backend,
    )
    switch("module://rps_compat.headless_backend")
    mpl.use = plt.switch_backend = lambda *args, **kwargs: None  # type: ignore[assignment]
    try:
        yield
    finally:
        for number in set(plt.get_fignums()) - set(figures):
            plt.close(number)
        mpl.use, plt.switch_backend = use, switch
        switch(backend)


@contextlib.contextmanager
def answering(answers: Sequence[str]) -> Iterator[None]:
    """Answer ``input()`` from `answers`, then with empty lines; show what was asked."""
    left, asked = iter(answers), builtins.input

    def answer(prompt: object = "", /) -> str:
        reply = next(left, "")
        print(f"{prompt}{reply}")
        return reply

    builtins.input = answer
    try:
        yield
    finally:
        builtins.input = asked


@contextlib.contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise OutOfTime in the script after `seconds` of real time."""
    if seconds is None or not math.isfinite(seconds):
        yield
        return
    if threading.current_thread() is not threading.main_thread() or not hasattr(
        signal, "setitimer"
    ):
        raise ScriptError("a time limit needs the main thread of a POSIX system")

    def stop(number: int, frame: FrameType | None) -> None:
        raise OutOfTime

    before = signal.signal(signal.SIGALRM, stop)
    # Repeated, because a bare `except:` in the script may swallow the first.
    signal.setitimer(signal.ITIMER_REAL, seconds, 0.25)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
