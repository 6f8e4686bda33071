"""Many steps of controller, certificate and arena, team by team, compiled."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from barrier_certificates.array_types import IntArray
from barrier_certificates.batch.active_rows import space_for
from barrier_certificates.batch.certify import (
    UNANSWERED,
    Answers,
    DriveModel,
    certify_team,
    face,
    rows_in,
)
from barrier_certificates.batch.compiling import compiled, entered
from barrier_certificates.batch.layout import Recipe, TeamRows
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
from rps_compat.batch.step_kernel import admit, body, move, room_for

VIOLATION, INTERVENTION, CLEARANCE = range(3)


class Wish(NamedTuple):
    """What robots would do.

    Attributes
    ----------
    target : (B, 2, N) array
        Unicycle commands that are held, or goals of the projection points, m.
    gain, speed : float
        To goals: by which factor ways become velocities, 1/s, and how fast they are at most, m/s.
        A gain of 0 holds commands.
    """

    target: Array
    gain: float
    speed: float


class Progress(NamedTuple):
    """How far each team is, and the worst of its way.

    Attributes
    ----------
    done : (B,) integer array
        Steps done.
    statuses : (B, 4) integer array
        Steps that ended with each status of the certificate.
    extremes : (3, B) array
        Largest violation and intervention, m/s; least clearance, m.
    """

    done: IntArray
    statuses: IntArray
    extremes: Array


@entered
def roll_teams(
    first: int,
    last: int,
    which: IntArray,
    constants: Array,
    wished: tuple[Any, ...],
    program: tuple[Any, ...],
    drives: tuple[Any, ...],
    pattern: tuple[Any, ...],
    poses: Array,
    counters: tuple[Any, ...],
    written: tuple[Any, ...],
    progress: tuple[Any, ...],
    steps: int,
) -> int:
    """Let teams go on until they have done so many steps, or a single certificate has to answer.

    Parameters
    ----------
    first, last : int
        The first of the teams asked for, and the one after the last.
    which : (k,) integer array
        The teams asked for.
    constants : (12,) array
        See `step_constants.constants_of`.
    wished : tuple
        What is in a `Wish`: what robots would do.
    program, drives, pattern : tuple
        The certificate, see `certify_teams`.
    poses : (B, 3, N) array
        Moved in place, m and rad.
    counters : tuple
        What is in a `Tally`, in which is counted.
    written : tuple
        What is in `Answers`: the commands at last; those that are left to a single certificate are
        as desired.
    progress : tuple
        What is in `Progress`: how far teams are.
    steps : int
        How many steps in all.

    Returns
    -------
    int
        How many teams wait for a single certificate.
    """
    recipe, drive, rows = Recipe(*program), DriveModel(*drives), rows_in(TeamRows(*pattern))
    answers, wish, number, waiting = Answers(*written), Wish(*wished), poses.shape[2], 0
    space, barrier = space_for(number, rows.bound.shape[0]), np.zeros(2)
    desired = np.zeros((2, number))
    cosine, sine = space.heading[0], space.heading[1]
    left, right, _, _, body_x, body_y, least = room_for(number)
    counts, by_robot, extremes = counters
    velocity, status, numbers = answers.velocity, answers.status, answers.numbers
    done, statuses, worst = progress
    for at in range(first, last):
        team = which[at]
        pose, target, answer = poses[team], wish.target[team], velocity[team]
        x, y, heading, forward, turn = pose[0], pose[1], pose[2], answer[0], answer[1]
        start_team(least)
        while done[team] < steps:
            face(drive, pose, space)
            wanted(wish.gain, wish.speed, drive.distance, target, pose, cosine, sine, desired)
            certify_team(recipe, drive, rows, space, barrier, desired, pose, team, answers)
            if status[team] == UNANSWERED:
                for k in range(number):
                    forward[k], turn[k] = desired[0, k], desired[1, k]
                waiting += 1
                break
            statuses[team, status[team]] += 1
            worst[VIOLATION, team] = max(worst[VIOLATION, team], numbers[0, team])
            worst[INTERVENTION, team] = max(worst[INTERVENTION, team], numbers[1, team])
            worst[CLEARANCE, team] = min(worst[CLEARANCE, team], numbers[2, team])
            if admit(constants, forward, turn, left, right):
                cut(constants, left, right, counts, extremes, team)
            body(constants, x, y, cosine, sine, body_x, body_y)
            if is_outside(constants, x, y):
                count_outside(constants, x, y, counts, by_robot, team)
            if is_close(constants, body_x, body_y, least):
                count_close(constants, body_x, body_y, counts, by_robot, team)
            move(constants, x, y, heading, forward, turn, left, right, cosine, sine)
            done[team] += 1
        finish_team(least, extremes, team)
    return waiting


@compiled
def wanted(
    gain: float,
    speed: float,
    distance: float,
    target: Array,
    pose: Array,
    cosine: Array,
    sine: Array,
    desired: Array,
) -> None:
    """Write what robots would do.

    Parameters
    ----------
    gain, speed : float
        See `Wish`.
    distance : float
        How far ahead of the axle the projection point lies, m.
    target : (2, N) array
        Commands, or goals.
    pose : (3, N) array
        Poses, m and rad.
    cosine, sine : (N,) array
        Of the headings.
    desired : (2, N) array
        Where the commands are written, m/s and rad/s.
    """
    for k in range(pose.shape[1]):
        x, y = target[0, k], target[1, k]
        if gain > 0.0:
            x = gain * (x - (pose[0, k] + distance * cosine[k]))
            y = gain * (y - (pose[1, k] + distance * sine[k]))
            length = math.sqrt(x * x + y * y)
            scale = speed / length if length > speed else 1.0
            x, y = scale * x, scale * y
            x, y = x * cosine[k] + y * sine[k], (y * cosine[k] - x * sine[k]) / distance
        desired[0, k], desired[1, k] = x, y
