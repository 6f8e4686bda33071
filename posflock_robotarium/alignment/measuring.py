"""From a recording to its metrics: all of them, or only those that somebody asks for."""

from __future__ import annotations

import dataclasses

from posflock_robotarium.alignment import catalogue
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.alignment.questions import Questions, asked_of
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.logs.plausibility import of_robots, sightings_of
from posflock_robotarium.logs.run import Run
from posflock_robotarium.logs.start import experiment_start


def measure(recording: Run, options: AnalysisOptions | None = None) -> MeasuredRun:
    """Return a run whose metrics can be asked for; nothing is computed yet.

    Parameters
    ----------
    recording : Run
        Poses over time.
    options : AnalysisOptions, optional
        Radius, window and thresholds.

    Raises
    ------
    LogError
        When the run is asked whether it flocks, and the neighbour radius is known from nowhere.
    ParameterError
        When the run ends before its drive to the start, or its transient, is over.
    """
    options = options or AnalysisOptions()
    asked = asked_of(recording, options.questions, options.radius)
    known = options.radius is not None or recording.parameters.get("neighbour_radius") is not None
    if known or asked.questions is Questions.FLOCKING:
        options = dataclasses.replace(options, radius=recording.neighbour_radius(options.radius))
    options = dataclasses.replace(options, questions=asked.questions)
    duration = float(recording.t[-1] - experiment_start(recording, options.drive))
    if options.transient is not None and options.transient >= duration:
        raise ParameterError(
            f"{recording.name}: --transient is {options.transient:g} s, but the run ends after "
            f"{duration:.2f} s: nothing is left to take means over; give less, or leave it out"
        )
    found = sightings_of(recording, recording.t, counted=not recording.timed)
    own = recording if found.impossible else of_robots(recording, found)
    curves = {key: metric.curve for key, metric in catalogue.metrics().items()}
    return MeasuredRun(own, options, curves, recording, found)


def curves_of(run: MeasuredRun) -> dict[str, Floats]:
    """Return every curve that the recording has data for.

    Parameters
    ----------
    run : MeasuredRun
        The run; what is computed stays with it.

    Returns
    -------
    dict of (T,) arrays
        By the key of the metric and in its unit; NaN where undefined.
    """
    found = {key: run.curve(key) for key in run.curve_functions}
    return {key: curve for key, curve in found.items() if curve is not None}


def numbers_of(run: MeasuredRun) -> dict[str, catalogue.Number]:
    """Return every number that the recording has data for, in the order of the summary's table.

    Parameters
    ----------
    run : MeasuredRun
        The run; what is computed stays with it.

    Returns
    -------
    dict of Number
        By key; NaN where a number is undefined (γ of a flock that stands, say).
    """
    found = {key: scalar.of(run) for key, scalar in catalogue.scalars().items()}
    return {key: number for key, number in found.items() if number is not None}
