"""Real runs as others published them: a script, and the log that the testbed gave back.

A folder of fetched repositories is searched for logs ``logs/NAME.txt`` with a script ``NAME.py``
beside that folder. What is read of a log: when something happened (``[t= 50.3s] sweep complete``),
how the run ended, and how long the robots drove to their start (the testbed's own lines). Only
times, counts and names of events are read; nothing of it is kept.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

_EVENT = re.compile(r"^\[t=\s*([\d.]+)\s*s\]\s*(.*)$", re.MULTILINE)
_LABEL_ENDS = re.compile(r"[;(:]|->")
_COUNTS = re.compile(r"\b([A-Za-z][\w-]*)=(\[[\d, ]+\]|\d+(?![\d.]))")
_STAMP = r"\[(\d+\.\d+)\] \[robotarium\]: "
_BEGIN = re.compile(_STAMP + r"Initializing (\d+) robots")
_ARRIVED = re.compile(_STAMP + "At initial conditions")

#: An event of a script's own timetable comes within this of a whole second, s.
ROUNDING = 0.06

#: What happened, and the how many-th time: names without their numbers, so that the third capture
#: is the third whoever it is.
Event = tuple[str, int]


class End(Enum):
    """How a real run ended."""

    COMPLETED = "completed"
    COLLISION = "collision"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class RealRun:
    """What is known of a real run.

    Attributes
    ----------
    script : Path
        What ran.
    text : str
        The log.
    """

    script: Path
    text: str

    @property
    def name(self) -> str:
        """The script's name as far as its first underscore."""
        return self.script.stem.split("_")[0]

    @property
    def end(self) -> End:
        """How it ended, by the testbed's own words."""
        if "Collision Detected" in self.text:
            return End.COLLISION
        return End.INTERRUPTED if "KeyboardInterrupt" in self.text else End.COMPLETED

    @property
    def events(self) -> dict[Event, float]:
        """When each event of robots happened, s; those of the script's timetable are left out.

        A timetable shows itself by whole seconds, always.
        """
        found = events_of(self.text)
        free = {what for (what, _), t in found.items() if abs(t - round(t)) > ROUNDING}
        return {event: t for event, t in found.items() if event[0] in free}

    @property
    def last(self) -> float:
        """Time of the last thing that the log tells, s; unknown times are after it."""
        return max(events_of(self.text).values(), default=0.0)

    @property
    def robots(self) -> int:
        """How many robots drove."""
        begun = _BEGIN.search(self.text)
        return int(begun[2]) if begun else 0

    @property
    def initial_drive(self) -> float | None:
        """Seconds of driving to the initial conditions; None where the log does not tell."""
        begun, arrived = _BEGIN.search(self.text), _ARRIVED.search(self.text)
        return float(arrived[1]) - float(begun[1]) if begun and arrived else None


def events_of(text: str) -> dict[Event, float]:
    """Return when each event of a printed log happened, s.

    Parameters
    ----------
    text : str
        What a script printed.
    """
    times: dict[Event, float] = {}
    seen: Counter[str] = Counter()
    for time, words in _EVENT.findall(text):
        what = re.sub(r"\d+", "#", _LABEL_ENDS.split(words)[0]).strip()
        seen[what] += 1
        times[what, seen[what]] = float(time)
    return times


def counts_of(text: str) -> dict[tuple[float, str], str]:
    """Return what a printed log counts at which time, s: whole numbers, and lists of them.

    Parameters
    ----------
    text : str
        What a script printed.
    """
    return {
        (float(time), name): value
        for time, words in _EVENT.findall(text)
        for name, value in _COUNTS.findall(words)
    }


def real_runs(folder: Path) -> Iterator[RealRun]:
    """Yield the real runs that lie in a folder of repositories, in the order of their names.

    Parameters
    ----------
    folder : Path
        Holds one repository, or several.
    """
    for log in sorted(folder.rglob("logs/*.txt")):
        script = log.parents[1] / f"{log.stem}.py"
        if script.is_file():
            yield RealRun(script, log.read_text(encoding="utf-8", errors="replace"))
