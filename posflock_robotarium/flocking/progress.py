"""Tell a waiting person how far a run is: a bar on a terminal, plain lines elsewhere.

Needs nothing but Python, because it goes to the testbed; a bar needs rich.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def steps_of(count: int, time_step: float, title: str) -> Iterator[int]:
    """Yield 0 … count − 1 and report on standard error as they pass.

    Parameters
    ----------
    count : int
        Steps to do.
    time_step : float
        Seconds of experiment in each; where there is no terminal, a line is written every
        tenth of the run.
    title : str
        What is being done.
    """
    if sys.stderr.isatty():
        try:
            from rich.console import Console
            from rich.progress import track
        except ImportError:
            pass
        else:
            yield from track(
                range(count), description=title, console=Console(stderr=True), transient=True
            )
            return
    told = 0
    for step in range(count):
        yield step
        tenths = 10 * (step + 1) // count
        if tenths > told:
            told = tenths
            done, whole = (step + 1) * time_step, count * time_step
            print(f"{title}: {done:.0f} of {whole:.0f} s", file=sys.stderr, flush=True)


@contextmanager
def counted(title: str) -> Iterator[Callable[[int, int], None]]:
    """Give a function of (done, all) that tells how far a computation is, and the time left.

    A bar on a terminal; elsewhere a plain line whenever another tenth is done.

    Parameters
    ----------
    title : str
        What is being done.
    """
    started, told = time.monotonic(), 0

    def tell(done: int, whole: int) -> None:
        nonlocal told
        if whole and (done == whole or 10 * done // whole > told):
            told = 10 * done // whole
            left = (time.monotonic() - started) / max(done, 1) * (whole - done)
            print(f"{title}: {done} of {whole}, {left:.0f} s left", file=sys.stderr, flush=True)

    if not sys.stderr.isatty():
        yield tell
        return
    try:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn
    except ImportError:
        yield tell
        return
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(title, *columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, whole: bar.update(task, completed=done, total=whole)
