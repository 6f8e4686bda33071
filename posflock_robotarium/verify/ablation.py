"""Which imperfection is it that breaks a script: runs under each of them alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.alignment.intervals import told_interval
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.verify import static
from rps_compat.running.outcome import Ended
from rps_compat.scripts.evidence import evidence_of
from rps_compat.violations import FaultKind

if TYPE_CHECKING:
    from posflock_robotarium.verify.trials import Limits
    from rps_compat.realism import Profile

#: Runs under one imperfection where nobody says how many.
EFFECT_TRIALS = 5


@dataclass(frozen=True)
class Ablation:
    """How a script fares under one imperfection alone.

    Attributes
    ----------
    effect : str
        Its name; ``all`` for the whole profile.
    trials, collisions, outside, failed : int
        Runs; how many had a collision, left the arena, ended badly.
    gap : float, optional
        Smallest distance of two centres in any of them, m; None where none has one.
    """

    effect: str
    trials: int
    collisions: int
    outside: int
    failed: int
    gap: float | None

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % confidence interval of the proportion of runs that collide; None of few runs."""
        return told_interval(self.collisions, self.trials)


def ablate(
    script: Path | str,
    *,
    effects: Sequence[str] = (),
    trials: int = EFFECT_TRIALS,
    profile: Profile | str | Path | None = None,
    generation: int = 2,
    seed: int = 0,
    limits: Limits | None = None,
    tell: Callable[[str, int, int], None] | None = None,
) -> list[Ablation]:
    """Run a script under each imperfection of a profile alone, and under all of them.

    Parameters
    ----------
    script : path
        The main file; its local modules and data lie beside it.
    effects : sequence of str
        Which; all that the profile has by default.
    trials : int
        Runs under each.
    profile : Profile, name or path
        The imperfections: one of `rps_compat.profiles.NAMES`, or a TOML file; by default those of
        the robots of that generation.
    generation : int
        Of the API that the testbed runs, where the script does not tell.
    seed : int
        First of the trials' seeds.
    limits : Limits, optional
        What each trial may use.
    tell : callable, optional
        Is told of progress: what, done, of how many.

    Raises
    ------
    ParameterError
        Where the script is not valid Python.
    ScriptError
        Where it cannot be read.
    ProfileError
        Where the profile is not one.
    """
    from posflock_robotarium.verify import trials as running
    from rps_compat.profiles import chosen_profile

    _, source = static.check_source(Path(script), generation)
    if source is None:
        raise ParameterError(f"{script}: is not valid Python; `posflock verify` says where")
    evidence = evidence_of(source.uses)
    generation = evidence.generation if evidence.certain else generation
    chosen = chosen_profile(profile, generation)
    cases = [(name, chosen.only(name)) for name in effects or chosen.effects] + [("all", chosen)]
    out = []
    with running.TrialRoom(source, generation, limits or running.Limits()) as room:
        plans = [
            room.plan(f"{name}-{k}", case, initial="arrive", seed=seed + k)
            for name, case in cases
            for k in range(trials)
        ]
        count = iter(range(1, len(plans) + 1))
        ran = room.run(plans, lambda o: tell(o.name, next(count), len(plans)) if tell else None)
    for index, (name, _) in enumerate(cases):
        own = [r.outcome for r in ran[index * trials : (index + 1) * trials]]
        out.append(
            Ablation(
                name,
                len(own),
                sum(bool(o.faults(FaultKind.COLLISION)) for o in own),
                sum(bool(o.faults(FaultKind.BOUNDARY)) for o in own),
                sum(o.ended not in (Ended.FINISHED, Ended.OVER_TIME) for o in own),
                min((o.smallest_gap.metres for o in own if o.smallest_gap), default=None),
            )
        )
    return out
