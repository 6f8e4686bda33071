"""What a metric must keep to, in words: a small exact grammar, and the units that it knows.

>>> target = parse_target("formation_error < 5 cm for 95 % of the time after 20 s")
>>> target.metric, target.relation.value, target.share, target.after
('formation_error', '<', 0.95, 20.0)
>>> target.limit_in("m")
0.05

Nothing is guessed: what does not follow the grammar is refused with the place and the grammar, a
length is never held against a time, and a number without its unit is no length.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import Enum
from typing import NoReturn

from posflock_robotarium.flocking.errors import ParameterError

GRAMMAR = (
    "METRIC < VALUE UNIT [always | for P % of the time | on average | at the end] [after S s], "
    "with <, <=, > or >=, as in 'formation_error < 0.05 m for 95 % of the time'"
)

_TOKENS = re.compile(r"<=|>=|[<>≤≥=]|[^\s<>≤≥=]+")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

_UNITS: dict[str, tuple[str, float]] = {
    "m": ("m", 1.0),
    "cm": ("m", 0.01),
    "mm": ("m", 0.001),
    "s": ("s", 1.0),
    "ms": ("s", 0.001),
    "min": ("s", 60.0),
    "rad": ("rad", 1.0),
    "deg": ("rad", math.pi / 180),
    "°": ("rad", math.pi / 180),
    "m/s": ("m/s", 1.0),
    "cm/s": ("m/s", 0.01),
    "mm/s": ("m/s", 0.001),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", math.pi / 180),
    "°/s": ("rad/s", math.pi / 180),
    "share": ("share", 1.0),
    "%": ("share", 0.01),
}


class Relation(Enum):
    """On which side of its limit a metric must be."""

    BELOW = "<"
    AT_MOST = "<="
    ABOVE = ">"
    AT_LEAST = ">="


class When(Enum):
    """At which times a metric must keep to its limit."""

    UNSAID = "unsaid"
    """Always, of a metric over time; of one number a run, that number."""
    ALWAYS = "always"
    SHARE = "for a share of the time"
    AVERAGE = "on average"
    END = "at the end"


_RELATIONS = {relation.value: relation for relation in Relation}
_RELATIONS |= {"≤": Relation.AT_MOST, "≥": Relation.AT_LEAST}
_WORDS = {
    ("always",): When.ALWAYS,
    ("on", "average"): When.AVERAGE,
    ("at", "the", "end"): When.END,
}
#: Words after a value that are no units.
RESERVED = frozenset({"always", "for", "on", "at", "after"})


@dataclass(frozen=True)
class Target:
    """What one metric must keep to.

    Attributes
    ----------
    text : str
        As it was written, blanks made one.
    metric : str
        Key of a metric, or of a number.
    relation : Relation
        On which side of the limit it must be.
    value : float
        The limit, in `unit`.
    unit : str
        As it was written; empty for a pure number.
    when : When
        At which times.
    share : float
        Of the time, from 0 to 1; 1 where it must hold always.
    after : float
        Seconds of the run before which it need not hold.
    """

    text: str
    metric: str
    relation: Relation
    value: float
    unit: str
    when: When
    share: float
    after: float

    def limit_in(self, unit: str) -> float:
        """Return the limit in the unit of the metric.

        Parameters
        ----------
        unit : str
            Unit of the metric; empty for a pure number.

        Raises
        ------
        ParameterError
            When the target's unit is of another kind, or missing.
        """
        if self.unit == unit:
            return self.value
        kind, size = _UNITS.get(unit, (None, 1.0))
        mine, factor = _UNITS.get(self.unit, ("", 1.0))
        if kind is not None and kind == mine:
            # Divided where that is exact: 5 cm are 0.05 m to the last bit.
            scale = size / factor
            return self.value / scale if scale >= 1.0 else self.value * factor / size
        known = [name for name, (other, _) in _UNITS.items() if kind is not None and other == kind]
        wanted = " or ".join(known or ([unit] if unit else []))
        got = f"{self.value:g} {self.unit}".strip()
        expected = f"is in {unit}; write a value in {wanted}" if unit else "is a pure number"
        raise ParameterError(f"target {self.text!r}: got {got}, but {self.metric} {expected}")


def parse_target(text: str) -> Target:
    """Read a target.

    Parameters
    ----------
    text : str
        In the words of `GRAMMAR`.

    Raises
    ------
    ParameterError
        When it does not follow the grammar.
    """
    reader = _Reader(text)
    metric = reader.word("a metric's name")
    if not re.fullmatch(r"[^\W\d]\w*", metric):
        reader.fail("a metric's name", metric)
    sign = reader.word("<, <=, > or >=")
    if sign not in _RELATIONS:
        reader.fail("<, <=, > or >=", sign)
    value = reader.number("a number such as 0.05")
    unit = "" if reader.next in RESERVED else reader.word(None)
    when, share = reader.when()
    after = reader.after()
    if reader.next is not None:
        expected = "the end of the target" if when is not When.UNSAID or after else "when it holds"
        reader.fail(expected, reader.next)
    return Target(reader.text, metric, _RELATIONS[sign], value, unit, when, share, after)


class _Reader:
    """The tokens of a target from left to right."""

    def __init__(self, text: str) -> None:
        self.text = " ".join(text.split())
        self._rest = _TOKENS.findall(text.replace("−", "-"))
        self._read: list[str] = []

    @property
    def next(self) -> str | None:
        """What comes next; None at the end."""
        return self._rest[0] if self._rest else None

    def fail(self, expected: str, got: str | None) -> NoReturn:
        """Refuse what was got in the place of what was expected."""
        if self._read and self._read[-1] == got:
            self._read.pop()
        after = f" after {' '.join(self._read)!r}" if self._read else ""
        found = "nothing" if got is None else repr(got)
        raise ParameterError(
            f"target {self.text!r}: expected {expected}{after}, got {found}. A target is {GRAMMAR}"
        )

    def word(self, expected: str | None) -> str:
        """Take the next token; where nothing need be there, an empty word."""
        if not self._rest:
            if expected is None:
                return ""
            self.fail(expected, None)
        self._read.append(self._rest.pop(0))
        return self._read[-1]

    def number(self, expected: str) -> float:
        """Take a number; what is written against it is left for the next."""
        token = self.word(expected)
        found = _NUMBER.match(token)
        glued = token[found.end() :] if found else ""
        if found is None or glued[:1] in (",", ".", "_") or not math.isfinite(float(found[0])):
            self.fail(expected, token)
        if glued:
            self._read[-1] = found[0]
            self._rest.insert(0, glued)
        return float(found[0])

    def words(self, *expected: str) -> None:
        """Take exactly these words."""
        for word in expected:
            got = self.word(repr(word))
            if got != word:
                self.fail(repr(word), got)

    def when(self) -> tuple[When, float]:
        """Take the times at which it must hold, and their share."""
        for words, when in _WORDS.items():
            if self.next == words[0]:
                self.words(*words)
                return when, 1.0
        if self.next != "for":
            return When.UNSAID, 1.0
        self.words("for")
        percent = self.number("a percentage such as 95 %")
        self.words("%", "of", "the", "time")
        if not 0.0 < percent <= 100.0:
            self.fail("a percentage above 0 and up to 100", f"{percent:g} %")
        return When.SHARE, percent / 100.0

    def after(self) -> float:
        """Take the seconds that do not count; 0 where none are named."""
        if self.next != "after":
            return 0.0
        self.words("after")
        seconds = self.number("seconds such as 20 s")
        self.words("s")
        if seconds < 0.0:
            self.fail("seconds from 0 on", f"{seconds:g} s")
        return seconds
