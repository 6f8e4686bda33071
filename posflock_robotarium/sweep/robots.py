"""The experiment ``robots``: nine robots, or more, on wheels in the arena."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.law import PAPER_EXPERIMENT
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.simulation.flock_trial import simulate
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

#: More robots than fit into the arena, and a day: what is beyond is a slip of the pen.
_MOST_ROBOTS, _LONGEST = 1000, 86_400.0


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
    flock, profile = _flock(parameters)
    side, spacing = number(parameters, "side"), number(parameters, "spacing")
    robots, duration = int(number(parameters, "robots")), number(parameters, "duration")
    found = []
    for seed in seeds:
        start = random_poses(robots, np.random.default_rng(seed), side=side, spacing=spacing)
        (noise,) = seed.spawn(1)
        trial = simulate(
            flock,
            start,
            duration,
            realism=profile.start(),
            seed=int(noise.generate_state(1, np.uint64)[0]),
        )
        numbers = asdict(summarise(trial.truth()))
        del numbers["ended"]
        found.append({k: math.nan if v is None else float(v) for k, v in numbers.items()})
        del found[-1]["duration"]
    return found


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
        check=_flock,
        reads=_profile_text,
    )
)
