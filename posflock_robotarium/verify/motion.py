"""Where robots went: collisions, walls, wheels and the start, from outcomes to findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from barrier_certificates import ties
from posflock_robotarium.alignment.intervals import told_interval, wilson_interval
from posflock_robotarium.verify.endings import is_explained
from posflock_robotarium.verify.findings import (
    Code,
    Finding,
    Verdict,
    count,
    interval_text,
)
from rps_compat import testbed
from rps_compat.running.outcome import Ended, Outcome
from rps_compat.violations import FaultKind


def judge_collisions(ideal: Outcome, trials: Sequence[Outcome]) -> Iterator[Finding]:
    """Tell of robots that come too close.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    trials : sequence of Outcome
        The runs with imperfections.
    """
    advice = (
        "keep centres at least 0.15 m apart: use a barrier certificate, with a larger safety radius"
    )
    first = _first(ideal, FaultKind.COLLISION)
    if first and _starts_in_collision(ideal):
        return  # told of as a start
    if first:
        yield Finding(
            Code.COLLISION,
            Verdict.FAIL,
            f"robots come within {100 * first.worst:.1f} cm of each other in the ideal"
            " simulator: the testbed's collision detector ends the run",
            advice,
            time=first.time,
            robots=first.robots,
            figure=first.worst,
            unit="m between collision points",
        )
        return
    yield from _proportion(FaultKind.COLLISION, trials, advice, "robots collide")


def judge_boundary(ideal: Outcome, trials: Sequence[Outcome]) -> Iterator[Finding]:
    """Tell of robots outside the arena.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    trials : sequence of Outcome
        The runs with imperfections.
    """
    advice = "keep robots inside: use a certificate with boundary, or smaller goals"
    first, report = _first(ideal, FaultKind.BOUNDARY), ideal.report
    if first and report:
        many = report.steps_outside > testbed.TOLERATED_VIOLATIONS
        yield Finding(
            Code.BOUNDARY,
            Verdict.FAIL if many else Verdict.RISK,
            f"robots are outside the arena at the start of {count(report.steps_outside, 'step')}",
            advice,
            time=first.time,
            robots=first.robots,
            figure=first.worst,
            unit="m outside",
        )
        return
    yield from _proportion(FaultKind.BOUNDARY, trials, advice, "robots leave the arena")


def _proportion(
    kind: FaultKind, trials: Sequence[Outcome], advice: str, words: str
) -> Iterator[Finding]:
    """Tell of a fault that imperfections bring out."""
    ran = [outcome for outcome in trials if outcome.steps]
    hit = [(outcome, first) for outcome in ran if (first := _first(outcome, kind))]
    if not hit:
        return
    low, _ = wilson_interval(len(hit), len(ran))
    told = told_interval(len(hit), len(ran))
    share = "" if told is None else f" ({interval_text(told)} of runs)"
    outcome, first = hit[0]
    yield Finding(
        Code(kind.value),
        Verdict.FAIL if low >= 0.2 else Verdict.RISK,
        f"{words} in {len(hit)} of {count(len(ran), 'trial')} with imperfections"
        f"{share}, though not in the ideal simulator;"
        f" first in the trial with seed {outcome.seed}",
        f"{advice}; `posflock verify --effect each` finds the imperfection that does it",
        time=first.time,
        robots=first.robots,
        figure=first.worst,
        unit="m",
        trials=(len(hit), len(ran)),
        interval=told,
    )


def judge_wheels(ideal: Outcome, trials: Sequence[Outcome]) -> Iterator[Finding]:
    """Tell of commands beyond the wheels' limit, in the run that asks for most.

    A controller that acts on late and noisy poses asks for more than in the ideal simulator.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    trials : sequence of Outcome
        The runs with imperfections.
    """
    over = [(saturated_steps(outcome), outcome) for outcome in (ideal, *trials)]
    steps, worst = max(over, key=lambda pair: pair[0])
    first = _first(worst, FaultKind.ACTUATOR)
    if first is None:
        return
    limit, most = testbed.GTERNAL.max_wheel_velocity, max(largest_wheel_speed(o) for _, o in over)
    many = steps > testbed.TOLERATED_VIOLATIONS
    where = "" if worst is ideal else f" in the trial with seed {worst.seed}"
    beside = "" if worst is ideal else f", {over[0][0]} in the ideal run"
    yield Finding(
        Code.ACTUATOR,
        Verdict.RISK if many else Verdict.NOTE,
        f"asks a wheel for more than {limit} rad/s in {count(steps, 'step')}{where}{beside}, up"
        f" to {most:.1f}: the motors cut that, and robots drive another curve",
        "scale commands down before set_velocities: 0.2 m/s straight is the limit, less in a turn",
        time=first.time,
        robots=first.robots,
        figure=most,
        unit="rad/s",
    )


def saturated_steps(outcome: Outcome) -> int:
    """Return in how many steps of a run a wheel was asked for more than it can.

    Parameters
    ----------
    outcome : Outcome
        The run; one without a report counts as none.
    """
    return 0 if outcome.report is None else outcome.report.steps_over_actuator_limits


def largest_wheel_speed(outcome: Outcome) -> float:
    """Return the fastest wheel that a run asked for beyond the limit, rad/s; 0 if none.

    Parameters
    ----------
    outcome : Outcome
        The run; one without a report counts as none.
    """
    return 0.0 if outcome.report is None else outcome.report.largest_wheel_velocity


def judge_start(
    ideal: Outcome, drive: Outcome | None, known: Sequence[Finding]
) -> Iterator[Finding]:
    """Tell of initial conditions that are too close, or that robots do not reach.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    drive : Outcome or None
        A run that only drives to its initial conditions; None where there was none.
    known : sequence of Finding
        What the source has told already.
    """
    gap = ideal.initial_gap
    colliding = _starts_in_collision(ideal)
    close = gap is not None and ties.short_of(gap.metres, testbed.SPACING)
    if gap is not None and close:
        yield Finding(
            Code.CLOSE_START,
            Verdict.FAIL if colliding else Verdict.RISK,
            f"initial conditions place two robots {100 * gap.metres:.1f} cm apart"
            + (": they begin in a collision, and cannot be driven there" if colliding else ""),
            f"keep centres at least {testbed.SPACING} m apart",
            time=0.0,
            robots=gap.robots,
            figure=gap.metres,
            unit="m",
        )
    # Whether robots get to places so close takes minutes of pushing, and hangs on its last bits.
    if close or colliding:
        return
    error = None if drive is None or drive.ended is not Ended.FAILED else drive.error
    if error is not None and error.type != "SystemExit" and not is_explained(error, known):
        yield Finding(
            Code.UNREACHABLE_START,
            Verdict.RISK,
            f"robots do not reach their initial conditions: {error.message}",
            "place them farther from walls and from each other",
            line=error.line,
            file=error.file,
        )


def _starts_in_collision(ideal: Outcome) -> bool:
    """Whether the initial conditions themselves are the first collision."""
    first = _first(ideal, FaultKind.COLLISION)
    gap = testbed.SPACING if ideal.initial_gap is None else ideal.initial_gap.metres
    return first is not None and first.time == 0.0 and ties.short_of(gap, testbed.SPACING)


@dataclass(frozen=True)
class _First:
    """When and with whom a kind of fault began, and its worst value in the run."""

    time: float
    robots: tuple[int, ...]
    worst: float


def _first(outcome: Outcome, kind: FaultKind) -> _First | None:
    faults = outcome.faults(kind)
    if not faults:
        return None
    pick = min if kind is FaultKind.COLLISION else max
    return _First(faults[0].start, faults[0].robots, pick(fault.worst for fault in faults))
