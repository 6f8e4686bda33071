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
from rps_compat.profiles import NAMES, load_profile, profile_text
from rps_compat.realism import Profile


def _flock(parameters: Parameters) -> tuple[Flock, Profile]:
    if number(parameters, "robots") < 1 or number(parameters, "duration") <= 0.0:
        raise ParameterError(
            "robots from 1 and a duration above 0 s are expected; got"
            f" {parameters['robots']} and {parameters['duration']}"
        )
    flock = Flock(law_parameters(parameters), walls=str(parameters["walls"]))
    return flock, load_profile(str(parameters["profile"]))


def _profile_text(parameters: Parameters) -> str:
    profile = str(parameters["profile"])
    return profile_text(profile) if profile in NAMES else Path(profile).read_text("utf-8")


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
