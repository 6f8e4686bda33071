"""A metric from a file of the user's: one function of the run, and what the report makes of it.

The function gets a `MeasuredRun` (``run.t``, ``run.positions``, ``run.velocities(…)`` and so on)
and returns one number, or one value a sample. What it is called, means and is measured in stands
beside it, by `metric` or as plain attributes of the function:

>>> @metric(unit="m", description="Largest distance of a robot from the arena's centre.")
... def reach(run):
...     return np.hypot(run.positions[:, 0], run.positions[:, 1]).max(axis=1)
>>> reach.unit, reach.description
('m', "Largest distance of a robot from the arena's centre.")

Nothing that a function returns is believed before it is looked at, and what it raises is told by
file and line. It runs in the reporter's own process, with the rights of whoever reports.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast

import numpy as np

from posflock_robotarium.alignment.answers import checked_answer
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import (
    OWN_GROUP,
    REDUCTIONS,
    Metric,
    Number,
    NumberFunction,
    Reduction,
    Scalar,
    forget,
    register,
)
from posflock_robotarium.alignment.panels import Panel
from posflock_robotarium.alignment.reductions import largest, smallest
from posflock_robotarium.alignment.targets import RESERVED
from posflock_robotarium.alignment.users_code import (
    MetricError,
    imported,
    said_by,
    where_defined,
)
from posflock_robotarium.flocking.errors import ParameterError

_Function = TypeVar("_Function", bound=Callable[..., Any])


def metric(
    *,
    unit: str = "",
    description: str = "",
    label: str = "",
    of_interest: Reduction = "mean",
    may_be_undefined: bool = False,
) -> Callable[[_Function], _Function]:
    """Return a decorator that says what a function of a run measures; it sets plain attributes.

    Parameters
    ----------
    unit : str
        Of what it returns, one word such as m or m/s; empty for a pure number.
    description : str
        What it measures, a sentence; by default the first line of the function's docstring.
    label : str
        What tables and plots call it; by default its name.
    of_interest : {'mean', 'smallest', 'largest'}
        What a coarser drawing keeps of a block of samples.
    may_be_undefined : bool
        Whether NaN means that it is undefined at that time, and is no mistake.
    """
    said = {
        "unit": unit,
        "description": description,
        "label": label,
        "of_interest": of_interest,
        "may_be_undefined": may_be_undefined,
    }

    def describe(function: _Function) -> _Function:
        for name, value in said.items():
            setattr(function, name, value)
        return function

    return describe


@dataclass(frozen=True)
class _Own:
    """One function from a file, and what is said of it."""

    where: str
    name: str
    function: Callable[[MeasuredRun], Any]
    label: str
    unit: str
    description: str
    of_interest: Reduction
    may_be_undefined: bool

    def answer(self, run: MeasuredRun) -> float | Floats:
        """Return what the function says of a run, looked at."""
        with said_by(self.function, self.name, self.where):
            answer = self.function(_guarded(run))
        try:
            return checked_answer(answer, run.recording, undefined=self.may_be_undefined)
        except ParameterError as error:
            line = where_defined(self.function, self.where)
            raise MetricError(f"{line}: {self.name} {error} (run {run.recording.name})") from error


class _OwnNumber(Scalar):
    """A number of a function that may return a curve: its definition says what was taken."""

    def of(self, run: MeasuredRun) -> Number | None:
        number = super().of(run)
        if number is None or run.curve(self.key) is None:
            return number
        return replace(number, definition=f"{number.definition} Mean {run.since}.")


@contextlib.contextmanager
def own_metrics(asked: Sequence[str]) -> Iterator[tuple[Metric | Scalar, ...]]:
    """Let the report know metrics of the user's within the ``with`` block.

    Parameters
    ----------
    asked : sequence of str
        Each as ``FILE.py:NAME``: a function of the run, or a `Metric` or `Scalar`.

    Yields
    ------
    tuple of Metric or Scalar
        The entries, in that order.

    Raises
    ------
    MetricError
        When there is no such file or function, importing the file fails, or what it says of the
        function makes no sense.
    ParameterError
        When a metric of that name is known already.
    """
    modules: dict[Path, ModuleType] = {}
    entries: list[Metric | Scalar] = []
    try:
        for one in dict.fromkeys(asked):
            entry = _entry(one, modules)
            try:
                register(entry)
            except ParameterError as error:
                raise MetricError(f"--metric {one}: {error}, by naming the function so") from error
            entries.append(entry)
        yield tuple(entries)
    finally:
        forget(*entries)


def _entry(asked: str, modules: dict[Path, ModuleType]) -> Metric | Scalar:
    file, _, name = asked.rpartition(":")
    if not file.endswith(".py") or not name.isidentifier():
        raise MetricError(f"--metric {asked}: expected FILE.py:FUNCTION, as my_metrics.py:error")
    path = Path(file)
    if path not in modules:
        modules[path] = imported(path)
    found = getattr(modules[path], name, None)
    if isinstance(found, (Metric, Scalar)):
        return _held(found, name, file)
    if found is None or not callable(found) or isinstance(found, type):
        functions = [
            key
            for key, value in vars(modules[path]).items()
            if getattr(value, "__module__", None) == modules[path].__name__ and callable(value)
        ]
        known = ", ".join(functions) or "none"
        raise MetricError(f"{file}: no function {name!r} in it; its functions: {known}")
    return _metric_of(_described(found, name, file))


def _described(function: Callable[[MeasuredRun], Any], name: str, file: str) -> _Own:
    """Read what a function says of itself, and refuse what makes no sense."""

    def said(what: str, default: Any) -> Any:
        value = getattr(function, what, None)
        value = default if value is None or value == "" else value
        if type(value) is not type(default):
            refuse(what, value, f"expected {type(default).__name__}")
        return value

    def refuse(what: str, value: Any, expected: str) -> None:
        line = where_defined(function, file)
        raise MetricError(f"{line}: {name}: {what} is {value!r}; {expected}")

    own = _Own(
        where=file,
        name=name,
        function=function,
        label=said("label", name.replace("_", " ")),
        unit=said("unit", ""),
        description=said("description", _first_line(function) or f"{name} of {Path(file).name}."),
        of_interest=cast("Reduction", said("of_interest", "mean")),
        may_be_undefined=said("may_be_undefined", False),
    )
    if own.unit in RESERVED or not re.fullmatch(r"[^\s<>=≤≥]{0,20}", own.unit):
        refuse("unit", own.unit, "expected one word, as m or m/s, and nothing of a pure number")
    if own.of_interest not in REDUCTIONS:
        refuse("of_interest", own.of_interest, f"expected one of {', '.join(REDUCTIONS)}")
    return own


def _first_line(function: Callable[[MeasuredRun], Any]) -> str:
    return (function.__doc__ or "").strip().partition("\n")[0]


def _metric_of(own: _Own) -> Metric:
    """Return the entry of a function, whether it turns out to give a curve or a number."""

    def curve(run: MeasuredRun) -> Floats | None:
        answer = run.once(own.answer)
        return answer if isinstance(answer, np.ndarray) else None

    def number(run: MeasuredRun) -> float:
        answer = run.once(own.answer)
        return run.settled_mean(answer) if isinstance(answer, np.ndarray) else answer

    label, words = (text.replace("{", "{{").replace("}", "}}") for text in _words(own))

    def end(word: str, value: NumberFunction) -> Scalar:
        return Scalar(
            f"{own.name}_{word}", f"{label}, {word}", own.unit, "Whole run.", OWN_GROUP, value
        )

    numbers = (
        _OwnNumber(own.name, label, own.unit, words, OWN_GROUP, number, True, own.label),
        end("smallest", smallest(own.name)),
        end("largest", largest(own.name)),
    )
    return Metric(
        own.name,
        own.label,
        own.unit,
        own.description,
        curve,
        own.of_interest,
        panel=Panel(f"own_{own.name}", own.label[:1].upper() + own.label[1:], own.unit, leads=True),
        figure=own.name,
        beside_replay=True,
        numbers=numbers,
    )


def _words(own: _Own) -> tuple[str, str]:
    ended = own.description if own.description.endswith((".", "!", "?")) else f"{own.description}."
    return own.label, ended


def _held(entry: Metric | Scalar, name: str, file: str) -> Metric | Scalar:
    """Return an entry of the registry whose functions fail by file and line."""

    def held(function: Callable[[MeasuredRun], Any]) -> Callable[[MeasuredRun], Any]:
        def call(run: MeasuredRun) -> Any:
            with said_by(function, name, file):
                return function(run)

        return call

    if isinstance(entry, Scalar):
        return replace(entry, value=held(entry.value))
    numbers = tuple(replace(scalar, value=held(scalar.value)) for scalar in entry.numbers)
    return replace(entry, curve=held(entry.curve), numbers=numbers)


def _guarded(run: MeasuredRun) -> MeasuredRun:
    """Return the same run, whose recording nobody can change by mistake."""
    known = run.recording
    return replace(run, recording=replace(known, t=run.t, poses=run.poses, commands=run.commands))
