"""Arena steering of many teams at once: see `flocking.steering`, which says why and how.

What is about all teams is done in arrays. Sines, cosines and lengths of single teams are asked of
`math` as the single flock does, so that a team turns by the same angle to the last bit; few teams
are near a wall at a time.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.steering import SteeringParameters, turning_sign

Floats = NDArray[np.float64]


class BatchSteering:
    """What turns the common velocity of each team off the walls.

    Parameters
    ----------
    parameters : SteeringParameters
        How to steer.
    arena : (4,) tuple
        Least x, greatest x, least y, greatest y, metres.
    margin : float
        How far inside the arena look-ahead points have to stay, metres.
    time_step : float
        Seconds between calls.
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
        self.parameters = parameters
        self.arena = arena
        self.margin = margin
        self.time_step = time_step
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
            inputs = inputs + _turned(inputs.mean(axis=2), self._angle)
        if turning.any():
            velocities = velocities + _turned(common, turning)
        return inputs, velocities, turning

    def _choose(self, points: Floats, common: Floats) -> None:
        """Choose which way each team turns now: 1, -1, or 0 for straight on."""
        left, right, bottom, top = self.arena
        least, most = points.min(axis=2), points.max(axis=2)
        gaps = np.stack(
            [least[:, 0] - left, right - most[:, 0], least[:, 1] - bottom, top - most[:, 1]], axis=1
        )
        call = np.maximum(0.0, self.parameters.reach - (gaps - self.margin))
        called = ties.beyond(call, 0.0).any(axis=1)
        self._sign[~called] = 0.0
        clear = self.parameters.clear
        for team in np.flatnonzero(called).tolist():
            self._sign[team] = turning_sign(self._sign[team], common[team], call[team], clear)


def _turned(common: Floats, angles: Floats) -> Floats:
    """Return (R(angle) − I)·common of each team as a column that adds to every robot's vector."""
    cosine = np.array([math.cos(angle) - 1.0 for angle in angles.tolist()])
    sine = np.array([math.sin(angle) for angle in angles.tolist()])
    x, y = common.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)[:, :, None]
