"""What the testbed would hold against a run, found by its own test where something may be wrong."""

from __future__ import annotations

import numpy as np

from posflock_robotarium.alignment.measured_run import MeasuredRun
from rps_compat.logged_violations import violations_of
from rps_compat.violations import FaultKind, Violations

DOUBTFUL = 1e-6
"""Metres from a wall, or beyond the collision diameter, within which the arena is asked."""


def faults_of(run: MeasuredRun) -> Violations:
    """Return collisions and boundary crossings; ask for them by ``run.once(faults_of)``.

    Parameters
    ----------
    run : MeasuredRun
        The run; its robot and arena hold the limits, m.
    """
    doubtful = np.zeros(len(run.recording.t), dtype=bool)
    for key, least in (
        ("wall_distance", 0.0),
        ("smallest_collision_distance", run.robot.collision_diameter),
    ):
        curve = run.curve(key)
        if curve is not None:
            doubtful |= curve < least + DOUBTFUL
    return violations_of(run.recording.poses, run.robot, np.flatnonzero(doubtful).tolist())


def count(run: MeasuredRun, kind: FaultKind) -> int:
    """Return how many faults of a kind there were, each counted once however long it lasted.

    Parameters
    ----------
    run : MeasuredRun
        The run; its robot and arena hold the limits, m.
    kind : FaultKind
        Two robots too close, or a robot's centre outside the arena; poses show no other kind.
    """
    return sum(event.kind is kind for event in run.once(faults_of).events)
