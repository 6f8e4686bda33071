"""The experiment ``freespace``: point agents, under the paper's models or a law of one's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial

import numpy as np

from posflock_robotarium.alignment.point_agents import measure, summarise
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import PAPER_SIMULATION
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.inputs import OwnLaw
from posflock_robotarium.freespace.sensing import Sensing
from posflock_robotarium.freespace.simulation import Floats, FreeSpace, simulate_batch
from posflock_robotarium.sweep.experiments import (
    Experiment,
    Outcome,
    Parameters,
    law_parameters,
    register,
)

_SENSING = asdict(Sensing())
_SPACE = ("agents", "dimensions", "side", "fastest_start", "duration", "time_step")
_DEFAULT_SPACE = FreeSpace().as_dict()
_DEFAULTS = (
    {name: _DEFAULT_SPACE[name] for name in _SPACE}
    | {"record_interval": 1.0}
    | PAPER_SIMULATION.as_dict()
    | _SENSING
)


def register_law(
    name: str, summary: str, law: Callable[..., Floats], own: Parameters | None = None
) -> None:
    """Register an experiment: the simulation of the paper under a law of one's own.

    It has the parameters and outcomes of ``freespace``, without ``model``.

    Parameters
    ----------
    name, summary : str
        Of the experiment.
    law : function of (Sensed, LawParameters, own parameters)
        Computes the input, (B, d, n) in m/s², see
        :class:`posflock_robotarium.freespace.simulation.FreeSpace`.
    own : dict of str to value, optional
        Parameters of the law alone, handed to it by name, with their defaults.

    Raises
    ------
    ParameterError
        Where a name is taken.
    """
    own = own or {}
    taken = sorted({*own} & {*_DEFAULTS, "model"})
    if taken:
        raise ParameterError(f"{', '.join(taken)}: freespace has such a parameter; rename it")

    def scenario(parameters: Parameters) -> FreeSpace:
        return _free_space(parameters, partial(law, **{key: parameters[key] for key in own}))

    def run(parameters: Parameters, seeds: Sequence[np.random.SeedSequence]) -> list[Outcome]:
        return _measured(scenario(parameters), seeds)

    register(
        Experiment(
            name,
            summary,
            {**_DEFAULTS, **own},
            run,
            headline=_HEADLINE,
            together=8,
            check=scenario,
            sources=(law,),
        )
    )


def _free_space(parameters: Parameters, own_law: OwnLaw | None = None) -> FreeSpace:
    space = {name: parameters[name] for name in (*_SPACE, "record_interval")}
    sensing = Sensing(**{name: parameters[name] for name in _SENSING})  # type: ignore[arg-type]
    space["model"] = parameters.get("model", Model.POSITION.value)
    law = law_parameters(parameters)
    return FreeSpace(**space, law=law, sensing=sensing, own_law=own_law)  # type: ignore[arg-type]


def _run_free_space(
    parameters: Parameters, seeds: Sequence[np.random.SeedSequence]
) -> list[Outcome]:
    return _measured(_free_space(parameters), seeds)


def _measured(scenario: FreeSpace, seeds: Sequence[np.random.SeedSequence]) -> list[Outcome]:
    numbers = summarise(measure(simulate_batch(scenario, seeds), scenario.law.radius))
    return [{name: float(row[b]) for name, row in numbers.items()} for b in range(len(seeds))]


_HEADLINE = ("gamma_settled", "nearest_neighbour_settled")

register(
    Experiment(
        "freespace",
        "Point agents in the plane or in space, the paper's simulation.",
        {"model": _DEFAULT_SPACE["model"], **_DEFAULTS},
        _run_free_space,
        headline=_HEADLINE,
        together=8,
        check=_free_space,
    )
)
