"""Arena steering of many teams at once: see `flocking.steering`, which says why and how.

What is about all teams is done in arrays. Sines, cosines and lengths of single teams are asked of
`math` as the single flock does, so that a team turns by the same angle to the last bit; few teams
are near a wall at a time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.steering import (
    SteeringParameters,
    WallSteering,
    added_by_turning,
    turning_sign,
)

Floats = NDArray[np.float64]


class BatchSteering(WallSteering):
    """What turns the common velocity of each team off the walls.

    Parameters
    ----------
    parameters, arena, margin, time_step
        See `WallSteering`.
    teams : int
        How many teams, B.
    """

    def __init__(
        self,
        parameters: SteeringParameters,
        arena: tuple[float, float, float, float],
        margin: float,
        time_step: float,
        teams: int,
    ) -> None:
        super().__init__(parameters, arena, margin, time_step)
        self._angle = np.zeros(teams)
        self._sign = np.zeros(teams)

    def steer(
        self, time: float, points: Floats, inputs: Floats, velocities: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Turn the common velocity of each team away from near walls; leave relative motion alone.

        Parameters
        ----------
        time : float
            Seconds since the imprint.
        points, inputs, velocities : (B, 2, N) array
            Look-ahead points in metres; the law's inputs in m/s²; velocities in m/s.

        Returns
        -------
        inputs, velocities : (B, 2, N) array
            The turned ones, m/s² and m/s.
        turning : (B,) array
            By how much the velocities were turned, rad.
        """
        if not ties.beyond(time, self.parameters.start):
            return inputs, velocities, np.zeros(len(points))
        common = velocities.mean(axis=2)
        self._choose(points, common)
        turning = self._sign * self.parameters.turn_rate * self.time_step
        self._angle += turning
        if self._angle.any():
            inputs = inputs + _for_each_robot(inputs.mean(axis=2), self._angle)
        if turning.any():
            velocities = velocities + _for_each_robot(common, turning)
        return inputs, velocities, turning

    def _choose(self, points: Floats, common: Floats) -> None:
        """Choose which way each team turns now: 1, -1, or 0 for straight on."""
        call = self.call(points.min(axis=2).T, points.max(axis=2).T).T
        called = ties.beyond(call, 0.0).any(axis=1)
        self._sign[~called] = 0.0
        clear = self.parameters.clear
        for team in np.flatnonzero(called).tolist():
            self._sign[team] = turning_sign(self._sign[team], common[team], call[team], clear)


def _for_each_robot(common: Floats, angles: Floats) -> Floats:
    """Return what turning adds to each team's (B, 2) vectors, as columns for every robot."""
    return added_by_turning(common.T, angles).T[:, :, None]
