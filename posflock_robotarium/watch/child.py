"""The script's process: ``python -m posflock_robotarium.watch.child``.

It reads its order, one line of JSON, from the standard input, and requests after that; the script
finds an empty one. What is shown goes through a pipe of which the script does not know the word.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from pathlib import Path
from typing import Any

from barrier_certificates.hearing import heard_by
from posflock_robotarium.flocking.attendance import attended_by
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.recorder import open_pose_log
from posflock_robotarium.watch.onlooker import Lines, WatchedRun
from posflock_robotarium.watch.settings import Settings
from rps_compat.profiles import profile_from_dict
from rps_compat.running.driver import Guests, drive
from rps_compat.running.plan import RunPlan
from rps_compat.running.watching import Teller
from rps_compat.scripts.deaths import hint
from rps_compat.scripts.evidence import evidence_in

#: The logs of this process, for what is noted in them while it runs.
_LOGS: list[PoseLog] = []


def open_watched_log(path: Path, robots: int, about: dict[str, Any]) -> PoseLog:
    """Open the pose log of one Robotarium instance, and remember it.

    Parameters
    ----------
    path : Path
        The log's path, without ending.
    robots : int
        Number of robots.
    about : dict
        Which script ran, on which generation, with which seed.
    """
    log = open_pose_log(path, robots, about)
    _LOGS.append(log)
    return log


def main() -> None:
    """Run the script as ordered, and tell how it went."""
    requests = Lines(os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    lines: list[str] = []
    while not lines and not requests.ended:
        lines = requests.within(float("inf"))
    order = json.loads(lines[0])
    plan = RunPlan.from_dict(order["plan"])
    teller = Teller(order["pipe"], order["word"])
    profiles = {name: profile_from_dict(table) for name, table in order["profiles"].items()}
    settings = Settings.from_dict(order["settings"])
    run = WatchedRun(teller.more, requests, settings, profiles, order["radius"], plan.seed)
    run.logs = _LOGS
    evidence = evidence_in(Path(plan.folder) / plan.script)
    guests = Guests(
        recorder=open_watched_log,
        advise=lambda error: hint(error, evidence, plan.generation),
        notes=tuple(order["notes"]),
        teller=teller,
        onlookers=(run,),
    )
    try:
        with heard_by(run.heard), attended_by(run.attend):
            outcome = drive(plan, guests)
        run.show(last=True)
        teller.outcome(outcome)
    finally:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError):
                stream.flush()
        os._exit(0)


if __name__ == "__main__":
    main()
