"""Who is whose neighbour when robots rest near the radius: links with hysteresis.

The paper finds N_i anew at every step.  The rest distance δ·|N_i| then jumps by δ whenever a robot
crosses the radius, which pushes it back across: a pair that happens to rest near the radius
chatters, and the flock trembles instead of drifting.  A band wider than δ ends that.  Hysteresis on
links is the usual remedy where a neighbourhood switches (Ji and Egerstedt, *Distributed
coordination control of multiagent systems while preserving connectedness*, 2007).

Few starts of the nine robots end so, but those do badly.  γ from motion in 120 s of the ideal arena
(``benchmarks/certified_flock.py --flocks papers-neighbours``):

====================  =====  =====  =====
seed                  157    167    188
====================  =====  =====  =====
no band               0.045  0.948  0.922
a band of 0.15 m      0.999  1.000  1.000
====================  =====  =====  =====
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import neighbours

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


class NeighbourMemory:
    """Who is whose neighbour, remembering who was: who went out of range has to come well within.

    Parameters
    ----------
    radius : float or (N,) array
        r_i, metres.
    hysteresis : float
        How far within the radius a robot has to come to count again, metres; 0 is the paper's rule.

    Raises
    ------
    ParameterError
        Where the hysteresis is negative, or not less than the radius.
    """

    def __init__(self, radius: float | Floats, hysteresis: float) -> None:
        least = float(np.min(radius))
        if not (math.isfinite(hysteresis) and 0.0 <= hysteresis < least):
            raise ParameterError(
                f"neighbour_hysteresis: expected from 0 to less than the radius, {least:g} m;"
                f" got {hysteresis!r}"
            )
        self.radius = radius
        self.hysteresis = hysteresis
        self.reset()

    def reset(self) -> None:
        """Forget who was linked: at the next step the radius alone decides."""
        self._linked: Booleans | None = None

    @property
    def links(self) -> Booleans | None:
        """Who was whose neighbour at the last step, (N, N); None before the first."""
        return self._linked

    def within(self, radius: float | Floats) -> NeighbourMemory:
        """Return the same memory for another radius: who is linked stays so, as far as it reaches.

        Parameters
        ----------
        radius : float or (N,) array
            r_i, metres.

        Raises
        ------
        ParameterError
            Where the hysteresis is not less than the radius.
        """
        other = NeighbourMemory(radius, self.hysteresis)
        other._linked = self._linked
        return other

    def update(self, points: Floats) -> Booleans:
        """Return who is whose neighbour now, and remember it.

        Parameters
        ----------
        points : (2, N) array
            Positions, m.

        Returns
        -------
        (N, N) boolean array
            Row i marks N_i.
        """
        within = neighbours(points, self.radius)
        if self._linked is not None:
            within &= self._linked | neighbours(points, self.radius - self.hysteresis)
        self._linked = within
        return within
