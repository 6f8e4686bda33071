"""What is left of the data when a run is ended from outside: from outcomes to findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from posflock_robotarium.verify.findings import Code, Finding, Verdict
from posflock_robotarium.verify.trials import Ran
from rps_compat.running.outcome import Ended

#: Endings of figures, which can be drawn again from data.
_PICTURES = (".png", ".jpg", ".jpeg", ".gif", ".svg", ".pdf", ".tiff", ".bmp")


_NOTHING_SAVED = Finding(
    Code.NOTHING_SAVED,
    Verdict.NOTE,
    "writes no file: what comes back is the video and what it prints",
    "log poses and commands during the loop (numpy.lib.format.open_memmap, or posflock's PoseLog):"
    " a report, and a realism profile fitted to these robots, need them",
)


def judge_data(
    ideal: Ran, interrupted: Ran | None, killed: Ran | None, known: Sequence[Finding]
) -> Iterator[Finding]:
    """Tell what is left of the data when a run is ended from outside.

    Parameters
    ----------
    ideal : Ran
        The ideal run.
    interrupted : Ran or None
        A run that was interrupted on its way; None where there was none.
    killed : Ran or None
        A run that was killed on its way; None where there was none.
    known : sequence of Finding
        What the source has told already.
    """
    if not ideal.data and ideal.outcome.ended is Ended.FINISHED:
        yield _NOTHING_SAVED
    written = [name for name, content in ideal.data.items() if content.readable]
    if not written or interrupted is None or not interrupted.outcome.steps:
        return
    if interrupted.outcome.ended is Ended.HUNG:
        yield Finding(
            Code.HANG,
            Verdict.RISK,
            "goes on after the KeyboardInterrupt in step(), without stepping",
            "let the interrupt end the loop",
            time=interrupted.outcome.time,
        )
    yield from _judge_what_is_left(ideal, interrupted, killed, written, known)


def _judge_what_is_left(
    ideal: Ran,
    interrupted: Ran,
    killed: Ran | None,
    written: Sequence[str],
    known: Sequence[Finding],
) -> Iterator[Finding]:
    """Compare the files of runs that were ended with those of the whole one."""
    kept = _kept(ideal, interrupted)
    lost = [name for name in written if name not in kept]
    t = interrupted.outcome.time or 0.0
    # Files that half a run leaves as a whole one does hold none of its data.
    recorded = [n for n in kept if ideal.data[n].digest != interrupted.data[n].digest]
    if not kept or (not recorded and any(not n.lower().endswith(_PICTURES) for n in lost)):
        if not any(finding.code is Code.SAVE_AT_END for finding in known):
            yield Finding(
                Code.DATA_LOST,
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
            Code.DATA_LOST,
            Verdict.NOTE,
            f"a KeyboardInterrupt leaves {', '.join(kept)}, but a kill leaves nothing",
            "write row by row during the loop (numpy.lib.format.open_memmap, or PoseLog)",
            time=killed.outcome.time,
            figure=float(len(written)),
            unit="files lost",
        )
    elif lost:
        yield Finding(
            Code.DATA_LOST,
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
