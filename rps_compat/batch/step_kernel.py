"""A step of one team in the ideal arena, compiled, with the order of operations of `Arena.step`."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from barrier_certificates.batch.compiling import compiled, entered, makes_arrays
from barrier_certificates.batch.headings import cosines_and_sines
from rps_compat.arena import WRAPPED_BEYOND
from rps_compat.arena_guests import Array
from rps_compat.batch.count_kernel import (
    count_close,
    count_outside,
    cut,
    finish_team,
    is_close,
    is_outside,
    start_team,
)
from rps_compat.batch.step_constants import (
    AHEAD,
    AXLE,
    HALF_RADIUS,
    LIMIT,
    PER_RADIUS,
    RADIUS_PER_AXLE,
    TIME_STEP,
)


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


@entered
def are_within(commands: Array, largest: float) -> bool:
    """Whether no command is beyond a number, and none is not a number.

    Parameters
    ----------
    commands : (B, 2, N) array
        Commands, m/s and rad/s.
    largest : float
        How large they may be, m/s or rad/s.
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
    axle, per_radius, limit, fast = constants[AXLE], constants[PER_RADIUS], constants[LIMIT], 0
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
    number, ahead = x.shape[0], constants[AHEAD]
    for k in range(number):
        body_x[k] = x[k] + ahead * cosine[k]
        body_y[k] = y[k] + ahead * sine[k]
    for k in range(number):
        body_x[number + k] = body_x[k]
        body_y[number + k] = body_y[k]


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
    seconds, turned = constants[TIME_STEP], 0
    half_radius, radius_per_axle = constants[HALF_RADIUS], constants[RADIUS_PER_AXLE]
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
