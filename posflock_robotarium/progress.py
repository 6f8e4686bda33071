"""Tell a waiting person how far a run is: a bar on a terminal, plain lines elsewhere.

Needs nothing but Python, because it goes to the testbed; a bar needs rich.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator


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
