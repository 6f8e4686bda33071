"""Where the robots start: random poses in a square, kept apart."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError

#: Squares begun afresh before giving up; nine robots at 0.30 m in 1 m need about three.
_ATTEMPTS = 2000
#: Throws for one robot before its square is begun afresh.
_THROWS = 200


def random_poses(
    robots: int,
    rng: np.random.Generator,
    *,
    side: float = 1.0,
    spacing: float = 0.30,
    centre: tuple[float, float] = (0.0, 0.0),
) -> NDArray[np.float64]:
    """Return random positions and headings in a square, every pair at least `spacing` apart.

    Parameters
    ----------
    robots : int
        N, at least 2.
    rng : numpy.random.Generator
        The run's source of chance; the same seed gives the same poses.
    side, spacing : float
        Metres.
    centre : (2,) tuple
        Of the square, metres.

    Returns
    -------
    (3, N) array
        x, y uniform over what the spacing leaves, θ uniform in [-π, π).

    Raises
    ------
    ParameterError
        Where an argument is not admissible, or so many robots do not fit.

    Examples
    --------
    >>> random_poses(9, np.random.default_rng(0)).shape
    (3, 9)
    """
    if not isinstance(robots, (int, np.integer)) or robots < 2:
        raise ParameterError(f"robots: expected a whole number from 2, got {robots!r}")
    for name, value in (("side", side), ("spacing", spacing)):
        if not (math.isfinite(value) and value > 0.0):
            raise ParameterError(f"{name}: expected more than 0 m, got {value!r}")
    # Discs of diameter `spacing` cover at most 0.9069 of the square grown by their radius.
    most = int(0.9069 * (side + spacing) ** 2 / (math.pi * spacing**2 / 4.0))
    if robots <= most:
        for _ in range(_ATTEMPTS):
            positions = _throw(robots, rng, side, spacing)
            if positions is not None:
                headings = rng.uniform(-math.pi, math.pi, robots)
                return np.vstack([positions + np.reshape(centre, (2, 1)), headings])
    why = f"at most {most} could" if robots > most else "random placement found no way"
    raise ParameterError(
        f"robots: {robots} do not fit in a square of {side:g} m at a spacing of {spacing:g} m"
        f" ({why}); ask for fewer robots, a smaller spacing or a larger side"
    )


def _throw(
    robots: int, rng: np.random.Generator, side: float, spacing: float
) -> NDArray[np.float64] | None:
    """Place robots one by one; None where one finds no room."""
    placed = np.empty((2, robots))
    for k in range(robots):
        candidates = rng.uniform(-side / 2.0, side / 2.0, (_THROWS, 2))
        apart = candidates[:, :, None] - placed[:, :k]
        free = (np.square(apart).sum(axis=1) >= spacing**2).all(axis=1)
        if not free.any():
            return None
        placed[:, k] = candidates[free.argmax()]
    return placed
