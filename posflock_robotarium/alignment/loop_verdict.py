"""Did the loop keep its time? Steps that are late, and those in which robots braked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict
from posflock_robotarium.logs.run import Run
from rps_compat.testbed import WATCHDOG

QUESTION = "Did the loop keep its time?"
DRIFT = 0.02
"""Share by which real time differs from the counted steps that is worth a word."""


def loop_verdict(recording: Run, v: Mapping[str, float]) -> Iterator[RunVerdict]:
    """Judge the times of steps; nothing where they were counted, or are no loop's but a tracker's.

    Parameters
    ----------
    recording : Run
        For what its clock is.
    v : mapping of float
        Values of the numbers by key, s.
    """
    if "step_longest" not in v or (recording.real_time is None and recording.commands is None):
        return
    because = (
        f"Steps took {1e3 * v['step_mean']:.1f} ms on average (median "
        f"{1e3 * v['step_median']:.1f} ms), the longest {_long(v['step_longest'])} at "
        f"{v['step_longest_at']:.1f} s."
    )
    counted = v["duration"]
    real = v.get("real_duration", counted)
    if abs(real - counted) > DRIFT * counted:
        because += (
            f" In real time the run lasted {real:.1f} s, by its steps {counted:.1f} s: speeds and "
            "times here are by its steps, with --time real by the clock."
        )
    over = int(v["steps_over_watchdog"])
    if not over:
        yield RunVerdict(QUESTION, Mark.GOOD, f"Yes, no step over {WATCHDOG:g} s.", because)
        return
    missing = "" if recording.real_time is not None else ", unless rows are missing there"
    answer = f"No: {over} step{'s' if over > 1 else ''} took over {WATCHDOG:g} s."
    because += f" Robots that hear nothing for {WATCHDOG:g} s brake{missing}."
    yield RunVerdict(QUESTION, Mark.CAUTION, answer, because)


def _long(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= WATCHDOG else f"{1e3 * seconds:.0f} ms"
