"""Is it the whole run? What the log, its rows and what was printed say of its end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from barrier_certificates import ties
from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict
from posflock_robotarium.logs.run import How, Run

QUESTION = "Is it the whole run?"
SHORT = 0.95
"""Share of what was planned from which on a run without an end is not called short."""

LATER = 1.0
"""Seconds after the last pose from which on a timed line tells that poses are missing."""


def whole_run_verdict(recording: Run, v: Mapping[str, float]) -> Iterator[RunVerdict]:
    """Judge whether the rows are all of a run; nothing where nobody knows.

    Parameters
    ----------
    recording : Run
        For what it says of its end, and what was printed.
    v : mapping of float
        Values of the numbers by key, s.
    """
    ending, planned, printed = recording.ending, recording.planned, recording.printed
    length = f"{v['duration']:.1f} s are logged"
    if planned is not None:
        length += f" of {planned:.1f} s planned"
    said = "" if printed is None else f" {printed.told[0].upper()}{printed.told[1:]}."
    if recording.doubts:
        first, *others = recording.doubts
        because = " ".join(f"{doubt[0].upper()}{doubt[1:]}." for doubt in others)
        yield _verdict(Mark.BAD, f"No: {first}.", f"{length}. {because}".strip() + said)
    elif printed is not None and printed.collision:
        unseen = "" if v.get("collisions") else " None is seen in the poses."
        yield _verdict(Mark.BAD, "No: a collision stopped it.", f"{length}.{said}{unseen}")
    elif ending is not None and ending.how is How.FINISHED:
        yield _verdict(Mark.GOOD, "Yes, the run finished.", f"{length}.{said}")
    elif printed is not None and printed.interrupted:
        answer = "No: a KeyboardInterrupt ended it."
        why = " So ends a run whose time is up, or that somebody stops."
        yield _verdict(Mark.CAUTION, answer, f"{length}.{said}{why}")
    elif printed is not None and printed.error:
        yield _verdict(Mark.CAUTION, "No: an error ended the script.", f"{length}.{said}")
    elif ending is not None:
        killed = ending.how is How.RUNNING
        words = "it was killed, or still goes on" if killed else ending.how.value
        because = f"{length}. {ending.reason}".strip() + said
        yield _verdict(Mark.CAUTION, f"No: {words}.", because)
    elif planned is not None and ties.short_of(v["duration"], SHORT * planned):
        yield _verdict(Mark.CAUTION, "Shorter than planned.", f"{length}.{said}")
    elif printed is not None:
        yield _by_what_was_printed(recording, v, f"{length}.{said}")


def _by_what_was_printed(recording: Run, v: Mapping[str, float], because: str) -> RunVerdict:
    """Judge a run of whose end only the printed lines tell, and that tell of nothing wrong."""
    assert recording.printed is not None
    last = recording.printed.last_time
    logged = v["duration"] - v.get("drive_in_log", 0.0)
    if last is not None and last > logged + LATER:
        answer = "No: lines were printed after its last pose."
        return _verdict(Mark.CAUTION, answer, because)
    if recording.printed.began_at is None:
        return _verdict(Mark.UNKNOWN, "Nothing says how it ended.", because)
    return _verdict(Mark.GOOD, "Yes, the script ended by itself.", because)


def _verdict(mark: Mark, answer: str, because: str) -> RunVerdict:
    return RunVerdict(QUESTION, mark, answer, because)
