"""What would be held against each of many runs, counted in arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rps_compat.arena_guests import Array
from rps_compat.violations import Violations

Counts = NDArray[np.int64]

SATURATED, ACTUATOR, OUTSIDE, CLOSE_PAIRS, CLOSE_STEPS = range(5)


class Tally(NamedTuple):
    """The counters of B teams, as compiled code takes them.

    Attributes
    ----------
    steps : (5, B) integer array
        Saturated steps, actuator steps, steps begun outside, pairs too close, steps begun so.
    by_robot : (2, B, N) integer array
        Steps that each robot began outside; pairs too close that it was in.
    extremes : (2, B) array
        Fastest wheel asked for beyond its limit, rad/s; smallest distance of two collision points
        at the start of a step, m.
    """

    steps: Counts
    by_robot: Counts
    extremes: Array


@dataclass(frozen=True, eq=False)
class BatchViolations:
    """Counters of B runs, with the meanings of `Violations`, which has events besides.

    Attributes
    ----------
    saturated_steps, actuator_steps, outside_steps, close_pairs, close_steps : (B,) integer array
        Of each team.
    outside_by_robot, close_by_robot : (B, N) integer array
        Of each robot.
    largest_wheel_velocity : (B,) array
        The fastest wheel asked for beyond its limit, rad/s; 0 where there was none.
    smallest_distance : (B,) array
        The least that two collision points were apart at the start of a step, m; infinite before
        the first step.
    """

    saturated_steps: Counts
    actuator_steps: Counts
    outside_steps: Counts
    close_pairs: Counts
    close_steps: Counts
    outside_by_robot: Counts
    close_by_robot: Counts
    largest_wheel_velocity: Array
    smallest_distance: Array

    @classmethod
    def of(cls, tally: Tally) -> BatchViolations:
        """Return the counters by name; they go on counting.

        Parameters
        ----------
        tally : Tally
            Arrays that steps count in.
        """
        return cls(*tally.steps, *tally.by_robot, *tally.extremes)

    @property
    def clean(self) -> NDArray[np.bool_]:
        """Teams in which no pair was too close and nobody outside, (B,) boolean array."""
        clean: NDArray[np.bool_] = (self.close_pairs == 0) & (self.outside_steps == 0)
        return clean

    def team(self, team: int) -> Violations:
        """Return the counters of one team as those of an arena; batches know no events.

        Parameters
        ----------
        team : int
            Which team.
        """

        def by_robot(counts: Counts) -> dict[int, int]:
            return {robot: int(n) for robot, n in enumerate(counts[team]) if n}

        return Violations(
            int(self.saturated_steps[team]),
            int(self.actuator_steps[team]),
            float(self.largest_wheel_velocity[team]),
            int(self.outside_steps[team]),
            by_robot(self.outside_by_robot),
            int(self.close_pairs[team]),
            by_robot(self.close_by_robot),
            int(self.close_steps[team]),
        )


def empty_tally(teams: int, robots: int) -> Tally:
    """Return counters at nought.

    Parameters
    ----------
    teams, robots : int
        Number of teams, B, and of robots in each, N.
    """
    extremes = np.zeros((2, teams))
    extremes[1] = np.inf
    steps = np.zeros((5, teams), dtype=np.int64)
    return Tally(steps, np.zeros((2, teams, robots), dtype=np.int64), extremes)
