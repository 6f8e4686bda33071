r"""Arena steering: the flock's common velocity turns away from walls, its relative motion does not.

An addition to the paper's law.  The paper's flock drifts at about 0.05 m/s and meets a wall of the
arena within half a minute.  There the certificate parks it: headings stay parallel, so γ from
headings still reads 0.98, while robots creep.  Pushing each robot off its wall does not help: the
drift comes back, since what drives it, an imbalance of the formation, is still there.  So steering
turns the drive itself.  With :math:`\bar u` and :math:`\bar w` the means of inputs and velocities
over the flock,

.. math:: u_i \leftarrow u_i + (R(\alpha) - I)\,\bar u, \qquad
          w_i \leftarrow w_i + (R(\dot\alpha\,\Delta t) - I)\,\bar w,

where α grows or falls at a constant rate while a robot is near a wall and the common velocity does
not yet point away from it.  The sign of the turn is latched until then, so that a corner does not
make the flock dither.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SteeringParameters:
    """How the flock's common velocity is turned away from a wall.

    Attributes
    ----------
    start : float
        Seconds from the imprint before steering may begin: the first transient is the law's.
    reach : float
        Metres from the wall margin at which a robot calls for steering.
    turn_rate : float
        rad/s by which the common velocity turns.
    clear : float
        Cosine between common velocity and the way inward at which turning stops.

    Raises
    ------
    ParameterError
        Where a value is out of its range.
    """

    start: float = 3.0
    reach: float = 0.18
    turn_rate: float = 0.45
    clear: float = 0.2

    def __post_init__(self) -> None:
        for name in ("start", "reach", "turn_rate"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(f"{name}: expected finite and more than zero, got {value!r}")
        if not -1.0 < self.clear < 1.0:
            raise ParameterError(f"clear: expected a cosine between -1 and 1, got {self.clear}")


class WallSteering:
    """What is common to all who turn flocks off the walls: how, within which walls, how often.

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
    """

    def __init__(
        self,
        parameters: SteeringParameters,
        arena: tuple[float, float, float, float],
        margin: float,
        time_step: float,
    ) -> None:
        self.parameters = parameters
        self.arena = arena
        self.margin = margin
        self.time_step = time_step

    def call(self, least: Floats, most: Floats) -> Floats:
        """Return how far look-ahead points are within reach of the walls.

        Parameters
        ----------
        least, most : (2, ...) array
            Their least and greatest x and y, m; the same of single points.

        Returns
        -------
        (4, ...) array
            At the least x, greatest x, least y and greatest y, m.
        """
        left, right, bottom, top = self.arena
        gaps = np.array([least[0] - left, right - most[0], least[1] - bottom, top - most[1]])
        return np.maximum(0.0, self.parameters.reach - (gaps - self.margin))


class ArenaSteering(WallSteering):
    """What turns a flock's common velocity off the walls, and by how much it has been turned.

    Made as any `WallSteering`.
    """

    _angle = 0.0
    _sign = 0.0

    def reset(self) -> None:
        """Forget by how much the flock was turned, and which way it turns."""
        self._angle = 0.0
        self._sign = 0.0

    def steer(
        self, time: float, points: Floats, inputs: Floats, velocities: Floats
    ) -> tuple[Floats, Floats, float]:
        """Turn the flock's common velocity away from near walls, and leave relative motion alone.

        Parameters
        ----------
        time : float
            Seconds since the imprint.
        points, inputs, velocities : (2, N) array
            Look-ahead points in metres; the law's inputs in m/s²; velocities in m/s.

        Returns
        -------
        inputs : (2, N) array
            The turned inputs, m/s².
        velocities : (2, N) array
            The turned velocities, m/s.
        turning : float
            By how much the velocities were turned, rad.
        """
        if not ties.beyond(time, self.parameters.start):
            return inputs, velocities, 0.0
        common = velocities.mean(axis=1)
        turning = self._turning(points, common)
        self._angle += turning
        return (
            inputs + added_by_turning(inputs.mean(axis=1)[:, None], np.array([self._angle])),
            velocities + added_by_turning(common[:, None], np.array([turning])),
            turning,
        )

    def _turning(self, points: Floats, common: Floats) -> float:
        """Return by how much to turn the common velocity now, rad, away from near walls."""
        call = self.call(points.min(axis=1), points.max(axis=1))
        self._sign = turning_sign(self._sign, common, call, self.parameters.clear)
        return self._sign * self.parameters.turn_rate * self.time_step


def turning_sign(sign: float, common: Floats, call: Floats, clear: float) -> float:
    """Return which way a flock turns now: 1 for left, -1 for right, 0 for straight on.

    Parameters
    ----------
    sign : float
        Which way it turned before.
    common : (2,) array
        Its common velocity, m/s.
    call : (4,) array
        How far it is within reach of the walls at the least x, greatest x, least y, greatest y, m.
    clear : float
        Cosine from which on a direction leads away from them.
    """
    inward = (call[0] - call[1], call[2] - call[3])
    along = common[0] * inward[0] + common[1] * inward[1]
    lengths = math.hypot(*common) * math.hypot(*inward)
    away = lengths > 0.0 and along >= clear * lengths
    if away or not ties.beyond(call, 0.0).any():
        return 0.0
    if sign != 0.0:
        return sign
    across = common[0] * inward[1] - common[1] * inward[0]
    # Straight at a wall, both ways are as good.
    return 1.0 if ties.reached(across, 0.0) else -1.0


def added_by_turning(common: Floats, angles: Floats) -> Floats:
    """Return what turning adds to velocities, (R(angle) − I)·common.

    Parameters
    ----------
    common : (2, K) array
        Common velocities, m/s, or inputs, m/s².
    angles : (K,) array
        By how much to turn each, rad.

    Returns
    -------
    (2, K) array
        In the unit of `common`.
    """
    # Python's own functions: numpy's differ in the last bit from processor to processor.
    cosine = np.array([math.cos(angle) - 1.0 for angle in angles.tolist()])
    sine = np.array([math.sin(angle) for angle in angles.tolist()])
    x, y = common
    return np.stack([cosine * x - sine * y, sine * x + cosine * y])
