"""The paper's experiment, over seeds: nine robots for 120 s, ideal and imperfect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import analyse
from posflock_robotarium.alignment.summary import summary_of
from posflock_robotarium.batch.batch_trial import simulate_teams
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.paper.evidence import Robots
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


def drive(seeds: Sequence[int], *, imperfect: bool, duration: float = DURATION) -> Robots:
    """Run the experiment once for each seed, all teams together.

    Numpy computes them whether numba is installed or not: the same numbers, to the last bit, as
    of each team in an arena of its own, and nothing is compiled at a first call.

    Parameters
    ----------
    seeds : sequence of int
        What the start of each team, and its noise, are drawn from.
    imperfect : bool
        Whether the arena is noisy.
    duration : float
        Seconds.
    """
    starts = [
        random_poses(ROBOTS, np.random.default_rng(seed), side=START_SIDE, spacing=START_SPACING)
        for seed in seeds
    ]
    trials = simulate_teams(
        Flock(),
        starts,
        duration,
        seeds=seeds,
        realism=[WhiteNoise() for _ in seeds] if imperfect else None,
        engine="numpy",
        threads=1,  # a reproduction has a process for each processor
    )
    analyses = [analyse(trial.truth()) for trial in trials]
    first = analyses[0].recording
    return Robots(
        first.t,
        np.stack([analysis.curves["gamma_headings"] for analysis in analyses]),
        np.stack([analysis.curves["gamma_motion"] for analysis in analyses]),
        tuple(summary_of(analysis) for analysis in analyses),
        first,
    )
