"""What the testbed and the script printed: the ``log.txt`` that comes back beside a log of poses.

The testbed stamps what it says itself (``[INFO] [1781274243.17] [robotarium]: …``): when it began
to drive the robots to their initial conditions, and when it started the script. What stopped a run
stands at its end: a collision, or the traceback of a KeyboardInterrupt (the time was up, or
somebody stopped it) or of an error. The script's own lines lie in between, and among these, since
they are buffered; those with a time in them are events.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from posflock_robotarium.logs.event_lines import events_in
from rps_compat.bounded_files import read_bounded

LARGEST = 4 << 20
"""Bytes beyond which nothing that was printed is read: forty minutes of a line every step."""

MOST_LINES = 100_000
"""Lines that are looked at, half of them the first ones: stamps lead, and what ended a run ends."""

_STAMPED = re.compile(r"^\[\w+\] \[(\d{9,12}(?:\.\d+)?)\] \[robotarium\]: *(.*)$")
_INITIALISING = re.compile(r"^Initializing (\d+) robots? to initial conditions")
_ARRIVED, _STARTED = "At initial conditions", "Starting Experiment"
_COLLISION = re.compile(
    r"^[ \t]*Collision Detected![ \t]*\r?\n[ \t]*Stopping experiment", re.MULTILINE
)
_INTERRUPT = re.compile(r"^KeyboardInterrupt\b", re.MULTILINE)
_ERROR = re.compile(r"^(?:\w+\.)*\w*(?:Error|Exception)\b.*$", re.MULTILINE)
#: Seconds beyond which no line tells the time of a run.
_LONGEST = 1e6
_TRACEBACK = "Traceback (most recent call last)"


@dataclass(frozen=True)
class PrintedLog:
    """What is known of a run from what was printed.

    Attributes
    ----------
    file : str
        What it was read from, as the report calls it.
    robots : int, optional
        How many the testbed drove to their initial conditions.
    driving_at, arrived_at, started_at : float, optional
        When the drive to the initial conditions began, when it had ended, and when the script
        went on, seconds since 1970.
    collision : bool
        Whether the testbed detected a collision and stopped the run.
    interrupted : bool
        Whether a KeyboardInterrupt ended the script.
    error : str
        The error that ended it; empty where none did.
    events : int
        How many lines have a time in them.
    last_time : float, optional
        The latest of these times, by the script's own clock, s.
    """

    file: str
    robots: int | None = None
    driving_at: float | None = None
    arrived_at: float | None = None
    started_at: float | None = None
    collision: bool = False
    interrupted: bool = False
    error: str = ""
    events: int = 0
    last_time: float | None = None

    @property
    def drive(self) -> float | None:
        """Seconds that the drive to the initial conditions took; None where it is not stamped."""
        if self.driving_at is None or self.arrived_at is None:
            return None
        return self.arrived_at - self.driving_at

    @property
    def began_at(self) -> float | None:
        """When the experiment began, seconds since 1970."""
        return self.arrived_at if self.started_at is None else self.started_at

    @property
    def told(self) -> str:
        """What it says, in one sentence of the report."""
        said = []
        if self.drive is not None:
            said.append(f"the drive to the start took {self.drive:.1f} s")
        if self.collision:
            said.append("the testbed detected a collision and stopped")
        if self.interrupted:
            said.append("a KeyboardInterrupt ended the script")
        if self.error:
            said.append(f"an error ended the script ({self.error})")
        if self.last_time is not None:
            said.append(f"{self.events} timed lines, the last at {self.last_time:.1f} s")
        return f"in {self.file}: {'; '.join(said) or 'nothing unusual'}"


def printed_log_of(text: str, file: str) -> PrintedLog | None:
    """Read what was printed; None where it tells nothing of a run.

    Parameters
    ----------
    text : str
        All of it.
    file : str
        What the report calls it.
    """
    robots: int | None = None
    stamps: dict[str, float] = {}
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        lines = lines[: MOST_LINES // 2] + lines[-MOST_LINES // 2 :]
        text = "\n".join(lines)
    for line in lines:
        stamped = _STAMPED.match(line)
        words = stamped[2] if stamped else line
        at = float(stamped[1]) if stamped else None
        if found := _INITIALISING.match(words):
            robots = int(found[1])
            what = "driving"
        elif words.startswith(_ARRIVED):
            what = "arrived"
        elif stamped and words.startswith(_STARTED):
            what = "started"
        else:
            continue
        if at is not None:
            stamps[what] = at
    times = [at for at in events_in(text).values() if at < _LONGEST]
    failed = _ERROR.search(text, text.rindex(_TRACEBACK)) if _TRACEBACK in text else None
    read = PrintedLog(
        file,
        robots,
        stamps.get("driving"),
        stamps.get("arrived"),
        stamps.get("started"),
        _COLLISION.search(text) is not None,
        _INTERRUPT.search(text) is not None,
        failed[0].strip()[:200] if failed else "",
        len(times),
        max(times, default=None),
    )
    return None if read == PrintedLog(file) else read


def printed_beside(file: Path) -> PrintedLog | None:
    """Read what was printed during the run of a log: ``log.txt`` or ``NAME_log.txt`` beside it.

    Parameters
    ----------
    file : Path
        The log of poses.
    """
    for name in (f"{file.stem}_log.txt", "log.txt"):
        beside = file.with_name(name)
        if beside != file and (found := read_printed(beside)) is not None:
            return found
    return None


def read_printed(file: Path) -> PrintedLog | None:
    """Read a file of what was printed; None where there is none, or it tells nothing of a run.

    Parameters
    ----------
    file : Path
        Such as ``log.txt``.
    """
    try:
        text = read_bounded(file, LARGEST).decode("utf-8", "replace")
    except OSError:
        return None
    return printed_log_of(text, file.name)
