"""Will it run on the testbed? Predict it, instead of waiting for the answer.

:func:`verify` reads a script's source (`static`), runs it once in the ideal simulator and many
times under imperfections (`trials`), interrupts it twice, and says PASS, RISK or FAIL with
reasons (`judge`, `findings`).  :func:`ablate` asks which imperfection it is that breaks a script.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.verify import judge, static
from posflock_robotarium.verify.ablation import EFFECT_TRIALS, Ablation, ablate
from posflock_robotarium.verify.endings import FATAL
from posflock_robotarium.verify.findings import Code, Finding, Verdict, verdict_of
from posflock_robotarium.verify.report import Report, report_of
from rps_compat import testbed
from rps_compat.bounded_files import read_bounded
from rps_compat.scripts.evidence import evidence_of

if TYPE_CHECKING:
    from posflock_robotarium.verify.trials import ForkServer, Limits, TrialRoom
    from rps_compat.realism import Profile

#: Runs with imperfections where nobody says how many.
TRIALS = 20

_NO_TRIALS = Finding(
    Code.NO_TRIALS,
    Verdict.RISK,
    "nothing was found, but no run under imperfections was looked at: the ideal simulator alone"
    " says little about real robots",
    f"leave out `--trials 0`: {TRIALS} runs are usual",
)

__all__ = [
    "EFFECT_TRIALS",
    "TRIALS",
    "Ablation",
    "Finding",
    "Report",
    "Verdict",
    "ablate",
    "findings",
    "verify",
]


def verify(
    script: Path | str,
    *,
    trials: int = TRIALS,
    profile: Profile | str | Path | None = None,
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
        The imperfections: one of `rps_compat.profiles.NAMES`, or a TOML file; by default those of
        the robots of that generation.
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
    asked = _Asked(trials, profile, generation, declared, seed, tell)
    with contextlib.suppress(OSError):  # that it cannot be read is said below
        asked = replace(asked, sha256=hashlib.sha256(read_bounded(Path(script))).hexdigest())
    report = _verified(Path(script), asked, tuple(search), limits, server)
    return replace(report, sha256=asked.sha256)


@dataclass(frozen=True)
class _Asked:
    """What a script is judged by, its sum, and who is told of it; see `verify`."""

    trials: int
    wanted: Profile | str | Path | None
    generation: int
    declared: float | None
    seed: int
    tell: Callable[[str, int, int], None] | None
    sha256: str = ""

    def __post_init__(self) -> None:
        if self.trials < 0:
            raise ParameterError(f"trials: expected 0 or more, got {self.trials}")
        if self.generation not in (1, 2):
            raise ParameterError(f"generation: expected 1 or 2, got {self.generation}")
        if self.declared is not None and not 0 < self.declared <= testbed.MAX_DURATION:
            raise ParameterError(
                f"declared: expected more than 0 and at most {testbed.MAX_DURATION:.0f} s,"
                f" got {self.declared}"
            )

    @cached_property
    def profile(self) -> Profile:
        """The imperfections of the trials."""
        from rps_compat.profiles import chosen_profile

        return chosen_profile(self.wanted, self.generation)

    @property
    def longest(self) -> float:
        """Seconds after which a run is over."""
        declared = min(self.declared or testbed.MAX_DURATION, testbed.MAX_DURATION)
        return declared + testbed.TIME_STEP  # the last step may end a little after it


def _verified(
    script: Path,
    asked: _Asked,
    search: tuple[Path, ...],
    limits: Limits | None,
    server: ForkServer | None,
) -> Report:
    """Read the source, run it unless that settled it, and put together what both say."""
    from posflock_robotarium.verify import trials as running

    generation, profile = asked.generation, asked.profile.name
    known, source = static.check_source(script, generation, search)
    if source is None or any(
        f.code in (Code.SYNTAX, Code.MODULE_MISSING, Code.STAND_IN) for f in known
    ):
        return report_of(script, known, generation, profile, declared=asked.declared)
    if any(finding.code is Code.GENERATION for finding in known):
        # Run it under the generation it was written for: there may be more to tell.
        generation = evidence_of(source.uses).generation
    with running.TrialRoom(source, generation, limits or running.Limits(), server) as room:
        containment = room.containment
        runs = _run(room, asked)
    found = judge.judge(runs, known, asked.declared, source.counts_its_steps)
    # Runs name the file of every line; a finding does only where that is not the script.
    found = [replace(f, file="") if f.file == script.name else f for f in found]
    # What is written elsewhere is not the run's data.
    elsewhere = {f.line for f in found if f.code is Code.OUTSIDE_WRITE and not f.file}
    known = [f for f in known if f.code is not Code.SAVE_AT_END or f.line not in elsewhere]
    found = [*known, *found]
    if not any(trial.outcome.steps for trial in runs.trials) and verdict_of(found) is Verdict.PASS:
        found.append(_NO_TRIALS)
    report = report_of(
        script,
        found,
        generation,
        profile,
        runs.ideal,
        runs.trials,
        asked.declared,
        judge.drive_time(runs),
    )
    return replace(report, containment=containment)


def _run(room: TrialRoom, asked: _Asked) -> judge.Runs:
    """Run the ideal trial, then all others, whose moments of interruption depend on it."""
    import numpy as np

    done, total = 0, asked.trials + 4

    def count(what: str) -> Callable[[object], None]:
        def told(_: object) -> None:
            nonlocal done
            done += 1
            if asked.tell is not None:
                asked.tell(what, done, total)

        return told

    longest, seed = asked.longest, asked.seed
    (ideal,) = room.run([room.plan("ideal", longest=longest)], count("ideal run"))
    fatal = ideal.outcome.ended in FATAL and not ideal.outcome.left_with_code
    if not ideal.outcome.steps or ideal.outcome.time is None or fatal:
        return judge.Runs(ideal)
    moments = np.random.default_rng([seed, 1]).uniform(0.25, 0.75, 2) * ideal.outcome.time
    plans = [
        room.plan("interrupted", interrupt_at=float(moments[0]), longest=longest),
        room.plan("killed", kill_at=float(moments[1]), longest=longest),
        room.plan("drive", initial="drive", only_start=True),
        *(
            room.plan(
                f"trial-{k:03d}", asked.profile, initial="arrive", seed=seed + k, longest=longest
            )
            for k in range(asked.trials)
        ),
    ]
    interrupted, killed, drive, *trials = room.run(plans, count("trials"))
    return judge.Runs(ideal, tuple(trials), drive.outcome, interrupted, killed)
