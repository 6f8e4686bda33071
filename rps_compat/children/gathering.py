"""What the child processes of a run have left, read when its script has ended."""

import contextlib
import json
import os
import re
import signal
from dataclasses import dataclass
from pathlib import Path

from rps_compat.children.leftovers import GRACE
from rps_compat.children.records import Record, RobotariumInstance
from rps_compat.clock import real
from rps_compat.containment.processes import look_at
from rps_compat.logged_end import LoggedEnd
from rps_compat.recording import files_of
from rps_compat.report import RunReport, report_of

#: Seconds between two looks at processes that end.
_LOOK = 0.02


@dataclass(frozen=True)
class Children:
    """What the child processes of a run leave.

    Attributes
    ----------
    reports
        One for each instance, by process and in the order of their making.
    files
        Logs that they have written.
    notes
        What the reports do not tell.
    """

    reports: tuple[RunReport, ...] = ()
    files: tuple[Path, ...] = ()
    notes: tuple[str, ...] = ()


def gather(room: Path) -> Children:
    """Read the records of a run.

    Parameters
    ----------
    room : Path
        Folder of the run's records.
    """
    reports: list[RunReport] = []
    files: list[Path] = []
    notes: list[str] = []
    for process in sorted(room.glob("*.process"), key=_in_order):
        instances = [
            instance
            for path in sorted(room.glob(f"{process.stem}-*.instance"), key=_in_order)
            if (instance := RobotariumInstance.read(path)).process == process.stem
        ]
        records = [Record.read(room, instance) for instance in instances]
        for instance, record in zip(instances, records, strict=True):
            reports.append(
                report_of(
                    instance.robots, record.steps, record.time_step, record.found, instance.process
                )
            )
            files += files_of(Path(instance.log)) if instance.log else []
        if any(instance.copied for instance in instances):
            notes.append(
                f"{process.stem} drove on a copy of a Robotarium that its parent had made: what "
                "that had done before is told of both"
            )
        note = _note_on(process, all(record.over for record in records))
        notes += [note] if note else []
    return Children(tuple(reports), tuple(files), tuple(notes))


def terminate(room: Path) -> None:
    """End the processes that have records and still run; let them close these.

    Parameters
    ----------
    room : Path
        Folder of the run's records.
    """
    ending = [process for process in room.glob("*.process") if _goes_on(process)]
    for process in ending:
        with contextlib.suppress(OSError, ValueError):
            os.kill(int(process.read_text()), signal.SIGTERM)
    looks = int(GRACE / _LOOK)
    while looks and any(_goes_on(process) for process in ending):
        real.sleep(_LOOK)  # whatever `time` does
        looks -= 1


def _goes_on(process: Path) -> bool:
    return not process.with_suffix(".end").exists() and _is_alive(process)


def _in_order(path: Path) -> list[str | int]:
    """Sort names with numbers as people do."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.stem)]


def _note_on(process: Path, over: bool) -> str:
    """Say what the records of a child do not tell; empty if the runs of its robots are `over`."""
    try:
        how, reason = json.loads(process.with_suffix(".end").read_text("utf-8"))
    except OSError:
        if over:
            return ""
        if _is_alive(process):
            return (
                f"{process.stem} still ran when the script had ended: what it did then is not told"
            )
        return (
            f"{process.stem} was ended while its robots drove: what is told of it ends with a step "
            "that it may not have finished"
        )
    return f"{process.stem} {how}: {reason}" if how == LoggedEnd.FAILED else ""


def _is_alive(process: Path) -> bool:
    """Whether the process of a record still runs."""
    try:
        number = int(process.read_text())
        if hasattr(os, "waitid"):
            with contextlib.suppress(ChildProcessError):  # not ours, but perhaps a child's
                return os.waitid(os.P_PID, number, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None
        if os.name == "nt":  # to ask would send it a Ctrl-C
            return True
        os.kill(number, 0)
    except (OSError, ValueError):
        return False
    seen = look_at(number)  # where nobody tells, who can be sent a signal runs
    return seen is None or not seen.ended
