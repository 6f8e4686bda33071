"""Robots that stand still although they were told to move, and a way out for them.

A certificate keeps robots safe, not busy: two that meet head on both stop, and an exact symmetry
never breaks by itself. The monitor notices it. *Tilting* the commands of those robots a little, all
to the same side, breaks the symmetry the way a rule of the road does; the tilted command is
certified like any other, so nothing about safety changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from barrier_certificates import checks, ties
from barrier_certificates.array_types import BoolArray, FloatArray

__all__ = ["DeadlockMonitor", "DeadlockParameters", "tilt"]


@dataclass(frozen=True)
class DeadlockParameters:
    """When a robot counts as stuck.

    Parameters
    ----------
    time_step : float
        Time between commands, s.
    patience : float
        A robot is stuck after being held for this long, s.
    held : float
        A robot is held while it may drive at less than this part of what was desired.
    idle : float
        A robot told to move at less than this is waiting, not stuck, m/s.
    """

    time_step: float = 0.033
    patience: float = 1.0
    held: float = 0.1
    idle: float = 0.005

    def __post_init__(self) -> None:
        checks.positive("time_step", self.time_step, "of seconds")
        checks.not_negative("patience", self.patience, "of seconds")
        checks.positive("held", self.held)
        checks.not_negative("idle", self.idle, "of m/s")


class DeadlockMonitor:
    """Counts for how long each robot has been held.

    Parameters
    ----------
    parameters : DeadlockParameters
        When a robot counts as stuck.
    """

    def __init__(self, parameters: DeadlockParameters) -> None:
        self.parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Forget for how long robots have been held."""
        self._held: FloatArray = np.zeros(0)
        self._stuck: BoolArray = np.zeros(0, dtype=bool)

    def stuck(self, number: int) -> BoolArray:
        """Return which robots are stuck; after a change of their number, nobody.

        Parameters
        ----------
        number : int
            Number of robots, N.

        Returns
        -------
        (N,) boolean array
            True for a stuck robot.
        """
        if self._stuck.shape[0] != number:
            self._held, self._stuck = np.zeros(number), np.zeros(number, dtype=bool)
        return self._stuck

    def watch(self, desired: FloatArray, command: FloatArray, velocity: FloatArray) -> None:
        """Take note of one step: what was desired, commanded and allowed.

        A stuck robot is free again when its command (tilted or not) is allowed as it is.

        Parameters
        ----------
        desired : (2, N) array
            What the user asked for, m/s.
        command : (2, N) array
            The same, tilted where a robot is stuck, m/s.
        velocity : (2, N) array
            What the certificate allowed, m/s.
        """
        stuck = self.stuck(desired.shape[1])
        p = self.parameters
        wish = np.hypot(desired[0], desired[1])
        held = (wish > p.idle) & (np.hypot(velocity[0], velocity[1]) < p.held * wish)
        self._held = np.where(held, self._held + p.time_step, 0.0)
        held_back = ties.beyond(np.abs(velocity - command).max(axis=0), 0.0)
        self._stuck = (stuck & held_back) | ties.beyond(self._held, p.patience)


def tilt(velocity: FloatArray, angle: float) -> FloatArray:
    """Return velocities turned anticlockwise.

    Parameters
    ----------
    velocity : (2, N) array
        Velocities, m/s.
    angle : float
        How far to turn, rad.

    Returns
    -------
    (2, N) array
        The turned velocities, m/s.
    """
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]]) @ velocity
