"""Metrics over time, a stretch of samples at a time so that memory stays small and cost linear.

Nothing is defined here: every value comes from `posflock_robotarium.alignment.metrics`,
which the experiment itself is judged by.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.estimators import Motion
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.logs.readers import Run
from rps_compat.arena import violations_of
from rps_compat.testbed import RobotModel
from rps_compat.violations import Violations

Floats = NDArray[np.float64]

PAIRS_AT_A_TIME = 200_000
"""Robot pairs in one stretch: a few MB of temporaries, which stay in the processor's cache."""


DOUBTFUL = 1e-6
"""Metres from a wall, or beyond the collision diameter, within which the arena is asked."""

SHARED = 0.1
"""Polarisation below which headings have no common direction, only what noise leaves of one."""


@dataclass(frozen=True, eq=False)
class Curves:
    """Values over time, and what went wrong when.

    Attributes
    ----------
    values : dict of (T,) arrays
        By the key of their `catalogue.Quantity`.
    violations : Violations
        What the arena holds against the run.
    speeds : (T, N) array
        Savitzky-Golay speed of each robot, m/s.
    """

    values: dict[str, Floats]
    violations: Violations
    speeds: Floats = field(repr=False)


def compute(
    recording: Run,
    motions: dict[str, Motion],
    radius: float | Floats,
    slowest: float,
    robot: RobotModel,
) -> Curves:
    """Compute every quantity of the catalogue that the recording has data for.

    Parameters
    ----------
    recording : Run
        Poses over time.
    motions : dict
        Velocities by estimator.
    radius : float or (N,) array
        Neighbour radius in metres.
    slowest : float
        Speed in m/s up to which a robot has no direction of motion.
    robot : RobotModel
        Collision test, wheels and arena of the testbed.

    Returns
    -------
    Curves
        One value a sample for each quantity.
    """
    samples, robots = len(recording.t), recording.robots
    values: dict[str, Floats] = {}
    smooth = motions["savitzky_golay"].velocities
    speeds = np.sqrt(np.square(smooth).sum(axis=1))

    def put(key: str, stretch: slice, part: NDArray[np.generic]) -> None:
        values.setdefault(key, np.full(samples, np.nan))[stretch] = part

    for stretch in _stretches(samples, robots):
        poses = recording.poses[stretch]
        positions = poses[:, :2]
        for name, short in (
            ("headings", "headings"),
            ("savitzky_golay", "motion"),
            ("differences", "differences"),
        ):
            velocities = motions[name].velocities[stretch]
            threshold = 0.0 if name == "headings" else slowest
            found = metrics.alignment(velocities, positions, radius, slowest=threshold)
            put(f"gamma_{short}", stretch, found.gamma)
            put(f"left_out_{short}", stretch, 1.0 - found.counted / robots)
            if name != "differences":
                polarisation = metrics.polarisation(velocities, slowest=threshold)
                put(f"polarisation_{short}", stretch, polarisation)
        common = metrics.common_heading(metrics.heading_vectors(poses))
        shared = values["polarisation_headings"][stretch] >= SHARED
        put("heading", stretch, np.where(shared, common, np.nan))
        put("speed", stretch, speeds[stretch].mean(axis=1))
        put("speed_slowest", stretch, speeds[stretch].min(axis=1))
        put("speed_fastest", stretch, speeds[stretch].max(axis=1))
        put("drift", stretch, np.sqrt(np.square(smooth[stretch].mean(axis=2)).sum(axis=1)))
        put("cohesive_radius", stretch, metrics.cohesive_radius(positions))
        put("spread", stretch, metrics.spread(positions))
        put("wall_distance", stretch, metrics.wall_distance(positions, robot.boundaries))
        if robots > 1:
            put("nearest_neighbour", stretch, metrics.nearest_neighbour_distance(positions))
            put("smallest_distance", stretch, metrics.smallest_distance(positions))
            points = positions + robot.collision_offset * metrics.heading_vectors(poses)
            put("smallest_collision_distance", stretch, metrics.smallest_distance(points))
    if robots > 1:
        values |= _connectivity(recording.poses[:, :2], radius)
    if recording.commands is not None:
        values["fastest_wheel"] = metrics.fastest_wheel(
            recording.commands, robot.wheel_radius, robot.base_length
        )
    if recording.intervention is not None:
        values["intervention"] = recording.intervention
    if recording.clearance is not None and np.isfinite(recording.clearance).any():
        values["clearance"] = np.where(
            np.isfinite(recording.clearance), recording.clearance, np.nan
        )
    return Curves(values, _violations(recording, robot, values), speeds)


def _stretches(samples: int, robots: int) -> Iterator[slice]:
    length = max(1, PAIRS_AT_A_TIME // robots**2)
    for start in range(0, samples, length):
        yield slice(start, min(start + length, samples))


def _violations(run: Run, robot: RobotModel, values: dict[str, Floats]) -> Violations:
    """Let the arena itself test the samples at which something may be wrong."""
    doubtful = values["wall_distance"] < DOUBTFUL
    if run.robots > 1:
        closest = values["smallest_collision_distance"]
        doubtful |= closest < robot.collision_diameter + DOUBTFUL
    return violations_of(run.poses, robot, np.flatnonzero(doubtful).tolist())


def _connectivity(positions: Floats, radius: float | Floats) -> dict[str, Floats]:
    """Return components and algebraic connectivity, computed only where the graph changes."""
    samples, _, robots = positions.shape
    components, connectivity = np.empty(samples), np.empty(samples)
    before: NDArray[np.bool_] | None = None
    last = (0.0, 0.0)
    for stretch in _stretches(samples, robots):
        linked = neighbours(positions[stretch], radius)
        previous = linked[:1] if before is None else before
        changed = (linked != np.concatenate([previous, linked[:-1]])).any(axis=(1, 2))
        changed[0] |= before is None
        rows = np.flatnonzero(changed)
        here = np.empty((len(linked), 2))
        if rows.size:
            where = positions[stretch][rows]
            found = np.stack(
                [
                    metrics.connected_components(where, radius),
                    metrics.algebraic_connectivity(where, radius),
                ],
                axis=1,
            )
            here[:] = found[np.maximum(np.cumsum(changed) - 1, 0)]
            here[: rows[0]] = last
        else:
            here[:] = last
        components[stretch], connectivity[stretch] = here.T
        last = (float(here[-1, 0]), float(here[-1, 1]))
        before = linked[-1:]
    return {"components": components, "algebraic_connectivity": connectivity}
