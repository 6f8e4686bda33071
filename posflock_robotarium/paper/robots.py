"""The paper's experiment, over seeds: nine robots for 120 s, ideal and imperfect."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import analyse
from posflock_robotarium.alignment.summary import Summary, summary_of
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.logs.run import Run
from posflock_robotarium.simulation.flock_trial import simulate
from rps_compat.arena_guests import Realism

Floats = NDArray[np.float64]

ROBOTS = 9
DURATION = 120.0
#: Robots start in a square of this side, at least so far apart, metres.
START_SIDE, START_SPACING = 1.0, 0.30


@dataclass
class WhiteNoise(Realism):
    """The simplest imperfect arena: every velocity and every measured position is off.

    Attributes
    ----------
    actuation : float
        Standard deviation of the share by which a robot misses its v and its ω, each step.
    tracking : float
        Standard deviation of measured x and y, metres.
    """

    actuation: float = 0.10
    tracking: float = 0.001
    _rng: np.random.Generator = field(default_factory=np.random.default_rng, init=False)

    def reset(self, poses: Floats, time_step: float, rng: np.random.Generator) -> None:
        """Begin a run."""
        self._rng = rng

    def actuate(self, velocities: Floats, poses: Floats, time: float) -> Floats:
        """Return what robots drive."""
        missed = self.actuation * self._rng.standard_normal(velocities.shape)
        return np.asarray(velocities * (1.0 + missed))

    def observe(self, poses: Floats) -> Floats:
        """Return what tracking reports."""
        seen: Floats = poses.copy()
        seen[:2] += self.tracking * self._rng.standard_normal((2, poses.shape[1]))
        return seen


@dataclass(frozen=True, eq=False)
class Drive:
    """One run of the experiment.

    Attributes
    ----------
    log : Run
        With true poses.
    summary : Summary
        Of the true poses.
    gamma_headings, gamma_motion : (T,) array
        γ over time.
    """

    log: Run
    summary: Summary
    gamma_headings: Floats
    gamma_motion: Floats


def drive(seed: int, *, imperfect: bool, duration: float = DURATION) -> Drive:
    """Run the experiment once.

    Parameters
    ----------
    seed : int
        What the start, and the noise, are drawn from.
    imperfect : bool
        Whether the arena is noisy.
    duration : float
        Seconds.
    """
    start = random_poses(
        ROBOTS, np.random.default_rng(seed), side=START_SIDE, spacing=START_SPACING
    )
    flock = Flock()
    trial = simulate(flock, start, duration, realism=WhiteNoise() if imperfect else None, seed=seed)
    log = trial.truth()
    analysis = analyse(log)
    curves = analysis.curves
    return Drive(log, summary_of(analysis), curves["gamma_headings"], curves["gamma_motion"])
