"""One trial: a script run once in a process of its own, watched, limited and recorded.

The process was forked for this trial and ends with it. The script sees the testbed's world: it is
``__main__``, has no arguments, finds its files flat in the working folder, and ``rps`` is the
simulator under the trial's imperfections. Its time is a clock that charges it for what it computes,
and policy stops what it must not do.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from rps_compat.running.driver import drive
from rps_compat.running.plan import RunPlan

#: Files of the folder in which a trial is watched.
OUTCOME, PRINTED = "outcome.json", "printed.txt"


def run_trial(plan: RunPlan) -> None:
    """Run the trial in this process, which it uses up; leave its outcome where it is watched.

    Parameters
    ----------
    plan : RunPlan
        What is run, and where it is watched.
    """
    assert plan.watched is not None
    watched = Path(plan.watched)
    printed = os.open(watched / PRINTED, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for descriptor in (1, 2):
        os.dup2(printed, descriptor)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout = open(1, "w", buffering=1, errors="replace", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="replace", closefd=False)  # noqa: SIM115
    try:
        outcome = drive(plan)
        part = watched / f"{OUTCOME}.part"
        part.write_text(json.dumps(outcome.as_dict()))
        os.replace(part, watched / OUTCOME)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)
