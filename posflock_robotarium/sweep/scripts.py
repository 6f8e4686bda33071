"""The experiment ``script``: any Robotarium script, whose constants a study varies.

The script stays as it is. Every run has a folder of its own, with a copy in which other numbers
stand for the constants at the top, the modules beside it and the files that it reads; what the
script writes goes with the folder. Runs have a simulated clock and no display, as ``posflock run``
has them without one; what comes out are the numbers of ``posflock report``.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import tempfile
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NoReturn

import numpy as np

from posflock_robotarium.alignment.catalogue import scalars
from posflock_robotarium.alignment.measuring import measure, numbers_of
from posflock_robotarium.alignment.own_metrics import own_metrics
from posflock_robotarium.flocking.errors import ParameterError, PosflockError
from posflock_robotarium.logs.readers import read
from posflock_robotarium.logs.recorder import open_pose_log
from posflock_robotarium.sweep.experiments import Experiment, Outcome, Parameters, Value, find
from posflock_robotarium.sweep.script_constants import constants_in, with_constants
from posflock_robotarium.sweep.sources import load
from posflock_robotarium.verify.files import files_read
from posflock_robotarium.verify.source import Source
from posflock_robotarium.verify.trials import lay_out
from rps_compat.bounded_files import read_bounded
from rps_compat.profiles import NAMES, load_profile, profile_text
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.running.outcome import Ended
from rps_compat.running.outcome import Outcome as RunOutcome
from rps_compat.scripts.source import read_script
from rps_compat.testbed import MAX_DURATION

NAME = "script"
#: Parameters of a study that are no constants of the script, with their defaults.
BESIDE: dict[str, Value] = {"profile": "ideal", "metric": ""}
#: Columns of a row that say what was run; a constant of such a name is not to be varied.
_COLUMNS = ("key", "point", "replication", "experiment", "study_seed", "seconds", "version", "code")


class ScriptRunError(PosflockError):
    """A script of a study did not end by itself, or left no log to judge."""


def experiment_of(name: str, module: Path | None) -> Experiment:
    """Return the experiment that a study names.

    Parameters
    ----------
    name : str
        Of a registered experiment, or ``script``.
    module : Path, optional
        The file that registers it; of ``script``, the script.

    Raises
    ------
    ParameterError
        Where there is none of that name, or it is ``script`` without one.
    ModuleError
        Where the module cannot be imported.
    """
    if name == NAME:
        if module is None:
            raise ParameterError(f'experiment "{NAME}": expected its file, script = "main.py"')
        return script_experiment(module)
    if module is not None:
        load(module)
    return find(name)


@cache
def script_experiment(path: Path) -> Experiment:
    """Return the experiment that runs a script.

    Parameters
    ----------
    path : Path
        The script's file, as it is when this process first asks.

    Raises
    ------
    ScriptError
        Where there is no such file, or it is not Python.
    """
    source = Source(read_script(path))
    constants = {
        name: value
        for name, value in constants_in(source.script).items()
        if name not in BESIDE and name not in _COLUMNS
    }

    def run(parameters: Parameters, seeds: Sequence[np.random.SeedSequence]) -> list[Outcome]:
        return [_one_run(source, parameters, seed) for seed in seeds]

    def check(parameters: Parameters) -> None:
        load_profile(str(parameters["profile"]))
        with own_metrics(_metrics(source, parameters)):
            pass

    def reads(parameters: Parameters) -> str:
        files = [source.path.parent / name for _, name in files_read(source)]
        files += [Path(asked.rpartition(":")[0]) for asked in _metrics(source, parameters)]
        sums = [hashlib.sha256(f.read_bytes()).hexdigest() for f in files if f.is_file()]
        return "\n".join([_profile_text(str(parameters["profile"])), *sums])

    return Experiment(
        NAME,
        f"{path.name}, with other numbers for its constants.",
        BESIDE | constants,
        run,
        headline=("speed", "smallest_distance"),
        check=check,
        reads=reads,
        sources=(run_script, *_faces()),
        units={key: scalar.unit or "–" for key, scalar in scalars().items()},
    )


def _faces() -> tuple[type, ...]:
    """Return what `rps` is for a script: the runner imports it by name."""
    from rps_compat.v1.robotarium import Robotarium as First
    from rps_compat.v2.robotarium import Robotarium as Second

    return First, Second


def _profile_text(name: str) -> str:
    return profile_text(name) if name in NAMES else read_bounded(Path(name)).decode()


def _metrics(source: Source, parameters: Parameters) -> list[str]:
    """Return the metrics asked for, whose files are named from the script's folder."""
    asked = str(parameters["metric"]).split()
    return [str(source.path.resolve().parent / one) for one in asked]


def _one_run(source: Source, parameters: Parameters, seed: np.random.SeedSequence) -> Outcome:
    constants = {name: value for name, value in parameters.items() if name not in BESIDE}
    with tempfile.TemporaryDirectory(prefix="posflock-") as name:
        script, out = Path(name, "run", source.path.name), Path(name, "out")
        script.parent.mkdir()
        lay_out(source, script.parent)
        script.write_bytes(with_constants(source.script, constants))
        profile = load_profile(str(parameters["profile"]))
        settings = RunSettings(
            headless=True,
            # As the trials of `verify`: numbers are of the experiment, not of the way to its start.
            initial="arrive" if profile.effects else "exact",
            seed=int(seed.generate_state(1)[0]),
            profile=profile,
            timeout=MAX_DURATION,
            out=out,
            recorder=open_pose_log,
            end_process=_end_worker,
        )
        with _quiet():
            outcome = run_script(script, settings=settings)
        log = _log_of(outcome)
        with own_metrics(_metrics(source, parameters)):
            numbers = numbers_of(measure(read(log)))
    return {_column(key, parameters): number.value for key, number in numbers.items()}


def _column(key: str, parameters: Parameters) -> str:
    """Return what a number is called in a table: a constant of its name has that already."""
    return f"run_{key}" if key in parameters or key in _COLUMNS else key


def _log_of(outcome: RunOutcome) -> Path:
    """Return the log of a run's one Robotarium."""
    if outcome.ended is not Ended.FINISHED:
        raise ScriptRunError(f"{outcome.ended}: {outcome.reason}")
    logs = [path for path in map(Path, outcome.files) if path.suffix == ".npy"]
    if len(logs) != 1:
        raise ScriptRunError(f"expected a script that makes one Robotarium, got {len(logs)}")
    return logs[0]


def _end_worker(outcome: RunOutcome) -> NoReturn:
    """End this worker process, which its script does not leave; the sweep goes on without it."""
    os._exit(outcome.exit_code or 1)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield
