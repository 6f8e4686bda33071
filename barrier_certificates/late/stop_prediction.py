"""Where robots would come to rest: the poses seen, moved by the commands in flight.

A command that was given from a until b seconds ago acts from τ − a until τ − b seconds from now. In
between, speeds approach it exponentially, and at the end they decay: the turn rate ω turns the
robot by ωT more, and the speed v takes it a way vT along the arc of that turn, exactly. All of it
is linear in the commands but for the headings, so the mean speeds in each interval are one matrix
times the commands, which changes only with the durations of steps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray
from barrier_certificates.late.late_robots import LateRobots, middle

__all__ = ["StopPrediction"]

_FORGOTTEN = 10.0
"""After so many time constants what a command has left is 5e-5 of it: two micrometres."""


class _Response(NamedTuple):
    """What the commands of the past do from now on."""

    seconds: FloatArray
    """(K,) durations of the intervals in which one command each acts."""
    means: FloatArray
    """(K, M) mean speeds in them, by the M commands."""
    last: FloatArray
    """(M,) speeds after the last of them, by the commands."""


class StopPrediction:
    """Remembers the commands of a team, and says where each robot would come to rest.

    Parameters
    ----------
    robots : LateRobots
        How late they answer; predictions take the middle of each range.
    time_step : float
        Time from one command to the next, s.
    """

    def __init__(self, robots: LateRobots, time_step: float) -> None:
        self.dead_time, self.lag = middle(robots.dead_time), middle(robots.lag)
        self.time_step = time_step
        self._gains = np.array([[middle(robots.speed_gain)], [middle(robots.turn_gain)]])
        memory = self.dead_time + _FORGOTTEN * self.lag
        self._length = math.ceil(memory / time_step) + 2
        self._longest = robots.longest_step or time_step
        self.reset()

    def reset(self) -> None:
        """Forget all commands: the robots have stood still."""
        self._commands: FloatArray | None = None
        self._durations = np.full(self._length, self.time_step)
        self._response: _Response | None = None

    def sent(self, commands: FloatArray) -> None:
        """Take note of the commands that robots have been sent.

        Parameters
        ----------
        commands : (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """
        if self._commands is None or self._commands.shape[2] != commands.shape[1]:
            self._commands = np.zeros((self._length, 2, commands.shape[1]))
        self._commands[:-1] = self._commands[1:]
        self._commands[-1] = self._gains * commands
        self._lasted(self.time_step)

    def elapsed(self, seconds: float) -> None:
        """Correct how long the last command has been held.

        Parameters
        ----------
        seconds : float
            Time since it was sent, s; beyond the longest that robots drive on, they stand.
        """
        if self._commands is None:
            return
        held = min(seconds, self._longest)
        if abs(self._durations[-1] - held) > 1e-9:
            self._durations[-1] = held
            self._response = None
        if seconds > held + 1e-9:
            self._commands[:-1] = self._commands[1:]
            self._commands[-1] = 0.0
            self._lasted(seconds - held)

    def stops(self, poses: FloatArray) -> FloatArray:
        """Return where robots come to rest if they are told to stop now.

        Parameters
        ----------
        poses : (3, N) array
            Poses as seen, m and rad.

        Returns
        -------
        (3, N) array
            Poses at rest, m and rad.
        """
        out = poses.copy()
        if self._commands is None or self._commands.shape[2] != poses.shape[1]:
            return out
        if self._response is None:
            self._response = self._respond()
        seconds, means, last = self._response
        past = self._commands.reshape(self._length, -1)
        number = poses.shape[1]
        if seconds.shape[0]:
            ways = (means @ past).reshape(-1, 2, number) * seconds[:, None, None]
            turns = ways[:, 1]
            heading = np.cumsum(turns, axis=0)
            heading += poses[2] - 0.5 * turns  # in the middle of each interval
            out[0] += (ways[:, 0] * np.cos(heading)).sum(axis=0)
            out[1] += (ways[:, 0] * np.sin(heading)).sum(axis=0)
            out[2] += turns.sum(axis=0)
        if self.lag:
            way, turn = self.lag * (last @ past).reshape(2, number)
            way *= np.sinc(turn / (2.0 * np.pi))  # the chord of the arc
            heading = out[2] + 0.5 * turn
            out[0] += way * np.cos(heading)
            out[1] += way * np.sin(heading)
            out[2] += turn
        return out

    def _lasted(self, seconds: float) -> None:
        """Take note that one more command was held for so long."""
        if np.any(np.abs(self._durations - seconds) > 1e-9):
            self._response = None
        self._durations[:-1] = self._durations[1:]
        self._durations[-1] = seconds

    def _respond(self) -> _Response:
        """Return what is left of the commands, by when they were given."""
        ended = np.concatenate([np.cumsum(self._durations[::-1])[::-1][1:], [0.0]])
        start = self.dead_time - ended - self._durations
        end = self.dead_time - ended
        speed: FloatArray = np.zeros(self._length)  # what each command contributes to the speed
        seconds, means = [], []
        for command in range(self._length):
            before = max(0.0, min(end[command], 0.0) - start[command])
            if before > 0.0:  # until now
                speed = self._approach(speed, command, before)[1]
            after = end[command] - max(start[command], 0.0)
            if after > 1e-12:
                mean, speed = self._approach(speed, command, after)
                seconds.append(after)
                means.append(mean)
        shape = (len(means), self._length)
        return _Response(np.array(seconds), np.array(means).reshape(shape), speed)

    def _approach(
        self, speed: FloatArray, command: int, seconds: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the mean speed while a command acts, and that after it, by the commands."""
        target = np.zeros(self._length)
        target[command] = 1.0
        if not self.lag:
            return target, target
        gap = speed - target
        left = math.exp(-seconds / self.lag)
        return target + (self.lag / seconds) * (1.0 - left) * gap, target + left * gap
