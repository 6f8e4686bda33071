"""What a run was, computed once: curves, numbers, faults and verdicts, to save, reload, compare.

>>> import numpy as np
>>> from posflock_robotarium.report import Run, analyse
>>> t = np.arange(100) * 0.033
>>> poses = np.zeros((100, 3, 2))
>>> poses[:, 0] = 0.1 * t[:, np.newaxis]
>>> poses[:, 1] = [0.0, 0.4]
>>> analysis = analyse(Run("pair", t, poses), radius=0.75)
>>> analysis.numbers["gamma_motion"].value
1.0
"""

from __future__ import annotations

import dataclasses
import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.estimators import ESTIMATORS
from posflock_robotarium.alignment.faults import faults_of
from posflock_robotarium.alignment.following import Following, following_of
from posflock_robotarium.alignment.measuring import curves_of, measure, numbers_of
from posflock_robotarium.alignment.metric_registry import Number
from posflock_robotarium.alignment.options import TRANSIENT, AnalysisOptions, settled_samples
from posflock_robotarium.alignment.plain_values import plain_value, statistics
from posflock_robotarium.alignment.questions import Asked, ChosenBy, Questions, asked_of
from posflock_robotarium.alignment.target_outcomes import (
    TargetOutcome,
    numbers_of_targets,
    outcomes_of,
)
from posflock_robotarium.alignment.verdicts import RunVerdict, verdicts_of
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.flocking.flock import told_walls
from posflock_robotarium.logs.plausibility import Sightings, of_robots, sightings_of
from posflock_robotarium.logs.printed_log import PrintedLog
from posflock_robotarium.logs.readers import ReadOptions, Run, read
from posflock_robotarium.logs.readers.numpy_archives import read_npz
from posflock_robotarium.logs.start import experiment_start
from rps_compat.testbed import RobotModel
from rps_compat.violations import Event
from rps_compat.whole_files import atomic_write

Floats = NDArray[np.float64]

FORMAT = "posflock analysis 1"

_COLUMNS = ("commands", "intervention", "clearance", "status", "real_time")


@dataclass(frozen=True, eq=False)
class Analysis:
    """The result of `analyse`.

    Attributes
    ----------
    recording : Run
        What was analysed.
    options : AnalysisOptions
        With what; its radius is the one that was used.
    robot : RobotModel
        Collision test, wheels and arena of the testbed.
    generation : str
        Which robot that is, in words.
    estimators : dict of str
        Estimator to the sentence that describes it.
    curves : dict of (T,) arrays
        Values over time by the key of their `metric_registry.Metric`; NaN where undefined.
    numbers : dict of Number
        Every scalar of the summary, with unit and definition.
    events : tuple of Event
        Collisions and boundary crossings in the order in which they began.
    verdicts : tuple of RunVerdict
        The run in sentences.
    asked : Asked
        What it was asked, and why that.
    targets : tuple of TargetOutcome
        How it did by its targets.
    following : Following or None
        How robots followed their commands; None of a log without any.
    """

    recording: Run
    options: AnalysisOptions
    robot: RobotModel
    generation: str
    estimators: Mapping[str, str]
    curves: Mapping[str, Floats]
    numbers: Mapping[str, Number]
    events: tuple[Event, ...] = field(repr=False)
    verdicts: tuple[RunVerdict, ...]
    asked: Asked
    targets: tuple[TargetOutcome, ...] = ()
    following: Following | None = None

    @property
    def name(self) -> str:
        """What the run is called."""
        return self.recording.name

    @property
    def origin(self) -> str:
        """Where the poses come from: ``simulation``, ``testbed`` or ``unknown``."""
        return {True: "simulation", False: "testbed", None: "unknown"}[self.recording.simulated]

    @property
    def walls(self) -> str:
        """What kept the flock off the walls, in words; empty where the log does not say."""
        return told_walls(self.recording.parameters)

    @property
    def transient(self) -> float:
        """Seconds of the transient, which numbers named "settled" leave out of a longer run."""
        return TRANSIENT if self.options.transient is None else self.options.transient

    @cached_property
    def sightings(self) -> Sightings:
        """What is believed of the poses, and what is not."""
        return sightings_of(self.recording, self.recording.t, counted=not self.recording.timed)

    @cached_property
    def believed(self) -> Run:
        """The run without poses that are not believed: what was measured, and is drawn."""
        found = self.sightings
        return self.recording if found.impossible else of_robots(self.recording, found)

    @property
    def settled(self) -> NDArray[np.bool_]:
        """Samples that count for the numbers named "settled": (T,) booleans."""
        return settled_samples(self.recording.t, self.options.transient, self.start)

    @property
    def start(self) -> float:
        """When the experiment began, s by the log's times: after the drive to the start."""
        return experiment_start(self.recording, self.options.drive)

    def summary(self) -> dict[str, Any]:
        """Return everything but the curves, ready for JSON (NaN becomes null).

        Returns
        -------
        dict
            Run, how it was read, estimators, options, numbers, statistics, events, what was asked,
            targets, verdicts.
        """
        recording = self.recording
        summary: dict[str, Any] = plain_value(
            {
                "format": FORMAT,
                "run": self.name,
                "sources": list(recording.sources),
                "how_it_was_read": list(recording.notes),
                "printed": recording.printed and dataclasses.asdict(recording.printed),
                "origin": self.origin,
                "robot": {"generation": self.generation, **dataclasses.asdict(self.robot)},
                "options": dataclasses.asdict(self.options),
                "estimators": dict(self.estimators),
                "numbers": {
                    key: dataclasses.asdict(number) for key, number in self.numbers.items()
                },
                "statistics": {key: statistics(curve) for key, curve in self.curves.items()},
                "events": [dataclasses.asdict(event) for event in self.events],
                "asked": {**dataclasses.asdict(self.asked), "reason": self.asked.reason},
                "targets": [dataclasses.asdict(target) for target in self.targets],
                "poses_left_out": [
                    {**dataclasses.asdict(entry), "why": entry.why.value}
                    for entry in self.sightings.unbelieved
                ],
                "verdicts": [dataclasses.asdict(verdict) for verdict in self.verdicts],
                "following": self.following and dataclasses.asdict(self.following),
                "parameters": dict(recording.parameters),
            }
        )
        return summary

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Save poses, curves and summary in one ``.npz`` that `load` reads back, bit for bit.

        Parameters
        ----------
        path : path
            Where the ``.npz`` is written.

        Raises
        ------
        OutputError
            When the file cannot be written.
        """
        target = Path(path)
        recording = self.recording
        arrays: dict[str, NDArray[Any]] = {
            "t": recording.t,
            "poses": recording.poses,
            "analysis": np.frombuffer(json.dumps(self.summary()).encode(), dtype=np.uint8),
        }
        for name in _COLUMNS:
            values = getattr(recording, name)
            if values is not None:
                arrays[name] = values
        arrays |= {f"curve_{key}": curve for key, curve in self.curves.items()}
        with atomic_write(target) as draft, draft.open("wb") as file:
            np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
        return target


def analyse(
    log: Run | str | os.PathLike[str],
    options: AnalysisOptions | None = None,
    *,
    radius: float | None = None,
    read_options: ReadOptions | None = None,
) -> Analysis:
    """Analyse one run.

    Parameters
    ----------
    log : Run or path
        What to analyse; a path is read by `readers.read`.
    options : AnalysisOptions, optional
        Radius, window and thresholds.
    radius : float, optional
        Short for ``AnalysisOptions(radius=radius)``.
    read_options : ReadOptions, optional
        What the file does not say itself.

    Returns
    -------
    Analysis
        Curves, numbers, events, verdicts.

    Raises
    ------
    LogError
        When the log cannot be read, or it is asked whether it flocks and its neighbour radius is
        known from nowhere.
    ParameterError
        When the run ends before its transient is over, or a target names no metric or another
        kind of unit.
    """
    options = options or AnalysisOptions()
    if radius is not None:
        options = dataclasses.replace(options, radius=radius)
    recording = log if isinstance(log, Run) else read(log, read_options)
    asked = asked_of(recording, options.questions, options.radius)
    run = measure(recording, options)
    numbers = numbers_of(run)
    targets = outcomes_of(run, numbers)
    return Analysis(
        recording=recording,
        options=run.options,
        robot=run.robot,
        generation=run.recording.logged_robot.words,
        estimators={name: run.motion(name).description for name in ESTIMATORS},
        curves=curves_of(run),
        numbers=numbers_of_targets(targets) | numbers,  # what was asked, first
        events=tuple(run.once(faults_of).events),
        verdicts=verdicts_of(
            recording,
            numbers,
            run.options.threshold,
            run.options.slowest,
            asked.questions,
            targets,
            run.sightings,
        ),
        asked=asked,
        targets=targets,
        following=run.once(following_of),
    )


def judged_again(saved: Analysis, asked: AnalysisOptions) -> Analysis:
    """Analyse the poses of a saved analysis again, as they were, but asked something else.

    Parameters
    ----------
    saved : Analysis
        From `load`.
    asked : AnalysisOptions
        Whose questions and targets are asked; all else is as it was.

    Raises
    ------
    LogError
        When it is asked whether it flocks, and its neighbour radius is known from nowhere.
    ParameterError
        When a target names no metric or another kind of unit.
    """
    questions = saved.asked.questions if saved.asked.by is ChosenBy.USER else None
    given = saved.asked.by in (ChosenBy.USER, ChosenBy.RADIUS)
    options = dataclasses.replace(
        saved.options,
        radius=saved.options.radius if given else None,
        questions=asked.questions or questions,
        targets=asked.targets or saved.options.targets,
    )
    return analyse(saved.recording, options)


def load(path: str | os.PathLike[str]) -> Analysis:
    """Read an analysis back that `Analysis.save` wrote.

    Parameters
    ----------
    path : path
        A file ``.npz``.

    Raises
    ------
    LogError
        When the file is none, or is damaged.
    """
    target = Path(path)
    if not target.is_file():
        raise LogError(f"{target}: no such file")
    arrays = read_npz(target)
    try:
        summary = json.loads(arrays["analysis"].tobytes().decode())
        if summary["format"] != FORMAT:
            raise LogError(f"{target}: format {summary['format']!r}, expected {FORMAT!r}")
        recording = Run(
            name=summary["run"],
            t=arrays["t"],
            poses=arrays["poses"],
            commands=arrays.get("commands"),
            intervention=arrays.get("intervention"),
            clearance=arrays.get("clearance"),
            status=arrays.get("status"),
            real_time=arrays.get("real_time"),
            printed=PrintedLog(**printed) if (printed := summary.get("printed")) else None,
            parameters=summary["parameters"],
            notes=tuple(summary["how_it_was_read"]),
            sources=tuple(summary["sources"]),
        )
        options = dict(summary["options"])
        if isinstance(options["radius"], list):
            options["radius"] = tuple(options["radius"])
        if options.get("questions") is not None:
            options["questions"] = Questions(options["questions"])
        options["targets"] = tuple(options.get("targets", ()))
        robot = dict(summary["robot"])
        generation = robot.pop("generation")
        robot["boundaries"] = tuple(robot["boundaries"])
        return Analysis(
            recording=recording,
            options=AnalysisOptions(**options),
            robot=RobotModel(**robot),
            generation=generation,
            estimators=summary["estimators"],
            curves={k[6:]: v for k, v in arrays.items() if k.startswith("curve_")},
            numbers={key: Number(**_restored(n)) for key, n in summary["numbers"].items()},
            events=tuple(
                Event(**{**event, "robots": tuple(event["robots"])}) for event in summary["events"]
            ),
            verdicts=tuple(RunVerdict(**verdict) for verdict in summary["verdicts"]),
            following=Following.from_dict(said) if (said := summary.get("following")) else None,
            **_asked(summary),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise LogError(f"{target}: not a saved analysis ({error!r})") from error


def _asked(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Read what was asked; analyses of earlier versions asked about flocking."""
    asked = summary.get("asked", {"questions": Questions.FLOCKING, "by": ChosenBy.USER})
    return {
        "asked": Asked(Questions(asked["questions"]), ChosenBy(asked["by"])),
        "targets": tuple(TargetOutcome(**target) for target in summary.get("targets", ())),
    }


def is_analysis(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file is a saved analysis and not a log.

    Parameters
    ----------
    path : path
        The file; it need not be there.
    """
    if not Path(path).is_file():
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            return "analysis.npy" in archive.namelist()
    except (OSError, zipfile.BadZipFile):
        return False


def _restored(number: Mapping[str, Any]) -> dict[str, Any]:
    return {k: float("nan") if k == "value" and v is None else v for k, v in number.items()}
