"""What a page may ask of the running simulation.

A request comes as one JSON object, ``{"do": "speed", "factor": 2.0}``. The server and the script's
process both read it here. Whatever is not exactly one of these requests is refused.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, ClassVar

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.watch.tuning import RANGES

#: How many times as fast as real time a page may ask for; None is as fast as it computes.
SPEEDS: tuple[float | None, ...] = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, None)
#: Characters that a request may have.
LONGEST = 1000
#: Steps that one request may ask for.
MOST_STEPS = 1000


class RequestError(ParameterError):
    """A page asked for something that does not exist."""


@dataclass(frozen=True)
class PageRequest:
    """What all requests have in common."""

    do: ClassVar[str] = ""

    def text(self) -> str:
        """Return the request as one line of JSON."""
        return json.dumps({"do": self.do, **asdict(self)})


@dataclass(frozen=True)
class Pause(PageRequest):
    """Hold the simulation in its step."""

    do = "pause"


@dataclass(frozen=True)
class Go(PageRequest):
    """Go on."""

    do = "go"


@dataclass(frozen=True)
class Step(PageRequest):
    """Drive so many steps, and hold the simulation again.

    Attributes
    ----------
    steps : int
        How many, at least 1.

    Raises
    ------
    RequestError
        Where that is no such number.
    """

    do = "step"
    steps: int = 1

    def __post_init__(self) -> None:
        if type(self.steps) is not int or not 1 <= self.steps <= MOST_STEPS:
            raise RequestError(
                f"steps: expected a whole number from 1 to {MOST_STEPS}, got {self.steps!r}"
            )


@dataclass(frozen=True)
class Speed(PageRequest):
    """Run so many times as fast as real time.

    Attributes
    ----------
    factor : float or None
        One of `SPEEDS`; None is as fast as it computes.

    Raises
    ------
    RequestError
        Where there is no such speed.
    """

    do = "speed"
    factor: float | None = 1.0

    def __post_init__(self) -> None:
        if isinstance(self.factor, bool) or self.factor not in SPEEDS:
            known = ", ".join("null" if speed is None else f"{speed:g}" for speed in SPEEDS)
            raise RequestError(f"factor: expected one of {known}, got {self.factor!r}")


@dataclass(frozen=True)
class UseProfile(PageRequest):
    """Let the robots be as imperfect as this profile says, from the next step on.

    Attributes
    ----------
    name : str
        Of the profile.

    Raises
    ------
    RequestError
        Where that is no name.
    """

    do = "profile"
    name: str

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise RequestError(f"name: expected a profile's name, got {self.name!r}")


@dataclass(frozen=True)
class Retune(PageRequest):
    """Let the flock follow another law from its next step on; what is None stays as it is.

    Attributes
    ----------
    distance_scale, persistence, radius : float, optional
        δ in metres, k in 1/s, r in metres, within `tuning.RANGES`.
    model : Model, optional
        Which of the paper's models.

    Raises
    ------
    RequestError
        Where a value is out of its range, or there is no such model.
    """

    do = "law"
    distance_scale: float | None = None
    persistence: float | None = None
    radius: float | None = None
    model: Model | None = None

    def __post_init__(self) -> None:
        for name, span in RANGES.items():
            value = getattr(self, name)
            if value is None:
                continue
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if not (number and math.isfinite(value) and span.least <= value <= span.most):
                raise RequestError(
                    f"{name}: expected a number from {span.least:g} to {span.most:g} {span.unit},"
                    f" got {value!r}"
                )
            object.__setattr__(self, name, float(value))
        if self.model is not None:
            try:
                object.__setattr__(self, "model", Model(self.model))
            except ValueError:
                names = ", ".join(model.value for model in Model)
                raise RequestError(f"model: expected one of {names}; got {self.model!r}") from None

    def over(self, before: Retune) -> Retune:
        """Return what both ask, this one having the last word.

        Parameters
        ----------
        before : Retune
            What was asked earlier.
        """
        asked = {name: value for name, value in vars(self).items() if value is not None}
        return Retune(**{**vars(before), **asked})


@dataclass(frozen=True)
class Again(PageRequest):
    """End the run, and start the script again from its beginning, as things are set now."""

    do = "again"


@dataclass(frozen=True)
class Stop(PageRequest):
    """Interrupt the script as Ctrl-C does."""

    do = "stop"


_KINDS: dict[str, type[PageRequest]] = {
    kind.do: kind for kind in (Pause, Go, Step, Speed, UseProfile, Retune, Again, Stop)
}


def read_request(text: str) -> PageRequest:
    """Return the request that a line of JSON is.

    Parameters
    ----------
    text : str
        One JSON object.

    Raises
    ------
    RequestError
        It is none, or one with a name or a value that no request has.
    """
    if len(text) > LONGEST:
        raise RequestError(f"a request of {len(text)} characters; expected at most {LONGEST}")
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        raise RequestError(f"expected a request as JSON, got {text[:80]!r}") from None
    if not isinstance(data, Mapping):
        raise RequestError(f"expected a JSON object, got {text[:80]!r}")
    return _request(dict(data))


def _request(data: dict[str, Any]) -> PageRequest:
    do = data.pop("do", None)
    kind = _KINDS.get(do) if isinstance(do, str) else None
    if kind is None:
        raise RequestError(f"do: expected one of {', '.join(_KINDS)}; got {do!r}")
    known = {field.name for field in fields(kind)}
    for name in data:
        if name not in known:
            expected = f"expected {', '.join(sorted(known))}" if known else "it takes nothing"
            raise RequestError(f"{do}: does not know {name!r}; {expected}")
    try:
        return kind(**data)
    except TypeError as error:
        raise RequestError(f"{do}: {error}") from None
