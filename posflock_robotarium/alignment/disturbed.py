"""What trackers, cameras and loops do to a log, done to flocks whose γ is known exactly.

γ from motion then has an error that is known, and the report states one: what noise takes from it,
and what the robots that are not seen may change.  `errors_of` holds one against the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import analyse
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.alignment.truth import KnownFlock, known_flock
from posflock_robotarium.logs.run import Run

Floats = NDArray[np.float64]
Disturbance = Callable[[Floats, Floats, np.random.Generator], None]

STATED = 2.0
"""How many times what noise takes from γ, which is measured in the log as well, is stated."""

LEAST_STATED = 2e-4
"""What is stated at least, of any γ that was told to a few digits."""


def _nothing(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Leave the log as it is."""


def _dropout(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Lose every tenth pose, at random."""
    poses.transpose(0, 2, 1)[rng.random((len(t), poses.shape[2])) < 0.1] = np.nan


def _each_unseen(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Lose each robot for 3 s, one after the other."""
    for n in range(poses.shape[2]):
        start = t[0] + 2.0 + 4.0 * n
        poses[(t >= start) & (t < start + 3.0), :, n] = np.nan


def _one_never(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Lose one robot for the whole run."""
    poses[:, :, -1] = np.nan


def _zeros(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Write zeros for two robots that are lost, 5 s each."""
    for n, start in ((1, 10.0), (2, 30.0)):
        poses[(t >= start) & (t < start + 5.0), :, n] = 0.0


def _markers(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Write -9999 for every twentieth pose, at random."""
    poses.transpose(0, 2, 1)[rng.random((len(t), poses.shape[2])) < 0.05] = -9999.0


def _swap(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Take two robots for each other from the middle on."""
    poses[len(t) // 2 :, :, [0, 1]] = poses[len(t) // 2 :, :, [1, 0]]


def _swap_and_back(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Take two robots for each other for 5 s."""
    rows = (t >= 20.0) & (t < 25.0)
    poses[rows] = poses[rows][:, :, [1, 0, *range(2, poses.shape[2])]]


def _frozen(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Hold the last pose of a robot that is lost, for 5 s."""
    rows = np.flatnonzero((t >= 15.0) & (t < 20.0))
    poses[rows, :, 3] = poses[rows[0] - 1, :, 3]


def _slow_camera(t: Floats, poses: Floats, rng: np.random.Generator) -> None:
    """Write each frame of the camera twice."""
    poses[1::2] = poses[: len(t) // 2 * 2 : 2]


DISTURBANCES: dict[str, Disturbance] = {
    "none": _nothing,
    "10 % of the poses missing": _dropout,
    "each robot unseen for 3 s": _each_unseen,
    "one robot never seen": _one_never,
    "two robots lost as zeros, 5 s": _zeros,
    "5 % of the poses -9999": _markers,
    "two robots swapped for good": _swap,
    "two robots swapped for 5 s": _swap_and_back,
    "one robot frozen for 5 s": _frozen,
    "each frame written twice": _slow_camera,
}
"""What is done to a log, by the words of the table."""

REAL_STEPS = "real step times"
"""One more: steps that are late now and then, and stalls, as loops on the testbed have them."""

NOISE = "four times the noise"
"""One more: 2 mm of tracking noise."""


@dataclass(frozen=True)
class DisturbedError:
    """What the report makes of a flock of known γ, seen badly.

    Attributes
    ----------
    motion : str
        What the robots do.
    disturbance : str
        What happened to the log.
    truth, estimate : float
        γ from motion, mean over time.
    stated : float
        The error that the report states.
    """

    motion: str
    disturbance: str
    truth: float
    estimate: float
    stated: float

    @property
    def error(self) -> float:
        """Estimate less truth."""
        return self.estimate - self.truth

    @property
    def holds(self) -> bool:
        """Whether the error is no larger than is stated."""
        return abs(self.error) <= self.stated


def errors_of(
    motions: tuple[str, ...] = ("parallel", "counter", "rotating", "random"),
    disturbances: tuple[str, ...] = (*DISTURBANCES, REAL_STEPS, NOISE),
    *,
    speed: float = 0.1,
    seed: int = 0,
) -> list[DisturbedError]:
    """Return error and stated error of γ from motion for every motion and disturbance.

    Parameters
    ----------
    motions, disturbances : tuple
        Which flocks, and what happens to their logs.
    speed : float
        m/s.
    seed : int
        Of flocks and disturbances.
    """
    found = []
    for motion in motions:
        for name in disturbances:
            noise = 0.002 if name == NOISE else 0.0005
            flock = known_flock(motion, speed, position_noise=noise, seed=seed)
            log = _disturbed(flock, name, np.random.default_rng(seed))
            options = AnalysisOptions(radius=flock.radius, transient=0.0)
            numbers = analyse(log, options).numbers
            unseen = numbers["gamma_unseen"].value if "gamma_unseen" in numbers else 0.0
            stated = STATED * numbers["gamma_bias"].value + unseen
            estimate = numbers["gamma_motion"].value
            found.append(
                DisturbedError(
                    motion, name, flock.gamma_motion, estimate, max(LEAST_STATED, stated)
                )
            )
    return found


def _disturbed(flock: KnownFlock, name: str, rng: np.random.Generator) -> Run:
    """Return the log of a flock as it comes out of a disturbance."""
    log = flock.recording
    # The same place for every motion: flocks of 60 s at 0.2 m/s leave no arena that is so large.
    large = {"arena": [-100.0, 100.0, -100.0, 100.0]}
    if name == REAL_STEPS:
        rows = _rows_of_a_real_loop(len(log.t), rng)
        return replace(log, t=log.t[rows], poses=log.poses[rows], parameters=large)
    poses = log.poses.copy()
    DISTURBANCES.get(name, _nothing)(log.t, poses, rng)
    return replace(log, poses=poses, parameters=large)


def _rows_of_a_real_loop(samples: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return the rows that a loop with late steps and stalls comes to."""
    steps = np.ones(samples, dtype=int)
    late = rng.random(samples)
    steps[late < 0.04] = 2
    steps[late < 0.007] = 10
    rows = np.cumsum(steps)
    return rows[rows < samples]
