"""What a study can run: a registry of experiments with flat, named, scalar parameters.

To add one, write a function of parameters and seeds that returns one dict of numbers a
seed, and register it with the defaults of its parameters:

>>> def coin(parameters, seeds):
...     return [{"heads": float(np.random.default_rng(s).random() < parameters["bias"])}
...             for s in seeds]
>>> register(Experiment("coin", "A biased coin.", {"bias": 0.5}, coin, ("heads",)))
>>> find("coin").with_defaults({"bias": 0.7})
{'bias': 0.7}

The experiments of this package, ``freespace`` and ``robots``, are imported when they are
asked for.  A module that registers one of its own can be named in a study file.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import LawParameters

Value = bool | int | float | str
Parameters = Mapping[str, Value]
Outcome = dict[str, float]
Run = Callable[[Parameters, Sequence[np.random.SeedSequence]], list[Outcome]]
#: The same, with parameters for each seed.
RunMixed = Callable[[Sequence[Parameters], Sequence[np.random.SeedSequence]], list[Outcome]]


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
    reads : function of parameters, optional
        Returns the text of files that the parameters name, whose contents decide a run too.
    sources : tuple of function
        Functions behind `run` that a reader of its module's imports would not find.
    units : mapping of str
        Of its parameters and outcomes; what is missing has an unknown one. Empty where the
        package's own experiments have the same names.
    run_mixed : function of (parameters of each run, seeds), optional
        Computes runs of different parameters in one call, each to the numbers that `run` gives.
    alike : function of parameters
        What runs have in common that `run_mixed` takes in one call, hashable; asked before anything
        is checked.
    engine : function of parameters, optional
        Who computes a run in this process, where that decides its last bits: a row says so.
    """

    name: str
    summary: str
    defaults: Parameters
    run: Run
    headline: tuple[str, ...]
    together: int = 1
    check: Callable[[Parameters], object] = lambda parameters: None
    reads: Callable[[Parameters], str] = lambda parameters: ""
    sources: tuple[Callable[..., object], ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    run_mixed: RunMixed | None = None
    alike: Callable[[Parameters], Hashable] = lambda parameters: None
    engine: Callable[[Parameters], str] | None = None

    def outcomes(
        self, parameters: Sequence[Parameters], seeds: Sequence[np.random.SeedSequence]
    ) -> list[Outcome]:
        """Compute one batch of runs, see `company`.

        Parameters
        ----------
        parameters : sequence of mapping
            Of each run.
        seeds : sequence of SeedSequence
            What each run draws from.
        """
        if self.run_mixed is not None:
            return self.run_mixed(parameters, seeds)
        return self.run(parameters[0], seeds)

    def company(self, parameters: Parameters) -> Hashable:
        """Return what is equal of runs that can be computed in one call.

        Parameters
        ----------
        parameters : mapping
            Of a run.
        """
        if self.run_mixed is not None:
            return self.alike(parameters)
        return tuple(sorted(parameters.items()))

    def with_defaults(self, given: Parameters) -> dict[str, Value]:
        """Return all parameters, those given in their default's type.

        Parameters
        ----------
        given : mapping
            Some parameters, by name.

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


#: Beyond this no parameter of an experiment means anything; in SI units, as all are.
LARGEST = 1e9

_EXPERIMENTS: dict[str, Experiment] = {}

#: Experiments of this package, and the module that registers each.
_BUILT_IN = {
    "freespace": "posflock_robotarium.sweep.points",
    "robots": "posflock_robotarium.sweep.robots",
}


def register(experiment: Experiment) -> None:
    """Make an experiment known under its name.

    Parameters
    ----------
    experiment : Experiment
        What a study may name from now on.

    Raises
    ------
    ParameterError
        Where another has the name already.
    """
    home = _BUILT_IN.get(experiment.name, experiment.run.__module__)
    if experiment.name in _EXPERIMENTS or home != experiment.run.__module__:
        raise ParameterError(f"experiment {experiment.name!r} is registered already")
    _EXPERIMENTS[experiment.name] = experiment


def find(name: str) -> Experiment:
    """Return the experiment of a name.

    Parameters
    ----------
    name : str
        As a study's file names it.

    Raises
    ------
    ParameterError
        Listing the names there are.
    """
    if name not in _EXPERIMENTS and name in _BUILT_IN:
        import_module(_BUILT_IN[name])
    if name not in _EXPERIMENTS:
        raise ParameterError(f"experiment: expected one of {', '.join(names())}; got {name!r}")
    return _EXPERIMENTS[name]


def names() -> list[str]:
    """Return the names of all experiments."""
    return sorted({*_EXPERIMENTS, *_BUILT_IN})


def _as(kind: type, name: str, value: Any) -> Value:
    """Return a value in the type of its default; a whole number will do for a float."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and not abs(value) <= LARGEST:  # NaN is none of these either
        raise ParameterError(f"{name}: expected a number within ±{LARGEST:g}, got {value!r:.40}")
    if kind is float and is_number:
        return float(value)
    if kind is int and isinstance(value, float) and value.is_integer():
        return int(value)
    if type(value) is not kind or not isinstance(value, (bool, int, float, str)):
        raise ParameterError(f"{name}: expected {kind.__name__}, got {value!r}")
    return value


def number(parameters: Parameters, name: str) -> float:
    """Return a parameter as a float.

    Parameters
    ----------
    parameters : mapping
        Names and values.
    name : str
        Which one.
    """
    return float(parameters[name])


def law_parameters(parameters: Parameters) -> LawParameters:
    """Return the parameters of the flocking law, from among an experiment's.

    Parameters
    ----------
    parameters : mapping
        Names and values.
    """
    return LawParameters(**{name: parameters[name] for name in LawParameters.__dataclass_fields__})  # type: ignore[arg-type]
