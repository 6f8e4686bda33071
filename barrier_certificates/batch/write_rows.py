"""The rows of one team for where it is, and how far each is broken: compiled.

The operations are those of `barrier_certificates.rows`, in their order, so that the rows of a team
in a batch are those that it would have alone.
"""

from __future__ import annotations

import math

from barrier_certificates.array_types import FloatArray
from barrier_certificates.batch.compiling import compiled
from barrier_certificates.batch.layout import Recipe, TeamRows
from barrier_certificates.rows.pairs import COINCIDENT
from barrier_certificates.ties import TIE

_NEAREST = COINCIDENT**2
_INVERSE_ROOT_2 = 1.0 / math.sqrt(2.0)


@compiled
def write_rows(
    recipe: Recipe,
    rows: TeamRows,
    position: FloatArray,
    heading: FloatArray,
    least: FloatArray,
    barrier: FloatArray,
) -> bool:
    """Write the rows of a team; return whether a single certificate has to.

    Parameters
    ----------
    recipe : Recipe
        What rows are made from.
    rows : TeamRows
        Where they are written.
    position : (2, N) array
        Positions, m.
    heading : (2, N) array
        Cosines and sines of the headings; of no meaning for robots without.
    least : (N,) array
        Room for work.
    barrier : (2,) array
        Where h and clearance of what is nearest to being unsafe are written, m² or m, and m.

    Returns
    -------
    bool
        Whether points coincide, or something is too close that a cautious certificate has rows for.
    """
    barrier[0] = barrier[1] = math.inf
    start = _write_limits(recipe, rows, heading)
    alone = start
    start = _write_walls(recipe, rows, position, start, least, barrier)
    if recipe.disturbed:
        _allow_for_wheels(rows, heading, recipe.disturbances[0], alone, start)
    alone = start
    if recipe.obstacles.shape[1]:
        start = _write_obstacles(recipe, rows, position, start, barrier)
        if start < 0:
            return True
    if recipe.pairs.shape[0]:
        start = _write_pairs(recipe, rows, position, start, least, barrier)
        if start < 0:
            return True
    if recipe.disturbed:
        _allow_for_wheels(rows, heading, recipe.disturbances[1], alone, start)
    return recipe.cautious and barrier[1] <= 0.0


@compiled
def _write_limits(recipe: Recipe, rows: TeamRows, heading: FloatArray) -> int:
    _, _, ax, ay, bound = rows
    cosine, sine = heading[0], heading[1]
    number, start = heading.shape[1], 0
    for side in range(recipe.limits.shape[1]):
        x, y = recipe.limits[0, side], recipe.limits[1, side]
        for k in range(number):
            if recipe.limits_turn:
                ax[start + k] = x * cosine[k] - y * sine[k]
                ay[start + k] = y * cosine[k] + x * sine[k]
            else:
                ax[start + k] = x
                ay[start + k] = y
            bound[start + k] = recipe.limits[2, side]
        start += number
    return start


@compiled
def _write_walls(
    recipe: Recipe,
    rows: TeamRows,
    position: FloatArray,
    start: int,
    least: FloatArray,
    barrier: FloatArray,
) -> int:
    _, _, ax, ay, bound = rows
    px, py = position[0], position[1]
    number, safe, unsafe = position.shape[1], recipe.gains[0, 0], recipe.gains[0, 1]
    for k in range(number):
        least[k] = math.inf
    for wall in range(recipe.walls.shape[1]):
        x, y, inner = recipe.walls[0, wall], recipe.walls[1, wall], recipe.walls[2, wall]
        for k in range(number):
            gap = inner - (x * px[k] + y * py[k])
            ax[start + k] = x
            ay[start + k] = y
            bound[start + k] = gap * gap * gap * (unsafe if gap < 0.0 else safe)
            least[k] = gap if gap < least[k] else least[k]
        start += number
    for k in range(number):
        if least[k] < barrier[1]:
            barrier[0] = barrier[1] = least[k]
    return start


@compiled
def _write_obstacles(
    recipe: Recipe, rows: TeamRows, position: FloatArray, start: int, barrier: FloatArray
) -> int:
    """Write the rows of all obstacles; −1 where a robot is in the very middle of one."""
    _, _, ax, ay, bound = rows
    px, py = position[0], position[1]
    number, safe, unsafe = position.shape[1], recipe.gains[1, 0], recipe.gains[1, 1]
    table = recipe.obstacles
    for o in range(table.shape[1]):
        for k in range(number):
            from_x, from_y = px[k] - table[0, o], py[k] - table[1, o]
            part = (from_x * table[2, o] + from_y * table[3, o]) * table[4, o]
            part = min(max(part, 0.0), 1.0)
            x, y = from_x - part * table[2, o], from_y - part * table[3, o]
            square = x * x + y * y
            if square < _NEAREST:
                return -1
            h = square - table[7, o] * table[7, o]
            distance = math.sqrt(square)
            x, y = x / distance, y / distance
            ax[start + k] = -x
            ay[start + k] = -y
            gain = unsafe if h < 0.0 else safe
            bound[start + k] = gain * (h * h * h) / distance - (x * table[5, o] + y * table[6, o])
            if distance - table[7, o] < barrier[1] - TIE:
                barrier[0], barrier[1] = h, distance - table[7, o]
        start += number
    return start


@compiled
def _write_pairs(
    recipe: Recipe,
    rows: TeamRows,
    position: FloatArray,
    start: int,
    least: FloatArray,
    barrier: FloatArray,
) -> int:
    """Write the rows of all pairs; −1 where two robots are at one point."""
    _, _, ax, ay, bound = rows
    px, py = position[0], position[1]
    number, radius, square_radius = position.shape[1], recipe.pairs[0], recipe.pairs[1]
    safe, unsafe = recipe.gains[2, 0], recipe.gains[2, 1]
    for k in range(number):
        least[k] = math.inf
    for i in range(number - 1):
        x, y, row = px[i], py[i], start - i - 1
        for j in range(i + 1, number):
            dx, dy = x - px[j], y - py[j]
            square = dx * dx + dy * dy
            least[j] = square if square < least[j] else least[j]
            scale = _INVERSE_ROOT_2 / math.sqrt(square)
            h = square - square_radius
            ax[row + j] = -(dx * scale)
            ay[row + j] = -(dy * scale)
            bound[row + j] = h * h * h * (scale * (unsafe if h < 0.0 else safe))
        start += number - i - 1
    nearest = math.inf
    for k in range(1, number):
        nearest = least[k] if least[k] < nearest else nearest
    if nearest < _NEAREST:
        return -1
    clearance = math.sqrt(nearest) - radius
    if clearance < barrier[1] - TIE:
        barrier[0], barrier[1] = nearest - square_radius, clearance
    return start


@compiled
def _allow_for_wheels(
    rows: TeamRows, heading: FloatArray, sizes: FloatArray, start: int, stop: int
) -> None:
    """Lower bounds by the worst that the wheels of a row's robots may do on their own."""
    first, second, ax, ay, bound = rows
    cosine, sine = heading[0], heading[1]
    for row in range(start, stop):
        x, y = ax[row], ay[row]
        for robot in (first[row], second[row]):
            if robot < heading.shape[1]:
                along = abs(x * cosine[robot] + y * sine[robot]) * sizes[0]
                across = abs(y * cosine[robot] - x * sine[robot]) * sizes[1]
                bound[row] -= max(along, across)


@compiled
def write_excess(
    rows: TeamRows, velocity: FloatArray, most: FloatArray, excess: FloatArray
) -> float:
    """Write how far each row is broken; return the largest.

    Parameters
    ----------
    rows : TeamRows
        What has to hold.
    velocity : (2, N) array
        Velocities, m/s.
    most : (N,) array
        Room for work.
    excess : (m,) array
        Where it is written, m/s; negative where a row holds.

    Returns
    -------
    float
        The largest of it, m/s.
    """
    _, second, ax, ay, bound = rows
    number, total, row = velocity.shape[1], bound.shape[0], 0
    vx, vy = velocity[0], velocity[1]
    for k in range(number):
        most[k] = -math.inf
    while row < total and second[row] >= number:
        for k in range(number):
            over = ax[row + k] * vx[k] + ay[row + k] * vy[k] - bound[row + k]
            excess[row + k] = over
            most[k] = over if over > most[k] else most[k]
        row += number
    if row < total:
        for i in range(number - 1):
            x, y, before = vx[i], vy[i], row - i - 1
            for j in range(i + 1, number):
                left = ax[before + j] * (x - vx[j]) + ay[before + j] * (y - vy[j])
                over = left - bound[before + j]
                excess[before + j] = over
                most[j] = over if over > most[j] else most[j]
            row += number - i - 1
    worst = -math.inf
    for k in range(number):
        worst = most[k] if most[k] > worst else worst
    return worst
