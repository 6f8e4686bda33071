"""The linear algebra of the rows that bind in one team: compiled.

With the binding rows as the rows of A, the point nearest to a target on all of them is
``x̂ − Aᵀλ`` with ``A Aᵀ λ = A x̂ − b``. Rows touch two robots at most, so an entry of ``A Aᵀ`` is a
product of two vectors or nothing; its Cholesky factor grows by a line where a row is added.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.batch.compiling import compiled, makes_arrays
from barrier_certificates.batch.layout import TeamRows

DEPENDENT = 1e-13
"""A row is a sum of others where so little of its squared length is left."""


class Space(NamedTuple):
    """Room for the search of one team; S = 2N is the most rows that can bind.

    Attributes
    ----------
    target, point, step, heading, position : (2, N) array
        What is to be projected, the answer, a direction, and where the team is.
    least : (N,) array
        Room for work of loops over robots.
    gap : (m,) array
        How far rows are broken, at the point or at the target, m/s.
    binding : (S + 1,) integer array
        The rows that bind.
    one, other : (S + 1,) integer array
        Their robots, side by side.
    along_x, along_y : (S + 1,) array
        Their coefficients, likewise.
    multiplier, right, side : (S + 1,) array
        Their multipliers, and two right-hand sides.
    factor : (S + 1, S + 1) array
        Cholesky factor of the products of the binding rows.
    largest : (1,) array
        The largest excess at the point, m/s.
    """

    target: FloatArray
    point: FloatArray
    step: FloatArray
    heading: FloatArray
    position: FloatArray
    least: FloatArray
    gap: FloatArray
    binding: IntArray
    one: IntArray
    other: IntArray
    along_x: FloatArray
    along_y: FloatArray
    multiplier: FloatArray
    right: FloatArray
    side: FloatArray
    factor: FloatArray
    largest: FloatArray


@makes_arrays
def space_for(number: int, total: int) -> Space:
    """Return room for a team.

    Parameters
    ----------
    number : int
        Number of robots, N.
    total : int
        Number of rows, m.
    """
    most = 2 * number + 1
    return Space(
        np.zeros((2, number)),
        np.zeros((2, number)),
        np.zeros((2, number)),
        np.zeros((2, number)),
        np.zeros((2, number)),
        np.zeros(number),
        np.zeros(total),
        np.zeros(most, dtype=np.intp),
        np.zeros(most, dtype=np.intp),
        np.zeros(most, dtype=np.intp),
        np.zeros(most),
        np.zeros(most),
        np.zeros(most),
        np.zeros(most),
        np.zeros(most),
        np.zeros((most, most)),
        np.zeros(1),
    )


@compiled
def copy(source: FloatArray, target: FloatArray) -> None:
    """Copy numbers, robot by robot: compiled much sooner than the copy of an array is.

    Parameters
    ----------
    source, target : (d, N) array
        From where, and to where.
    """
    for row in range(source.shape[0]):
        for k in range(source.shape[1]):
            target[row, k] = source[row, k]


@compiled
def products(rows: TeamRows, space: Space, row: int, count: int, out: FloatArray) -> None:
    """Write the products of a row with those that bind.

    Parameters
    ----------
    rows : TeamRows
        All rows.
    space : Space
        The rows that bind.
    row : int
        Which one; it is none of these.
    count : int
        How many bind.
    out : (S + 1,) array
        Where the products are written.
    """
    one, other, along_x, along_y = space.one, space.other, space.along_x, space.along_y
    i, j, x, y = rows.first[row], rows.second[row], rows.ax[row], rows.ay[row]
    for a in range(count):
        # Numbers of nobody are told apart, so no branch is needed, which a processor could not
        # foresee.
        p, q = one[a], other[a]
        times = int(i == p) + int(j == q) - int(i == q) - int(j == p)
        out[a] = times * (x * along_x[a] + y * along_y[a])


@compiled
def broken_by(rows: TeamRows, row: int, velocity: FloatArray) -> float:
    """Return how far velocities break a row, m/s; negative where it holds.

    Parameters
    ----------
    rows : TeamRows
        All rows.
    row : int
        Which one.
    velocity : (2, N) array
        Velocities, m/s.
    """
    i, j = rows.first[row], rows.second[row]
    x, y = velocity[0, i], velocity[1, i]
    if j < velocity.shape[1]:
        x -= velocity[0, j]
        y -= velocity[1, j]
    excess: float = rows.ax[row] * x + rows.ay[row] * y - rows.bound[row]
    return excess


@compiled
def subtract(rows: TeamRows, row: int, times: float, velocity: FloatArray) -> None:
    """Subtract a row from velocities so many times.

    Parameters
    ----------
    rows : TeamRows
        All rows.
    row : int
        Which one.
    times : float
        How often.
    velocity : (2, N) array
        From what, in place.
    """
    x, y = times * rows.ax[row], times * rows.ay[row]
    i, j = rows.first[row], rows.second[row]
    velocity[0, i] -= x
    velocity[1, i] -= y
    if j < velocity.shape[1]:
        velocity[0, j] += x
        velocity[1, j] += y


@compiled
def append(rows: TeamRows, space: Space, row: int, count: int) -> bool:
    """Add a row to the binding ones, unless it depends on them; return whether it was added.

    Parameters
    ----------
    rows : TeamRows
        All rows.
    space : Space
        The rows that bind, and their factor, which grows by a line.
    row : int
        Which one.
    count : int
        How many bind already.
    """
    factor, line, left = space.factor, space.right, 1.0  # all rows are of unit length
    products(rows, space, row, count, line)
    for a in range(count):
        value = line[a]
        for b in range(a):
            value -= factor[count, b] * factor[a, b]
        value *= factor[a, a]  # the diagonal holds inverses
        factor[count, a] = value
        left -= value * value
    if not left > DEPENDENT:
        return False
    factor[count, count] = 1.0 / math.sqrt(left)
    space.binding[count] = row
    space.one[count], space.other[count] = rows.first[row], rows.second[row]
    space.along_x[count], space.along_y[count] = rows.ax[row], rows.ay[row]
    return True


@compiled
def solve(space: Space, count: int, right: FloatArray, out: FloatArray) -> None:
    """Solve ``A Aᵀ λ = r``.

    Parameters
    ----------
    space : Space
        The factor of ``A Aᵀ``.
    count : int
        Number of binding rows, k.
    right : (S + 1,) array
        Right-hand side r.
    out : (S + 1,) array
        Where λ is written.
    """
    factor = space.factor
    for a in range(count):
        value = right[a]
        for b in range(a):
            value -= factor[a, b] * out[b]
        out[a] = value * factor[a, a]
    for a in range(count - 1, -1, -1):
        value = out[a]
        for b in range(a + 1, count):
            value -= factor[b, a] * out[b]
        out[a] = value * factor[a, a]


@compiled
def project_on(rows: TeamRows, space: Space, count: int) -> None:
    """Write the point nearest to the target on all binding rows, and their multipliers.

    Parameters
    ----------
    rows : TeamRows
        All rows.
    space : Space
        Target, binding rows and factor; point and multipliers are written.
    count : int
        Number of binding rows.
    """
    binding, right, multiplier = space.binding, space.right, space.multiplier
    for a in range(count):
        right[a] = broken_by(rows, binding[a], space.target)
    solve(space, count, right, multiplier)
    copy(space.target, space.point)
    for a in range(count):
        subtract(rows, binding[a], multiplier[a], space.point)
