"""How a run went: its end, what was measured, what it left."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from barrier_certificates.word_enum import WordEnum
from rps_compat.generations import Generation
from rps_compat.logged_end import LoggedEnd
from rps_compat.report import Fault, RunReport
from rps_compat.running.policy_violations import PolicyViolation, read_violation
from rps_compat.violations import FaultKind


class Ended(WordEnum):
    """How a run ended: one word for one thing, in every command and every file."""

    #: By itself.
    FINISHED = "finished"
    #: By an exception, or with an exit code that says failure.
    FAILED = "failed"
    #: By Ctrl-C, or by a KeyboardInterrupt as it was planned.
    INTERRUPTED = "interrupted"
    #: It went on when the experiment's time was over, and was interrupted as the testbed does.
    OVER_TIME = "over time"
    #: By the limit of real time.
    TIMED_OUT = "timed out"
    #: All that was left waited for ever, or computed without a step.
    HUNG = "hung"
    #: It made a Robotarium and never stepped it.
    IDLE = "idle"
    #: It wanted more memory than it was allowed.
    OUT_OF_MEMORY = "out of memory"
    #: As it was planned: enough was seen.
    STOPPED = "stopped"
    #: As it was planned, by a signal that no program survives.
    KILLED = "killed"
    #: Its process ended without a word.
    DIED = "died"

    @property
    def in_log(self) -> LoggedEnd:
        """How a log calls it."""
        return _IN_LOG.get(self, LoggedEnd.FAILED)


_IN_LOG = {
    Ended.FINISHED: LoggedEnd.FINISHED,
    Ended.IDLE: LoggedEnd.FINISHED,
    Ended.STOPPED: LoggedEnd.FINISHED,
    Ended.INTERRUPTED: LoggedEnd.INTERRUPTED,
    Ended.TIMED_OUT: LoggedEnd.INTERRUPTED,
    Ended.OVER_TIME: LoggedEnd.INTERRUPTED,
}


@dataclass(frozen=True)
class Failure:
    """What ended a run that did not end by itself.

    Attributes
    ----------
    type, full_type, kinds
        Name of the exception's class, the same with its module, and of all that it derives from.
    message
        What the exception says.
    line, file
        The innermost line of the script's own files that it came through; None and empty where it
        came through none.
    lines
        All of them: line and file, the outermost first.
    missing
        File beside the script that was to be read and is not there; empty if that was not it.
    module
        Module that could not be imported; None if that was not it.
    number
        Of the system's error (``errno``); None where it was none.
    """

    type: str = ""
    full_type: str = ""
    kinds: tuple[str, ...] = ()
    message: str = ""
    line: int | None = None
    file: str = ""
    lines: tuple[tuple[int, str], ...] = ()
    missing: str = ""
    module: str | None = None
    number: int | None = None

    def __str__(self) -> str:
        return f"{self.type}: {self.message}".strip(": ")


@dataclass(frozen=True)
class Gap:
    """The smallest of some distance, when and where.

    Attributes
    ----------
    metres : float
        The distance, m.
    time : float
        When, s.
    robots : tuple of int
        Which robots.
    """

    metres: float
    time: float
    robots: tuple[int, ...]


@dataclass(frozen=True)
class LoopTimes:
    """How long the script took from one step to the next, computing and sleeping.

    Attributes
    ----------
    p50, p99, longest
        Median, 99th percentile and largest, s.
    late
        Share of the steps that took longer than a time step.
    at
        When the longest was, s of the run.
    """

    p50: float
    p99: float
    longest: float
    late: float
    at: float


@dataclass(frozen=True)
class Silence:
    """How long robots drove on without a new command.

    Attributes
    ----------
    seconds : float
        How long, s.
    at : float
        When, s.
    """

    seconds: float
    at: float


@dataclass(frozen=True)
class Outcome:
    """How a run went. What is unknown is None.

    Attributes
    ----------
    script
        The script that ran.
    generation
        Of the API that it ran on.
    ended
        How it ended.
    reason
        In words, for everything but "finished".
    exit_code
        For the shell: the script's own, or one of `rps_compat.running.ending.EXIT_CODES`.
    reports
        One for each Robotarium instance, in the order of their making: first those of the script's
        own process, then those of its child processes.
    files
        What the run left in its folder.
    notes
        What is no fault of the run, and yet to be known before the testbed.
    folder
        Where the run left its files; None if nowhere.
    error
        What ended it.
    name, seed, profile
        Those of its plan.
    steps
        How often ``step()`` was called.
    time, clock
        Seconds of the run, by its steps and by the clock that the script saw.
    finishing_call
        Whether it called what a script of its generation is to call at its end.
    smallest_gap, initial_gap
        Distance of the nearest two robots' centres, in the run and at its start.
    wall_gap
        Distance of the outermost robot's centre from the nearest wall; outside is negative.
    loop
        How long its loop took.
    silence
        How long its robots had no new command.
    policy_violations
        What it did that it must not do.
    """

    script: Path
    generation: Generation
    ended: Ended
    reason: str = ""
    exit_code: int = 0
    reports: tuple[RunReport, ...] = ()
    files: tuple[Path, ...] = ()
    notes: tuple[str, ...] = ()
    folder: Path | None = None
    error: Failure | None = None
    name: str = ""
    seed: int | None = None
    profile: str = ""
    steps: int | None = None
    time: float | None = None
    clock: float | None = None
    finishing_call: bool | None = None
    smallest_gap: Gap | None = None
    initial_gap: Gap | None = None
    wall_gap: Gap | None = None
    loop: LoopTimes | None = None
    silence: Silence | None = None
    policy_violations: tuple[PolicyViolation, ...] = ()

    @property
    def clean(self) -> bool:
        """Whether the run finished and nothing would have stopped it on the testbed."""
        return self.exit_code == 0 and all(report.clean for report in self.reports)

    @property
    def left_with_code(self) -> bool:
        """Whether the script itself ended, with an exit code that says failure."""
        return self.error is not None and self.error.type == "SystemExit"

    @property
    def report(self) -> RunReport | None:
        """The report on the last Robotarium that the script made; None without one."""
        return self.reports[-1] if self.reports else None

    def faults(self, kind: FaultKind) -> list[Fault]:
        """Return the faults of a kind, of the last Robotarium.

        Parameters
        ----------
        kind : FaultKind
            What was wrong.
        """
        return [] if self.report is None else [f for f in self.report.faults if f.kind is kind]

    def as_dict(self) -> dict[str, Any]:
        """Return the outcome as plain data, ready for JSON.

        Files are told relative to the folder, so that equal runs into two folders are equal.
        """
        data = asdict(self) | {
            "script": str(self.script),
            "ended": self.ended.value,
            "clean": self.clean,
            "reports": [report.as_dict() for report in self.reports],
            "files": [self._relative(path) for path in self.files],
        }
        del data["folder"]
        return data

    def as_json(self) -> str:
        """Return the outcome and its folder as JSON: for a program that started the run."""
        folder = None if self.folder is None else str(self.folder)
        return json.dumps({**self.as_dict(), "folder": folder}, indent=1)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Outcome:
        """Return the outcome that :meth:`as_dict` gave, or JSON of it.

        Parameters
        ----------
        data : dict
            What it gave.
        """
        known = {field.name for field in fields(cls)}
        values = {name: value for name, value in data.items() if name in known}
        for name, kind in _PARTS.items():
            if values.get(name) is not None:
                values[name] = _read(kind, values[name])
        values["script"] = Path(values["script"])
        values["ended"] = Ended(values["ended"])
        values["reports"] = tuple(_report(report) for report in values["reports"])
        values["files"] = tuple(Path(name) for name in values["files"])
        values["notes"] = tuple(values["notes"])
        values["policy_violations"] = tuple(
            read_violation(found) for found in values["policy_violations"]
        )
        folder = values.get("folder")
        values["folder"] = None if folder is None else Path(folder)
        return cls(**values)

    def _relative(self, path: Path) -> str:
        if self.folder is not None and path.is_relative_to(self.folder):
            return path.relative_to(self.folder).as_posix()
        return str(path)


_PARTS: dict[str, type] = {
    "error": Failure,
    "smallest_gap": Gap,
    "initial_gap": Gap,
    "wall_gap": Gap,
    "loop": LoopTimes,
    "silence": Silence,
}


def _read(kind: type, table: dict[str, Any]) -> Any:
    values = {n: tuple(v) if isinstance(v, list) else v for n, v in table.items()}
    if "lines" in values:
        values["lines"] = tuple((line, file) for line, file in values["lines"])
    return kind(**values)


def _report(table: dict[str, Any]) -> RunReport:
    values = {name: value for name, value in table.items() if name != "clean"}
    values["faults"] = tuple(
        _read(Fault, fault | {"kind": FaultKind(fault["kind"])}) for fault in values["faults"]
    )
    return RunReport(**values)


def summary(result: Outcome) -> str:
    """Tell in a few lines how a run went and what it left: for a terminal.

    Parameters
    ----------
    result : Outcome
        How the run went.
    """
    lines = [f"{result.script.name}: generation {result.generation}, {result.ended}"]
    if result.reason:
        lines[0] += f" ({result.reason})"
    for number, report in enumerate(result.reports, start=1):
        which = f"Robotarium {number}" if len(result.reports) > 1 else ""
        which += f" ({report.process})" if report.process else ""
        which += ": " if which else ""
        lines.append(
            f"{which}{report.number_of_robots} robots, {report.steps} steps, "
            f"{report.duration:.1f} s on the testbed, {report.verdict}"
        )
        lines += [
            f"  {fault}" for fault in report.faults[:5] if fault.kind is not FaultKind.ACTUATOR
        ]
    lines += [f"note: {note}" for note in result.notes]
    if result.files:
        folders = sorted({str(path.parent) for path in result.files})
        names = ", ".join(path.name for path in result.files)
        lines.append(f"in {', '.join(folders)}: {names}")
    return "\n".join(lines)
