"""How a study draws the values of a parameter, anew for every run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from barrier_certificates.word_enum import WordEnum
from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.sweep.experiments import Value


class StudyError(PosflockError):
    """A study file asks for something that cannot be run."""


class ParameterSpread(WordEnum):
    """How the values of a parameter are spread; what a study file calls it."""

    #: From low to high.
    UNIFORM = "uniform"
    #: The same in the logarithm.
    LOGUNIFORM = "loguniform"
    #: With mean and standard deviation.
    NORMAL = "normal"
    #: A whole number from low to high, both among them.
    INTEGERS = "integers"
    #: Any of a list.
    CHOICE = "choice"


@dataclass(frozen=True)
class ParameterDistribution:
    """How a parameter is drawn.

    Attributes
    ----------
    kind : ParameterSpread
        How its values are spread.
    arguments : tuple
        Two numbers, or the list to choose from.

    Raises
    ------
    StudyError
        Where the arguments make no sense.
    """

    kind: ParameterSpread
    arguments: tuple[Value, ...]

    def __post_init__(self) -> None:
        if self.kind is ParameterSpread.CHOICE:
            if not self.arguments:
                raise StudyError("choice: expected a list of at least one value, got none")
            return
        numbers = [a for a in self.arguments if isinstance(a, (int, float))]
        if len(numbers) != 2 or len(self.arguments) != 2:
            raise StudyError(f"{self.kind}: expected two numbers, got {list(self.arguments)}")
        first, second = numbers
        if self.kind is ParameterSpread.INTEGERS and not all(type(n) is int for n in numbers):
            raise StudyError(f"integers: expected two whole numbers, got {list(self.arguments)}")
        if self.kind is ParameterSpread.NORMAL and second < 0.0:
            raise StudyError(f"normal: expected a deviation of zero or more, got {second}")
        if self.kind is not ParameterSpread.NORMAL and not first <= second:
            raise StudyError(f"{self.kind}: expected low ≤ high, got {first} and {second}")
        if self.kind is ParameterSpread.LOGUNIFORM and first <= 0.0:
            raise StudyError(f"loguniform: expected numbers above zero, got {first}")

    def as_dict(self) -> dict[str, list[Value]]:
        """Return the distribution as a study file writes it."""
        return {self.kind.value: list(self.arguments)}

    def examples(self) -> tuple[Value, ...]:
        """Return values of every type that may be drawn, with the least and the greatest."""
        if self.kind in (ParameterSpread.CHOICE, ParameterSpread.INTEGERS):
            return self.arguments
        mean_or_bounds = (
            self.arguments[:1] if self.kind is ParameterSpread.NORMAL else self.arguments
        )
        return (0.5, *map(float, mean_or_bounds))

    def draw(self, generator: np.random.Generator) -> Value:
        """Draw one value.

        Parameters
        ----------
        generator : Generator
            Where it is drawn from.
        """
        return _DRAWS[self.kind](generator, self.arguments)


_DRAWS: dict[ParameterSpread, Callable[[np.random.Generator, Any], Value]] = {
    ParameterSpread.UNIFORM: lambda generator, a: float(generator.uniform(a[0], a[1])),
    ParameterSpread.LOGUNIFORM: lambda generator, a: float(
        np.exp(generator.uniform(np.log(a[0]), np.log(a[1])))
    ),
    ParameterSpread.NORMAL: lambda generator, a: float(generator.normal(a[0], a[1])),
    ParameterSpread.INTEGERS: lambda generator, a: int(
        generator.integers(a[0], a[1], endpoint=True)
    ),
    ParameterSpread.CHOICE: lambda generator, a: a[int(generator.integers(len(a)))],
}


def read_distribution(name: str, said: Any) -> ParameterDistribution:
    """Return the distribution that a study file writes.

    Parameters
    ----------
    name : str
        The parameter, for the error.
    said : dict
        What stands there, as ``{"uniform": [0.0, 1.0]}``.

    Raises
    ------
    StudyError
        Where it is no distribution, or none that there is.
    """
    if not isinstance(said, dict) or len(said) != 1:
        raise StudyError(
            f"distributions.{name}: expected one distribution such as"
            f" {{ uniform = [0.0, 1.0] }}, got {said!r}"
        )
    ((kind, arguments),) = said.items()
    if kind not in list(ParameterSpread):
        raise StudyError(
            f"distributions.{name}: expected one of {', '.join(ParameterSpread)}; got {kind!r}"
        )
    if not isinstance(arguments, list):
        raise StudyError(f"distributions.{name}: expected a list for {kind}, got {arguments!r}")
    return ParameterDistribution(ParameterSpread(kind), tuple(arguments))
