"""What agents ask for: the inputs of the law, from what they sense.

One flock in a batch knows nothing of another. Small flocks take all pairs in arrays, large ones a
list of the pairs in reach; both compute the same.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.law import (
    LawParameters,
    check_states,
    displacements,
    position_based_input,
    velocity_based_input,
)
from posflock_robotarium.freespace.neighbour_search import (
    neighbour_pairs,
    position_based_input_over,
    velocity_based_input_over,
)
from posflock_robotarium.freespace.sensing import Sensed, Sensors

Floats = NDArray[np.float64]
#: An input of one's own, (B, d, n) in m/s², before saturation.
OwnLaw = Callable[[Sensed, LawParameters], Floats]


class Input(Protocol):
    """What the agents of a batch of flocks ask for at any time."""

    @abstractmethod
    def __call__(self, positions: Floats, velocities: Floats, time: float) -> Floats:
        """Return the inputs of a batch of flocks, before saturation.

        Parameters
        ----------
        positions, velocities : (B, d, n) array
            True states, m and m/s.
        time : float
            Time since the start, s.

        Returns
        -------
        (B, d, n) array
            Inputs, m/s².
        """


class OwnInput(Input):
    """A user's input, which must be finite and have the shape of the states.

    Parameters
    ----------
    own_law : callable
        From what is sensed and the parameters to inputs (B, d, n), m/s².
    law : LawParameters
        δ, r, k and the limits.
    sensors : Sensors
        What agents know of the states.
    """

    def __init__(self, own_law: OwnLaw, law: LawParameters, sensors: Sensors) -> None:
        self._own_law, self._law, self._sensors = own_law, law, sensors
        self._first: Floats | None = None

    def __call__(self, positions: Floats, velocities: Floats, time: float) -> Floats:
        p, v = self._sensors.read(positions, velocities)
        if self._first is None:
            self._first = p
        sensed = Sensed(p, v, self._first, time, self._sensors.detected(time))
        return check_states(self._own_law(sensed, self._law), "input of the own law", like=p)


class ModelInput(Input):
    """The input of one of the paper's models; the imprint is taken from what is sensed first.

    Parameters
    ----------
    law : LawParameters
        δ, r, k and the limits.
    sensors : Sensors
        What agents know of the states.
    velocity_based : bool
        Whether the law is the velocity-based one.
    threshold : bool
        Whether the alignment gain of the position-based law stops decaying at t = 1/k.
    """

    def __init__(
        self, law: LawParameters, sensors: Sensors, *, velocity_based: bool, threshold: bool
    ) -> None:
        self._law, self._sensors = law, sensors
        self._velocity_based, self._threshold = velocity_based, threshold
        #: What is kept of the first positions that are sensed.
        self._first: Floats | None = None


class DenseInput(ModelInput):
    """From all n² pairs, in arrays."""

    def __call__(self, positions: Floats, velocities: Floats, time: float) -> Floats:
        p, v = self._sensors.read(positions, velocities)
        if self._first is None:
            self._first = displacements(p)
        detected = self._sensors.detected(time)
        if self._velocity_based:
            return velocity_based_input(p, v, self._law, detected=detected)
        return position_based_input(
            p, self._first, time, self._law, threshold=self._threshold, detected=detected
        )


class TreeInput(ModelInput):
    """From a list of the pairs in reach, flock by flock."""

    def __call__(self, positions: Floats, velocities: Floats, time: float) -> Floats:
        p, v = self._sensors.read(positions, velocities)
        if self._first is None:
            self._first = p
        return np.stack([self._of(flock, p[flock], v[flock], time) for flock in range(len(p))])

    def _of(self, flock: int, p: Floats, v: Floats, time: float) -> Floats:
        pairs = neighbour_pairs(p, self._law.radius)
        detected = self._sensors.detected_among(flock, pairs.other, time)
        if detected is not None:
            pairs = pairs.where(detected)
        if self._velocity_based:
            return velocity_based_input_over(pairs, p, v, self._law)
        assert self._first is not None
        return position_based_input_over(
            pairs, p, self._first[flock], time, self._law, threshold=self._threshold
        )
