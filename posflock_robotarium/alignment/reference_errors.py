"""How far each robot of a run is from where it is in a reference run: APE and RPE, as evo has them.

With Q the pose of a robot in the reference and P its pose in the run, at the same time:

- *absolute pose error* (APE): P against Q. Its translation is the distance of the two positions,
  its rotation the angle between the two headings. It tells whether a robot was in its place.
- *relative pose error* (RPE): how P moved in the next Δ against how Q moved, each seen from its own
  pose: (Qₖ⁻¹ Qₖ₊Δ)⁻¹ (Pₖ⁻¹ Pₖ₊Δ), over pairs that follow one another. It tells how truly a robot
  drove, wherever it was; a misplaced start does not count.

The terms are those of J. Sturm et al., *A benchmark for the evaluation of RGB-D SLAM systems*
(2012), and of the tool evo with its defaults: no trajectory is moved onto the other, and samples
belong together when they are the nearest in time and no more than 10 ms apart. Statistics are over
samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.logs.run import GAP_FACTOR, Run
from rps_compat.kinematics import wrap

Floats = NDArray[np.float64]

NEAREST = 0.01
"""Seconds by which samples of one time may differ, as evo has it."""


@dataclass(frozen=True)
class ErrorStatistics:
    """One kind of error of one robot, over samples.

    Attributes
    ----------
    rmse, mean, median, sd, smallest, largest : float
        In metres or radians.
    """

    rmse: float
    mean: float
    median: float
    sd: float
    smallest: float
    largest: float


@dataclass(frozen=True)
class RobotErrors:
    """Errors of one robot against the reference.

    Attributes
    ----------
    robot : int
        Counted from 0, as everywhere.
    samples, pairs : int
        Compared poses, and motions over Δ.
    position : ErrorStatistics
        Translation of the APE, m.
    heading : ErrorStatistics or None
        Rotation of the APE, rad; None where a run has no headings.
    motion : ErrorStatistics or None
        Translation of the RPE, m; None without headings, or where the runs are shorter than Δ.
    turning : ErrorStatistics or None
        Rotation of the RPE, rad.
    """

    robot: int
    samples: int
    pairs: int
    position: ErrorStatistics
    heading: ErrorStatistics | None
    motion: ErrorStatistics | None
    turning: ErrorStatistics | None


@dataclass(frozen=True)
class ReferenceErrors:
    """Errors of one run against the reference.

    Attributes
    ----------
    run, reference : str
        What they are called.
    delta : float
        Seconds over which the RPE looks at motion.
    frames : int
        The same in compared samples.
    robots : tuple of RobotErrors
        One a robot.
    """

    run: str
    reference: str
    delta: float
    frames: int
    robots: tuple[RobotErrors, ...]


def errors_against(
    run: Run, reference: Run, *, delta: float = 1.0, offset: float = 0.0
) -> ReferenceErrors:
    """Compare each robot of a run with the robot of the same number in a reference.

    Parameters
    ----------
    run, reference : Run
        Both in the frame of the arena; times are taken since the first pose of each.
    delta : float
        Seconds over which motion is compared, taken as whole samples.
    offset : float
        Seconds that are added to the times of the reference, where it began later.

    Raises
    ------
    LogError
        When the runs have other numbers of robots, or no samples at the same times.
    ParameterError
        When `delta` is not a time above 0, or `offset` not a time.
    """
    if not (np.isfinite(delta) and delta > 0.0 and np.isfinite(offset)):
        raise ParameterError(f"delta {delta} s, offset {offset} s; expected a time above 0, a time")
    if run.robots != reference.robots:
        raise LogError(
            f"{run.name} has {run.robots} robots, the reference {reference.name} has "
            f"{reference.robots}; errors are those of the same robots in the same order"
        )
    t = run.t - run.t[0]
    mine, theirs = _associated(t, reference.t - reference.t[0] + offset)
    if not len(mine):
        raise LogError(
            f"{run.name} and the reference {reference.name} have no samples within "
            f"{1e3 * NEAREST:g} ms of each other; say with --reference-offset by how many seconds "
            "the reference began later"
        )
    t = t[mine]
    step = float(np.median(np.diff(t))) if len(t) > 1 else delta
    frames = max(1, ties.nearest_whole(delta / step))
    robots = [
        _of_robot(n, t, run.poses[mine, :, n], reference.poses[theirs, :, n], frames)
        for n in range(run.robots)
    ]
    return ReferenceErrors(run.name, reference.name, frames * step, frames, tuple(robots))


def _associated(t: Floats, other: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which samples belong together: to each of the fewer, the nearest of the more."""
    if len(other) < len(t):
        theirs, mine = _associated(other, t)
        return mine, theirs
    after = np.searchsorted(other, t).clip(1, len(other) - 1)
    nearest = np.where(t - other[after - 1] <= other[after] - t, after - 1, after)
    mine = np.flatnonzero(ties.within(np.abs(other[nearest] - t), NEAREST))
    return mine, nearest[mine]


def _of_robot(n: int, t: Floats, run: Floats, reference: Floats, frames: int) -> RobotErrors:
    """Return the errors of one robot of two (K, 3) series of poses."""
    seen = np.isfinite(run[:, :2]).all(axis=1) & np.isfinite(reference[:, :2]).all(axis=1)
    t, run, reference = t[seen], run[seen], reference[seen]
    if not len(t):
        raise LogError(f"robot {n}: never seen in both runs at the same time")
    apart = np.hypot(run[:, 0] - reference[:, 0], run[:, 1] - reference[:, 1])
    turned = np.abs(wrap(run[:, 2] - reference[:, 2]))
    headed = bool(np.isfinite(turned).all())
    motion, turning = _relative(t, run, reference, frames) if headed else (np.empty(0),) * 2
    return RobotErrors(
        robot=n,
        samples=len(t),
        pairs=len(motion),
        position=_statistics(apart),
        heading=_statistics(turned) if headed else None,
        motion=_statistics(motion) if len(motion) else None,
        turning=_statistics(turning) if len(turning) else None,
    )


def _relative(t: Floats, run: Floats, reference: Floats, frames: int) -> tuple[Floats, Floats]:
    """Return translation and rotation of the RPE over pairs that follow one another."""
    at = np.arange(0, len(t), frames)
    first, last = at[:-1], at[1:]
    if len(first):
        # A pair across a gap is no motion over Δ.
        whole = t[last] - t[first] <= GAP_FACTOR * np.median(t[last] - t[first])
        first, last = first[whole], last[whole]
    moved, theirs = _seen_from(run[first], run[last]), _seen_from(reference[first], reference[last])
    apart = np.hypot(moved[:, 0] - theirs[:, 0], moved[:, 1] - theirs[:, 1])
    return apart, np.abs(wrap(moved[:, 2] - theirs[:, 2]))


def _seen_from(start: Floats, end: Floats) -> Floats:
    """Return the poses (K, 3) of `end` in the frames of the poses of `start`."""
    x, y = end[:, 0] - start[:, 0], end[:, 1] - start[:, 1]
    cos, sin = np.cos(start[:, 2]), np.sin(start[:, 2])
    return np.stack([cos * x + sin * y, cos * y - sin * x, end[:, 2] - start[:, 2]], axis=1)


def _statistics(errors: Floats) -> ErrorStatistics:
    return ErrorStatistics(
        rmse=float(np.sqrt(np.square(errors).mean())),
        mean=float(errors.mean()),
        median=float(np.median(errors)),
        sd=float(errors.std()),
        smallest=float(errors.min()),
        largest=float(errors.max()),
    )


def worst_of(errors: Sequence[RobotErrors]) -> RobotErrors:
    """Return the robot whose position was farthest off, root mean square.

    Parameters
    ----------
    errors : sequence of RobotErrors
        One a robot, at least one.
    """
    return max(errors, key=lambda robot: robot.position.rmse)
