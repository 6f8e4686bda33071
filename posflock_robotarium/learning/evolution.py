"""An evolution strategy: how to climb where there is no gradient, only a score.

A generation tries the present vector with noise added, and with the same noise taken away; what
scored better pulls the vector its way. Scores count by rank alone, so that no outlier pulls harder
(Salimans et al., *Evolution strategies as a scalable alternative to reinforcement learning*, 2017),
and steps are Adam's (Kingma and Ba, 2015). A few hundred numbers are found so within minutes, by
numpy alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posflock_robotarium.flocking.errors import ParameterError

__all__ = ["Evolution", "EvolutionSettings", "evolve"]

Floats = NDArray[np.float64]

#: From vectors (P, D) and the number of the generation to their scores (P,); the more the better.
Objective = Callable[[Floats, int], Floats]
#: Told after each generation how many are done, of how many, and the score of the vector.
Progress = Callable[[int, int, float], None]

_FIRST, _SECOND, _SMALL = 0.9, 0.99, 1e-8  # Adam's


@dataclass(frozen=True)
class EvolutionSettings:
    """How a vector is searched for.

    Attributes
    ----------
    generations : int
        How many.
    pairs : int
        Pairs of vectors that a generation tries.
    noise : float
        Standard deviation of what is added to each number.
    step : float
        How far a number moves in a generation at most, about.
    seed : int
        What the noise is drawn from.

    Raises
    ------
    ParameterError
        Where a number makes no sense.
    """

    generations: int = 100
    pairs: int = 16
    noise: float = 0.15
    step: float = 0.1
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("generations", "pairs"):
            if getattr(self, name) < 1:
                raise ParameterError(f"{name}: expected one at least, got {getattr(self, name)!r}")
        for name in ("noise", "step"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ParameterError(f"{name}: expected more than 0, got {getattr(self, name)!r}")


@dataclass(frozen=True, eq=False)
class Evolution:
    """What a search found, and how it went.

    Attributes
    ----------
    vector : (D,) array
        What was found.
    scores : (generations,) array
        Of the vector as it was at the start of each generation.
    spread : (generations, 2) array
        Lowest and highest score of what each generation tried.
    """

    vector: Floats
    scores: Floats
    spread: Floats


def evolve(
    objective: Objective,
    start: ArrayLike,
    settings: EvolutionSettings,
    progress: Progress = lambda done, total, score: None,
) -> Evolution:
    """Search for a vector of high score.

    Parameters
    ----------
    objective : callable
        From vectors (P, D) and the number of the generation to scores (P,).
    start : (D,) array
        Where the search begins.
    settings : EvolutionSettings
        How it goes.
    progress : callable, optional
        Told after each generation: how many are done, of how many, the vector's score.

    Raises
    ------
    ParameterError
        Where a score is not finite.

    Examples
    --------
    >>> found = evolve(lambda x, k: -(x**2).sum(axis=1), [1.0, -1.0], EvolutionSettings(80))
    >>> bool(np.abs(found.vector).max() < 0.1)
    True
    """
    rng = np.random.default_rng(settings.seed)
    vector = np.array(start, dtype=float)
    mean, square = np.zeros_like(vector), np.zeros_like(vector)
    scores, spread = [], []
    for generation in range(settings.generations):
        noise = rng.standard_normal((settings.pairs, vector.size))
        around = settings.noise * np.concatenate([noise, -noise, np.zeros((1, vector.size))])
        found = np.asarray(objective(vector + around, generation), dtype=float)
        if found.shape != (len(around),) or not np.isfinite(found).all():
            raise ParameterError(
                f"scores: expected {len(around)} finite numbers, got shape {found.shape}"
            )
        tried = found[:-1]
        worth = _ranks(tried)
        slope = (worth[: settings.pairs] - worth[settings.pairs :]) @ noise / settings.pairs
        mean = _FIRST * mean + (1.0 - _FIRST) * slope
        square = _SECOND * square + (1.0 - _SECOND) * slope**2
        first = mean / (1.0 - _FIRST ** (generation + 1))
        second = square / (1.0 - _SECOND ** (generation + 1))
        vector = vector + settings.step * first / (np.sqrt(second) + _SMALL)
        scores.append(found[-1])
        spread.append((tried.min(), tried.max()))
        progress(generation + 1, settings.generations, float(found[-1]))
    return Evolution(vector, np.array(scores), np.array(spread))


def _ranks(scores: Floats) -> Floats:
    """Return ranks of scores from -0.5 to 0.5; those that are equal but for rounding share one."""
    digits = np.round(scores, 9)
    order = np.sort(digits)
    first = np.searchsorted(order, digits, side="left")
    last = np.searchsorted(order, digits, side="right")
    ranks: Floats = (first + last - 1) / 2.0 / max(len(scores) - 1, 1) - 0.5
    return ranks
