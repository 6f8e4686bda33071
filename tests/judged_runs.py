"""Short runs whose verdicts are known: a pair that drives side by side, a flock that is parked."""

import dataclasses

import numpy as np

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.report import Run, analyse


def verdict(analysis, question):
    return next(v for v in analysis.verdicts if question in v.question)


def parked(noise=0.0005, **changes):
    flock = known_flock("stopped", 0.0, position_noise=noise)
    return analyse(dataclasses.replace(flock.recording, **changes), radius=flock.radius)


def pair(distance, heading=(0.0, 0.0), samples=120):
    """Two robots beside each other that drive along x, `distance` (T,) apart."""
    t = np.arange(samples) * 0.033
    poses = np.zeros((samples, 3, 2))
    poses[:, 0] = -0.5 + 0.1 * t[:, np.newaxis]
    poses[:, 1, 1] = distance
    poses[:, 2] = heading
    return Run("pair", t, poses)
