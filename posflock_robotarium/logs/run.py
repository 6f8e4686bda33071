"""One run as poses over time, and all that is known about it: the type that everything shares.

A `Run` is what every reader returns, what a simulation leaves, what every writer writes and what is
judged.  **What is unknown stays unknown**: a column that nobody wrote is None, a step that nobody
knows of is NaN (or "" as a word), and no table, figure or file makes a zero of it.

It is checked once, here, so that the analysis behind it never meets a pose that is none, a step
back in time or an array of the wrong shape.  Three things that look like damage are kept on
purpose: a robot that was *not seen* for a while has NaN for its pose then, which is nobody else's
loss; a *gap* (samples missing in the middle) stays a gap, never bridged by an estimator; and a
*short* run (cut off by a kill, a collision stop or an interrupt) is simply short.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.known_numbers import known_commands, known_poses
from posflock_robotarium.logs.printed_log import PrintedLog
from posflock_robotarium.logs.robots import LoggedRobot, robot_of
from rps_compat.testbed import RobotModel

Floats = NDArray[np.float64]

GAP_FACTOR = 3.0
"""A step longer than this many median steps is a gap, not a slow loop."""


class LayoutError(LogError):
    """The file is sound, but more than one reading of it is possible (or none): say which."""


class How(Enum):
    """How a run ended."""

    RUNNING = "running"
    """Its log was never closed: it was killed, or still goes on."""
    FINISHED = "finished"
    INTERRUPTED = "interrupted"
    FAILED = "failed"


@dataclass(frozen=True)
class Ending:
    """How a run ended, and why.

    Attributes
    ----------
    how : How
        The kind of end.
    reason : str
        Why, in words; empty where none was recorded.
    """

    how: How
    reason: str = ""


def ending_of(parameters: Mapping[str, Any]) -> Ending | None:
    """Return how a run ended by what its log says; None where it does not, or nothing known.

    Parameters
    ----------
    parameters : mapping
        What the log says about the run; its ``ended`` holds ``how``, a value of `How`, and
        ``reason``.
    """
    said = parameters.get("ended")
    if not isinstance(said, Mapping):
        return None
    try:
        how = How(said.get("how"))
    except ValueError:
        return None
    return Ending(how, str(said.get("reason") or ""))


def missing_rows(there: int, promised: int | None) -> tuple[str, ...]:
    """Return what is to be said of rows that a file promises and does not have.

    Parameters
    ----------
    there : int
        Rows that were found.
    promised : int or None
        Rows that were written, as the file says; None where it does not.

    Returns
    -------
    tuple of str
        A sentence for `Run.doubts`; nothing where no row is missing.
    """
    if promised is None or there >= promised:
        return ()
    return (f"{promised - there} of {promised} rows are missing",)


@dataclass(frozen=True)
class Run:
    """Poses of one run over time, and all that is known about it.

    Parameters
    ----------
    name : str
        What the run is called in tables and on the page (the file's stem).
    t : (T,) array
        Seconds, strictly increasing.
    poses : (T, 3, N) array
        x, y in metres and heading in radians; NaN where a robot was not seen. Where only positions
        were logged, every heading is NaN. What no robot can have (see `known_numbers`)
        is unseen, and noted.
    commands : (T, 2, N) array, optional
        Commanded linear (m/s) and angular (rad/s) velocity; NaN where unknown. What nobody commands
        (see `known_numbers`) is unknown, and noted.
    intervention : (T,) array, optional
        Intervention of the certificate: how far it changed a velocity at most, each step (m/s); NaN
        where unknown.
    clearance : (T,) array, optional
        How far the team is from being unsafe at each step (m); NaN where unknown.
    status : (T,) array of str, optional
        What the certificate answered at each step; "" where unknown.
    parameters : mapping
        Whatever the log says about the run: law, seed, versions, how it ended.
    notes : tuple of str
        How the file was read, one sentence a decision.
    sources : tuple of str
        The files that were read.
    timed : bool
        Whether the times were recorded, not counted from the step that the reader was given.
    doubts : tuple of str
        Why the rows cannot be all that were written, or those that were, whatever the log says of
        how it ended; one a reason.
    real_time : (T,) array, optional
        Seconds on a clock that nobody set, at which each row was written, strictly increasing.
    printed : PrintedLog, optional
        What testbed and script printed during the run.

    Raises
    ------
    LogError
        When shapes disagree, too few poses are known, most are absurd, or time does not increase.
    """

    name: str
    t: Floats
    poses: Floats
    commands: Floats | None = None
    intervention: Floats | None = None
    clearance: Floats | None = None
    status: NDArray[np.str_] | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()
    timed: bool = True
    doubts: tuple[str, ...] = ()
    real_time: Floats | None = None
    printed: PrintedLog | None = None

    def __post_init__(self) -> None:
        where = self.sources[0] if self.sources else self.name
        if self.poses.ndim != 3 or self.poses.shape[1] != 3:
            raise LogError(f"{where}: poses have shape {self.poses.shape}, expected (T, 3, N)")
        samples, _, robots = self.poses.shape
        if robots < 1:
            raise LogError(f"{where}: no robot in it, shape {self.poses.shape}")
        if samples < 2:
            raise LogError(f"{where}: {samples} pose(s) over time; an analysis needs at least 2")
        if self.t.shape != (samples,):
            raise LogError(f"{where}: {self.t.shape[0]} times for {samples} poses")
        _check_time(where, self.t)
        poses, note = known_poses(where, self.poses)
        if poses is not self.poses:
            object.__setattr__(self, "poses", poses)
        if note:
            object.__setattr__(self, "notes", (*self.notes, note))
        self._check_columns(where)

    def _check_columns(self, where: str) -> None:
        """Refuse columns of other shapes or absurd values; one that says nothing is unknown."""
        samples, _, robots = self.poses.shape
        for name, shape in (
            ("commands", (samples, 2, robots)),
            ("intervention", (samples,)),
            ("clearance", (samples,)),
            ("status", (samples,)),
            ("real_time", (samples,)),
        ):
            values = getattr(self, name)
            if values is None:
                continue
            if values.shape != shape:
                raise LogError(f"{where}: {name} has shape {values.shape}, expected {shape}")
            unknown = values == "" if name == "status" else np.isnan(values)
            if unknown.all():
                object.__setattr__(self, name, None)
        if self.commands is not None:
            commands, note = known_commands(self.commands)
            object.__setattr__(self, "commands", commands)
            object.__setattr__(self, "notes", tuple(dict.fromkeys((*self.notes, *note))))
        if self.real_time is not None:
            _check_time(where, self.real_time, "real time")
        if self.intervention is not None and np.isinf(self.intervention).any():
            row = int(np.flatnonzero(np.isinf(self.intervention))[0])
            raise LogError(f"{where}: row {row}: intervention is not a finite number")

    @property
    def robots(self) -> int:
        """How many robots were recorded."""
        return int(self.poses.shape[2])

    @property
    def headed(self) -> bool:
        """Whether headings were logged, not positions only."""
        return not bool(np.isnan(self.poses[0, 2, 0])) or bool(np.isfinite(self.poses[:, 2]).any())

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which robots' positions are known when, shape (T, N)."""
        known: NDArray[np.bool_] = np.isfinite(self.poses[:, 0])
        return known

    @property
    def step(self) -> float:
        """Median time between samples, in seconds."""
        return float(np.median(np.diff(self.t)))

    @property
    def gaps(self) -> NDArray[np.intp]:
        """Samples before which time is missing: (k,) indices into `t`."""
        steps = np.diff(self.t)
        return np.flatnonzero(ties.beyond(steps, GAP_FACTOR * np.median(steps))) + 1

    @property
    def segments(self) -> list[slice]:
        """The stretches between gaps; every sample is in exactly one."""
        edges = [0, *self.gaps.tolist(), len(self.t)]
        return [slice(first, last) for first, last in pairwise(edges)]

    @property
    def ending(self) -> Ending | None:
        """How the run ended; None where the log does not say."""
        return ending_of(self.parameters)

    @property
    def planned(self) -> float | None:
        """Seconds that the run was meant to last; None where the log does not say."""
        return self._number("duration")

    @property
    def first_pose_at(self) -> float | None:
        """When the first row was written, seconds since 1970; None where nobody knows."""
        opened = self._number("opened_at")
        if opened is not None and self.real_time is not None:
            return opened + float(self.real_time[0])
        return self._number("first_pose_at")

    @property
    def simulated(self) -> bool | None:
        """Whether the poses come from a simulator; None where the log does not say."""
        said = self.parameters.get("simulated")
        return said if isinstance(said, bool) else None

    @property
    def robot(self) -> RobotModel:
        """The robot and the arena of this run: what it is judged by."""
        return self.logged_robot.model

    @property
    def logged_robot(self) -> LoggedRobot:
        """The robot and the arena of this run, and how it is known."""
        return robot_of(self.parameters)

    def neighbour_radius(self, given: ArrayLike | None = None) -> float | tuple[float, ...]:
        """Return the neighbour radius in metres, one or one a robot.

        Parameters
        ----------
        given : float or (N,) array, optional
            What the user says, m; by default what the log says.

        Raises
        ------
        LogError
            Where neither tells it, it is no length, or there is not one for each robot.
        """
        radius = self.parameters.get("neighbour_radius") if given is None else given
        if radius is None:
            raise LogError(
                f"{self.name}: the log does not say the neighbour radius; "
                "give it in metres with --radius (0.75 in the nine-robot experiment)"
            )
        try:
            values = np.asarray(radius, dtype=float)
        except (TypeError, ValueError) as error:
            raise LogError(
                f"{self.name}: neighbour radius {radius!r}; expected metres above 0"
            ) from error
        if values.ndim > 1 or (values.ndim == 1 and len(values) != self.robots):
            raise LogError(
                f"{self.name}: neighbour radius of shape {values.shape} for "
                f"{self.robots} robots; expected one, or one a robot"
            )
        if not (np.isfinite(values).all() and (values > 0).all()):
            raise LogError(f"{self.name}: neighbour radius {radius!r}; expected metres above 0")
        return float(values) if values.ndim == 0 else tuple(values.tolist())

    def _number(self, name: str) -> float | None:
        said = self.parameters.get(name)
        if isinstance(said, bool) or not isinstance(said, (int, float)) or not math.isfinite(said):
            return None
        return float(said)

    def noted(self, *notes: str) -> Run:
        """Return the same run with more to say about how it was read.

        Parameters
        ----------
        *notes : str
            How it was read, one sentence a decision.
        """
        return replace(self, notes=self.notes + notes)


def _check_time(where: str, t: Floats, name: str = "time") -> None:
    bad = np.flatnonzero(~np.isfinite(t))
    if bad.size:
        raise LogError(f"{where}: row {bad[0]}: {name} is {t[bad[0]]}, not a finite number")
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        row = int(back[0]) + 1
        what = "stands still" if t[row] == t[row - 1] else "runs backwards"
        raise LogError(
            f"{where}: row {row}: {name} {what}, {t[row - 1]:g} s then {t[row]:g} s "
            f"({back.size} such row(s)); sort or mend the file"
        )
