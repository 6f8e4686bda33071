"""How robots followed their commands: achieved speed and turn rate over the commanded, per robot.

The gains are those that a calibration fits (see `calibration`), with their 99 % intervals, over the
stretch of the run in which commands vary most: there the log says most, and a report stays fast.
What robots drive is held against what they would drive with a gain of 1, with the dead time and the
lag that were fitted, so that being late does not look like being slow. A gain is distance per
commanded distance of the log's time: slower wheels, or steps longer than their log says, look the
same.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.measured_run import MeasuredRun
from posflock_robotarium.calibration.estimate import Estimate
from posflock_robotarium.calibration.identifiability import FittedParameter
from posflock_robotarium.calibration.log_to_profile import Fitting, fitting_of
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.plausibility import fastest
from posflock_robotarium.logs.run import Run

Floats = NDArray[np.float64]

INCREMENTS = 5_000
"""Steps of robots that a report fits to: a gain is then sure to 1 or 2 %."""

LEAST_ROWS = 200
"""Rows that it takes of a team so large that these are more."""

LARGEST_COMMAND = 100.0
"""m/s or rad/s beyond which a command is taken for damage."""

_EVERY = 8
"""Every how manieth row is looked at for how much commands vary."""

_POINTS = 8
"""Points of a robot's curve of achieved over commanded; each is a mean of as many steps."""

_FEWEST = 10
"""Steps below which no point is drawn."""


@dataclass(frozen=True)
class Response:
    """How one robot followed its commanded speed, or its commanded turn rate.

    Attributes
    ----------
    gain : Estimate or None
        Achieved over commanded, with its 99 % interval; None where the log does not determine it.
    reason : str
        Why there is no gain; empty where there is one.
    commanded, achieved : tuple of float
        Means of steps that were commanded alike, with dead time and lag, and of what the robot
        did in them: m/s, or rad/s.
    """

    gain: Estimate | None
    reason: str
    commanded: tuple[float, ...]
    achieved: tuple[float, ...]


@dataclass(frozen=True)
class Following:
    """How a team followed its commands.

    Attributes
    ----------
    speed, turn : tuple of Response
        One a robot; empty where nothing could be fitted.
    dead_time, lag : Estimate or None
        Of the team, s; None where the log does not determine it.
    first, last : float
        Ends of the stretch that was fitted, s by the log's times.
    notes : tuple of str
        What must be known before the gains are believed, a sentence each.
    refused : str
        Why nothing could be fitted; empty where it could.
    """

    speed: tuple[Response, ...]
    turn: tuple[Response, ...]
    dead_time: Estimate | None
    lag: Estimate | None
    first: float
    last: float
    notes: tuple[str, ...] = ()
    refused: str = ""

    def gains(self, turn: bool = False) -> list[float]:
        """Return the gains that were determined, robot by robot.

        Parameters
        ----------
        turn : bool
            Of turn rates instead of speeds.
        """
        responses = self.turn if turn else self.speed
        return [response.gain.value for response in responses if response.gain is not None]

    @classmethod
    def from_dict(cls, said: Mapping[str, Any]) -> Following:
        """Return what `dataclasses.asdict` made plain.

        Parameters
        ----------
        said : mapping
            By the names of the attributes.
        """

        def estimate(value: Mapping[str, float] | None) -> Estimate | None:
            return None if value is None else Estimate(**value)

        def responses(values: list[Mapping[str, Any]]) -> tuple[Response, ...]:
            return tuple(
                Response(
                    estimate(value["gain"]),
                    value["reason"],
                    tuple(value["commanded"]),
                    tuple(value["achieved"]),
                )
                for value in values
            )

        return cls(
            responses(said["speed"]),
            responses(said["turn"]),
            estimate(said["dead_time"]),
            estimate(said["lag"]),
            said["first"],
            said["last"],
            tuple(said["notes"]),
            said["refused"],
        )


def following_of(run: MeasuredRun) -> Following | None:
    """Return how robots followed their commands; None of a log without any.

    Parameters
    ----------
    run : MeasuredRun
        The run; ask for it by ``run.once(following_of)``.
    """
    recording = run.recording
    if recording.commands is None:
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # absurd commands are refused below
        part = _most_varied(recording, run.start)
    first, last = float(part.t[0]), float(part.t[-1])
    if not part.headed:
        return Following((), (), None, None, first, last, refused="there are no headings in it")
    told = float(np.nanmax(np.abs(recording.commands)))
    if told > LARGEST_COMMAND:
        reason = f"a command of {told:.3g} in it is none that a robot can be given"
        return Following((), (), None, None, first, last, refused=reason)
    try:
        fitting = fitting_of(part)
    except LogError as error:
        reason = str(error).removeprefix(f"{part.name}: ")
        return Following((), (), None, None, first, last, refused=reason)
    found = fitting.calibration
    kinds = FittedParameter.SPEED_GAIN, FittedParameter.TURN_GAIN
    speed, turn = (
        tuple(_response(fitting, kind, robot, axis) for robot in range(part.robots))
        for axis, kind in enumerate(kinds)
    )
    return Following(speed, turn, found.dead_time, found.lag, first, last, found.warnings)


def _most_varied(recording: Run, start: float) -> Run:
    """Return the part of a run in which its commands vary most, whole where it is short."""
    assert recording.commands is not None
    begin = int(np.searchsorted(recording.t, start))
    rows = max(LEAST_ROWS, INCREMENTS // recording.robots)
    left = len(recording.t) - begin
    if left > rows:
        # Speeds and turn rates in shares of the largest, so that both count.
        scale = np.array(fastest(recording.robot))[:, np.newaxis]
        told = (recording.commands[begin::_EVERY] / scale).reshape(-1, 2 * recording.robots)
        told = np.nan_to_num(told)
        sums, squares = (
            np.concatenate([np.zeros((1, told.shape[1])), np.cumsum(part, axis=0)])
            for part in (told, np.square(told))
        )
        few = rows // _EVERY
        mean = (sums[few:] - sums[:-few]) / few
        variance = (squares[few:] - squares[:-few]) / few - np.square(mean)
        begin += _EVERY * int(np.argmax(variance.sum(axis=1).round(9)))
        begin = min(begin, len(recording.t) - rows)
    return _rows(recording, slice(begin, min(begin + rows, len(recording.t))))


def _rows(recording: Run, chosen: slice) -> Run:
    assert recording.commands is not None
    clock = recording.real_time
    return replace(
        recording,
        t=recording.t[chosen],
        poses=recording.poses[chosen],
        commands=recording.commands[chosen],
        real_time=None if clock is None else clock[chosen],
        intervention=None,
        clearance=None,
        status=None,
    )


def _response(fitting: Fitting, kind: FittedParameter, robot: int, axis: int) -> Response:
    """Return how one robot followed its speed (axis 0) or its turn rate (axis 1)."""
    found = fitting.calibration
    gain = (found.turn_gain if axis else found.speed_gain)[robot]
    reasons = [out.reason for out in found.left_out if (out.kind, out.robot) == (kind, robot)]
    known = fitting.known[:, robot]
    commanded = fitting.driven[known, axis, robot]
    achieved = (fitting.turned if axis else fitting.went)[known, robot]
    commanded_means, achieved_means = _means(commanded, achieved)
    return Response(gain, "; ".join(reasons), commanded_means, achieved_means)


def _means(commanded: Floats, achieved: Floats) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return means of as many steps each, in the order of what was commanded."""
    parts = min(_POINTS, len(commanded) // _FEWEST)
    if parts < 1:
        return (), ()
    order = np.array_split(np.argsort(commanded, kind="stable"), parts)
    told, did = (
        tuple(float(values[part].mean()) for part in order) for values in (commanded, achieved)
    )
    return told, did
