"""A step of many teams in numpy: what the arena does to one, on arrays with a team more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import TIE, beyond
from barrier_certificates.wall_distance import wall_distances
from rps_compat.arena_guests import Array
from rps_compat.batch.batch_violations import (
    ACTUATOR,
    CLOSE_PAIRS,
    CLOSE_STEPS,
    OUTSIDE,
    SATURATED,
    Tally,
)
from rps_compat.testbed import RobotModel


def judged(robot: RobotModel, poses: Array, commands: Array, tally: Tally) -> tuple[Array, Array]:
    """Count what is wrong at the start of a step; return the commands that the wheels admit.

    Parameters
    ----------
    robot : RobotModel
        The robots and their arena.
    poses : (B, 3, N) array
        Where the robots stand, m and rad.
    commands : (B, 2, N) array
        What they are told, m/s and rad/s.
    tally : Tally
        What is counted.

    Returns
    -------
    admitted : (B, 2, N) array
        Velocities with each wheel cut at its limit, m/s and rad/s.
    heading : (2, B, N) array
        Cosines and sines of the headings.
    """
    radius, axle, limit = robot.wheel_radius, robot.base_length, robot.max_wheel_velocity
    forward, turn = 2.0 * commands[:, 0], axle * commands[:, 1]
    wheels = np.stack([forward - turn, forward + turn], axis=1) * (1 / (2 * radius))
    fastest = np.abs(wheels).max(axis=(1, 2))
    fast = fastest > limit
    if fast.any():
        tally.steps[SATURATED] += fast
        asked = beyond(fastest, limit)
        tally.steps[ACTUATOR] += asked
        largest = tally.extremes[0]
        np.maximum(largest, fastest, out=largest, where=asked)
        np.clip(wheels, -limit, limit, out=wheels)
    _count_outside(robot, poses, tally)
    heading = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    _count_close(robot, poses, heading, tally)
    left, right = wheels[:, 0], wheels[:, 1]
    admitted = np.empty_like(wheels)
    np.multiply(left + right, radius / 2, out=admitted[:, 0])
    np.multiply(right - left, radius / axle, out=admitted[:, 1])
    return admitted, heading


def _count_outside(robot: RobotModel, poses: Array, tally: Tally) -> None:
    x, y = poses[:, 0], poses[:, 1]
    x_min, x_max, y_min, y_max = robot.boundaries
    beyond_x = (x < x_min - TIE) | (x > x_max + TIE)
    beyond_y = (y < y_min - TIE) | (y > y_max + TIE)
    outside: NDArray[np.bool_] = np.any(beyond_x | beyond_y, axis=1)
    if outside.any():
        tally.steps[OUTSIDE] += outside
        out = beyond(-wall_distances(poses, robot.boundaries), 0.0)
        tally.by_robot[0] += out & outside[:, None]


def _count_close(robot: RobotModel, poses: Array, heading: Array, tally: Tally) -> None:
    number = poses.shape[2]
    if number < 2:
        return
    bodies = np.empty((2, number, poses.shape[0]))  # pairs are rows, which are copied whole
    bodies[0] = (poses[:, 0] + robot.collision_offset * heading[0]).T
    bodies[1] = (poses[:, 1] + robot.collision_offset * heading[1]).T
    i, j = np.triu_indices(number, 1)
    apart = bodies[:, i] - bodies[:, j]
    apart *= apart
    nearest = np.sqrt((apart[0] + apart[1]).min(axis=0))
    np.minimum(tally.extremes[1], nearest, out=tally.extremes[1])
    reach = robot.collision_diameter + TIE
    for team in np.flatnonzero(nearest <= reach * (1.0 + 1e-12)).tolist():
        offset = bodies[:, i, team] - bodies[:, j, team]
        close = np.flatnonzero(np.hypot(offset[0], offset[1]) <= reach)
        tally.steps[CLOSE_PAIRS, team] += close.size
        tally.steps[CLOSE_STEPS, team] += close.size > 0
        for robots in (i[close], j[close]):
            np.add.at(tally.by_robot[1, team], robots, 1)
