"""What is held against a team in a step, compiled: the counters are those of `Tally`.

Pairs are gone through by how far apart their numbers are, 0 and 1, 1 and 2, … then 0 and 2, so that
the inner loop has as many turns as there are robots. Squared distances are compared first, with
room for rounding; what may be too close is measured as the arena does.
"""

from __future__ import annotations

import math

from barrier_certificates.batch.compiling import compiled
from barrier_certificates.ties import TIE
from rps_compat.arena_guests import Array
from rps_compat.batch.batch_violations import (
    ACTUATOR,
    CLOSE_PAIRS,
    CLOSE_STEPS,
    OUTSIDE,
    SATURATED,
    Counts,
)
from rps_compat.batch.step_constants import LIMIT, TOO_CLOSE, X_MAX, X_MIN, Y_MAX, Y_MIN


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
    limit, fastest = constants[LIMIT], 0.0
    counts[SATURATED, team] += 1
    for k in range(left.shape[0]):
        fastest = max(fastest, abs(left[k]), abs(right[k]))
        left[k] = max(min(left[k], limit), -limit)
        right[k] = max(min(right[k], limit), -limit)
    if fastest > limit + TIE:
        counts[ACTUATOR, team] += 1
        extremes[0, team] = max(extremes[0, team], fastest)


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
    x_min, x_max = constants[X_MIN] - TIE, constants[X_MAX] + TIE
    y_min, y_max, outside = constants[Y_MIN] - TIE, constants[Y_MAX] + TIE, 0
    for k in range(x.shape[0]):
        outside |= (x[k] < x_min) | (x[k] > x_max) | (y[k] < y_min) | (y[k] > y_max)
    return outside != 0


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
        inside = min(x[k] - constants[X_MIN], constants[X_MAX] - x[k])
        inside = min(inside, y[k] - constants[Y_MIN], constants[Y_MAX] - y[k])
        if -inside > TIE:
            by_robot[0, team, k] += 1


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
    reach = constants[TOO_CLOSE] * constants[TOO_CLOSE] * (1.0 + 1e-12)
    for apart in range(1, number // 2 + 1):
        for k in range(number):
            x, y = body_x[k] - body_x[k + apart], body_y[k] - body_y[k + apart]
            square = x * x + y * y
            close |= square <= reach
            least[k] = square if square < least[k] else least[k]
    return close != 0


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
    number, found, reach = body_x.shape[0] // 2, 0, constants[TOO_CLOSE]
    for i in range(number - 1):
        for j in range(i + 1, number):
            if math.hypot(body_x[i] - body_x[j], body_y[i] - body_y[j]) <= reach:
                found += 1
                by_robot[1, team, i] += 1
                by_robot[1, team, j] += 1
    if found > 0:
        counts[CLOSE_PAIRS, team] += found
        counts[CLOSE_STEPS, team] += 1
