"""From what trials did to what that means for a submission.

Every judgement is one function from outcomes to findings. The ideal run shows what the script
itself does; the trials show how that fares under imperfections, as proportions with Wilson
intervals; two more trials are interrupted and show what is left of the data.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from posflock_robotarium.verify.endings import judge_end, judge_policy
from posflock_robotarium.verify.findings import Code, Finding, Verdict, too_many_robots
from posflock_robotarium.verify.initial_drive_time import DriveTime, predicted_drive
from posflock_robotarium.verify.interruptions import judge_data
from posflock_robotarium.verify.motion import (
    judge_boundary,
    judge_collisions,
    judge_start,
    judge_wheels,
)
from posflock_robotarium.verify.timing import judge_duration, judge_loop
from posflock_robotarium.verify.trials import Ran
from rps_compat import testbed
from rps_compat.running.outcome import Ended, Outcome


@dataclass(frozen=True)
class Runs:
    """All runs of a script.

    Attributes
    ----------
    ideal : Ran
        Without imperfections, from the exact initial conditions.
    trials : tuple of Ran
        With imperfections; none where the ideal run failed.
    drive : Outcome, optional
        In which the robots had to drive to their initial conditions first.
    interrupted, killed : Ran, optional
        Ended by KeyboardInterrupt in ``step()``, and by a kill.
    """

    ideal: Ran
    trials: tuple[Ran, ...] = ()
    drive: Outcome | None = None
    interrupted: Ran | None = None
    killed: Ran | None = None


def drive_time(runs: Runs) -> DriveTime:
    """Return how long driving to the initial conditions is predicted to take.

    Parameters
    ----------
    runs : Runs
        What was run.
    """
    report, drive = runs.ideal.outcome.report, runs.drive
    arrived = drive is not None and drive.ended is Ended.STOPPED
    robots = 1 if report is None else report.number_of_robots
    return predicted_drive(robots, drive.time if drive is not None and arrived else None)


def judge(
    runs: Runs, known: Sequence[Finding], declared: float | None = None, counted: bool = False
) -> list[Finding]:
    """Return what the runs say beyond the findings `known` from the source.

    Parameters
    ----------
    runs : Runs
        What was run.
    known : sequence of Finding
        From the source: an error that only follows from one of these is not told twice.
    declared : float, optional
        Seconds that will be declared at submission.
    counted : bool
        Whether the loop counts its steps, so that a run that goes on is long, not endless.
    """
    ideal, trials = runs.ideal.outcome, [trial.outcome for trial in runs.trials]
    found = list(judge_end(ideal, trials, known, counted))
    found += judge_policy([runs.ideal, *runs.trials], [*known, *found])
    if ideal.steps:
        found += _robots(ideal, known)
        found += judge_collisions(ideal, trials)
        found += judge_boundary(ideal, trials)
        found += judge_wheels(ideal, trials)
        found += judge_start(ideal, runs.drive, known)
        if ideal.ended is not Ended.OUT_OF_MEMORY:  # to fill memory takes time, too
            found += judge_loop([ideal, *trials], known)
        found += judge_duration(ideal, drive_time(runs), declared, counted)
        found += judge_data(runs.ideal, runs.interrupted, runs.killed, known)
    elif ideal.ended is Ended.FINISHED and not any(f.code is Code.NO_FINISHING_CALL for f in known):
        found.append(
            Finding(
                Code.NO_STEP,
                Verdict.FAIL,
                "ends without a single step() of a Robotarium",
                "call get_poses(), set_velocities() and step() in a loop",
            )
        )
    return found


def _robots(ideal: Outcome, known: Sequence[Finding]) -> Iterator[Finding]:
    """Count robots, and look for the end in order, where the source did not show them."""
    told = {finding.code for finding in known}
    robots = 0 if ideal.report is None else ideal.report.number_of_robots
    if robots > testbed.MAX_ROBOTS and Code.TOO_MANY_ROBOTS not in told:
        yield too_many_robots(robots)
    finished = ideal.ended is Ended.FINISHED
    if finished and not ideal.finishing_call and Code.NO_FINISHING_CALL not in told:
        right = "debug" if ideal.generation == 2 else "call_at_scripts_end"
        yield Finding(
            Code.NO_FINISHING_CALL,
            Verdict.RISK,
            f"ends without having called {right}() of its Robotarium, so it says nothing about"
            " its violations",
            f"end the script with r.{right}()",
        )
