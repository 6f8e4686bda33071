"""Will it run on the testbed? Predict it, instead of waiting for the answer.

:func:`verify` reads a script's source (`static`), runs it once in the ideal simulator and many
times under imperfections (`trials`), interrupts it twice, and says PASS, RISK or FAIL with
reasons (`judge`, `findings`).  :func:`ablate` asks which imperfection it is that breaks a script.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.verify import judge, static
from posflock_robotarium.verify.ablation import EFFECT_TRIALS, Ablation, ablate
from posflock_robotarium.verify.endings import FATAL
from posflock_robotarium.verify.findings import (
    Finding,
    Verdict,
    verdict_of,
    wilson_interval,
)
from posflock_robotarium.verify.timing import recommended_duration
from rps_compat import testbed
from rps_compat.scripts.evidence import evidence_of

if TYPE_CHECKING:
    from posflock_robotarium.verify.trials import ForkServer, Limits, Ran
    from rps_compat.realism import Profile
    from rps_compat.running.outcome import Gap, LoopTimes, Outcome

#: Version of the format of ``verify.json``; see docs/verify.md.
SCHEMA = "posflock verify 1"
#: Runs with imperfections where nobody says how many.
TRIALS = 20

__all__ = [
    "EFFECT_TRIALS",
    "TRIALS",
    "Ablation",
    "Finding",
    "Report",
    "Verdict",
    "ablate",
    "verify",
]


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
    """

    script: Path
    verdict: Verdict
    findings: list[Finding]
    generation: int
    profile: str
    ideal: Ran | None = None
    trials: list[Ran] = field(default_factory=list)
    declared: float | None = None

    @property
    def exit_code(self) -> int:
        """0 for PASS, 1 for RISK, 2 for FAIL."""
        return {Verdict.PASS: 0, Verdict.RISK: 1, Verdict.FAIL: 2}[self.verdict]

    def figures(self) -> dict[str, Any]:
        """Return the numbers that a reader wants even where nothing is wrong."""
        if self.ideal is None or not self.ideal.outcome.steps:
            return {}
        ideal, report = self.ideal.outcome, self.ideal.outcome.report
        if report is None or ideal.clock is None:
            return {}
        ran = [trial.outcome for trial in self.trials if trial.outcome.steps]
        least, median, most = testbed.INITIAL_DRIVE
        out: dict[str, Any] = {
            "robots": report.number_of_robots,
            "steps": ideal.steps,
            "run_seconds": ideal.clock,
            "initial_drive_seconds": {"least": least, "median": median, "most": most},
            "predicted_seconds": ideal.clock + median,
            "recommended_duration": recommended_duration(ideal.clock),
            "loop_milliseconds": _milliseconds(ideal.loop),
            "largest_wheel_speed": report.largest_wheel_velocity,
            "smallest_gap": {"ideal": _metres(ideal.smallest_gap)},
            "smallest_wall_gap": {"ideal": _metres(ideal.wall_gap)},
        }
        if ran:
            for name, part in (("smallest_gap", "smallest_gap"), ("smallest_wall_gap", "wall_gap")):
                gaps = [getattr(o, part).metres for o in ran if getattr(o, part)]
                out[name]["trials"] = min(gaps) if gaps else None
            for kind in ("collision", "boundary"):
                hits = sum(bool(outcome.faults(kind)) for outcome in ran)
                out[f"{kind}_runs"] = {
                    "trials": len(ran),
                    "hits": hits,
                    "interval": list(wilson_interval(hits, len(ran))),
                }
        return out

    def as_dict(self) -> dict[str, Any]:
        """Return what ``verify.json`` holds; docs/verify.md describes it."""
        return {
            "schema": SCHEMA,
            "script": self.script.name,
            "verdict": self.verdict.name,
            "generation": self.generation,
            "profile": self.profile,
            "declared": self.declared,
            "findings": [finding.as_dict() for finding in self.findings],
            "figures": self.figures(),
            "trials": [_row(ran.outcome) for ran in [self.ideal, *self.trials] if ran is not None],
        }


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
        "smallest_gap": _metres(outcome.smallest_gap),
        "wall_gap": _metres(outcome.wall_gap),
    }


def _metres(gap: Gap | None) -> float | None:
    return None if gap is None else gap.metres


def _milliseconds(loop: LoopTimes | None) -> dict[str, float]:
    if loop is None:
        return {}
    return {"p50": 1000 * loop.p50, "p99": 1000 * loop.p99, "max": 1000 * loop.longest}


def verify(
    script: Path | str,
    *,
    trials: int = TRIALS,
    profile: Profile | str | Path = "gritsbot_x",
    generation: int = 2,
    declared: float | None = None,
    seed: int = 0,
    limits: Limits | None = None,
    search: Sequence[Path] = (),
    tell: Callable[[str, int, int], None] | None = None,
    server: ForkServer | None = None,
) -> Report:
    """Predict whether the testbed takes `script`, runs it, and gives its data back.

    Parameters
    ----------
    script : path
        The main file; its local modules and data lie beside it.
    trials : int
        Runs with imperfections, besides the ideal one.
    profile : Profile, name or path
        The imperfections: ``gritsbot_x``, ``harsh``, or a TOML file.
    generation : int
        Of the API that the testbed runs: 2 since April 2026.
    declared : float, optional
        Seconds that will be declared at submission.
    seed : int
        First of the trials' seeds.
    limits : Limits, optional
        What each trial may use.
    search : sequence of Path
        Further folders with local modules.
    tell : callable, optional
        Is told of progress: what, done, of how many.
    server : ForkServer, optional
        The process that runs the trials, to share it between calls.

    Raises
    ------
    ScriptError
        Where `script` cannot be read.
    ParameterError
        Where an option is outside its range.
    ProfileError
        Where the profile is not one.
    """
    from posflock_robotarium.verify import trials as running
    from rps_compat.profiles import load_profile
    from rps_compat.realism import Profile

    script = Path(script)
    if trials < 0:
        raise ParameterError(f"trials: expected 0 or more, got {trials}")
    if generation not in (1, 2):
        raise ParameterError(f"generation: expected 1 or 2, got {generation}")
    if declared is not None and not 0 < declared <= testbed.MAX_DURATION:
        raise ParameterError(
            f"declared: expected more than 0 and at most {testbed.MAX_DURATION:.0f} s,"
            f" got {declared}"
        )
    chosen = profile if isinstance(profile, Profile) else load_profile(profile)
    known, source = static.check_source(script, generation, tuple(search))
    if source is None or any(f.code in ("syntax", "module-missing", "stand-in") for f in known):
        return _report(script, known, generation, chosen.name, declared=declared)
    if any(finding.code == "generation" for finding in known):
        # Run it under the generation it was written for: there may be more to tell.
        generation = evidence_of(source.uses).generation
    with running.TrialRoom(source, generation, limits or running.Limits(), server) as room:
        found, ideal, ran = _run(room, chosen, trials, declared, seed, known, tell)
    # Runs name the file of every line; a finding does only where that is not the script.
    found = [replace(f, file="") if f.file == script.name else f for f in found]
    # What is written elsewhere is not the run's data.
    elsewhere = {f.line for f in found if f.code == "outside-write" and not f.file}
    known = [f for f in known if f.code != "save-at-end" or f.line not in elsewhere]
    return _report(script, [*known, *found], generation, chosen.name, ideal, ran, declared)


def _run(
    room: Any,
    profile: Profile,
    trials: int,
    declared: float | None,
    seed: int,
    known: list[Finding],
    tell: Callable[[str, int, int], None] | None,
) -> tuple[list[Finding], Ran, list[Ran]]:
    """Run the ideal trial, then all others, whose moments of interruption depend on it."""
    import numpy as np

    done = 0

    def count(what: str, total: int) -> Callable[[Any], None]:
        def told(_: Any) -> None:
            nonlocal done
            done += 1
            if tell is not None:
                tell(what, done, total)

        return told

    longest = min(declared or testbed.MAX_DURATION, testbed.MAX_DURATION)
    total = trials + 4
    counted = room.source.counts_its_steps
    (ideal,) = room.run([room.plan("ideal", longest=longest)], count("ideal run", total))
    fatal = ideal.outcome.ended in FATAL and not ideal.outcome.left_with_code
    if not ideal.outcome.steps or ideal.outcome.time is None or fatal:
        found = judge.judge(ideal, [], None, None, None, declared, known, counted)
        return found, ideal, []
    moments = np.random.default_rng([seed, 1]).uniform(0.25, 0.75, 2) * ideal.outcome.time
    plans = [
        room.plan("interrupted", interrupt_at=float(moments[0]), longest=longest),
        room.plan("killed", kill_at=float(moments[1]), longest=longest),
        room.plan("drive", initial="drive", only_start=True),
        *(
            room.plan(f"trial-{k:03d}", profile, initial="arrive", seed=seed + k, longest=longest)
            for k in range(trials)
        ),
    ]
    interrupted, killed, drive, *ran = room.run(plans, count("trials", total))
    found = judge.judge(ideal, ran, drive.outcome, interrupted, killed, declared, known, counted)
    return found, ideal, ran


def _report(
    script: Path,
    findings: Sequence[Finding],
    generation: int,
    profile: str,
    ideal: Ran | None = None,
    trials: Sequence[Ran] = (),
    declared: float | None = None,
) -> Report:
    ordered = sorted(findings, key=lambda finding: -finding.verdict)
    return Report(
        script, verdict_of(ordered), ordered, generation, profile, ideal, list(trials), declared
    )
