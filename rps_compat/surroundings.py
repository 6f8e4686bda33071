"""What stands around a script while it runs, and is put back when it ends.

A matplotlib that draws on demand, prepared answers to ``input()``: each is a context manager, so
that a script that fails leaves the process as it found it.
"""

import builtins
import contextlib
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path


def has_display() -> bool:
    """Whether a window could be opened here."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


@contextlib.contextmanager
def headless_matplotlib() -> Iterator[dict[str, None]]:
    """Draw on demand, whatever window system the script asks matplotlib for.

    The block is given what the run will have to tell about its windows.
    """
    import matplotlib as mpl
    from matplotlib import pyplot as plt

    from rps_compat import headless_backend

    figures, backend, use, switch = (
        plt.get_fignums(),
        mpl.get_backend(),
        mpl.use,
        plt.switch_backend,
    )
    switch("module://rps_compat.headless_backend")
    mpl.use = plt.switch_backend = lambda *args, **kwargs: None  # type: ignore[assignment]
    headless_backend.notes.clear()
    try:
        yield headless_backend.notes
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


def forget_modules_of(folder: Path, known: set[str]) -> None:
    """Drop modules that the script imported from its own `folder`: the next script has its own."""
    for name in set(sys.modules) - known:
        source = getattr(sys.modules[name], "__file__", None)
        if source and Path(source).parent == folder:
            del sys.modules[name]
