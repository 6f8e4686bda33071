"""How runs ended, and what policy they violated: from outcomes to findings."""

from __future__ import annotations

import errno
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from posflock_robotarium.alignment.intervals import told_interval
from posflock_robotarium.verify.findings import Code, Finding, Verdict
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
        finding = _ending(_End(ideal, Verdict.FAIL))
        waits = ideal.ended is Ended.HUNG and any(f.code is Code.BLOCKING_CALL for f in known)
        if finding and not waits and not is_explained(ideal.error, known) and not _refused(ideal):
            yield finding
        return
    if ideal.ended is Ended.OVER_TIME and not counted:
        yield Finding(
            Code.ENDLESS,
            Verdict.RISK,
            f"was still running after {ideal.time or 0.0:.0f} s and had to be interrupted",
            "end the loop after a number of steps",
            time=ideal.time,
        )
    failed = [outcome for outcome in trials if outcome.ended in FATAL]
    if failed:
        finding = _ending(_End(failed[0], Verdict.RISK, (len(failed), len(trials))))
        if finding:
            yield finding


def _refused(outcome: Outcome) -> bool:
    """Whether a run ended at a line that policy had stopped, whatever a library made of that."""
    error = outcome.error
    stopped = [v for v in outcome.policy_violations if v.line and _POLICIES[Code(v.kind)].stopped]
    return error is not None and any((v.line, v.file) in error.lines for v in stopped)


@dataclass(frozen=True)
class _End:
    """How a run ended badly, and in how many of how many trials, where it was one of them."""

    outcome: Outcome
    verdict: Verdict
    trials: tuple[int, int] | None = None

    @property
    def error(self) -> Failure:
        """The error that ended it, which may be none."""
        return self.outcome.error or Failure()

    def finding(
        self, code: Code, message: str, advice: str, verdict: Verdict | None = None
    ) -> Finding:
        """Return the finding, with the place and time of this end."""
        outcome, error = self.outcome, self.error
        return Finding(
            code,
            self.verdict if verdict is None else verdict,
            message,
            advice,
            line=error.line,
            file=error.file,
            time=outcome.time if outcome.steps else None,
            trials=self.trials,
            interval=told_interval(*self.trials) if self.trials else None,
        )


def _ending(end: _End) -> Finding | None:
    outcome, error = end.outcome, end.error
    if "ForbiddenError" in error.kinds:
        return None  # the violation is told of
    what = str(error)
    if outcome.ended is Ended.HUNG:
        message = f"made no step after t = {outcome.time or 0.0:.1f} s and had to be killed"
        return end.finding(
            Code.HANG, message, "look for an endless loop, or for a wait, at this line"
        )
    if outcome.ended is Ended.OUT_OF_MEMORY:
        message = f"needs more memory than the limit ({what})"
        return end.finding(Code.MEMORY, message, "use smaller arrays")
    if outcome.left_with_code:
        message = f"ends with exit code {error.message or 'not 0'}"
        return end.finding(Code.EXIT_CODE, message, "let it end with 0")
    if "InitialConditionsError" in error.kinds:
        advice = "place the robots inside the arena, at least 0.15 m apart"
        return end.finding(Code.UNREACHABLE_START, what, advice)
    if "WrongGenerationError" in error.kinds:
        return end.finding(Code.GENERATION, what, "use the name it gives")
    return _failed(end)


def _failed(end: _End) -> Finding:
    """Tell of an exception, or of a process that died."""
    error, what = end.error, str(end.error)
    module = error.module or "."
    if libraries.is_available(module):  # that is, only this machine lacks it
        distribution = libraries.IMPORT_NAMES.get(module)
        return end.finding(
            Code.INTERNAL,
            f"could not be run: the testbed has {module}, but the Python that verifies has not",
            f"`pip install {distribution}` and verify again"
            if distribution
            else "verify again under Python 3.10",
            Verdict.RISK,
        )
    missing = error.missing
    if missing:
        if not missing.lower().endswith(tuple(testbed.ENDINGS)):
            message = f"reads {missing}, which has an ending that cannot be uploaded"
            advice = f"use one of {' '.join(testbed.ENDINGS)}"
            return end.finding(Code.FILE_ENDING, message, advice)
        message = f"reads {missing}, which is not beside the script"
        return end.finding(Code.FILE_MISSING, message, "put it beside the script")
    if error.number in (errno.EFBIG, errno.EDQUOT):
        policy = _POLICIES[Code.DISK]
        return end.finding(Code.DISK, f"{policy.words} ({what})", policy.advice)
    if error.number == errno.EROFS:  # native code, which only namespaces have held
        policy = _POLICIES[Code.OUTSIDE_WRITE]
        return end.finding(Code.OUTSIDE_WRITE, f"{policy.words} ({what})", policy.advice)
    newer = newer_library(error.type, error.message)
    if newer:  # that is, only this machine refuses it
        return end.finding(Code.INTERNAL, f"could not be run: {newer}", REHEARSE, Verdict.RISK)
    if end.outcome.ended is Ended.DIED:
        return end.finding(Code.CRASH, what, "look at the end of its output")
    return end.finding(Code.CRASH, f"ends with {what}", "mend this line")


@dataclass(frozen=True)
class _Policy:
    """What a script must not do, what to do instead, how bad it is, and whether it was stopped."""

    words: str
    advice: str
    verdict: Verdict = Verdict.FAIL
    stopped: bool = True


_POLICIES = {
    Code.OUTSIDE_WRITE: _Policy(
        "writes outside its own folder",
        "write into the working folder: only those files come back",
    ),
    Code.FORK: _Policy("starts or ends other processes", "do the work in one process"),
    Code.NETWORK: _Policy("uses the network", "upload what it needs as files", Verdict.RISK),
    Code.MEMORY: _Policy("needs more memory than the limit", "use smaller arrays"),
    Code.DISK: _Policy("writes or prints more than the limit", "write less, or every tenth step"),
    Code.BLOCKING_CALL: _Policy(
        "waits for somebody, and on the testbed nobody is there", "remove it", stopped=False
    ),
}


def judge_policy(runs: Sequence[Ran], known: Sequence[Finding]) -> Iterator[Finding]:
    """Tell of writing elsewhere, of other processes, of the network, of questions.

    Parameters
    ----------
    runs : sequence of Ran
        The ideal run and the others.
    known : sequence of Finding
        What the source has told already.
    """
    told = {finding.code for finding in known}
    for run in runs:
        for violation in run.outcome.policy_violations:
            code = Code(violation.kind)
            if code in told:
                continue
            told.add(code)
            policy = _POLICIES[code]
            yield Finding(
                code,
                policy.verdict,
                f"{policy.words} ({violation.what[:120]})"
                + ("; it was stopped" if policy.stopped else ""),
                policy.advice,
                line=violation.line,
                file=violation.file,
                time=violation.time or None,
            )
