"""Whether the loop is fast enough and the run fits its duration: from outcomes to findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from barrier_certificates import ties
from posflock_robotarium.verify.findings import Code, Finding, Verdict
from rps_compat import testbed
from rps_compat.running.outcome import Ended, Outcome

#: Share of the steps that may take longer than 33 ms.
_LATE = 0.1


def judge_loop(ideal: Outcome, known: Sequence[Finding]) -> Iterator[Finding]:
    """Tell of loops that take too long, and of robots that have no new command for too long.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    known : sequence of Finding
        What the source has told already.
    """
    loop = ideal.loop
    # A sleep that the source shows is not told twice; what the loop takes besides is.
    slept = [f.figure or 0.0 for f in known if f.code in (Code.SLOW_SLEEP, Code.WATCHDOG)]
    asleep = max(slept, default=0.0)
    told = bool(slept) and loop is not None and loop.p99 - asleep <= testbed.TIME_STEP
    if loop and loop.late > _LATE and not told:
        yield Finding(
            Code.SLOW_LOOP,
            Verdict.RISK,
            f"its loop takes {1000 * loop.p50:.0f} ms of computing and sleeping at the median"
            f" ({1000 * loop.p99:.0f} ms at the 99th percentile), and more than 33 ms in"
            f" {100 * loop.late:.0f} % of the steps: step() can be called every"
            " 33 ms only if it takes less, so commands come late and the run stretches",
            "compute less in a loop, or hold a command for several steps",
            figure=1000 * loop.p99,
            unit="ms",
        )
    if loop and loop.longest - asleep >= testbed.WATCHDOG:
        yield Finding(
            Code.WATCHDOG,
            Verdict.RISK,
            f"one loop takes {loop.longest:.2f} s: robots brake after {testbed.WATCHDOG} s without"
            " a command",
            "do long computations before the loop",
            time=loop.at,
            figure=loop.longest,
            unit="s",
        )
    elif ideal.silence and ties.reached(ideal.silence.seconds, testbed.WATCHDOG):
        yield Finding(
            Code.WATCHDOG,
            Verdict.RISK,
            f"lets robots drive for {ideal.silence.seconds:.1f} s on one command: they brake"
            f" after {testbed.WATCHDOG} s without a new one, which the simulator does not show",
            "call set_velocities() before every step()",
            time=ideal.silence.at,
            figure=ideal.silence.seconds,
            unit="s",
        )


def judge_duration(ideal: Outcome, declared: float | None, counted: bool) -> Iterator[Finding]:
    """Tell of a run that does not fit its duration.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    declared : float or None
        Duration that will be declared, s; None where it is not known.
    counted : bool
        Whether the source shows that the script counts its steps.
    """
    least, median, most = testbed.INITIAL_DRIVE
    allowed = min(declared or testbed.MAX_DURATION, testbed.MAX_DURATION)
    of = f"the {allowed:.0f} s that {'are declared' if declared else 'any experiment has'}"
    run = ideal.clock
    if run is None:
        return
    if ideal.ended is Ended.OVER_TIME:
        if counted:
            yield Finding(
                Code.DURATION,
                Verdict.FAIL,
                f"has steps left after {run:.0f} s, without the drive to the initial conditions:"
                f" it does not fit {of}",
                "declare more, or take fewer steps" if declared else "take fewer steps",
                time=run,
                figure=run + median,
                unit="s",
            )
        return
    if ties.within(run + most, allowed):
        return
    certain = ties.beyond(run + least, allowed)
    yield Finding(
        Code.DURATION,
        Verdict.FAIL if certain else Verdict.RISK,
        f"takes {run:.0f} s, and driving to the initial conditions before it took {least:.0f} to"
        f" {most:.0f} s (median {median:.0f}) in published runs: {run + median:.0f} s of {of}",
        f"declare {recommended_duration(run):.0f} s"
        if declared and ties.within(run + most, testbed.MAX_DURATION)
        else "shorten it",
        time=run,
        figure=run + median,
        unit="s",
    )


def recommended_duration(run: float) -> float:
    """Return the duration to declare, s: the slowest drive to the start fits.

    Parameters
    ----------
    run : float
        How long the run itself takes, s.
    """
    tens = -ties.whole(-(run + testbed.INITIAL_DRIVE[2]) / 10)
    return float(min(testbed.MAX_DURATION, 10 * tens))
