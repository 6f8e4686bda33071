"""Times that are written as dates or times of day, in seconds."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import LogError

_DATE = re.compile(
    r"(?P<date>\d{4}-\d{2}-\d{2})[T ](?P<clock>\d{2}:\d{2}(?::\d{2}(?:[.,]\d{1,9})?)?)"
    r"(?P<zone>Z|[+-]\d{2}:?\d{2})?"
)
_DAY_FIRST = re.compile(r"\d{1,2}([./-])\d{1,2}\1\d{4},?[T ]")
"""Or month first: which of them does not matter to a run that ends within a day."""
_CLOCK = re.compile(
    r"(?:(?P<hours>\d{1,2}):)?(?P<minutes>\d{1,2}):(?P<seconds>\d{1,2}(?:[.,]\d+)?)"
    r"(?: ?(?P<half>[AP])\.?M\.?)?",
    re.IGNORECASE,
)
_DAY = 86400.0


def seconds_of(words: tuple[str, ...], where: str) -> NDArray[np.float64]:
    """Return times in seconds: of dates since 1970, of times of day since midnight.

    Parameters
    ----------
    words : tuple of str
        ``2026-06-11T14:03:00.033``, with a blank for the T and a zone or not, ``14:03:00.033``,
        also with AM or PM, or behind a day such as ``11.06.2026`` or ``06/11/2026``, of which only
        the time of day is taken. Midnight may pass once between two times of day.
    where : str
        File name for messages.

    Returns
    -------
    (T,) array
        s. The zone is left out, since only differences count.

    Raises
    ------
    LogError
        With the first that is neither.
    """
    seconds = np.empty(len(words))
    for row, word in enumerate(words):
        if date := _DATE.fullmatch(word.strip()):
            moment = np.datetime64(f"{date['date']}T{date['clock'].replace(',', '.')}", "ns")
            seconds[row] = moment.astype(np.int64) * 1e-9
        elif clock := _CLOCK.fullmatch(_DAY_FIRST.sub("", word.strip(), count=1)):
            hours = int(clock["hours"] or 0)
            if clock["half"]:
                hours = hours % 12 + (12 if clock["half"] in "pP" else 0)
            whole = 60 * hours + int(clock["minutes"])
            seconds[row] = 60 * whole + float(clock["seconds"].replace(",", "."))
        else:
            raise LogError(
                f"{where}: row {row}: time is {word[:40]!r}; expected seconds, a date such as "
                "2026-06-11T14:03:00.033, or a time of day such as 14:03:00.033"
            )
    passed = np.diff(seconds) < -_DAY / 2
    seconds[1:] += _DAY * np.cumsum(passed)
    return seconds
