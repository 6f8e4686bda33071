"""The figures of a verify report: what a reader wants to know even where nothing is wrong."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from posflock_robotarium.alignment.intervals import told_interval
from posflock_robotarium.verify.motion import largest_wheel_speed, saturated_steps
from posflock_robotarium.verify.timing import recommended_duration
from rps_compat.violations import FaultKind

if TYPE_CHECKING:
    from posflock_robotarium.verify.initial_drive_time import DriveTime
    from rps_compat.running.outcome import Gap, LoopTimes, Outcome


@dataclass(frozen=True)
class Smallest:
    """The smallest of some distance in the ideal run and in all trials.

    Attributes
    ----------
    ideal : float, optional
        In the ideal run, m; None where unknown.
    trials : float, optional
        In all trials together, m; None where unknown in each.
    """

    ideal: float | None
    trials: float | None


@dataclass(frozen=True)
class Most:
    """The largest of some count in the ideal run and in any trial.

    Attributes
    ----------
    ideal : int
        In the ideal run.
    trials : int, optional
        In the trial with most; None where no trial stepped.
    """

    ideal: int
    trials: int | None


@dataclass(frozen=True)
class Hits:
    """In how many of how many trials something happened.

    Attributes
    ----------
    hits : int
        Trials in which it happened.
    trials : int
        Trials in which it could have: those that stepped; at least 1.
    """

    hits: int
    trials: int

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % confidence interval of the proportion of runs; None of few."""
        return told_interval(self.hits, self.trials)

    def as_dict(self) -> dict[str, Any]:
        """Return what ``verify.json`` holds of it."""
        interval = None if self.interval is None else list(self.interval)
        return {"trials": self.trials, "hits": self.hits, "interval": interval}


@dataclass(frozen=True)
class Figures:
    """What the ideal run and the trials measured.

    Attributes
    ----------
    robots : int
        How many the script drives.
    steps : int
        Of the ideal run.
    run_seconds : float
        Length of the ideal run, without the drive to the initial conditions.
    drive : DriveTime
        Predicted for the drive to the initial conditions.
    loop : LoopTimes, optional
        How long the script takes from one step to the next.
    largest_wheel_speed : float
        The fastest wheel that any run asks for beyond the limit, rad/s.
    saturated_steps : Most
        Steps in which a wheel was asked for more than it can.
    gap, wall_gap : Smallest
        Between two centres, and between a centre and a wall.
    collisions, outside : Hits, optional
        Trials with a collision, and with a robot outside; None where no trial stepped.
    """

    robots: int
    steps: int
    run_seconds: float
    drive: DriveTime
    loop: LoopTimes | None
    largest_wheel_speed: float
    saturated_steps: Most
    gap: Smallest
    wall_gap: Smallest
    collisions: Hits | None
    outside: Hits | None

    @property
    def recommended_duration(self) -> float:
        """Seconds to declare."""
        return recommended_duration(self.run_seconds, self.drive)

    def as_dict(self) -> dict[str, Any]:
        """Return what ``verify.json`` holds; docs/how-to/verify.md describes it."""
        loop = self.loop
        out: dict[str, Any] = {
            "robots": self.robots,
            "steps": self.steps,
            "run_seconds": self.run_seconds,
            "initial_drive_seconds": self.drive.as_dict(),
            "predicted_seconds": self.run_seconds + self.drive.median,
            "recommended_duration": self.recommended_duration,
            "loop_milliseconds": {}
            if loop is None
            else {"p50": 1000 * loop.p50, "p99": 1000 * loop.p99, "max": 1000 * loop.longest},
            "largest_wheel_speed": self.largest_wheel_speed,
            "saturated_steps": {"ideal": self.saturated_steps.ideal},
            "smallest_gap": {"ideal": self.gap.ideal},
            "smallest_wall_gap": {"ideal": self.wall_gap.ideal},
        }
        if self.collisions is not None and self.outside is not None:
            out["saturated_steps"]["trials"] = self.saturated_steps.trials
            out["smallest_gap"]["trials"] = self.gap.trials
            out["smallest_wall_gap"]["trials"] = self.wall_gap.trials
            out["collision_runs"] = self.collisions.as_dict()
            out["boundary_runs"] = self.outside.as_dict()
        return out


def figures_of(ideal: Outcome, trials: Sequence[Outcome], drive: DriveTime) -> Figures | None:
    """Return the figures of an ideal run and its trials; None where the ideal run never stepped.

    Parameters
    ----------
    ideal : Outcome
        Of the run without imperfections.
    trials : sequence of Outcome
        Of the runs with imperfections; those that never stepped are left out.
    drive : DriveTime
        Predicted for the drive to the initial conditions.
    """
    report = ideal.report
    if not ideal.steps or report is None or ideal.clock is None:
        return None
    ran = [outcome for outcome in trials if outcome.steps]
    return Figures(
        robots=report.number_of_robots,
        steps=ideal.steps,
        run_seconds=ideal.clock,
        drive=drive,
        loop=ideal.loop,
        largest_wheel_speed=max(map(largest_wheel_speed, (ideal, *ran))),
        saturated_steps=Most(saturated_steps(ideal), max(map(saturated_steps, ran), default=None)),
        gap=Smallest(metres(ideal.smallest_gap), _least(o.smallest_gap for o in ran)),
        wall_gap=Smallest(metres(ideal.wall_gap), _least(o.wall_gap for o in ran)),
        collisions=_hits(ran, FaultKind.COLLISION),
        outside=_hits(ran, FaultKind.BOUNDARY),
    )


def metres(gap: Gap | None) -> float | None:
    """Return the length of a gap, m; None where it is unknown.

    Parameters
    ----------
    gap : Gap, optional
        The smallest distance that a run measured; None where it measured none.
    """
    return None if gap is None else gap.metres


def _least(gaps: Iterable[Gap | None]) -> float | None:
    return min((gap.metres for gap in gaps if gap is not None), default=None)


def _hits(ran: Sequence[Outcome], kind: FaultKind) -> Hits | None:
    return Hits(sum(bool(outcome.faults(kind)) for outcome in ran), len(ran)) if ran else None
