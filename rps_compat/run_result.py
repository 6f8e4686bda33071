"""How a run went: its end, a report on each instance, what it left."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rps_compat.ending import Ended
from rps_compat.generations import Generation
from rps_compat.report import RunReport


@dataclass(frozen=True)
class RunResult:
    """How a run went.

    Attributes
    ----------
    script
        The script that ran.
    generation
        The generation that it ran on.
    ended
        "finished", "failed" (an exception), "interrupted" (Ctrl-C), "timeout", "stuck" (all that
        was left waited for ever) or "idle" (it made a Robotarium and never stepped it).
    reason
        In words, for everything but "finished".
    exit_code
        For the shell: the script's own, or one of `rps_compat.ending.EXIT_CODES`.
    reports
        One for each Robotarium instance, in the order of their making: first those of the script's
        own process, then those of its child processes.
    files
        What the run left in its folder.
    notes
        What is no fault of the run, and yet to be known before the testbed.
    folder
        Where the run left its files; None if nowhere.
    """

    script: Path
    generation: Generation
    ended: Ended
    reason: str
    exit_code: int
    reports: tuple[RunReport, ...]
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    folder: Path | None = None

    @property
    def clean(self) -> bool:
        """Whether the run finished and nothing would have stopped it on the testbed."""
        return self.exit_code == 0 and all(report.clean for report in self.reports)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain data, ready for JSON.

        Files are told relative to the folder, so that equal runs into two folders are equal.
        """
        return {
            "script": str(self.script),
            "generation": self.generation,
            "ended": self.ended,
            "reason": self.reason,
            "exit_code": self.exit_code,
            "clean": self.clean,
            "notes": list(self.notes),
            "reports": [report.as_dict() for report in self.reports],
            "files": [self._relative(path) for path in self.files],
        }

    def as_json(self) -> str:
        """Return the result and its folder as JSON: for a program that started the run."""
        folder = None if self.folder is None else str(self.folder)
        return json.dumps({**self.as_dict(), "folder": folder}, indent=1)

    def _relative(self, path: Path) -> str:
        if self.folder is not None and path.is_relative_to(self.folder):
            return path.relative_to(self.folder).as_posix()
        return str(path)


def summary(result: RunResult) -> str:
    """Tell in a few lines how a run went and what it left: for a terminal."""
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
        lines += [f"  {fault}" for fault in report.faults[:5] if fault.kind != "actuator"]
    lines += [f"note: {note}" for note in result.notes]
    if result.files:
        folders = sorted({str(path.parent) for path in result.files})
        names = ", ".join(path.name for path in result.files)
        lines.append(f"in {', '.join(folders)}: {names}")
    return "\n".join(lines)
