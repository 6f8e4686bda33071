"""One trial: a script run once in a process of its own, watched, limited and recorded.

The process was forked for this trial and ends with it. The script sees the testbed's world: it is
``__main__``, has no arguments, finds its files flat in the working folder, and ``rps`` is the
simulator under the trial's imperfections. Its time is a clock that charges it for what it computes,
and policy stops what it must not do.
"""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

from rps_compat.running.driver import Guests, drive
from rps_compat.running.plan import RunPlan
from rps_compat.running.watching import Teller


def run_trial(plan: RunPlan, teller: Teller, printed: Path) -> None:
    """Run the trial in this process, which it uses up, and tell its outcome.

    Parameters
    ----------
    plan : RunPlan
        What is run.
    teller : Teller
        Who is told.
    printed : Path
        File for what the script prints.
    """
    output = os.open(printed, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND)
    for descriptor in (1, 2):
        os.dup2(output, descriptor)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout = open(1, "w", buffering=1, errors="replace", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="replace", closefd=False)  # noqa: SIM115
    try:
        teller.outcome(drive(plan, Guests(teller=teller)))
    finally:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError):  # it has printed more than it may
                stream.flush()
        os._exit(0)
