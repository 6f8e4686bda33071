"""From what trials did to what that means for a submission.

Every judgement is one function from outcomes to findings.  The ideal run shows what the script
itself does; the trials show how that fares under imperfections, as proportions with Wilson
intervals; two more trials are interrupted and show what is left of the data.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from barrier_certificates import ties
from posflock_robotarium import testbed
from posflock_robotarium.verify.findings import (
    Finding,
    Verdict,
    count,
    too_many_robots,
    wilson_interval,
)
from posflock_robotarium.verify.trial import Outcome
from posflock_robotarium.verify.trials import Ran
from rps_compat.scripts import libraries
from rps_compat.scripts.deaths import REHEARSE, newer_library

#: Share of the steps that may take longer than 33 ms.
_LATE = 0.1
#: Endings of figures, which can be drawn again from data.
_PICTURES = (".png", ".jpg", ".jpeg", ".gif", ".svg", ".pdf", ".tiff", ".bmp")
_FATAL = ("crashed", "exited", "memory", "hung", "died")


def judge(
    ideal: Ran,
    trials: Sequence[Ran],
    drive: Outcome | None,
    interrupted: Ran | None,
    killed: Ran | None,
    declared: float | None,
    known: Sequence[Finding],
    counted: bool = False,
) -> list[Finding]:
    """Return what the runs say beyond the findings `known` from the source.

    Parameters
    ----------
    ideal : Ran
        Without imperfections, from the exact initial conditions.
    trials : sequence of Ran
        With imperfections.
    drive : Outcome, optional
        In which the robots had to drive to their initial conditions first.
    interrupted, killed : Ran, optional
        Ended by KeyboardInterrupt in ``step()``, and by a kill.
    declared : float, optional
        Seconds that will be declared at submission.
    known : sequence of Finding
        From the source: an error that only follows from one of these is not told twice.
    counted : bool
        Whether the loop counts its steps, so that a run that goes on is long, not endless.
    """
    runs = [ideal, *trials]
    found = [
        *_endings(ideal.outcome, [t.outcome for t in trials], known, counted),
        *_policy_violations(runs, known),
    ]
    if ideal.outcome.steps:
        found += _robots(ideal.outcome, known)
        found += _collisions(ideal.outcome, [t.outcome for t in trials])
        found += _boundary(ideal.outcome, [t.outcome for t in trials])
        found += _actuator(ideal.outcome)
        found += _start(ideal.outcome, drive, known)
        if ideal.outcome.ended != "memory":  # to fill memory takes time, too
            found += _loop(ideal.outcome, known)
        found += _duration(ideal.outcome, declared, counted)
        found += _data(ideal, interrupted, killed, known)
    elif ideal.outcome.ended == "finished" and not any(
        f.code == "no-finishing-call" for f in known
    ):
        found.append(
            Finding(
                "no-step",
                Verdict.FAIL,
                "ends without a single step() of a Robotarium",
                "call get_poses(), set_velocities() and step() in a loop",
            )
        )
    return found


def is_explained(error: dict[str, Any], known: Sequence[Finding]) -> bool:
    """Whether an error comes from a line that the source's findings already condemn."""
    lines = {(line, file) for line, file in map(tuple, error.get("lines") or [])}
    return any(
        finding.verdict is Verdict.FAIL
        and any(
            line == finding.line and (not finding.file or file == finding.file)
            for line, file in lines
        )
        for finding in known
    )


def _endings(
    ideal: Outcome, trials: Sequence[Outcome], known: Sequence[Finding], counted: bool
) -> Iterator[Finding]:
    """Tell of crashes, hangs, endless loops."""
    if ideal.ended in _FATAL:
        finding = _ending(ideal, Verdict.FAIL)
        waits = ideal.ended == "hung" and any(f.code == "blocking-call" for f in known)
        if finding and not waits and not is_explained(ideal.error, known):
            yield finding
        return
    if ideal.ended == "over-time" and not counted:
        yield Finding(
            "endless",
            Verdict.RISK,
            f"was still running after {ideal.time:.0f} s and had to be interrupted",
            "end the loop after a number of steps",
            time=ideal.time,
        )
    failed = [outcome for outcome in trials if outcome.ended in _FATAL]
    if failed:
        finding = _ending(failed[0], Verdict.RISK, (len(failed), len(trials)))
        if finding:
            yield finding


def _ending(
    outcome: Outcome, verdict: Verdict, trials: tuple[int, int] | None = None
) -> Finding | None:
    error = outcome.error
    kinds = error.get("kinds", [])
    if "ForbiddenError" in kinds:
        return None  # the violation is told of
    place: dict[str, Any] = {"line": error.get("line"), "file": error.get("file", "")}
    what = f"{error.get('type')}: {error.get('message')}".strip(": ")
    settings: dict[str, Any] = {
        **place,
        "time": outcome.time if outcome.steps else None,
        "trials": trials,
        "interval": wilson_interval(*trials) if trials else None,
    }
    if outcome.ended == "hung":
        message = f"made no step after t = {outcome.time:.1f} s and had to be killed"
        advice = "look for an endless loop, or for a wait, at this line"
        return Finding("hang", verdict, message, advice, **settings)
    if outcome.ended == "memory":
        message = f"needs more memory than the limit ({what})"
        return Finding("memory", verdict, message, "use smaller arrays", **settings)
    if outcome.ended == "exited":
        message = f"ends with exit code {error.get('message') or 'not 0'}"
        return Finding("exit-code", verdict, message, "let it end with 0", **settings)
    if "InitialConditionsError" in kinds:
        advice = "place the robots inside the arena, at least 0.15 m apart"
        return Finding("unreachable-start", verdict, what, advice, **settings)
    if "WrongGenerationError" in kinds:
        return Finding("generation", verdict, what, "use the name it gives", **settings)
    module = error.get("module") or "."
    if libraries.is_available(module):  # that is, only this machine lacks it
        distribution = libraries.IMPORT_NAMES.get(module)
        return Finding(
            "internal",
            Verdict.RISK,
            f"could not be run: the testbed has {module}, but the Python that verifies has not",
            f"`pip install {distribution}` and verify again"
            if distribution
            else "verify again under Python 3.10",
            **settings,
        )
    missing = error.get("missing", "")
    if missing:
        ending = not missing.lower().endswith(tuple(testbed.ENDINGS))
        return Finding(
            "file-ending" if ending else "file-missing",
            verdict,
            f"reads {missing}, which "
            + ("has an ending that cannot be uploaded" if ending else "is not beside the script"),
            f"use one of {' '.join(testbed.ENDINGS)}" if ending else "put it beside the script",
            **settings,
        )
    newer = newer_library(str(error.get("type")), str(error.get("message")))
    if newer:  # that is, only this machine refuses it
        return Finding("internal", Verdict.RISK, f"could not be run: {newer}", REHEARSE, **settings)
    if outcome.ended == "died":
        return Finding("crash", verdict, what, "look at the end of its output", **settings)
    return Finding("crash", verdict, f"ends with {what}", "mend this line", **settings)


def _robots(ideal: Outcome, known: Sequence[Finding]) -> Iterator[Finding]:
    """Count robots, and look for the end in order, where the source did not show them."""
    told = {finding.code for finding in known}
    if ideal.robots > testbed.MAX_ROBOTS and "too-many-robots" not in told:
        yield too_many_robots(ideal.robots)
    if ideal.ended == "finished" and not ideal.finishing_call and "no-finishing-call" not in told:
        right = "debug" if ideal.generation == 2 else "call_at_scripts_end"
        yield Finding(
            "no-finishing-call",
            Verdict.RISK,
            f"ends without having called {right}() of its Robotarium, so it says nothing about"
            " its violations",
            f"end the script with r.{right}()",
        )


def _policy_violations(runs: Sequence[Ran], known: Sequence[Finding]) -> Iterator[Finding]:
    """Tell of writing elsewhere, of other processes, of the network, of questions."""
    advice = {
        "outside-write": "write into the working folder: only those files come back",
        "fork": "do the work in one process",
        "network": "upload what it needs as files",
        "blocking-call": "remove it",
    }
    told = {finding.code for finding in known}
    words = {
        "outside-write": "writes outside its own folder",
        "fork": "starts or ends other processes",
        "network": "uses the network",
        "blocking-call": "waits for somebody, and on the testbed nobody is there",
    }
    for run in runs:
        for violation in run.outcome.policy_violations:
            kind = violation["kind"]
            if kind in told:
                continue
            told.add(kind)
            yield Finding(
                kind,
                Verdict.RISK if kind == "network" else Verdict.FAIL,
                f"{words[kind]} ({violation['what'][:120]})"
                + ("; it was stopped" if kind != "blocking-call" else ""),
                advice[kind],
                line=violation["line"],
                file=violation["file"],
                time=violation["time"] or None,
            )


def _collisions(ideal: Outcome, trials: Sequence[Outcome]) -> Iterator[Finding]:
    advice = (
        "keep centres at least 0.15 m apart: use a barrier certificate, with a larger safety radius"
    )
    first = _first(ideal, "collision")
    if first and _starts_in_collision(ideal):
        return  # told of as a start
    if first:
        yield Finding(
            "collision",
            Verdict.FAIL,
            f"robots come within {100 * first['worst']:.1f} cm of each other in the ideal"
            " simulator: the testbed's collision detector ends the run",
            advice,
            time=first["time"],
            robots=first["robots"],
            figure=first["worst"],
            unit="m between collision points",
        )
        return
    yield from _proportion("collision", trials, advice, "robots collide", "collision")


def _boundary(ideal: Outcome, trials: Sequence[Outcome]) -> Iterator[Finding]:
    advice = "keep robots inside: use a certificate with boundary, or smaller goals"
    first = _first(ideal, "boundary")
    if first:
        many = ideal.outside_steps > testbed.TOLERATED_VIOLATIONS
        yield Finding(
            "boundary",
            Verdict.FAIL if many else Verdict.RISK,
            f"robots are outside the arena at the start of {count(ideal.outside_steps, 'step')}",
            advice,
            time=first["time"],
            robots=first["robots"],
            figure=first["worst"],
            unit="m outside",
        )
        return
    yield from _proportion("boundary", trials, advice, "robots leave the arena", "boundary")


def _proportion(
    code: str, trials: Sequence[Outcome], advice: str, words: str, kind: str
) -> Iterator[Finding]:
    """Tell of a fault that imperfections bring out."""
    ran = [outcome for outcome in trials if outcome.steps]
    hit = [(outcome, first) for outcome in ran if (first := _first(outcome, kind))]
    if not hit:
        return
    low, high = wilson_interval(len(hit), len(ran))
    outcome, first = hit[0]
    yield Finding(
        code,
        Verdict.FAIL if low >= 0.2 else Verdict.RISK,
        f"{words} in {len(hit)} of {count(len(ran), 'trial')} with imperfections"
        f" ({100 * low:.0f} to {100 * high:.0f} % of runs), though not in the ideal simulator;"
        f" first in the trial with seed {outcome.seed}",
        advice,
        time=first["time"],
        robots=first["robots"],
        figure=first["worst"],
        unit="m",
        trials=(len(hit), len(ran)),
        interval=(low, high),
    )


def _actuator(ideal: Outcome) -> Iterator[Finding]:
    first = _first(ideal, "actuator")
    if not first:
        return
    limit = 12.5
    many = ideal.actuator_steps > testbed.TOLERATED_VIOLATIONS
    yield Finding(
        "actuator",
        Verdict.RISK if many else Verdict.NOTE,
        f"asks a wheel for more than {limit} rad/s in {count(ideal.actuator_steps, 'step')}, up"
        f" to {ideal.largest_wheel:.1f}: the motors cut that, and robots drive another curve",
        "scale commands down before set_velocities: 0.2 m/s straight is the limit, less in a turn",
        time=first["time"],
        robots=first["robots"],
        figure=ideal.largest_wheel,
        unit="rad/s",
    )


def _start(ideal: Outcome, drive: Outcome | None, known: Sequence[Finding]) -> Iterator[Finding]:
    gap = ideal.initial_gap
    colliding = _starts_in_collision(ideal)
    close = bool(gap) and ties.short_of(gap["metres"], testbed.SPACING)
    if close:
        yield Finding(
            "close-start",
            Verdict.FAIL if colliding else Verdict.RISK,
            f"initial conditions place two robots {100 * gap['metres']:.1f} cm apart"
            + (": they begin in a collision, and cannot be driven there" if colliding else ""),
            f"keep centres at least {testbed.SPACING} m apart",
            time=0.0,
            robots=tuple(gap["robots"]),
            figure=gap["metres"],
            unit="m",
        )
    # Whether robots get to places so close takes minutes of pushing, and hangs on its last bits.
    if close or colliding:
        return
    if drive is not None and drive.ended == "crashed" and not is_explained(drive.error, known):
        yield Finding(
            "unreachable-start",
            Verdict.RISK,
            f"robots do not reach their initial conditions: {drive.error.get('message')}",
            "place them farther from walls and from each other",
            line=drive.error.get("line"),
            file=drive.error.get("file", ""),
        )


def _starts_in_collision(ideal: Outcome) -> bool:
    """Whether the initial conditions themselves are the first collision."""
    first = _first(ideal, "collision")
    gap = ideal.initial_gap.get("metres", testbed.SPACING)
    return first is not None and first["time"] == 0.0 and ties.short_of(gap, testbed.SPACING)


def _loop(ideal: Outcome, known: Sequence[Finding]) -> Iterator[Finding]:
    loop = ideal.loop
    # A sleep that the source shows is not told twice; what the loop takes besides is.
    slept = [f.figure or 0.0 for f in known if f.code in ("slow-sleep", "watchdog")]
    asleep = max(slept, default=0.0)
    if loop and loop["late"] > _LATE and not (slept and loop["p99"] - asleep <= testbed.TIME_STEP):
        yield Finding(
            "slow-loop",
            Verdict.RISK,
            f"its loop takes {1000 * loop['p50']:.0f} ms of computing and sleeping at the median"
            f" ({1000 * loop['p99']:.0f} ms at the 99th percentile), and more than 33 ms in"
            f" {100 * loop['late']:.0f} % of the steps: step() can be called every"
            " 33 ms only if it takes less, so commands come late and the run stretches",
            "compute less in a loop, or hold a command for several steps",
            figure=1000 * loop["p99"],
            unit="ms",
        )
    if loop and loop["max"] - asleep >= testbed.WATCHDOG:
        yield Finding(
            "watchdog",
            Verdict.RISK,
            f"one loop takes {loop['max']:.2f} s: robots brake after {testbed.WATCHDOG} s without"
            " a command",
            "do long computations before the loop",
            time=loop["at"],
            figure=loop["max"],
            unit="s",
        )
    elif ties.reached(ideal.silent.get("seconds", 0.0), testbed.WATCHDOG):
        yield Finding(
            "watchdog",
            Verdict.RISK,
            f"lets robots drive for {ideal.silent['seconds']:.1f} s on one command: they brake"
            f" after {testbed.WATCHDOG} s without a new one, which the simulator does not show",
            "call set_velocities() before every step()",
            time=ideal.silent["at"],
            figure=ideal.silent["seconds"],
            unit="s",
        )


def _duration(ideal: Outcome, declared: float | None, counted: bool) -> Iterator[Finding]:
    least, median, most = testbed.INITIAL_DRIVE
    allowed = min(declared or testbed.MAX_DURATION, testbed.MAX_DURATION)
    of = f"the {allowed:.0f} s that {'are declared' if declared else 'any experiment has'}"
    run = ideal.clock
    if ideal.ended == "over-time":
        if counted:
            yield Finding(
                "duration",
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
        "duration",
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
    """Return the duration to declare for a run of so many seconds: the slowest drive fits."""
    tens = -ties.whole(-(run + testbed.INITIAL_DRIVE[2]) / 10)
    return float(min(testbed.MAX_DURATION, 10 * tens))


def _data(
    ideal: Ran, interrupted: Ran | None, killed: Ran | None, known: Sequence[Finding]
) -> Iterator[Finding]:
    """Tell what is left of the data when a run is ended from outside."""
    written = [name for name, content in ideal.data.items() if content.readable]
    if not written or interrupted is None or not interrupted.outcome.steps:
        return
    if interrupted.outcome.ended == "hung":
        yield Finding(
            "hang",
            Verdict.RISK,
            "goes on after the KeyboardInterrupt in step(), without stepping",
            "let the interrupt end the loop",
            time=interrupted.outcome.time,
        )
    kept = _kept(ideal, interrupted)
    lost = [name for name in written if name not in kept]
    t = interrupted.outcome.time
    # Files that half a run leaves as a whole one does hold none of its data.
    recorded = [n for n in kept if ideal.data[n].digest != interrupted.data[n].digest]
    if not kept or (not recorded and any(not n.lower().endswith(_PICTURES) for n in lost)):
        if not any(finding.code == "save-at-end" for finding in known):
            yield Finding(
                "data-lost",
                Verdict.RISK,
                f"interrupted at t = {t:.0f} s, it left nothing of {', '.join(lost)}",
                "write during the loop, or in `try: … finally:` around it",
                time=t,
                figure=float(len(lost)),
                unit="files lost",
            )
        return
    if killed is not None and killed.outcome.steps and not _kept(ideal, killed):
        yield Finding(
            "data-lost",
            Verdict.NOTE,
            f"a KeyboardInterrupt leaves {', '.join(kept)}, but a kill leaves nothing",
            "write row by row during the loop (numpy.lib.format.open_memmap, or PoseLog)",
            time=killed.outcome.time,
            figure=float(len(written)),
            unit="files lost",
        )
    elif lost:
        yield Finding(
            "data-lost",
            Verdict.NOTE,
            f"interrupted at t = {t:.0f} s, it left {', '.join(kept)}, and not {', '.join(lost)}",
            "",
            time=t,
            figure=float(len(lost)),
            unit="files lost",
        )


def _kept(ideal: Ran, ended: Ran) -> list[str]:
    return [
        name
        for name, content in ideal.data.items()
        if content.readable and name in ended.data and ended.data[name].readable
    ]


def _first(outcome: Outcome, kind: str) -> dict[str, Any] | None:
    """Return when and with whom a kind of fault began, and its worst value."""
    events = [event for event in outcome.events if event[0] == kind]
    if not events:
        return None
    _, robots, first, _, _ = events[0]
    pick = min if kind == "collision" else max
    return {
        "time": first * outcome.time_step,
        "robots": tuple(robots),
        "worst": pick(event[4] for event in events),
    }
