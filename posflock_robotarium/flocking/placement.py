"""Where the robots start: random poses in a square, apart enough for the certificate to hold.

A certificate keeps safe a team that starts safe, and what it keeps apart are not the robots'
centres but their *look-ahead points* (the Robotarium's projection points), 5 cm ahead of them:
robots that face each other at 0.30 m have theirs at 0.20 m.  Nor do robots start exactly where
they are asked to.  The testbed brings them within 5 cm and 0.2 rad, which moves a look-ahead point
by 6 cm at most.  So starts are drawn with centres *and* look-ahead points apart, the latter by the
certificate's radius and twice those 6 cm.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]

#: Squares begun afresh before giving up; nine robots as by default in 1 m need two.
_ATTEMPTS = 300
#: Squares begun only to say how many robots would have fitted.
_TRIALS = 50
#: Throws for one robot before its square is begun afresh.
_THROWS = 200


def random_poses(
    robots: int,
    rng: np.random.Generator,
    *,
    side: float = 1.0,
    spacing: float = 0.30,
    centre: tuple[float, float] = (0.0, 0.0),
    look_ahead: float = 0.05,
    look_ahead_spacing: float = 0.32,
    within: tuple[float, float, float, float] | None = None,
) -> Floats:
    """Return random positions and headings in a square, every pair apart twice over.

    Parameters
    ----------
    robots : int
        N, at least 2.
    rng : numpy.random.Generator
        The run's source of chance; the same seed gives the same poses.
    side : float
        Of the square that the robots' centres lie in, metres.
    spacing : float
        Least distance between two centres, metres.
    centre : (2,) tuple
        Of the square, metres.
    look_ahead : float
        How far ahead of its centre a robot's look-ahead point lies, metres.
    look_ahead_spacing : float
        Least distance between two look-ahead points, metres.  The default leaves the 0.20 m of the
        flock's certificate after the testbed has missed both poses by as much as it may.
    within : (4,) tuple, optional
        Least x, greatest x, least y, greatest y of look-ahead points, metres.

    Returns
    -------
    (3, N) array
        x, y, θ uniform over what the distances leave.

    Raises
    ------
    ParameterError
        Where an argument is not admissible, or so many robots do not fit; it says how many did.

    Examples
    --------
    >>> random_poses(9, np.random.default_rng(0)).shape
    (3, 9)
    """
    if not isinstance(robots, (int, np.integer)) or robots < 2:
        raise ParameterError(f"robots: expected a whole number from 2, got {robots!r}")
    for name, value in (
        ("side", side),
        ("spacing", spacing),
        ("look_ahead_spacing", look_ahead_spacing),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise ParameterError(f"{name}: expected more than 0 m, got {value!r}")
    if not (math.isfinite(look_ahead) and look_ahead >= 0.0):
        raise ParameterError(f"look_ahead: expected 0 m or more, got {look_ahead!r}")
    most = min(_most(side, spacing), _most(side + 2.0 * look_ahead, look_ahead_spacing))
    square = _Square(side, spacing, centre, look_ahead, look_ahead_spacing, within)
    fitted = 0
    for _ in range(_ATTEMPTS if robots <= most else _TRIALS):
        poses = square.throw(robots, rng)
        if poses.shape[1] == robots:
            return poses
        fitted = max(fitted, poses.shape[1])
    raise ParameterError(
        f"robots: {robots} do not fit in a square of {side:g} m with centres {spacing:g} m and"
        f" look-ahead points {look_ahead_spacing:g} m apart"
        + ("" if within is None else f", these within {within}")
        + f" (random placement found room for {fitted}, and no way for more than {most} exists);"
        " ask for fewer robots, smaller distances or a larger side"
    )


def _most(side: float, spacing: float) -> int:
    """Return how many points in a square can be so far apart at most."""
    # Discs of diameter `spacing` cover at most 0.9069 of the square grown by their radius.
    return int(0.9069 * (side + spacing) ** 2 / (math.pi * spacing**2 / 4.0))


class _Square:
    """Poses one by one, each from the first of many throws that keeps all distances."""

    def __init__(
        self,
        side: float,
        spacing: float,
        centre: tuple[float, float],
        look_ahead: float,
        look_ahead_spacing: float,
        within: tuple[float, float, float, float] | None,
    ) -> None:
        self.side, self.centre, self.look_ahead = side, np.array(centre, dtype=float), look_ahead
        self.nearest = np.square([spacing, look_ahead_spacing])
        left, right, bottom, top = within or (-math.inf, math.inf, -math.inf, math.inf)
        self.lowest, self.highest = np.array([left, bottom]), np.array([right, top])

    def throw(self, robots: int, rng: np.random.Generator) -> Floats:
        """Place robots until one finds no room; return the poses (3, up to N) found."""
        placed = np.empty((robots, 2, 2))  # robot; centre or look-ahead point; x, y
        headings = np.empty(robots)
        for k in range(robots):
            thrown = np.empty((_THROWS, 2, 2))
            half = self.side / 2.0
            thrown[:, 0] = self.centre + rng.uniform(-half, half, (_THROWS, 2))
            heading = rng.uniform(-math.pi, math.pi, _THROWS)
            ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
            thrown[:, 1] = thrown[:, 0] + self.look_ahead * ahead
            apart = np.square(thrown[:, None] - placed[:k]).sum(axis=3)
            free = (apart >= self.nearest).all(axis=(1, 2))
            points = thrown[:, 1]
            free &= ((points >= self.lowest) & (points <= self.highest)).all(axis=1)
            if not free.any():
                return np.vstack([placed[:k, 0].T, headings[:k]])
            chosen = int(free.argmax())
            placed[k], headings[k] = thrown[chosen], heading[chosen]
        return np.vstack([placed[:, 0].T, headings])
