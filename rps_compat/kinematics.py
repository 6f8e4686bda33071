"""From velocities of a point to commands of a unicycle, and back.

A unicycle at (x, y, θ) takes a forward speed v and a turn rate ω; it cannot move sideways, so a
velocity u of its centre cannot be obeyed at once. There are two ways out:

- **Project.** A point at distance d ahead of the centre, q = p + d e with e = (cos θ, sin θ), *can*
  move in any direction: q̇ = v e + d ω e⊥. This is a linear bijection for d > 0, so a point velocity
  has exactly one command: v = e·q̇, ω = e⊥·q̇ / d (feedback linearisation; Siciliano et al.,
  *Robotics*, section 11.6).
- **Turn, then drive.** v is the component of u along the heading, and ω is proportional to the
  angle between heading and u.

Everything here works on columns, one for each robot: poses (3, N), velocities (2, N), in metres,
radians and seconds; nothing checks and nothing changes its arguments.
"""

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import beyond, reached, short_of, within

Array = NDArray[np.float64]

HALF_TURN = float(np.pi)


def wrap(angle: Array) -> Array:
    """`angle` (rad) brought into [−π, π]; half a turn, to within a tie, keeps its sign."""
    wrapped = np.arctan2(np.sin(angle), np.cos(angle))
    with_sign: Array = np.where(
        reached(np.abs(wrapped), HALF_TURN), np.copysign(HALF_TURN, angle), wrapped
    )
    return with_sign


def bearing(across: Array, along: Array) -> Array:
    """Angle (rad), in (−π, π], of vectors with these components to the left and ahead.

    What lies exactly behind has the bearing π.
    """
    angle = np.arctan2(across, along)
    one_sided: Array = np.where(within(angle, -HALF_TURN), HALF_TURN, angle)
    return one_sided


def projection_point(poses: Array, distance: float) -> Array:
    """Points (2, N) that lie `distance` (m) ahead of the centres of `poses` (3, N)."""
    points: Array = poses[:2] + distance * _heading(poses)
    return points


def center_of(points: Array, poses: Array, distance: float) -> Array:
    """Centres (2, N) whose projection points are `points`, with the headings of `poses`."""
    centers: Array = points - distance * _heading(poses)
    return centers


def point_velocity(commands: Array, poses: Array, distance: float) -> Array:
    """Velocities (2, N) of the projection points under `commands` (v; ω) (2, N)."""
    cos, sin = _heading(poses)
    ahead, sideways = commands[0], distance * commands[1]
    return np.array([cos * ahead - sin * sideways, sin * ahead + cos * sideways])


def unicycle_command(velocities: Array, poses: Array, distance: float) -> Array:
    """Commands (v; ω) (2, N) under which the projection points move with `velocities` (2, N)."""
    ahead, sideways = along_and_across(velocities, poses)
    return np.array([ahead, sideways / distance])


def along_and_across(velocities: Array, poses: Array) -> tuple[Array, Array]:
    """Components of `velocities` (2, N) along the headings and to their left, (N,) each."""
    cos, sin = _heading(poses)
    x, y = velocities[0], velocities[1]
    return cos * x + sin * y, cos * y - sin * x


def facing(velocities: Array, headings: Array) -> NDArray[np.bool_]:
    """For each robot, whether `velocities` (2, N) point before, not beside or behind it."""
    courses = np.arctan2(velocities[1], velocities[0])
    ahead: NDArray[np.bool_] = short_of(np.abs(wrap(courses - headings)), HALF_TURN / 2)
    return ahead


def turn_rate(across: Array, along: Array, headings: Array, limit: float) -> Array:
    """Turn rates (N,) that are `limit` (rad/s) when the velocity points 90° to the left.

    Proportional to the angle of the velocity (`along`, `across`) from the heading, so up to
    2·`limit` for a velocity that points straight back. There both ways are equally far, and the
    last bit of a sine would choose, one way on one processor and the other on the next. So the
    robot turns back through the heading 0: to the right where its heading is positive, else to the
    left.
    """
    angles = bearing(across, along)
    to_the_right = reached(angles, HALF_TURN) & beyond(headings, 0.0)
    rates: Array = limit * np.where(to_the_right, -HALF_TURN, angles) / (HALF_TURN / 2)
    return rates


def limited(rates: Array, limit: float) -> Array:
    """`rates` (N,) cut to [−`limit`, `limit`]; NaN stays NaN."""
    below = np.where(rates > limit, limit, rates)
    cut: Array = np.where(below < -limit, -limit, below)
    return cut


def scaled_to_norm(velocities: Array, limit: float) -> Array:
    """Copy of `velocities` (2, N) in which columns longer than `limit` (m/s) have that length."""
    speeds = np.hypot(velocities[0], velocities[1])
    scaled = np.array(velocities, dtype=float)
    fast = speeds > limit
    scaled[:, fast] *= limit / speeds[fast]
    return scaled


def wheels_from_command(wheel_radius: float, base_length: float) -> Array:
    """Matrix (2, 2) from a command (v; ω) to wheel speeds (left; right) in rad/s."""
    return np.array([[1.0, -base_length / 2], [1.0, base_length / 2]]) / wheel_radius


def _heading(poses: Array) -> Array:
    angles = poses[2]
    return np.array([np.cos(angles), np.sin(angles)])


def rotations(angles: Array) -> Array:
    """Rotations about the vertical axis, (3, 3, M) for M `angles` (rad) of any shape."""
    cos, sin = np.cos(np.ravel(angles)), np.sin(np.ravel(angles))
    turned = np.zeros((3, 3, cos.size))
    turned[0, 0] = turned[1, 1] = cos
    turned[0, 1], turned[1, 0] = -sin, sin
    turned[2, 2] = 1.0
    return turned
