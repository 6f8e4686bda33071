"""The certificate of one team after the other, from what is desired to what is sent: compiled."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.batch.active_rows import Space, broken_by, copy, space_for
from barrier_certificates.batch.compiling import compiled, entered, makes_arrays
from barrier_certificates.batch.headings import cosines_and_sines
from barrier_certificates.batch.layout import Recipe, TeamRows
from barrier_certificates.batch.search import NOT_FOUND, climb, guess
from barrier_certificates.batch.write_rows import write_excess, write_rows
from barrier_certificates.projection.scaled_program import TOLERANCE

TRIVIAL, OPTIMAL, RELAXED, FAILED = range(4)
UNANSWERED = 4
"""A single certificate has to answer for this team."""

_LARGE = 1e3  # m, m/s: beyond, a single certificate takes care of units and rounding
_FAST = 10.0  # m/s, likewise


class DriveModel(NamedTuple):
    """How robots follow what is certified.

    Attributes
    ----------
    distance : float
        How far ahead of the axle the projection point lies, m; 0 for robots without headings.
    time_step : float
        How long a command is held, s; 0 leaves arcs out of account.
    commands : bool
        Whether what is desired, and what is answered, are unicycle commands, not velocities.
    """

    distance: float
    time_step: float
    commands: bool


class Answers(NamedTuple):
    """What is answered for B teams, and remembered.

    Attributes
    ----------
    velocity : (B, 2, N) array
        Velocities, or unicycle commands.
    status : (B,) integer array
        `TRIVIAL`, `OPTIMAL`, `RELAXED`, `FAILED` or, until a single certificate has, `UNANSWERED`.
    numbers : (4, B) array
        Violation and intervention, m/s; clearance, m; smallest h.
    binding : (B, 2N + 1) integer array
        Rows that bind, in any order.
    bound : (B,) integer array
        How many do.
    """

    velocity: FloatArray
    status: IntArray
    numbers: FloatArray
    binding: IntArray
    bound: IntArray


@entered
def certify_teams(
    first: int,
    last: int,
    program: tuple[Any, ...],
    drives: tuple[Any, ...],
    pattern: tuple[Any, ...],
    desired: FloatArray,
    states: FloatArray,
    written: tuple[Any, ...],
) -> int:
    """Answer for teams one after the other; return how many were left unanswered.

    Parameters
    ----------
    first, last : int
        The first team, and the one after the last.
    program, drives, pattern : tuple
        What is in a `Recipe`, from which rows are made; in a `DriveModel`, how robots follow; in
        `TeamRows`, who is in each row.
    desired : (B, 2, N) array
        What is desired.
    states : (B, 2, N) or (B, 3, N) array
        Positions, or poses.
    written : tuple
        What is in `Answers`, where answers are written; binding rows are read as those of the last
        step.
    """
    recipe, drive, rows = Recipe(*program), DriveModel(*drives), rows_in(TeamRows(*pattern))
    answers = Answers(*written)
    space = space_for(desired.shape[2], rows.bound.shape[0])
    barrier, left = np.zeros(2), 0
    for team in range(first, last):
        face(drive, states[team], space)
        certify_team(
            recipe, drive, rows, space, barrier, desired[team], states[team], team, answers
        )
        left += int(answers.status[team] == UNANSWERED)
    return left


@makes_arrays
def rows_in(pattern: TeamRows) -> TeamRows:
    """Return room for the rows of one team.

    Parameters
    ----------
    pattern : TeamRows
        Who is in each row.
    """
    total = pattern.bound.shape[0]
    return TeamRows(
        pattern.first, pattern.second, np.empty(total), np.empty(total), np.empty(total)
    )


@compiled
def face(drive: DriveModel, states: FloatArray, space: Space) -> None:
    """Write cosines and sines of a team's headings, where it has any.

    Parameters
    ----------
    drive : DriveModel
        How robots follow.
    states : (2, N) or (3, N) array
        Positions, or poses.
    space : Space
        Where they are written.
    """
    if drive.distance > 0.0:
        cosines_and_sines(states[2], space.heading[0], space.heading[1])


@compiled
def certify_team(
    recipe: Recipe,
    drive: DriveModel,
    rows: TeamRows,
    space: Space,
    barrier: FloatArray,
    desired: FloatArray,
    states: FloatArray,
    team: int,
    answers: Answers,
) -> None:
    """Answer for one team.

    Parameters
    ----------
    recipe, drive, rows, space
        What rows are made from, how robots follow, and room for rows and search, in which headings
        stand already, see `face`.
    barrier : (2,) array
        Room for the nearest barrier.
    desired : (2, N) array
        What is desired.
    states : (2, N) or (3, N) array
        Positions, or poses.
    team : int
        Which team.
    answers : Answers
        Where the answer is written.
    """
    status, count = UNANSWERED, answers.bound[team]
    answers.bound[team] = 0
    if _is_plain(desired) and _is_plain(states):
        _place(drive, states, desired, space)
        alone = write_rows(recipe, rows, space.position, space.heading, space.least, barrier)
        if not alone:
            answers.numbers[2, team], answers.numbers[3, team] = barrier[1], barrier[0]
            worst = -math.inf
            for a in range(count):
                space.binding[a] = answers.binding[team, a]
                worst = max(worst, broken_by(rows, space.binding[a], space.target))
            if worst <= TOLERANCE:  # else it is known already that something has to be done
                worst = write_excess(rows, space.target, space.least, space.gap)
            if worst <= TOLERANCE:
                status = TRIVIAL
                answers.numbers[0, team] = max(worst, 0.0)
                answers.numbers[1, team] = 0.0
                copy(desired, answers.velocity[team])
            elif worst <= _FAST:
                count = guess(rows, space, count, worst)
                if count == NOT_FOUND:
                    count = climb(rows, space, worst)
                if count != NOT_FOUND:
                    status = OPTIMAL
                    _answer(drive, space, count, team, answers)
    answers.status[team] = status


@compiled
def _is_plain(numbers: FloatArray) -> bool:
    """Whether all numbers are finite and of a size that robots have."""
    odd = 0
    for row in range(numbers.shape[0]):
        for k in range(numbers.shape[1]):
            odd |= not abs(numbers[row, k]) <= _LARGE
    return odd == 0


@compiled
def _place(drive: DriveModel, states: FloatArray, desired: FloatArray, space: Space) -> None:
    """Write positions and the target of the points that are certified."""
    number, distance = desired.shape[1], drive.distance
    position, target, cosine, sine = (
        space.position,
        space.target,
        space.heading[0],
        space.heading[1],
    )
    for k in range(number):
        position[0, k], position[1, k] = states[0, k], states[1, k]
        target[0, k], target[1, k] = desired[0, k], desired[1, k]
    if distance > 0.0:
        for k in range(number):
            position[0, k] += distance * cosine[k]
            position[1, k] += distance * sine[k]
        if drive.commands:
            _to_points(drive, target, cosine, sine, space.step)


@compiled
def _to_points(
    drive: DriveModel, target: FloatArray, cosine: FloatArray, sine: FloatArray, turned: FloatArray
) -> None:
    """Make velocities of projection points of unicycle commands, in place."""
    distance, step, number = drive.distance, drive.time_step, target.shape[1]
    if step > 0.0:
        for k in range(number):
            # Beyond a quarter turn a step cannot be told from a shorter one.
            target[1, k] = min(max(step * target[1, k], -0.5 * math.pi), 0.5 * math.pi)
        cosines_and_sines(target[1], turned[0], turned[1])
        for k in range(number):
            target[0, k] -= distance * (1.0 - turned[0, k]) / step
            target[1, k] = distance * turned[1, k] / step
    else:
        for k in range(number):
            target[1, k] *= distance
    for k in range(number):
        ahead, aside = target[0, k], target[1, k]
        target[0, k] = ahead * cosine[k] - aside * sine[k]
        target[1, k] = ahead * sine[k] + aside * cosine[k]


@compiled
def _arcsine(sine: float) -> float:
    """Return the angle of a sine, rad; of small ones by the series, without a call."""
    if abs(sine) > 0.05:
        return math.asin(sine)
    z = sine * sine
    tail = 35.0 / 1152.0 + z * (63.0 / 2816.0 + z * (231.0 / 13312.0))
    return sine + sine * z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * (5.0 / 112.0 + z * tail)))


@compiled
def _answer(drive: DriveModel, space: Space, count: int, team: int, answers: Answers) -> None:
    """Write the answer, what it cost, and which rows bind."""
    change, point, target = 0.0, space.point, space.target
    heading, velocity = space.heading, answers.velocity
    for k in range(target.shape[1]):
        x, y = point[0, k], point[1, k]
        dx, dy = x - target[0, k], y - target[1, k]
        change = max(change, dx * dx + dy * dy)
        if drive.commands:
            cosine, sine = heading[0, k], heading[1, k]
            forward, turn = x * cosine + y * sine, (y * cosine - x * sine) / drive.distance
            if drive.time_step > 0.0:
                part = min(max(drive.time_step * turn, -1.0), 1.0)
                behind = part * part / (1.0 + math.sqrt(1.0 - part * part))  # 1 − cosine
                forward += drive.distance * behind / drive.time_step
                turn = _arcsine(part) / drive.time_step
            x, y = forward, turn
        velocity[team, 0, k], velocity[team, 1, k] = x, y
    numbers, binding, found = answers.numbers, answers.binding, space.binding
    numbers[0, team], numbers[1, team] = max(space.largest[0], 0.0), math.sqrt(change)
    answers.bound[team] = count
    for a in range(count):
        binding[team, a] = found[a]
