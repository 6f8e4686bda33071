"""A study file: which runs of which experiment.

.. code-block:: toml

    experiment = "freespace"
    module = "my_law.py"            # only for an experiment of one's own: registers it
    # or, in the place of both:  script = "main.py"
    seed = 1                        # of the whole study
    replications = 20               # of every combination
    common_random_numbers = true    # replication r starts alike in every combination

    [parameters]                    # fixed
    duration = 100.0

    [grid]                          # every combination of these
    model = ["velocity", "position"]
    position_noise = [0.0, 0.02, 0.05]

    [distributions]                 # drawn anew for every run
    distance_scale = { uniform = [0.4, 0.55] }

    [[figures]]
    x = "position_noise"
    y = "gamma_settled"
    by = "model"

Every run has a random stream of its own, ``SeedSequence(seed, spawn_key=...)``, whose key
follows from the run's combination and replication, never from its place in a list: runs
can be added to a study, and be computed in any order, on any machine, without changing one
another.  The stream does not depend on the code, the run's key in the store does: after the
law is edited every run is computed again, from the same start and with the same noise.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.sweep.experiments import Experiment, Value
from posflock_robotarium.sweep.parameter_distribution import (
    ParameterDistribution,
    StudyError,
    read_distribution,
)
from posflock_robotarium.sweep.scripts import NAME as SCRIPT
from posflock_robotarium.sweep.scripts import experiment_of
from posflock_robotarium.sweep.sources import ModuleError, code_of
from rps_compat.bounded_files import read_bounded
from rps_compat.errors import ScriptError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


#: Runs of one study: their descriptions alone take a gigabyte.
MOST_RUNS = 1_000_000


@dataclass(frozen=True)
class Figure:
    """A picture that a study asks for.

    Attributes
    ----------
    x : str
        Parameter along the axis.
    y : str
        Outcome.
    by : str
        Parameter that tells curves apart; empty for one curve.
    """

    x: str
    y: str
    by: str = ""


@dataclass(frozen=True)
class PlannedRun:
    """One run of a study.

    Attributes
    ----------
    key : str
        Names the run by everything that decides its result.
    point : int
        Number of its combination in the grid, from 0.
    replication : int
        From 0.
    parameters : dict
        Every parameter of the experiment.
    stream : SeedSequence
        What it draws from.
    """

    key: str
    point: int
    replication: int
    parameters: dict[str, Value]
    stream: np.random.SeedSequence


@dataclass(frozen=True)
class Study:
    """What a study file says.

    Attributes
    ----------
    experiment : Experiment
        What is run.
    seed : int
        Of the whole study.
    replications : int
        Runs of every combination.
    common_random_numbers : bool
        Whether replication r of every combination draws from one stream, so that
        combinations can be compared run by run.
    parameters : dict
        Fixed values.
    grid : dict of str to list
        Values of which every combination is run.
    distributions : dict of str to distribution
        Parameters drawn anew for every run.
    figures : tuple of Figure
        Pictures asked for.
    module : Path, optional
        The file that registers the experiment, where it is not one of this package's; the script,
        where that is what is run.

    Raises
    ------
    StudyError
        Where a value is outside its range.
    ParameterError
        Where a combination is not admissible.
    """

    experiment: Experiment
    seed: int = 0
    replications: int = 10
    common_random_numbers: bool = False
    parameters: Mapping[str, Value] = field(default_factory=dict)
    grid: Mapping[str, list[Value]] = field(default_factory=dict)
    distributions: Mapping[str, ParameterDistribution] = field(default_factory=dict)
    figures: tuple[Figure, ...] = ()
    module: Path | None = None

    def __post_init__(self) -> None:
        if self.replications < 1 or self.seed < 0:
            raise StudyError(
                "replications from 1 and a seed from 0 are expected; got"
                f" {self.replications} and {self.seed}"
            )
        places = (*self.parameters, *self.grid, *self.distributions)
        twice = sorted({name for name in places if places.count(name) > 1})
        if twice:
            raise StudyError(
                f"{', '.join(twice)}: given in two of [parameters], [grid] and [distributions]"
            )
        runs = self.replications * math.prod(map(len, self.grid.values()))
        if runs > MOST_RUNS:
            raise StudyError(
                f"replications: expected at most {MOST_RUNS} runs in all, got {self.replications}"
                f" of each combination, {runs} runs"
            )
        for name, distribution in self.distributions.items():
            for value in distribution.examples():
                self.experiment.with_defaults({name: value})
        for _, parameters in self._points():
            self.experiment.check(parameters)
        for figure in self.figures:
            for name in (figure.x, *([figure.by] if figure.by else [])):
                if name not in (*self.grid, *self.distributions):
                    raise StudyError(f"figures: {name!r} is not varied in this study")

    @property
    def code(self) -> str:
        """Digest of the code that computes the runs."""
        return code_of(self.experiment, self.module)

    @property
    def said(self) -> dict[str, Any]:
        """The study as its file would say it, but for the figures."""
        return {
            "experiment": self.experiment.name,
            **({"module": self.module.name} if self.module else {}),
            "seed": self.seed,
            "replications": self.replications,
            "common_random_numbers": self.common_random_numbers,
            "parameters": dict(self.parameters),
            "grid": dict(self.grid),
            "distributions": {name: d.as_dict() for name, d in self.distributions.items()},
        }

    def runs(self) -> list[PlannedRun]:
        """Return every run, combination by combination."""
        code = self.code
        return [
            self._run(code, point, combination, parameters, replication)
            for point, (combination, parameters) in enumerate(self._points())
            for replication in range(self.replications)
        ]

    def _points(self) -> list[tuple[dict[str, Value], dict[str, Value]]]:
        """Return for each combination what was chosen, and all parameters."""
        chosen = [
            dict(zip(self.grid, values, strict=True))
            for values in itertools.product(*self.grid.values())
        ]
        return [
            (combination, self.experiment.with_defaults({**self.parameters, **combination}))
            for combination in chosen
        ]

    def _run(
        self,
        code: str,
        point: int,
        combination: dict[str, Value],
        parameters: dict[str, Value],
        replication: int,
    ) -> PlannedRun:
        identity = {
            "experiment": self.experiment.name,
            "parameters": parameters,
            "distributions": {n: d.as_dict() for n, d in self.distributions.items()},
            "seed": self.seed,
            "common": self.common_random_numbers,
            "replication": replication,
        }
        name = _digest(identity)
        spawn_key = (replication,) if self.common_random_numbers else (replication, int(name, 16))
        drawing, stream = np.random.SeedSequence(self.seed, spawn_key=spawn_key).spawn(2)
        generator = np.random.default_rng(drawing)
        drawn = {n: d.draw(generator) for n, d in sorted(self.distributions.items())}
        chosen = self.experiment.with_defaults({**self.parameters, **combination, **drawn})
        key = _digest({"run": name, "code": code, "reads": self.experiment.reads(chosen)})
        return PlannedRun(key, point, replication, chosen, stream)


def _digest(identity: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]


def read_study(path: Path) -> Study:
    """Read a study file.

    Parameters
    ----------
    path : Path
        A TOML file.

    Raises
    ------
    StudyError
        Where the file cannot be read, is not TOML, or has an unknown key or a wrong value;
        the message names the file.
    """
    try:
        said = tomllib.loads(read_bounded(path).decode("utf-8"))
    except OSError as error:
        raise StudyError(f"cannot read {path}: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise StudyError(f"{path} is not TOML: {error}") from error
    try:
        return parse_study(said, path.parent)
    except (StudyError, ParameterError, ModuleError, ScriptError) as error:
        raise StudyError(f"{path}: {error}") from error


def parse_study(said: Mapping[str, Any], folder: Path = Path()) -> Study:
    """Make a study of what a study file says; unknown keys are refused.

    Parameters
    ----------
    said : dict
        The file's contents.
    folder : Path
        Where it lies: `module` is a path from here.

    Raises
    ------
    StudyError, ParameterError, ModuleError, ScriptError
        Naming the key, what was got and what was expected.
    """
    shapes = {"experiment": str, "module": str, "script": str, "seed": int, "replications": int}
    shapes["common_random_numbers"] = bool
    tables = ("parameters", "grid", "distributions")
    _refuse_unknown(said, (*shapes, *tables, "figures"), "a study")
    for name, kind in shapes.items():
        if name in said and type(said[name]) is not kind:
            raise StudyError(f"{name}: expected {kind.__name__}, got {said[name]!r}")
    experiment, module = _chosen(said, folder)
    for name in tables:
        if not isinstance(said.get(name, {}), dict):
            raise StudyError(f"[{name}]: expected a table, got {said[name]!r}")
    for name, values in said.get("grid", {}).items():
        if not isinstance(values, list) or not values:
            raise StudyError(f"grid.{name}: expected a list of at least one value, got {values!r}")
        if len(set(map(repr, values))) < len(values):
            raise StudyError(f"grid.{name}: a value is listed twice in {values!r}")
    chosen = ("experiment", "module", "script")
    return Study(
        experiment=experiment,
        parameters=said.get("parameters", {}),
        grid=said.get("grid", {}),
        distributions={
            n: read_distribution(n, d) for n, d in said.get("distributions", {}).items()
        },
        figures=tuple(_figure(figure) for figure in said.get("figures", ())),
        module=module,
        **{name: said[name] for name in shapes if name not in chosen and name in said},
    )


def _chosen(said: Mapping[str, Any], folder: Path) -> tuple[Experiment, Path | None]:
    """Return the experiment, and the file that it comes from where that is the user's own."""
    if "script" in said:
        if not {"experiment", "module"}.isdisjoint(said):
            raise StudyError("script: a study has either a script or an experiment, not both")
        script = (folder / said["script"]).resolve()
        return experiment_of(SCRIPT, script), script
    if "experiment" not in said:
        raise StudyError(
            'experiment: expected a name such as "freespace", or script = "main.py"; got none'
        )
    module = (folder / said["module"]).resolve() if "module" in said else None
    return experiment_of(said["experiment"], module), module


def _figure(said: Any) -> Figure:
    if not isinstance(said, dict):
        raise StudyError(f"figures: expected tables [[figures]], got {said!r}")
    _refuse_unknown(said, ("x", "y", "by"), "a figure")
    for name in ("x", "y"):
        if not isinstance(said.get(name), str):
            raise StudyError(f"figures.{name}: expected a name, got {said.get(name)!r}")
    return Figure(said["x"], said["y"], said.get("by", ""))


def _refuse_unknown(said: Mapping[str, Any], known: tuple[str, ...], what: str) -> None:
    unknown = sorted(set(said) - set(known))
    if unknown:
        raise StudyError(f"{', '.join(unknown)}: not part of {what}; expected {', '.join(known)}")
