"""Timed lines that a script prints: which event a line tells, and when it was.

``[t= 50.3s] marshal at gate 2`` is the event "marshal at gate" at 50.3 s: what is left of a line
when its time and all numbers are taken out names the event, so that the same line of another run is
found whatever was measured in it.  A line that comes several times is as many events, in order.
"""

from __future__ import annotations

import re
from collections import Counter

#: How scripts write the time of a line; the first that fits counts.
_TIMES = (
    re.compile(r"\bt(?:ime)?\s*[=:]\s*(\d+(?:\.\d+)?)\s*(?:s(?:ec(?:onds?)?)?\b)?", re.IGNORECASE),
    re.compile(r"^\W*(\d+(?:\.\d+)?)\s*s(?:ec(?:onds?)?)?\b", re.IGNORECASE),
    re.compile(r"\b(?:at|after)\s+(\d+(?:\.\d+)?)\s*s(?:ec(?:onds?)?)?\b", re.IGNORECASE),
)
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")

#: What an event is called, and which of its kind it is, from 0.
EventKey = tuple[str, int]


def events_in(text: str) -> dict[EventKey, float]:
    """Return the events of all lines that have a time, and their times in seconds.

    Parameters
    ----------
    text : str
        What a script printed, or a log of it.
    """
    seen: Counter[str] = Counter()
    events: dict[EventKey, float] = {}
    for line in text.splitlines():
        found = next((match for match in (t.search(line) for t in _TIMES) if match), None)
        if found is None:
            continue
        rest = line[: found.start()] + " " + line[found.end() :]
        name = " ".join(_NUMBER.sub(" ", rest).split()).strip("[]() ")
        events[name, seen[name]] = float(found[1])
        seen[name] += 1
    return events
