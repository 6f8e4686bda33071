"""What stands around a script while it runs, and is put back when it ends.

A matplotlib that draws on demand, prepared answers to ``input()``: each is a context manager, so
that a script that fails leaves the process as it found it.
"""

import builtins
import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from types import ModuleType
from typing import TextIO

from rps_compat.when_imported import when_imported


def has_display() -> bool:
    """Whether a window could be opened here."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


@contextlib.contextmanager
def headless_matplotlib() -> Iterator[dict[str, None]]:
    """Draw on demand, whatever window system the script asks matplotlib for.

    The block is given what the run will have to tell about its windows. A script that draws nothing
    does not wait for matplotlib to be imported.
    """
    notes: dict[str, None] = {}
    changes: dict[str, Callable[[], contextlib.AbstractContextManager[None]]] = {
        "matplotlib": _no_choice_of_backend,
        "matplotlib.pyplot": partial(_no_windows, notes),
    }
    with contextlib.ExitStack() as around:

        def change(module: ModuleType) -> None:
            around.enter_context(changes[module.__name__]())

        around.enter_context(when_imported(changes, change))
        yield notes


@contextlib.contextmanager
def _no_choice_of_backend() -> Iterator[None]:
    import matplotlib as mpl

    use = mpl.use
    mpl.use = lambda *args, **kwargs: None
    try:
        with mpl.rc_context():  # plt.ion() of one script must not outlive it
            yield
    finally:
        mpl.use = use


@contextlib.contextmanager
def _no_windows(notes: dict[str, None]) -> Iterator[None]:
    import matplotlib as mpl
    from matplotlib import pyplot as plt

    from rps_compat import headless_backend

    before, headless_backend.notes = headless_backend.notes, notes
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
        headless_backend.notes = before


@contextlib.contextmanager
def stdout_on_stderr() -> Iterator[TextIO]:
    """Let everything that is printed go to stderr, by child processes as well.

    The block is given the stdout of before, for what is to go there all the same.
    """
    sys.stdout.flush()
    stdout = os.dup(1)
    os.dup2(2, 1)
    ours = sys.stdout
    with contextlib.suppress(OSError):  # it is no file
        if ours.fileno() == 1:
            ours = open(stdout, "w", encoding=ours.encoding, errors=ours.errors, closefd=False)  # noqa: SIM115 - flushed below
    try:
        with contextlib.redirect_stdout(sys.stderr):
            yield ours
    finally:
        ours.flush()
        os.dup2(stdout, 1)
        os.close(stdout)


@contextlib.contextmanager
def answering(answers: Sequence[str], told: Callable[[], None] | None = None) -> Iterator[None]:
    """Answer ``input()`` from a list, then with empty lines; show what was asked.

    `told`, if given, is told of each question that has no answer.

    Parameters
    ----------
    answers : sequence of str
        The answers, in order.
    told : callable, optional
        Is called at each question that has no answer.
    """
    left, asked = iter(answers), builtins.input

    def answer(prompt: object = "", /) -> str:
        reply = next(left, None)
        if reply is None:
            reply = ""
            if told is not None:
                told()
        print(f"{prompt}{reply}")
        return reply

    builtins.input = answer
    try:
        yield
    finally:
        builtins.input = asked
