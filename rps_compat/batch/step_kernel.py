"""A step of one team in the ideal arena, compiled: operations and order are those of `Arena.step`.

Pairs are gone through by how far apart their numbers are, 0 and 1, 1 and 2, … then 0 and 2, so that
the inner loop has as many turns as there are robots. Squared distances are compared first, with
room for rounding; what may be too close is measured as the arena does.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from barrier_certificates.batch.compiling import compiled, entered, makes_arrays
from barrier_certificates.batch.headings import cosines_and_sines
from barrier_certificates.ties import TIE
from rps_compat.arena import WRAPPED_BEYOND
from rps_compat.arena_guests import Array
from rps_compat.batch.batch_violations import (
    ACTUATOR,
    CLOSE_PAIRS,
    CLOSE_STEPS,
    OUTSIDE,
    SATURATED,
    Counts,
)
from rps_compat.testbed import RobotModel

_AXLE, _PER_RADIUS, _HALF_RADIUS, _RADIUS_PER_AXLE, _LIMIT, _AHEAD, _TOO_CLOSE, _TIME_STEP = range(
    8
)
_X_MIN, _X_MAX, _Y_MIN, _Y_MAX = range(8, 12)


class StepSpace(NamedTuple):
    """Space for the steps of one team, and its rows, each an array of its own.

    Taking an array out of a tuple, or a row out of an array, costs as much as a robot's step, so it
    is done once a team.

    Attributes
    ----------
    left, right : (N,) array
        Speeds of the wheels, rad/s.
    cosine, sine : (N,) array
        Of the headings.
    body_x, body_y : (2 N,) array
        Collision points, twice in a row, m.
    least : (N,) array
        Smallest squared distances, m².
    """

    left: Array
    right: Array
    cosine: Array
    sine: Array
    body_x: Array
    body_y: Array
    least: Array


@makes_arrays
def room_for(number: int) -> StepSpace:
    """Return room for a team.

    Parameters
    ----------
    number : int
        Number of robots, N.
    """
    return StepSpace(
        np.zeros(number),
        np.zeros(number),
        np.zeros(number),
        np.zeros(number),
        np.zeros(2 * number),
        np.zeros(2 * number),
        np.zeros(number),
    )


def constants_of(robot: RobotModel) -> Array:
    """Return the dimensions and limits that a step takes, and what follows from them.

    Parameters
    ----------
    robot : RobotModel
        The robots and their arena.

    Returns
    -------
    (12,) array
        By the names above, in metres and radians.
    """
    radius, axle = robot.wheel_radius, robot.base_length
    close = robot.collision_diameter + TIE
    motion = (axle, 1 / (2 * radius), radius / 2, radius / axle, robot.max_wheel_velocity)
    return np.array([*motion, robot.collision_offset, close, robot.time_step, *robot.boundaries])


@entered
def are_within(commands: Array, largest: float) -> bool:
    """Whether no command is beyond a number, and none is not a number.

    Parameters
    ----------
    commands : (B, 2, N) array
        Commands, m/s and rad/s.
    largest : float
        The number.
    """
    beyond = 0
    for command in commands.flat:
        beyond |= not abs(command) <= largest
    return beyond == 0


@entered
def drive_teams(
    first: int,
    last: int,
    constants: Array,
    poses: Array,
    commands: Array,
    counters: tuple[Any, ...],
    steps: int,
) -> None:
    """Let teams drive for some steps, each holding its commands.

    Parameters
    ----------
    first, last : int
        The first team, and the one after the last.
    constants : (12,) array
        See `constants_of`.
    poses : (B, 3, N) array
        Moved in place, m and rad.
    commands : (B, 2, N) array
        Cut in place at the wheels' limits, m/s and rad/s.
    counters : tuple
        What is in a `Tally`, in which is counted.
    steps : int
        How many steps.
    """
    left, right, cosine, sine, body_x, body_y, least = room_for(poses.shape[2])
    counts, by_robot, extremes = counters
    for team in range(first, last):
        x, y, heading = poses[team, 0], poses[team, 1], poses[team, 2]
        forward, turn = commands[team, 0], commands[team, 1]
        start_team(least)
        for _ in range(steps):
            if admit(constants, forward, turn, left, right):
                cut(constants, left, right, counts, extremes, team)
            cosines_and_sines(heading, cosine, sine)
            body(constants, x, y, cosine, sine, body_x, body_y)
            if is_outside(constants, x, y):
                count_outside(constants, x, y, counts, by_robot, team)
            if is_close(constants, body_x, body_y, least):
                count_close(constants, body_x, body_y, counts, by_robot, team)
            move(constants, x, y, heading, forward, turn, left, right, cosine, sine)
        finish_team(least, extremes, team)


@compiled
def start_team(least: Array) -> None:
    """Forget the distances of the team before.

    Parameters
    ----------
    least : (N,) array
        Smallest squared distances, m².
    """
    for k in range(least.shape[0]):
        least[k] = math.inf


@compiled
def finish_team(least: Array, extremes: Array, team: int) -> None:
    """Note the smallest distance of a team.

    Parameters
    ----------
    least : (N,) array
        Smallest squared distances, m².
    extremes : (2, B) array
        Where it is noted, see `Tally`.
    team : int
        Which team.
    """
    for k in range(least.shape[0]):
        extremes[1, team] = min(extremes[1, team], math.sqrt(least[k]))


@compiled
def admit(constants: Array, forward: Array, turn: Array, left: Array, right: Array) -> bool:
    """Write how fast wheels are to turn; return whether any is to turn too fast.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    forward, turn : (N,) array
        Commands, m/s and rad/s.
    left, right : (N,) array
        Where the wheels' speeds are written, rad/s.
    """
    axle, per_radius, limit, fast = constants[_AXLE], constants[_PER_RADIUS], constants[_LIMIT], 0
    for k in range(forward.shape[0]):
        ahead, across = 2.0 * forward[k], axle * turn[k]
        one, other = (ahead - across) * per_radius, (ahead + across) * per_radius
        left[k], right[k] = one, other
        fast |= (abs(one) > limit) | (abs(other) > limit)
    return fast != 0


@compiled
def body(
    constants: Array, x: Array, y: Array, cosine: Array, sine: Array, body_x: Array, body_y: Array
) -> None:
    """Write the collision points, twice in a row.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    x, y : (N,) array
        Positions, m.
    cosine, sine : (N,) array
        Of the headings.
    body_x, body_y : (2 N,) array
        Where they are written, m.
    """
    number, ahead = x.shape[0], constants[_AHEAD]
    for k in range(number):
        body_x[k] = x[k] + ahead * cosine[k]
        body_y[k] = y[k] + ahead * sine[k]
    for k in range(number):
        body_x[number + k] = body_x[k]
        body_y[number + k] = body_y[k]


@compiled
def is_outside(constants: Array, x: Array, y: Array) -> bool:
    """Whether any robot is outside.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    x, y : (N,) array
        Positions, m.
    """
    x_min, x_max = constants[_X_MIN] - TIE, constants[_X_MAX] + TIE
    y_min, y_max, outside = constants[_Y_MIN] - TIE, constants[_Y_MAX] + TIE, 0
    for k in range(x.shape[0]):
        outside |= (x[k] < x_min) | (x[k] > x_max) | (y[k] < y_min) | (y[k] > y_max)
    return outside != 0


@compiled
def is_close(constants: Array, body_x: Array, body_y: Array, least: Array) -> bool:
    """Whether any two robots may be too close; keep the smallest squared distances.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    body_x, body_y : (2 N,) array
        Collision points, m.
    least : (N,) array
        Smallest squared distances so far, m².
    """
    number, close = least.shape[0], 0
    reach = constants[_TOO_CLOSE] * constants[_TOO_CLOSE] * (1.0 + 1e-12)
    for apart in range(1, number // 2 + 1):
        for k in range(number):
            x, y = body_x[k] - body_x[k + apart], body_y[k] - body_y[k + apart]
            square = x * x + y * y
            close |= square <= reach
            least[k] = square if square < least[k] else least[k]
    return close != 0


@compiled
def move(
    constants: Array,
    x: Array,
    y: Array,
    heading: Array,
    forward: Array,
    turn: Array,
    left: Array,
    right: Array,
    cosine: Array,
    sine: Array,
) -> None:
    """Drive for one time step as the wheels turn.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    x, y, heading : (N,) array
        Poses, moved in place, m and rad.
    forward, turn : (N,) array
        Where the velocities are written that the wheels admit, m/s and rad/s.
    left, right : (N,) array
        How fast the wheels turn, rad/s.
    cosine, sine : (N,) array
        Of the headings.
    """
    seconds, turned = constants[_TIME_STEP], 0
    half_radius, radius_per_axle = constants[_HALF_RADIUS], constants[_RADIUS_PER_AXLE]
    for k in range(x.shape[0]):
        v, w = (left[k] + right[k]) * half_radius, (right[k] - left[k]) * radius_per_axle
        forward[k], turn[k] = v, w
        distance, angle = seconds * v, heading[k] + seconds * w
        x[k] += distance * cosine[k]
        y[k] += distance * sine[k]
        heading[k] = angle
        turned |= abs(angle) > WRAPPED_BEYOND
    if turned != 0:
        for k in range(heading.shape[0]):
            heading[k] = math.atan2(math.sin(heading[k]), math.cos(heading[k]))


@compiled
def cut(
    constants: Array, left: Array, right: Array, counts: Counts, extremes: Array, team: int
) -> None:
    """Count wheels that are asked for too much, and cut them.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    left, right : (N,) array
        Speeds of the wheels, cut in place, rad/s.
    counts : (5, B) integer array
        Steps, see `Tally`.
    extremes : (2, B) array
        See `Tally`.
    team : int
        Which team.
    """
    limit, fastest = constants[_LIMIT], 0.0
    counts[SATURATED, team] += 1
    for k in range(left.shape[0]):
        fastest = max(fastest, abs(left[k]), abs(right[k]))
        left[k] = max(min(left[k], limit), -limit)
        right[k] = max(min(right[k], limit), -limit)
    if fastest > limit + TIE:
        counts[ACTUATOR, team] += 1
        extremes[0, team] = max(extremes[0, team], fastest)


@compiled
def count_outside(
    constants: Array, x: Array, y: Array, counts: Counts, by_robot: Counts, team: int
) -> None:
    """Count a step that begins with robots outside.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    x, y : (N,) array
        Positions, m.
    counts : (5, B) integer array
        Steps, see `Tally`.
    by_robot : (2, B, N) integer array
        See `Tally`.
    team : int
        Which team.
    """
    counts[OUTSIDE, team] += 1
    for k in range(x.shape[0]):
        inside = min(x[k] - constants[_X_MIN], constants[_X_MAX] - x[k])
        inside = min(inside, y[k] - constants[_Y_MIN], constants[_Y_MAX] - y[k])
        if -inside > TIE:
            by_robot[0, team, k] += 1


@compiled
def count_close(
    constants: Array, body_x: Array, body_y: Array, counts: Counts, by_robot: Counts, team: int
) -> None:
    """Count the pairs that are too close, measured as the arena measures.

    Parameters
    ----------
    constants : (12,) array
        See `constants_of`.
    body_x, body_y : (2 N,) array
        Collision points, m.
    counts : (5, B) integer array
        Steps, see `Tally`.
    by_robot : (2, B, N) integer array
        See `Tally`.
    team : int
        Which team.
    """
    number, found, reach = body_x.shape[0] // 2, 0, constants[_TOO_CLOSE]
    for i in range(number - 1):
        for j in range(i + 1, number):
            if math.hypot(body_x[i] - body_x[j], body_y[i] - body_y[j]) <= reach:
                found += 1
                by_robot[1, team, i] += 1
                by_robot[1, team, j] += 1
    if found > 0:
        counts[CLOSE_PAIRS, team] += found
        counts[CLOSE_STEPS, team] += 1
