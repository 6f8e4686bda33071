"""A run that is being measured: its poses, motions and curves, each computed when first asked for.

Metrics are functions of a `MeasuredRun`. Whatever several of them need (a direction of motion, γ,
another curve) is computed once and kept. Memory stays small and cost linear: functions of robot
pairs go through `MeasuredRun.by_stretch`, a stretch of samples at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.estimators import Motion, estimate
from posflock_robotarium.alignment.options import TRANSIENT, AnalysisOptions, settled_samples
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS, neighbour_matrices
from posflock_robotarium.logs.plausibility import Sightings
from posflock_robotarium.logs.run import Run
from posflock_robotarium.logs.start import experiment_start
from rps_compat.testbed import RobotModel

Floats: TypeAlias = NDArray[np.float64]
CurveFunction: TypeAlias = "Callable[[MeasuredRun], Floats | None]"
_T = TypeVar("_T")

PAIRS_AT_A_TIME = 200_000
"""Robot pairs in one stretch: a few MB of temporaries, which stay in the processor's cache."""

KEPT_PAIRS = 50_000_000
"""Pairs over time, a byte each, up to which it is kept who is whose neighbour."""


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """One run and what has been found of it so far.

    Attributes
    ----------
    recording : Run
        Poses over time, each robot's own; NaN where none is believed.
    options : AnalysisOptions
        Radius, window and thresholds; the radius is the one to use.
    curve_functions : mapping of str
        How each curve is computed, by its key.
    logged : Run
        The same as it was logged.
    sightings : Sightings
        What of that is believed.
    """

    recording: Run
    options: AnalysisOptions
    curve_functions: Mapping[str, CurveFunction] = field(repr=False)
    logged: Run = field(repr=False)
    sightings: Sightings = field(repr=False)
    _found: dict[tuple[object, ...], Any] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def robot(self) -> RobotModel:
        """Collision test, wheels and arena of the testbed."""
        return self.recording.robot

    @property
    def robots(self) -> int:
        """How many robots were recorded, N."""
        return self.recording.robots

    @cached_property
    def t(self) -> Floats:
        """Times of the samples in seconds, shape (T,); not to be written."""
        return read_only(self.recording.t)

    @cached_property
    def poses(self) -> Floats:
        """x, y in metres and heading in radians, shape (T, 3, N); not to be written."""
        return read_only(self.recording.poses)

    @cached_property
    def headings(self) -> Floats:
        """Headings in radians, shape (T, N), NaN where none were logged; not to be written."""
        return read_only(self.recording.poses[:, 2])

    @cached_property
    def commands(self) -> Floats | None:
        """Commanded m/s and rad/s, shape (T, 2, N), None without; not to be written."""
        return None if self.recording.commands is None else read_only(self.recording.commands)

    @cached_property
    def positions(self) -> Floats:
        """Positions in metres, shape (T, 2, N), NaN where unseen; not to be written."""
        return read_only(self.recording.poses[:, :2])

    @property
    def has_neighbours(self) -> bool:
        """Whether it is known how far neighbours are seen, without which nobody has any."""
        return self.options.radius is not None

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Which robots are seen when, shape (T, N)."""
        return self.recording.seen

    @cached_property
    def all_seen(self) -> bool:
        """Whether everybody is seen all the time, as nearly always."""
        return bool(self.seen.all())

    @cached_property
    def radius(self) -> float | Floats:
        """Return the neighbour radius in metres: one number, or a (N,) array of one a robot."""
        reach = np.asarray(self.options.radius, dtype=float)
        return float(reach) if reach.ndim == 0 else reach

    def neighbours(self, stretch: slice) -> NDArray[np.bool_]:
        """Tell who is whose neighbour in one of the `stretches`.

        Parameters
        ----------
        stretch : slice
            Which.

        Returns
        -------
        (K, N, N) boolean array
            Row i marks the neighbours of robot i; not to be written.
        """
        if len(self.recording.t) * self.recording.robots**2 > KEPT_PAIRS:
            found = neighbour_matrices if self.recording.robots >= TREE_FROM_AGENTS else neighbours
            return found(self.positions[stretch], self.radius)
        return self.once(_neighbours, stretch.start, stretch.stop)

    @cached_property
    def speeds(self) -> Floats:
        """Savitzky-Golay speed of each robot in m/s, shape (T, N)."""
        return read_only(np.sqrt(np.square(self.velocities("savitzky_golay")).sum(axis=1)))

    @cached_property
    def settled(self) -> NDArray[np.bool_]:
        """Samples that count for the numbers named "settled", shape (T,)."""
        return settled_samples(self.recording.t, self.options.transient, self.start)

    @cached_property
    def start(self) -> float:
        """When the experiment began, s by the log's times: after the drive to the start."""
        return experiment_start(self.recording, self.options.drive)

    @property
    def transient(self) -> float:
        """Seconds of the transient, after which these begin where the run is longer."""
        return TRANSIENT if self.options.transient is None else self.options.transient

    @cached_property
    def since(self) -> str:
        """The time that settled numbers are taken over, in words."""
        if self.settled.all():
            return "of the whole run"
        first, t = int(np.argmax(self.settled)), self.recording.t
        if self.start == t[0]:
            return f"after {t[first] - t[0]:.0f} s"
        return f"from {t[first] - self.start:.0f} s after the drive to the start"

    @cached_property
    def weights(self) -> Floats:
        """The time each sample stands for; all one when samples are evenly spaced, (T,)."""
        r = self.recording
        steps = np.diff(r.t)
        if np.abs(steps - steps.mean()).max() <= 1e-6 * steps.mean():
            return np.ones(len(r.t))
        steps[r.gaps - 1] = r.step
        return np.append(steps, r.step)

    def motion(self, estimator: str) -> Motion:
        """Return the motion of the robots by one estimator.

        Parameters
        ----------
        estimator : str
            A key of `estimators.ESTIMATORS`.
        """
        return self.once(_estimated, estimator)

    def velocities(self, estimator: str) -> Floats:
        """Return the velocities of the robots by one estimator.

        Parameters
        ----------
        estimator : str
            A key of `estimators.ESTIMATORS`; that of headings has unit vectors for velocities.

        Returns
        -------
        (T, 2, N) array
            Velocities in the frame of the arena, m/s.
        """
        return read_only(self.motion(estimator).velocities)

    def curve(self, key: str) -> Floats | None:
        """Return a metric over time.

        Parameters
        ----------
        key : str
            Key of the metric, one of `curve_functions`.

        Returns
        -------
        (T,) array, or None
            In the unit of the metric, NaN where undefined; None where the recording has no data.

        Raises
        ------
        ParameterError
            When no metric has that key, or its function returns anything but one value a sample.
        """
        if key not in self.curve_functions:
            known = ", ".join(self.curve_functions)
            raise ParameterError(f"curve {key!r} is of no metric; expected one of {known}")
        values, samples = self.once(self.curve_functions[key]), len(self.recording.t)
        if values is not None and np.shape(values) != (samples,):
            raise ParameterError(
                f"metric {key!r}: its function returned shape {np.shape(values)}; expected one "
                f"value a sample, ({samples},)"
            )
        return None if values is None else read_only(np.asarray(values))

    def once(self, compute: Callable[..., _T], *arguments: object) -> _T:
        """Return ``compute(run, *arguments)``, computed the first time only.

        Parameters
        ----------
        compute : callable
            Takes this run and the arguments. It has to be the same object at every call for its
            result to be found again: a named function, not a lambda written on the spot.
        *arguments : hashable
            What it depends on besides the run.
        """
        question = (compute, *arguments)
        if question not in self._found:
            self._found[question] = compute(self, *arguments)
        found: _T = self._found[question]
        return found

    def by_stretch(self, measure: Callable[[slice], NDArray[Any]]) -> Floats:
        """Return what a function says of each stretch of samples, joined.

        Parameters
        ----------
        measure : callable
            Takes a slice of samples and returns one value for each of them.

        Returns
        -------
        (T,) array
            The values, in the unit of `measure`.
        """
        values = np.empty(len(self.recording.t))
        for stretch in self.stretches():
            values[stretch] = measure(stretch)
        return values

    def stretches(self) -> Iterator[slice]:
        """Yield stretches of samples, in order, that hold `PAIRS_AT_A_TIME` pairs or fewer."""
        samples, length = len(self.recording.t), max(1, PAIRS_AT_A_TIME // self.recording.robots**2)
        for start in range(0, samples, length):
            yield slice(start, min(start + length, samples))

    def mean(self, values: Floats) -> float:
        """Return the mean over the run of a value a sample, weighted by the time it stands for.

        Parameters
        ----------
        values : (T,) array
            In any unit, which is the mean's too; NaN where undefined.
        """
        return weighted_mean(values, self.weights)

    def settled_mean(self, values: Floats) -> float:
        """Return the same over the settled samples.

        Parameters
        ----------
        values : (T,) array
            One value a sample of the whole run, in any unit; NaN where undefined.
        """
        return weighted_mean(values[self.settled], self.weights[self.settled])


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return the same values, which nobody can change by way of what is returned.

    Parameters
    ----------
    array : (...) array
        Of any unit.

    Returns
    -------
    (...) array
        A view.
    """
    view = array.view()
    view.flags.writeable = False
    return view


def weighted_mean(values: Floats, weights: Floats) -> float:
    """Return the mean of the values that are defined; NaN where none is.

    Parameters
    ----------
    values : (T,) array
        In any unit, which is the mean's too; NaN where undefined.
    weights : (T,) array
        The time that each value stands for, in any unit.
    """
    known = np.isfinite(values)
    if not known.any():
        return float("nan")
    if (weights == 1.0).all():
        return float(values[known].mean())
    return float(np.average(values[known], weights=weights[known]))


def _estimated(run: MeasuredRun, estimator: str) -> Motion:
    return estimate(run.recording, estimator, run.options.window)


def _neighbours(run: MeasuredRun, start: int, stop: int) -> NDArray[np.bool_]:
    return read_only(neighbours(run.positions[start:stop], run.radius))
