"""The experiment ``robots``: nine robots, or more, on wheels in the arena."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.batch import numba_is_installed
from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.batch.batch_trial import simulate_teams
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.law import PAPER_EXPERIMENT
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.simulation.flock_trial import Trial, simulate
from posflock_robotarium.sweep.experiments import (
    Experiment,
    Outcome,
    Parameters,
    Value,
    law_parameters,
    number,
    register,
)
from rps_compat.bounded_files import read_bounded
from rps_compat.profiles import NAMES, load_profile, profile_text
from rps_compat.realism import Profile

Floats = NDArray[np.float64]

#: More robots than fit into the arena, and a day: what is beyond is a slip of the pen.
_MOST_ROBOTS, _LONGEST = 1000, 86_400.0
#: Seconds from which on a run is compiled, where numba is installed: a shorter one is over before
#: compiled code is loaded. It hangs on the run alone, so that company changes no number.
_COMPILED_FROM = 10.0
#: Poses that trials keep in memory, 70 bytes each; pairs of robots that a processor's cache holds.
_KEPT_POSES, _CACHED_PAIRS = 2_000_000, 1 << 15


def _flock(parameters: Parameters) -> tuple[Flock, Profile]:
    robots, duration = number(parameters, "robots"), number(parameters, "duration")
    if not (1 <= robots <= _MOST_ROBOTS and 0.0 < duration <= _LONGEST):
        raise ParameterError(
            f"robots from 1 to {_MOST_ROBOTS} and a duration above 0 s and up to {_LONGEST:g} s are"
            f" expected; got {parameters['robots']} and {parameters['duration']}"
        )
    flock = Flock(law_parameters(parameters), walls=str(parameters["walls"]))
    return flock, load_profile(str(parameters["profile"]))


def _profile_text(parameters: Parameters) -> str:
    profile = str(parameters["profile"])
    return profile_text(profile) if profile in NAMES else read_bounded(Path(profile)).decode()


def _run_robots(parameters: Parameters, seeds: Sequence[np.random.SeedSequence]) -> list[Outcome]:
    return _run_mixed([parameters] * len(seeds), seeds)


def _run_mixed(
    parameters: Sequence[Parameters], seeds: Sequence[np.random.SeedSequence]
) -> list[Outcome]:
    """Compute runs that may differ in law, start and imperfections."""
    runs = [_planned(one, seed) for one, seed in zip(parameters, seeds, strict=True)]
    robots, duration = int(number(parameters[0], "robots")), number(parameters[0], "duration")
    together = _teams_at_once(robots, runs[0].flock.steps_in(duration))
    found: dict[int, Outcome] = {}
    for real in (False, True):  # by themselves, since the ideal arena is compiled
        alike = [k for k, run in enumerate(runs) if bool(run.profile.effects) is real]
        for at in range(0, len(alike), together):
            chosen = alike[at : at + together]
            trials = _trials([runs[k] for k in chosen], duration)
            found |= {k: _outcome(trial) for k, trial in zip(chosen, trials, strict=True)}
    return [found[k] for k in range(len(runs))]


@dataclass(frozen=True, eq=False)
class _Planned:
    """A run that is still to be computed."""

    flock: Flock
    profile: Profile
    start: Floats
    noise: int


def _planned(parameters: Parameters, stream: np.random.SeedSequence) -> _Planned:
    flock, profile = _flock(parameters)
    start = random_poses(
        int(number(parameters, "robots")),
        np.random.default_rng(stream),
        side=number(parameters, "side"),
        spacing=number(parameters, "spacing"),
    )
    return _Planned(flock, profile, start, _noise_of(stream))


def _trials(runs: Sequence[_Planned], duration: float) -> list[Trial]:
    """Compute trials, each to the same numbers in whatever company."""
    first = runs[0]
    compiled = _is_compiled(duration)
    if len(runs) == 1 and not compiled:  # bit for bit what numpy makes of many, and faster
        realism = first.profile.start()
        return [simulate(first.flock, first.start, duration, realism=realism, seed=first.noise)]
    return simulate_teams(
        first.flock,
        [run.start for run in runs],
        duration,
        seeds=[run.noise for run in runs],
        realism=[run.profile for run in runs],
        laws=[run.flock.law for run in runs],
        engine="numba" if compiled else "numpy",
        threads=1,  # a study has a process for each processor
    )


def _is_compiled(duration: float) -> bool:
    return duration >= _COMPILED_FROM and numba_is_installed()


def _engine(parameters: Parameters) -> str:
    return "numba" if _is_compiled(number(parameters, "duration")) else "numpy"


def _alike(parameters: Parameters) -> tuple[Value, ...]:
    shared = ("robots", "duration", "walls")
    return (*(parameters[name] for name in shared), parameters["profile"] == "ideal")


def _teams_at_once(robots: int, steps: int) -> int:
    """Return how many teams advance together; this decides speed and memory, but no result."""
    return max(1, min(_KEPT_POSES // (robots * steps), _CACHED_PAIRS // robots**2))


def _noise_of(stream: np.random.SeedSequence) -> int:
    """Return the seed of a run's imperfections: of the stream's first child, however often asked.

    ``spawn`` would give another child when a batch that failed is computed again, run by run.
    """
    child = np.random.SeedSequence(stream.entropy, spawn_key=(*stream.spawn_key, 0))
    return int(child.generate_state(1, np.uint64)[0])


def _outcome(trial: Trial) -> Outcome:
    numbers = asdict(summarise(trial.truth()))
    del numbers["ended"]
    outcome = {k: math.nan if v is None else float(v) for k, v in numbers.items()}
    del outcome["duration"]
    return outcome


_ROBOTS: dict[str, Value] = {
    "robots": 9,
    "duration": 120.0,
    "side": 1.0,
    "spacing": 0.3,
    "walls": "steer",
    "profile": "ideal",
}

register(
    Experiment(
        "robots",
        "Robots on wheels in the arena, with the imperfections of a profile.",
        _ROBOTS | PAPER_EXPERIMENT.as_dict(),
        _run_robots,
        headline=("gamma_motion", "smallest_distance"),
        together=32,
        check=_flock,
        reads=_profile_text,
        run_mixed=_run_mixed,
        alike=_alike,
        engine=_engine,
    )
)
