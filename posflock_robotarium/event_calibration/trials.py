"""Simulate a script under candidate gains and delays, and hear when it prints what.

The trials are those of ``verify``, each in a process of its own, with the robots arriving as on the
testbed; only the clock is not charged for what this machine computes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.event_lines import EventKey, events_in
from posflock_robotarium.verify.fork_server import PRINTED
from posflock_robotarium.verify.source import Source
from posflock_robotarium.verify.static import check_source
from posflock_robotarium.verify.trials import Limits, TrialRoom
from rps_compat.distributions import DistributionKind, RobotDistribution, constant
from rps_compat.realism import DeadTime, Gains, Profile
from rps_compat.running.outcome import Outcome
from rps_compat.running.plan import ClockPolicy
from rps_compat.scripts.evidence import evidence_of


@dataclass(frozen=True)
class Candidate:
    """What robots may be like.

    Attributes
    ----------
    gain : float
        Mean speed gain of the robots.
    delay : float
        Dead time, s.
    seed : int
        Of everything random.
    """

    gain: float
    delay: float
    seed: int


@dataclass(frozen=True)
class Heard:
    """What a script printed under a candidate.

    Attributes
    ----------
    candidate : Candidate
        Under which.
    events : dict
        From events to their times, s.
    seconds : float
        How long the run was, s.
    """

    candidate: Candidate
    events: dict[EventKey, float]
    seconds: float


def script_source(script: Path) -> Source:
    """Return a script as trials need it.

    Parameters
    ----------
    script : Path
        The script's file.

    Raises
    ------
    LogError
        Where it is not Python.
    """
    findings, source = check_source(script)
    if source is None:
        raise LogError(f"{script}: {'; '.join(map(str, findings))}")
    return source


def hear(
    source: Source,
    base: Profile,
    candidates: Sequence[Candidate],
    limits: Limits,
    tell: Callable[[Outcome], None] | None = None,
) -> list[Heard]:
    """Simulate a script under each candidate.

    Parameters
    ----------
    source : Source
        The script, as :func:`script_source` reads it.
    base : Profile
        All that the candidates have in common.
    candidates : sequence of Candidate
        What is tried.
    limits : Limits
        What each trial may use.
    tell : callable, optional
        Is told of each outcome when it is there.
    """
    generation = evidence_of(source.uses).generation
    with TrialRoom(source, generation, limits) as room:
        plans = [
            replace(
                room.plan(f"{number:03d}", with_candidate(base, c), initial="arrive", seed=c.seed),
                clock=ClockPolicy.SIMULATED,
            )
            for number, c in enumerate(candidates)
        ]
        ran = room.run(plans, tell)
        return [
            Heard(candidate, _events(Path(plan.folder).parent), trial.outcome.time or 0.0)
            for candidate, plan, trial in zip(candidates, plans, ran, strict=True)
        ]


def with_candidate(base: Profile, candidate: Candidate) -> Profile:
    """Return a profile with another mean speed gain and another dead time.

    How much robots differ, and how both depend on speed, stays as it was.

    Parameters
    ----------
    base : Profile
        All but gain and delay.
    candidate : Candidate
        Its gain and delay.
    """
    gains = base.gains or Gains()
    speed = scaled(gains.speed, candidate.gain / mean_of(gains.speed))
    delay = constant(candidate.delay)
    dead_time = replace(base.dead_time, seconds=delay) if base.dead_time else DeadTime(delay)
    return replace(base, gains=replace(gains, speed=speed), dead_time=dead_time)


def mean_of(distribution: RobotDistribution) -> float:
    """Return the mean of a distribution over robots.

    Parameters
    ----------
    distribution : RobotDistribution
        Which.
    """
    values = distribution.values
    return values[0] if distribution.kind is DistributionKind.NORMAL else float(np.mean(values))


def scaled(distribution: RobotDistribution, factor: float) -> RobotDistribution:
    """Return a distribution over robots with every value times a factor.

    Parameters
    ----------
    distribution : RobotDistribution
        Which.
    factor : float
        Above 0.
    """
    values = tuple(factor * value for value in distribution.values)
    return RobotDistribution(distribution.kind, values, factor * distribution.limit)


def _events(beside: Path) -> dict[EventKey, float]:
    printed = beside / PRINTED
    return events_in(printed.read_text(errors="replace")) if printed.is_file() else {}
