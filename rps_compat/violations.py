"""What would be held against a run on the testbed, counted and told apart by robot and time.

The arena reports each step at which something is wrong; here consecutive steps of the same pair or
robot become one *event* with a beginning, an end and its worst value, so that a million-step
overlap is one line of a report and memory does not grow with the length of the fault.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from barrier_certificates.word_enum import WordEnum


class FaultKind(WordEnum):
    """What the testbed holds against a run."""

    #: A pair too close.
    COLLISION = "collision"
    #: A robot outside.
    BOUNDARY = "boundary"
    #: Wheels asked to turn faster than they can.
    ACTUATOR = "actuator"


@dataclass
class Event:
    """A fault that lasted from one step to another.

    Attributes
    ----------
    kind
        What is wrong.
    robots
        The pair, or the one robot.
    first, last
        Steps, counted from 0, at whose start the fault was seen first and last.
    worst
        Smallest distance (m) between a pair's collision points, largest distance (m) beyond a
        wall, or largest wheel speed asked for (rad/s).
    """

    kind: FaultKind
    robots: tuple[int, ...]
    first: int
    last: int
    worst: float


@dataclass
class Violations:
    """Counters of one run, in every form that the two generations report.

    Attributes
    ----------
    saturated_steps
        Steps in which a wheel's speed was cut, if only by a last bit: held commands that were cut
        before are sometimes cut again by rounding, and the published simulators count that.
    actuator_steps
        Steps in which at least one wheel was asked for more than its limit.
    largest_wheel_velocity
        The fastest wheel asked for in those steps, rad/s; 0 when there were none.
    outside_steps
        Steps that began with at least one robot outside the boundaries.
    outside_by_robot
        Steps that each robot began outside.
    close_pairs
        Pairs too close, summed over steps: two pairs in one step count twice.
    close_by_robot
        The same for each robot: a pair counts for both of its robots.
    close_steps
        Steps that began with at least one pair too close.
    events
        Faults in the order in which they began.
    """

    saturated_steps: int = 0
    actuator_steps: int = 0
    largest_wheel_velocity: float = 0.0
    outside_steps: int = 0
    outside_by_robot: dict[int, int] = field(default_factory=dict)
    close_pairs: int = 0
    close_by_robot: dict[int, int] = field(default_factory=dict)
    close_steps: int = 0
    events: list[Event] = field(default_factory=list)
    _open: dict[tuple[FaultKind, tuple[int, ...]], Event] = field(default_factory=dict, repr=False)

    @property
    def clean(self) -> bool:
        """No pair too close and nobody outside: the testbed would not stop this run."""
        return self.close_pairs == 0 and self.outside_steps == 0

    def actuator(self, step: int, wheels: NDArray[np.float64], limit: float) -> None:
        """Count a step in which wheels go beyond their limit.

        Parameters
        ----------
        step : int
            Number of the step.
        wheels : (2, N) array
            Wheel speeds without their sign, rad/s.
        limit : float
            Their limit, rad/s.
        """
        self.saturated_steps += 1
        fastest = wheels.max(axis=0)
        robots = np.flatnonzero(ties.beyond(fastest, limit))
        if not robots.size:
            return
        self.actuator_steps += 1
        self.largest_wheel_velocity = max(self.largest_wheel_velocity, float(fastest.max()))
        for robot in robots:
            self._note(FaultKind.ACTUATOR, (int(robot),), step, float(fastest[robot]))

    def outside(self, step: int, beyond: NDArray[np.float64]) -> None:
        """Count a step that begins with robots outside the arena.

        Parameters
        ----------
        step : int
            Number of the step.
        beyond : (N,) array
            How far each is outside, m; inside is negative.
        """
        self.outside_steps += 1
        for robot in map(int, np.flatnonzero(ties.beyond(beyond, 0.0))):
            self.outside_by_robot[robot] = self.outside_by_robot.get(robot, 0) + 1
            self._note(FaultKind.BOUNDARY, (robot,), step, float(beyond[robot]))

    def close(
        self,
        step: int,
        first: NDArray[np.intp],
        second: NDArray[np.intp],
        distances: NDArray[np.float64],
    ) -> None:
        """Count a step that begins with pairs too close.

        Parameters
        ----------
        step : int
            Number of the step.
        first : (k,) integer array
            One robot of each pair.
        second : (k,) integer array
            The other robot of each pair.
        distances : (k,) array
            How far their collision points are apart, m.
        """
        self.close_steps += 1
        self.close_pairs += len(first)
        for i, j, distance in zip(first.tolist(), second.tolist(), distances.tolist(), strict=True):
            for robot in (i, j):
                self.close_by_robot[robot] = self.close_by_robot.get(robot, 0) + 1
            self._note(FaultKind.COLLISION, (i, j), step, distance)

    def lasting(self, since: int) -> list[Event]:
        """Return the events that were seen at a step or later, of each kind and robots.

        Parameters
        ----------
        since : int
            Number of that step.
        """
        if since == 0:
            return self.events
        return [event for event in self._open.values() if event.last >= since]

    def _note(self, kind: FaultKind, robots: tuple[int, ...], step: int, value: float) -> None:
        event = self._open.get((kind, robots))
        if event is None or event.last < step - 1:
            event = Event(kind, robots, step, step, value)
            self._open[kind, robots] = event
            self.events.append(event)
            return
        event.last = step
        worse = min if kind is FaultKind.COLLISION else max
        event.worst = worse(event.worst, value)
