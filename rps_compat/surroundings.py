"""What stands around a script while it runs, and is put back when it ends.

A matplotlib that draws on demand, prepared answers to ``input()``, a limit of real time: each is
a context manager, so that a script that fails leaves the process as it found it.
"""

import builtins
import contextlib
import importlib.util
import math
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from types import FrameType, ModuleType
from typing import Any

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
    """Draw on demand, whatever window system the script asks matplotlib for.

    A script that draws nothing does not wait for matplotlib to be imported.
    """
    with contextlib.ExitStack() as around:
        for module, change in (
            ("matplotlib", _no_choice_of_backend),
            ("matplotlib.pyplot", _no_windows),
        ):
            around.enter_context(_WhenImported(module, change))
        yield


class _WhenImported:
    """Enters a context as soon as a module is there, and leaves it in the end."""

    def __init__(
        self, module: str, change: Callable[[], contextlib.AbstractContextManager[None]]
    ) -> None:
        self._module, self._change = module, change
        self._entered = contextlib.ExitStack()

    def __enter__(self) -> None:
        if self._module in sys.modules:
            self._entered.enter_context(self._change())
        else:
            sys.meta_path.insert(0, self)

    def __exit__(self, *_: object) -> None:
        if self in sys.meta_path:
            sys.meta_path.remove(self)
        self._entered.close()

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        """Find the module as Python would, and hear of it when it has been imported."""
        if name != self._module:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is None or spec.loader is None:
            return spec
        loader, run = spec.loader, spec.loader.exec_module

        def exec_module(module: ModuleType) -> None:
            run(module)
            self._entered.enter_context(self._change())

        loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec


@contextlib.contextmanager
def _no_choice_of_backend() -> Iterator[None]:
    import matplotlib as mpl

    use = mpl.use
    mpl.use = lambda *args, **kwargs: None
    try:
        yield
    finally:
        mpl.use = use


@contextlib.contextmanager
def _no_windows() -> Iterator[None]:
    import matplotlib as mpl
    from matplotlib import pyplot as plt

    figures, backend, switch = plt.get_fignums(), mpl.get_backend(), plt.switch_backend
    switch("module://rps_compat.headless_backend")
    plt.switch_backend = lambda *args, **kwargs: None
    try:
        yield
    finally:
        for number in set(plt.get_fignums()) - set(figures):
            plt.close(number)
        plt.switch_backend = switch
        with contextlib.suppress(ImportError):  # it needs a display
            switch(backend)


@contextlib.contextmanager
def stdout_on_stderr() -> Iterator[None]:
    """Let everything that is printed go to stderr, by child processes as well."""
    sys.stdout.flush()
    stdout = os.dup(1)
    os.dup2(2, 1)
    try:
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        os.dup2(stdout, 1)
        os.close(stdout)


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
