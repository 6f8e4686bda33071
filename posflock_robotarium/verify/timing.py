"""Whether the loop is fast enough and the run fits its duration: from outcomes to findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median

from barrier_certificates import ties
from posflock_robotarium.verify.findings import Code, Finding, Verdict
from posflock_robotarium.verify.initial_drive_time import DriveTime
from rps_compat import testbed
from rps_compat.running.outcome import Ended, Outcome

#: Share of the steps that may take longer than 33 ms.
_LATE = 0.1


def judge_loop(runs: Sequence[Outcome], known: Sequence[Finding]) -> Iterator[Finding]:
    """Tell of loops that take too long, and of robots that have no new command for too long.

    Parameters
    ----------
    runs : sequence of Outcome
        The ideal run and those with imperfections, in which a controller may compute for longer.
    known : sequence of Finding
        What the source has told already.
    """
    # A sleep that the source shows is not told twice; what the loop takes besides is.
    slept = [f.figure or 0.0 for f in known if f.code in (Code.SLOW_SLEEP, Code.WATCHDOG)]
    yield from _slow_loop(runs, slept)
    yield from _stall(runs, max(slept, default=0.0))


def _slow_loop(runs: Sequence[Outcome], slept: Sequence[float]) -> Iterator[Finding]:
    """Tell of a loop that is often late: the median over runs, so that no busy moment decides."""
    loops = [outcome.loop for outcome in runs if outcome.loop is not None]
    if not loops:
        return
    p50, p99, late = (
        median(getattr(loop, name) for loop in loops) for name in ("p50", "p99", "late")
    )
    told = bool(slept) and p99 - max(slept) <= testbed.TIME_STEP
    if late > _LATE and not told:
        yield Finding(
            Code.SLOW_LOOP,
            Verdict.RISK,
            f"its loop takes {1000 * p50:.0f} ms of computing and sleeping at the median"
            f" ({1000 * p99:.0f} ms at the 99th percentile), and more than 33 ms in"
            f" {100 * late:.0f} % of the steps: step() can be called every"
            " 33 ms only if it takes less, so commands come late and the run stretches",
            "compute less in a loop, or hold a command for several steps",
            figure=1000 * p99,
            unit="ms",
        )


def _stall(runs: Sequence[Outcome], asleep: float) -> Iterator[Finding]:
    """Tell of the longest time, in any run, in which robots have no new command."""
    longest = max(
        (outcome.loop for outcome in runs if outcome.loop is not None),
        key=lambda loop: loop.longest,
        default=None,
    )
    silence = max(
        (outcome.silence for outcome in runs if outcome.silence is not None),
        key=lambda silence: silence.seconds,
        default=None,
    )
    if longest and longest.longest - asleep >= testbed.WATCHDOG:
        yield Finding(
            Code.WATCHDOG,
            Verdict.RISK,
            f"one loop takes {longest.longest:.2f} s: robots brake after {testbed.WATCHDOG} s"
            " without a command",
            "do long computations before the loop",
            time=longest.at,
            figure=longest.longest,
            unit="s",
        )
    elif silence and ties.reached(silence.seconds, testbed.WATCHDOG):
        yield Finding(
            Code.WATCHDOG,
            Verdict.RISK,
            f"lets robots drive for {silence.seconds:.1f} s on one command: they brake"
            f" after {testbed.WATCHDOG} s without a new one, which the simulator does not show",
            "call set_velocities() before every step()",
            time=silence.at,
            figure=silence.seconds,
            unit="s",
        )


def judge_duration(
    ideal: Outcome, drive: DriveTime, declared: float | None, counted: bool
) -> Iterator[Finding]:
    """Tell of a run that does not fit its duration.

    Whether the testbed charges the drive to the start is not known: a published run of 60 s, with
    60 s declared, took 65 s from the start on and counted as completed, so either the drive is not
    charged or there is a margin. A run that fits by itself is no certain failure, therefore.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    drive : DriveTime
        How long driving to the initial conditions is predicted to take.
    declared : float or None
        Duration that will be declared, s; None where it is not known.
    counted : bool
        Whether the source shows that the script counts its steps.
    """
    allowed = min(declared or testbed.MAX_DURATION, testbed.MAX_DURATION)
    of = f"the {allowed:.0f} s that {'are declared' if declared else 'any experiment has'}"
    run = ideal.clock
    if run is None:
        return
    shorter = "declare more, or take fewer steps" if declared else "take fewer steps"
    if ideal.ended is Ended.OVER_TIME:
        if counted:
            yield Finding(
                Code.DURATION,
                Verdict.FAIL,
                f"has steps left after {run:.0f} s, without the drive to the initial conditions:"
                f" it does not fit {of}",
                shorter,
                time=run,
                figure=run + drive.median,
                unit="s",
            )
        return
    if ties.within(run + drive.most, allowed):
        return
    fits = ties.within(run, allowed + testbed.TIME_STEP)
    yield Finding(
        Code.DURATION,
        Verdict.RISK if fits else Verdict.FAIL,
        f"takes {run:.0f} s: it fits {of} except for the drive to the initial conditions, which is"
        f" predicted to take {drive} before it; whether that counts is not known"
        if fits
        else f"takes {run:.0f} s: it does not fit {of}, even without the drive to the initial"
        " conditions",
        f"declare {recommended_duration(run, drive):.0f} s"
        if declared and ties.within(run + drive.most, testbed.MAX_DURATION)
        else "shorten it",
        time=run,
        figure=run + drive.median,
        unit="s",
    )


def recommended_duration(run: float, drive: DriveTime) -> float:
    """Return the duration to declare, s: the run, with the slowest drive to the start predicted.

    Parameters
    ----------
    run : float
        How long the run itself takes, s.
    drive : DriveTime
        How long driving to the initial conditions is predicted to take.
    """
    tens = -ties.whole(-(run + drive.most) / 10)
    return float(min(testbed.MAX_DURATION, 10 * tens))
