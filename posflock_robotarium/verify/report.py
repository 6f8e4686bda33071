"""What verify found out about a script: the verdict, its reasons, and the figures of the runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posflock_robotarium.verify.figures import Figures, figures_of, metres
from posflock_robotarium.verify.findings import Finding, Verdict, verdict_of

if TYPE_CHECKING:
    from posflock_robotarium.verify.initial_drive_time import DriveTime
    from posflock_robotarium.verify.trials import Ran
    from rps_compat.containment.namespaces import Containment
    from rps_compat.running.outcome import Outcome

#: Version of the format of ``verify.json``; see docs/how-to/verify.md.
SCHEMA = "posflock verify 1"


@dataclass(frozen=True)
class Report:
    """What verify found out.

    Attributes
    ----------
    script : Path
        The main file.
    verdict : Verdict
        PASS, RISK or FAIL.
    findings : list of Finding
        Reasons, the worst first.
    generation : int
        Of the API that the runs used.
    profile : str
        The realism profile of the trials.
    ideal : Ran, optional
        The ideal run; None where the source alone settled it.
    trials : list of Ran
        Those with imperfections.
    declared : float, optional
        Duration that will be declared, s.
    drive : DriveTime, optional
        Predicted for the drive to the initial conditions; None where the source alone settled it.
    sha256 : str
        Sum of the script as it was verified, as a bundle's `MANIFEST` has it; empty where unknown.
    containment : Containment, optional
        What held the runs; None where nothing ran.
    """

    script: Path
    verdict: Verdict
    findings: list[Finding]
    generation: int
    profile: str
    ideal: Ran | None = None
    trials: list[Ran] = field(default_factory=list)
    declared: float | None = None
    drive: DriveTime | None = None
    sha256: str = ""
    containment: Containment | None = None

    @property
    def exit_code(self) -> int:
        """0 for PASS, 1 for RISK, 2 for FAIL."""
        return {Verdict.PASS: 0, Verdict.RISK: 1, Verdict.FAIL: 2}[self.verdict]

    @property
    def figures(self) -> Figures | None:
        """The numbers that a reader wants even where nothing is wrong; None where nothing ran."""
        if self.ideal is None or self.drive is None:
            return None
        trials = [trial.outcome for trial in self.trials]
        return figures_of(self.ideal.outcome, trials, self.drive)

    def as_dict(self) -> dict[str, Any]:
        """Return what ``verify.json`` holds; docs/how-to/verify.md describes it."""
        figures = self.figures
        return {
            "schema": SCHEMA,
            "script": self.script.name,
            "sha256": self.sha256 or None,
            "verdict": self.verdict.name,
            "generation": self.generation,
            "profile": self.profile,
            "declared": self.declared,
            "containment": None if self.containment is None else self.containment.value,
            "findings": [finding.as_dict() for finding in self.findings],
            "figures": {} if figures is None else figures.as_dict(),
            "trials": [_row(ran.outcome) for ran in [self.ideal, *self.trials] if ran is not None],
        }


def report_of(
    script: Path,
    findings: Sequence[Finding],
    generation: int,
    profile: str,
    ideal: Ran | None = None,
    trials: Sequence[Ran] = (),
    declared: float | None = None,
    drive: DriveTime | None = None,
) -> Report:
    """Put the findings in order, the worst first, and say what they come to.

    Parameters
    ----------
    script : Path
        The main file.
    findings : sequence of Finding
        Of the source and of the runs; those that are equally bad keep their order.
    generation : int
        Of the API that the runs used, 1 or 2.
    profile : str
        Name of the realism profile of the trials.
    ideal : Ran, optional
        The ideal run; None where the source alone settled it.
    trials : sequence of Ran
        Those with imperfections.
    declared : float, optional
        Duration that will be declared, s.
    drive : DriveTime, optional
        Predicted for the drive to the initial conditions.
    """
    ordered = sorted(findings, key=lambda finding: -finding.verdict)
    return Report(
        script,
        verdict_of(ordered),
        ordered,
        generation,
        profile,
        ideal,
        list(trials),
        declared,
        drive,
    )


def _row(outcome: Outcome) -> dict[str, Any]:
    """Return the row of a trial in ``verify.json``."""
    report = outcome.report
    return {
        "name": outcome.name,
        "seed": outcome.seed,
        "ended": outcome.ended.value,
        "steps": outcome.steps,
        "seconds": outcome.time,
        "close_pairs": None if report is None else report.pairs_too_close,
        "outside_steps": None if report is None else report.steps_outside,
        "smallest_gap": metres(outcome.smallest_gap),
        "wall_gap": metres(outcome.wall_gap),
    }
