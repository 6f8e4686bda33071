"""The three models that the paper compares, by name, and the input of each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.word_enum import WordEnum
from posflock_robotarium.flocking.law import (
    LawParameters,
    position_based_input,
    velocity_based_input,
)

Floats = NDArray[np.float64]


class Model(WordEnum):
    """The three models the paper compares."""

    VELOCITY = "velocity"
    POSITION = "position"
    POSITION_NO_THRESHOLD = "position-no-threshold"

    @property
    def label(self) -> str:
        """The paper's name for it, as its figures print it."""
        return _LABELS[self]

    def input(
        self,
        positions: Floats,
        velocities: Floats,
        imprint: Floats,
        time: float,
        parameters: LawParameters,
        detected: NDArray[np.bool_] | None = None,
    ) -> Floats:
        """Return what agents want to do under this model, before saturation.

        Parameters
        ----------
        positions, velocities : (..., d, n) array
            Metres and m/s; a position-based model does not look at velocities.
        imprint : (..., d, n, n) array
            ``displacements`` of the first instant, metres; the velocity-based one needs none.
        time : float
            Seconds since that instant, more than zero.
        parameters : LawParameters
            δ, r and k.
        detected : (..., n, n) boolean array, optional
            Row i marks the agents that i senses; by default every one within its radius.

        Returns
        -------
        (..., d, n) array
            Inputs in m/s².

        Raises
        ------
        ParameterError
            Where an array has the wrong shape or a value that is not finite, or time is not
            positive.
        """
        if self is Model.VELOCITY:
            return velocity_based_input(positions, velocities, parameters, detected=detected)
        threshold = self is Model.POSITION
        return position_based_input(
            positions, imprint, time, parameters, threshold=threshold, detected=detected
        )


_LABELS = {
    Model.VELOCITY: "V-based",
    Model.POSITION: "P-based (thr.)",
    Model.POSITION_NO_THRESHOLD: "P-based (no thr.)",
}
