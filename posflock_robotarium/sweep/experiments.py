"""What a study can run: a registry of experiments with flat, named, scalar parameters.

To add one, write a function of parameters and seeds that returns one dict of numbers a
seed, and register it with the defaults of its parameters:

>>> def coin(parameters, seeds):
...     return [{"heads": float(np.random.default_rng(s).random() < parameters["bias"])}
...             for s in seeds]
>>> register(Experiment("coin", "A biased coin.", {"bias": 0.5}, coin, ("heads",)))
>>> find("coin").with_defaults({"bias": 0.7})
{'bias': 0.7}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from posflock_robotarium.errors import ParameterError
from posflock_robotarium.flock import Flock
from posflock_robotarium.freespace import FreeSpace, simulate_batch
from posflock_robotarium.law import PAPER_EXPERIMENT, PAPER_SIMULATION, LawParameters
from posflock_robotarium.measures import measure, summarise
from posflock_robotarium.placement import random_poses
from posflock_robotarium.sensing import Sensing
from posflock_robotarium.summary import summarise as summarise_log
from posflock_robotarium.trial import simulate
from rps_compat.profiles import load_profile
from rps_compat.realism import Profile

Value = bool | int | float | str
Parameters = Mapping[str, Value]
Outcome = dict[str, float]
Run = Callable[[Parameters, Sequence[np.random.SeedSequence]], list[Outcome]]


@dataclass(frozen=True)
class Experiment:
    """Something a study can run.

    Attributes
    ----------
    name : str
        What a study file calls it.
    summary : str
        What it is, in one line.
    defaults : dict of str to value
        Every parameter, with the value it has where a study says nothing.
    run : function of (parameters, seeds)
        Runs once for each seed and returns one dict of numbers each; raises ParameterError
        where the parameters do not fit together.
    headline : tuple of str
        The outcomes that are drawn where a study asks for no figures.
    together : int
        Runs that are fastest computed in one call.
    check : function of parameters, optional
        Raises ParameterError before anything runs.
    """

    name: str
    summary: str
    defaults: Parameters
    run: Run
    headline: tuple[str, ...]
    together: int = 1
    check: Callable[[Parameters], object] = lambda parameters: None

    def with_defaults(self, given: Parameters) -> dict[str, Value]:
        """Return all parameters, those given in their default's type.

        Raises
        ------
        ParameterError
            Naming an unknown parameter, or a value of the wrong type.
        """
        parameters = dict(self.defaults)
        for name, value in given.items():
            if name not in parameters:
                known = ", ".join(sorted(parameters))
                raise ParameterError(
                    f"{name}: not a parameter of {self.name}; expected one of {known}"
                )
            parameters[name] = _as(type(parameters[name]), name, value)
        return parameters


_EXPERIMENTS: dict[str, Experiment] = {}


def register(experiment: Experiment) -> None:
    """Make an experiment known under its name.

    Raises
    ------
    ParameterError
        Where another has the name already.
    """
    if experiment.name in _EXPERIMENTS:
        raise ParameterError(f"experiment {experiment.name!r} is registered already")
    _EXPERIMENTS[experiment.name] = experiment


def find(name: str) -> Experiment:
    """Return the experiment of a name.

    Raises
    ------
    ParameterError
        Listing the names there are.
    """
    if name not in _EXPERIMENTS:
        names = ", ".join(sorted(_EXPERIMENTS))
        raise ParameterError(f"experiment: expected one of {names}; got {name!r}")
    return _EXPERIMENTS[name]


def names() -> list[str]:
    """Return the names of all experiments."""
    return sorted(_EXPERIMENTS)


def _as(kind: type, name: str, value: Any) -> Value:
    """Return a value in the type of its default; a whole number will do for a float."""
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if kind is int and isinstance(value, float) and value.is_integer():
        return int(value)
    if type(value) is not kind or not isinstance(value, (bool, int, float, str)):
        raise ParameterError(f"{name}: expected {kind.__name__}, got {value!r}")
    return value


def _number(parameters: Parameters, name: str) -> float:
    return float(parameters[name])


def _law(parameters: Parameters) -> LawParameters:
    return LawParameters(**{name: parameters[name] for name in LawParameters.__dataclass_fields__})  # type: ignore[arg-type]


# ---------------------------------------------------------------- points in free space

_SENSING = asdict(Sensing())
_SPACE = ("model", "agents", "dimensions", "side", "fastest_start", "duration", "time_step")


def _free_space(parameters: Parameters) -> FreeSpace:
    space = {name: parameters[name] for name in (*_SPACE, "record_interval")}
    sensing = Sensing(**{name: parameters[name] for name in _SENSING})  # type: ignore[arg-type]
    return FreeSpace(**space, law=_law(parameters), sensing=sensing)  # type: ignore[arg-type]


def _run_free_space(
    parameters: Parameters, seeds: Sequence[np.random.SeedSequence]
) -> list[Outcome]:
    scenario = _free_space(parameters)
    numbers = summarise(measure(simulate_batch(scenario, seeds), scenario.law.radius))
    return [{name: float(row[b]) for name, row in numbers.items()} for b in range(len(seeds))]


_DEFAULT_SPACE = FreeSpace().as_dict()

register(
    Experiment(
        "freespace",
        "Point agents in the plane or in space, the paper's simulation.",
        {name: _DEFAULT_SPACE[name] for name in _SPACE}
        | {"record_interval": 1.0}
        | PAPER_SIMULATION.as_dict()
        | _SENSING,
        _run_free_space,
        headline=("gamma_settled", "nearest_neighbour_settled"),
        together=8,
        check=_free_space,
    )
)


# ---------------------------------------------------------------- robots in the arena


def _flock(parameters: Parameters) -> tuple[Flock, Profile]:
    if _number(parameters, "robots") < 1 or _number(parameters, "duration") <= 0.0:
        raise ParameterError(
            "robots from 1 and a duration above 0 s are expected; got"
            f" {parameters['robots']} and {parameters['duration']}"
        )
    flock = Flock(_law(parameters), walls=str(parameters["walls"]))
    return flock, load_profile(str(parameters["profile"]))


def _run_robots(parameters: Parameters, seeds: Sequence[np.random.SeedSequence]) -> list[Outcome]:
    flock, profile = _flock(parameters)
    side, spacing = _number(parameters, "side"), _number(parameters, "spacing")
    robots, duration = int(_number(parameters, "robots")), _number(parameters, "duration")
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
        numbers = summarise_log(trial.truth()).as_dict()
        found.append({k: float(v) for k, v in numbers.items() if not isinstance(v, str)})
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
    )
)
