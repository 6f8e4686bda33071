"""What the testbed would say about a run: duration, and what was wrong with it.

The counters are the published ones; the report adds when, who and how near. Two forms: the text
that each generation prints at the end of a script, and plain data for JSON.
"""

from dataclasses import asdict, dataclass
from typing import Any

from barrier_certificates.ties import beyond
from rps_compat.arena import Arena
from rps_compat.generations import Generation
from rps_compat.testbed import MAX_DURATION, MAX_ROBOTS
from rps_compat.violations import FaultKind, Violations

#: How generation 1 calls its faults; scripts read these strings in ``_errors``.
MESSAGES = {
    FaultKind.BOUNDARY: "iteration(s) robots were outside the boundaries.",
    FaultKind.COLLISION: "iteration(s) where robots collided.",
    FaultKind.ACTUATOR: "iteration(s) where the actuator limits of at least one robot were "
    "exceeded and thresholded to their maximum rotational velocity.",
}
#: The verdict on a run in which nothing went wrong.
NO_VIOLATIONS = "no violations"
#: Faults beyond this many are summed up in the text; the data has them all.
LISTED = 10


@dataclass(frozen=True)
class Fault:
    """One fault from its beginning to its end.

    Attributes
    ----------
    kind
        What was wrong.
    robots
        The robots concerned.
    start, end
        Seconds of the run at which it was seen first and last.
    worst
        Smallest distance of the pair's collision points, largest distance outside (m), or fastest
        wheel asked for (rad/s).
    """

    kind: FaultKind
    robots: tuple[int, ...]
    start: float
    end: float
    worst: float

    def __str__(self) -> str:
        robots = " and ".join(f"{robot}" for robot in self.robots)
        span = f"{self.start:.2f} s" + (f" to {self.end:.2f} s" if self.end > self.start else "")
        if self.kind is FaultKind.COLLISION:
            return f"robots {robots} too close at {span}, {100 * self.worst:.1f} cm at the nearest"
        if self.kind is FaultKind.BOUNDARY:
            return f"robot {robots} outside at {span}, {100 * self.worst:.1f} cm at the farthest"
        return f"robot {robots} asked for wheels of {self.worst:.1f} rad/s at {span}"


@dataclass(frozen=True)
class RunReport:
    """Everything that would be held against one run; see :func:`report_on`.

    Attributes
    ----------
    number_of_robots, steps
        Size and length of the run.
    duration
        Seconds that the steps take on the testbed.
    steps_too_close, steps_outside, steps_over_actuator_limits
        Steps that began with a pair too close, with a robot outside, with a wheel over its limit.
    pairs_too_close
        Pairs too close summed over the steps, as generation 2 counts.
    largest_wheel_velocity
        Fastest wheel asked for beyond the limit, rad/s; 0 if none was.
    faults
        Each fault once, in the order in which they began.
    process
        Name of the child process of the script that the robots were in; empty in its own.
    """

    number_of_robots: int
    steps: int
    duration: float
    steps_too_close: int
    steps_outside: int
    steps_over_actuator_limits: int
    pairs_too_close: int
    largest_wheel_velocity: float
    faults: tuple[Fault, ...]
    process: str = ""

    @property
    def clean(self) -> bool:
        """Nobody too close, nobody outside: the testbed would not stop this run."""
        return not (self.steps_too_close or self.steps_outside)

    @property
    def verdict(self) -> str:
        """The report in a few words."""
        found = [
            f"{steps} steps {what}"
            for steps, what in (
                (self.steps_too_close, "with robots too close"),
                (self.steps_outside, "with robots outside"),
                (self.steps_over_actuator_limits, "over the actuator limits"),
            )
            if steps
        ]
        return ", ".join(found) or NO_VIOLATIONS

    @property
    def notes(self) -> list[str]:
        """What the testbed does not take, although nothing went wrong here."""
        notes = []
        if self.number_of_robots > MAX_ROBOTS:
            notes.append(f"{self.number_of_robots} robots: the testbed has {MAX_ROBOTS}")
        if beyond(self.duration, MAX_DURATION):
            notes.append(
                f"{self.duration:.1f} s: the testbed ends every run after {MAX_DURATION:g} s"
            )
        return notes

    def as_dict(self) -> dict[str, Any]:
        """Return the report as plain data, ready for JSON."""
        return {**asdict(self), "clean": self.clean}

    def text(self, generation: Generation) -> str:
        """Return what the testbed prints at the end of a script, line breaks included.

        Parameters
        ----------
        generation : int
            Of the API: 1 or 2.
        """
        return self._text1() if generation == 1 else self._text2()

    def _share(self, steps: int) -> str:
        percent = 100 * steps / max(self.steps, 1)
        return f"{steps} out of {self.steps} (~{percent:.0f}%) timesteps"

    def _listing(self, kind: FaultKind, indent: str) -> str:
        faults = [fault for fault in self.faults if fault.kind is kind]
        lines = [f"{indent}{fault}\n" for fault in faults[:LISTED]]
        if len(faults) > LISTED:
            lines.append(f"{indent}and {len(faults) - LISTED} more\n")
        return "".join(lines)

    def _text1(self) -> str:
        out = f"This run takes about {self.duration:.2f} seconds on the Robotarium.\n"
        found = [
            (kind, steps)
            for kind, steps in (
                (FaultKind.BOUNDARY, self.steps_outside),
                (FaultKind.COLLISION, self.steps_too_close),
                (FaultKind.ACTUATOR, self.steps_over_actuator_limits),
            )
            if steps
        ]
        if not found:
            return out + "Nothing was found that would stop it there.\n"
        for kind, steps in found:
            out += f"{steps} {MESSAGES[kind]}\n" + self._listing(kind, "    ")
        return out

    def _text2(self) -> str:
        out = f"Your simulation took approximately {self.duration:.2f} real seconds to execute.\n\n"
        excess = self.steps_over_actuator_limits
        if self.clean and not excess:
            return out + (
                "No errors or warnings in your simulation!  "
                "Your script will run on the Robotarium!\n\n"
            )
        if self.clean:
            out += "No hard errors detected, your script will run on the Robotarium!\n\n"
        for kind, steps, what in (
            (FaultKind.COLLISION, self.steps_too_close, "robots too close to each other"),
            (FaultKind.BOUNDARY, self.steps_outside, "robots outside the boundaries"),
        ):
            if steps:
                out += f"ERROR: {self._share(steps)} had {what}.\n"
                out += self._listing(kind, "         ")
        if excess:
            out += (
                f"WARNING: {self._share(excess)} had velocity command(s) exceed actuator limits.\n"
                "         A large percentage of exceeded actuator commands will cause noticeable\n"
                "         differences between this simulation and the physical Robotarium.\n"
            )
        return out


def report_on(arena: Arena) -> RunReport:
    """Report on the run of an arena so far.

    Parameters
    ----------
    arena : Arena
        Where it runs.
    """
    return report_of(arena.number_of_robots, arena.steps, arena.robot.time_step, arena.violations)


def report_of(
    robots: int, steps: int, time_step: float, found: Violations, process: str = ""
) -> RunReport:
    """Report on a run of which only this is known.

    Parameters
    ----------
    robots, steps
        How many.
    time_step
        Seconds of one step.
    found
        What was wrong.
    process
        Name of the child process that the robots were in.
    """
    return RunReport(
        number_of_robots=robots,
        steps=steps,
        duration=steps * time_step,
        steps_too_close=found.close_steps,
        steps_outside=found.outside_steps,
        steps_over_actuator_limits=found.actuator_steps,
        pairs_too_close=found.close_pairs,
        largest_wheel_velocity=found.largest_wheel_velocity,
        faults=tuple(
            Fault(e.kind, e.robots, e.first * time_step, e.last * time_step, e.worst)
            for e in found.events
        ),
        process=process,
    )
