"""How runs ended, and what policy they violated: from outcomes to findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from posflock_robotarium.verify.findings import Finding, Verdict, wilson_interval
from posflock_robotarium.verify.trials import Ran
from rps_compat import testbed
from rps_compat.running.outcome import Ended, Failure, Outcome
from rps_compat.scripts import libraries
from rps_compat.scripts.deaths import REHEARSE, newer_library

#: Ends that no experiment should have.
FATAL = (Ended.FAILED, Ended.OUT_OF_MEMORY, Ended.HUNG, Ended.DIED)


def is_explained(error: Failure | None, known: Sequence[Finding]) -> bool:
    """Whether an error comes from a line that the source's findings already condemn.

    Parameters
    ----------
    error : Failure or None
        The error that ended a run.
    known : sequence of Finding
        What the source has told already.
    """
    lines = set() if error is None else set(error.lines)
    return any(
        finding.verdict is Verdict.FAIL
        and any(
            line == finding.line and (not finding.file or file == finding.file)
            for line, file in lines
        )
        for finding in known
    )


def judge_end(
    ideal: Outcome, trials: Sequence[Outcome], known: Sequence[Finding], counted: bool
) -> Iterator[Finding]:
    """Tell of crashes, hangs, endless loops.

    Parameters
    ----------
    ideal : Outcome
        The ideal run.
    trials : sequence of Outcome
        The runs with imperfections.
    known : sequence of Finding
        What the source has told already.
    counted : bool
        Whether the source shows that the script counts its steps.
    """
    if ideal.ended in FATAL:
        finding = _ending(ideal, Verdict.FAIL)
        waits = ideal.ended is Ended.HUNG and any(f.code == "blocking-call" for f in known)
        if finding and not waits and not is_explained(ideal.error, known):
            yield finding
        return
    if ideal.ended is Ended.OVER_TIME and not counted:
        yield Finding(
            "endless",
            Verdict.RISK,
            f"was still running after {ideal.time or 0.0:.0f} s and had to be interrupted",
            "end the loop after a number of steps",
            time=ideal.time,
        )
    failed = [outcome for outcome in trials if outcome.ended in FATAL]
    if failed:
        finding = _ending(failed[0], Verdict.RISK, (len(failed), len(trials)))
        if finding:
            yield finding


def _ending(
    outcome: Outcome, verdict: Verdict, trials: tuple[int, int] | None = None
) -> Finding | None:
    error = outcome.error or Failure()
    if "ForbiddenError" in error.kinds:
        return None  # the violation is told of
    what = str(error)
    settings: dict[str, Any] = {
        "line": error.line,
        "file": error.file,
        "time": outcome.time if outcome.steps else None,
        "trials": trials,
        "interval": wilson_interval(*trials) if trials else None,
    }
    if outcome.ended is Ended.HUNG:
        message = f"made no step after t = {outcome.time or 0.0:.1f} s and had to be killed"
        advice = "look for an endless loop, or for a wait, at this line"
        return Finding("hang", verdict, message, advice, **settings)
    if outcome.ended is Ended.OUT_OF_MEMORY:
        message = f"needs more memory than the limit ({what})"
        return Finding("memory", verdict, message, "use smaller arrays", **settings)
    if outcome.left_with_code:
        message = f"ends with exit code {error.message or 'not 0'}"
        return Finding("exit-code", verdict, message, "let it end with 0", **settings)
    if "InitialConditionsError" in error.kinds:
        advice = "place the robots inside the arena, at least 0.15 m apart"
        return Finding("unreachable-start", verdict, what, advice, **settings)
    if "WrongGenerationError" in error.kinds:
        return Finding("generation", verdict, what, "use the name it gives", **settings)
    return _failed(outcome, error, verdict, settings)


def _failed(
    outcome: Outcome, error: Failure, verdict: Verdict, settings: dict[str, Any]
) -> Finding:
    """Tell of an exception, or of a process that died."""
    what = str(error)
    module = error.module or "."
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
    missing = error.missing
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
    newer = newer_library(error.type, error.message)
    if newer:  # that is, only this machine refuses it
        return Finding("internal", Verdict.RISK, f"could not be run: {newer}", REHEARSE, **settings)
    if outcome.ended is Ended.DIED:
        return Finding("crash", verdict, what, "look at the end of its output", **settings)
    return Finding("crash", verdict, f"ends with {what}", "mend this line", **settings)


def judge_policy(runs: Sequence[Ran], known: Sequence[Finding]) -> Iterator[Finding]:
    """Tell of writing elsewhere, of other processes, of the network, of questions.

    Parameters
    ----------
    runs : sequence of Ran
        The ideal run and the others.
    known : sequence of Finding
        What the source has told already.
    """
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
            kind = violation.kind
            if kind in told:
                continue
            told.add(kind)
            yield Finding(
                kind,
                Verdict.RISK if kind == "network" else Verdict.FAIL,
                f"{words[kind]} ({violation.what[:120]})"
                + ("; it was stopped" if kind != "blocking-call" else ""),
                advice[kind],
                line=violation.line,
                file=violation.file,
                time=violation.time or None,
            )
