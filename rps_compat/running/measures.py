"""What is measured of a run, step by step: gaps, loop times, silence, and how far it is.

Each part is told of a step inside the script's ``step()``, before the robots move.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from barrier_certificates.ties import beyond, first_smallest, short_of
from barrier_certificates.wall_distance import wall_distances
from rps_compat.arena import Arena
from rps_compat.clock import SimulatedClock
from rps_compat.running.outcome import Gap, LoopTimes, Outcome, Silence


class RunMeasures:
    """Measures one run; as the pace of every Robotarium it lets each step's time pass, too.

    Parameters
    ----------
    clock
        Charges the script for what it computes.

    Attributes
    ----------
    seconds
        Of the run so far, by the clock.
    smallest_gap, initial_gap, wall_gap
        See `Outcome`; None before anything was measured.
    """

    def __init__(self, clock: SimulatedClock) -> None:
        self.clock = clock
        self.seconds = 0.0
        self.smallest_gap: Gap | None = None
        self.initial_gap: Gap | None = None
        self.wall_gap: Gap | None = None
        self._arenas = 0
        self._loops: list[float] = []
        self._silent = Silence(0.0, 0.0)
        self._silence = 0.0
        self._left = 0.0
        self._begun = False
        self._time_step = 0.0

    def created(self, arena: Arena) -> None:
        """Take note of a Robotarium that the script made.

        Parameters
        ----------
        arena : Arena
            Where its robots stand before the first step.
        """
        self._arenas += 1
        if self._arenas == 1:
            self.measure(0.0, arena)
            self.initial_gap = self.smallest_gap
        self.clock.resume()

    def step(self, time: float, arena: Arena) -> None:
        """Take note of a step.

        Parameters
        ----------
        time : float
            Time of the run, s.
        arena : Arena
            The arena, as it is now.
        """
        self._time_step = arena.robot.time_step
        spent = self.clock.spent()
        if self._begun:
            self._loops.append(spent)
        self._begun = True
        self.clock.resume()
        self._left = max(self._time_step - spent, 0.0)
        self.seconds += spent + self._left
        self.measure(time, arena)
        self._hear(time, arena)

    def after_step(self, time_step: float) -> None:
        """Let the step's time pass; the simulator's own work is not the script's.

        Parameters
        ----------
        time_step : float
            The step's duration, s.
        """
        self.clock.advance(self._left)

    def measure(self, time: float, arena: Any) -> None:
        """Measure the gaps between robots, and to the walls.

        Parameters
        ----------
        time : float
            Time of the run, s.
        arena : Arena
            The arena, as it is now.
        """
        poses = arena.poses
        points = poses[0] + 1j * poses[1]
        if points.size > 1:
            gaps = np.abs(points[:, None] - points) + np.diag(np.full(points.size, np.inf))
            if self.smallest_gap is None or short_of(gaps.min(), self.smallest_gap.metres):
                k = first_smallest(gaps.flat)
                self.smallest_gap = Gap(float(gaps.flat[k]), time, divmod(int(k), points.size))
        wall = wall_distances(poses, arena.robot.boundaries)
        if self.wall_gap is None or short_of(wall.min(), self.wall_gap.metres):
            robot = first_smallest(wall)
            self.wall_gap = Gap(float(wall[robot]), time, (int(robot),))

    def _hear(self, time: float, arena: Arena) -> None:
        """Count how long the robots drive on without a new command."""
        if arena.is_commanded or not np.abs(arena.velocities).max(initial=0.0) > 0:
            self._silence = 0.0
        else:
            self._silence += arena.robot.time_step
            if beyond(self._silence, self._silent.seconds):
                self._silent = Silence(self._silence, time)

    def told_in(self, outcome: Outcome) -> Outcome:
        """Return an outcome with what was measured.

        Parameters
        ----------
        outcome : Outcome
            How the run went.
        """
        return replace(
            outcome,
            clock=self.seconds,
            loop=self._loop_times(),
            silence=self._silent,
            smallest_gap=self.smallest_gap,
            initial_gap=self.initial_gap,
            wall_gap=self.wall_gap,
        )

    def _loop_times(self) -> LoopTimes | None:
        if not self._loops:
            return None
        loops = np.array(self._loops)
        return LoopTimes(
            p50=float(np.quantile(loops, 0.5)),
            p99=float(np.quantile(loops, 0.99)),
            longest=float(loops.max()),
            late=float(np.mean(loops > self._time_step)),
            at=(int(loops.argmax()) + 1) * self._time_step,
        )
