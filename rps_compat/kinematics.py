"""From velocities of a point to commands of a unicycle, and back.

A unicycle at (x, y, θ) takes a forward speed v and a turn rate ω; it cannot move sideways, so a
velocity u of its centre cannot be obeyed at once. There are two ways out:

- **Project.** A point at distance d ahead of the centre, q = p + d e with e = (cos θ, sin θ), *can*
  move in any direction: q̇ = v e + d ω e⊥. It is called projection point, or look-ahead point. This
  is a linear bijection for d > 0, so a point velocity has exactly one command: v = e·q̇,
  ω = e⊥·q̇ / d (feedback linearisation; Siciliano et al., *Robotics*, section 11.6).
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
    """Bring angles into [−π, π]; half a turn, to within a tie, keeps its sign.

    Parameters
    ----------
    angle : (...) array
        Angles, rad.

    Returns
    -------
    (...) array
        The same directions, rad.
    """
    wrapped = np.arctan2(np.sin(angle), np.cos(angle))
    with_sign: Array = np.where(
        reached(np.abs(wrapped), HALF_TURN), np.copysign(HALF_TURN, angle), wrapped
    )
    return with_sign


def bearing(across: Array, along: Array) -> Array:
    """Return the angles, in (−π, π], of vectors with these components.

    What lies exactly behind has the bearing π.

    Parameters
    ----------
    across : (N,) array
        Components to the left.
    along : (N,) array
        Components ahead, in the same unit.

    Returns
    -------
    (N,) array
        Angles from straight ahead, to the left, rad.
    """
    angle = np.arctan2(across, along)
    one_sided: Array = np.where(within(angle, -HALF_TURN), HALF_TURN, angle)
    return one_sided


def projection_point(poses: Array, distance: float) -> Array:
    """Return the points that lie a distance ahead of the robots' centres.

    Parameters
    ----------
    poses : (3, N) array
        Poses, m and rad.
    distance : float
        How far ahead of the centre a projection point lies, m.

    Returns
    -------
    (2, N) array
        Points, m.
    """
    points: Array = poses[:2] + distance * _heading(poses)
    return points


def center_of(points: Array, poses: Array, distance: float) -> Array:
    """Return the centres of robots whose projection points are known.

    Parameters
    ----------
    points : (2, N) array
        Projection points, m.
    poses : (3, N) array
        Poses, of which the headings are read, rad.
    distance : float
        How far ahead of the centre a projection point lies, m.

    Returns
    -------
    (2, N) array
        Centres, m.
    """
    centers: Array = points - distance * _heading(poses)
    return centers


def point_velocity(commands: Array, poses: Array, distance: float) -> Array:
    """Return the velocities of the projection points under commands.

    Parameters
    ----------
    commands : (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    poses : (3, N) array
        Poses, m and rad.
    distance : float
        How far ahead of the centre a projection point lies, m.

    Returns
    -------
    (2, N) array
        Velocities in the arena's frame, m/s.
    """
    cos, sin = _heading(poses)
    ahead, sideways = commands[0], distance * commands[1]
    return np.array([cos * ahead - sin * sideways, sin * ahead + cos * sideways])


def unicycle_command(velocities: Array, poses: Array, distance: float) -> Array:
    """Return the commands under which the projection points move with given velocities.

    Parameters
    ----------
    velocities : (2, N) array
        Velocities in the arena's frame, m/s.
    poses : (3, N) array
        Poses, m and rad.
    distance : float
        How far ahead of the centre a projection point lies, m.

    Returns
    -------
    (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    """
    ahead, sideways = along_and_across(velocities, poses)
    return np.array([ahead, sideways / distance])


def along_and_across(velocities: Array, poses: Array) -> tuple[Array, Array]:
    """Return the components of velocities along the headings and to their left.

    Parameters
    ----------
    velocities : (2, N) array
        Velocities in the arena's frame, m/s.
    poses : (3, N) array
        Poses, m and rad.

    Returns
    -------
    along : (N,) array
        Ahead, m/s.
    across : (N,) array
        To the left, m/s.
    """
    cos, sin = _heading(poses)
    x, y = velocities[0], velocities[1]
    return cos * x + sin * y, cos * y - sin * x


def facing(velocities: Array, headings: Array) -> NDArray[np.bool_]:
    """Return for each robot whether its velocity points before it, not beside or behind.

    Parameters
    ----------
    velocities : (2, N) array
        Velocities in the arena's frame, m/s.
    headings : (N,) array
        Headings, rad.

    Returns
    -------
    (N,) boolean array
        True where it does.
    """
    courses = np.arctan2(velocities[1], velocities[0])
    ahead: NDArray[np.bool_] = short_of(np.abs(wrap(courses - headings)), HALF_TURN / 2)
    return ahead


def turn_rate(across: Array, along: Array, headings: Array, limit: float) -> Array:
    """Return turn rates that are the limit when the velocity points 90° to the left.

    Proportional to the angle of the velocity (`along`, `across`) from the heading, so up to
    2·`limit` for a velocity that points straight back. There both ways are equally far, and the
    last bit of a sine would choose, one way on one processor and the other on the next. So the
    robot turns back through the heading 0: to the right where its heading is positive, else to the
    left.

    Parameters
    ----------
    across : (N,) array
        Components of the velocity to the left, m/s.
    along : (N,) array
        Components ahead, m/s.
    headings : (N,) array
        Headings, rad.
    limit : float
        Turn rate at 90°, rad/s.

    Returns
    -------
    (N,) array
        Turn rates, rad/s.
    """
    angles = bearing(across, along)
    to_the_right = reached(angles, HALF_TURN) & beyond(headings, 0.0)
    rates: Array = limit * np.where(to_the_right, -HALF_TURN, angles) / (HALF_TURN / 2)
    return rates


def limited(rates: Array, limit: float) -> Array:
    """Cut rates to ± a limit; NaN stays NaN.

    Parameters
    ----------
    rates : (N,) array
        Rates, in any unit.
    limit : float
        The limit, in the same unit.

    Returns
    -------
    (N,) array
        The cut rates.
    """
    below = np.where(rates > limit, limit, rates)
    cut: Array = np.where(below < -limit, -limit, below)
    return cut


def scaled_to_norm(velocities: Array, limit: float) -> Array:
    """Copy velocities, those that are too long with the length of the limit.

    Parameters
    ----------
    velocities : (2, N) array
        Velocities, m/s.
    limit : float
        Greatest length, m/s.

    Returns
    -------
    (2, N) array
        Velocities, m/s.
    """
    speeds = np.hypot(velocities[0], velocities[1])
    scaled = np.array(velocities, dtype=float)
    fast = speeds > limit
    scaled[:, fast] *= limit / speeds[fast]
    return scaled


def wheels_from_command(wheel_radius: float, base_length: float) -> Array:
    """Return the matrix from a command (v; ω) to wheel speeds (left; right).

    Parameters
    ----------
    wheel_radius : float
        Radius of a wheel, m.
    base_length : float
        From wheel to wheel, m.

    Returns
    -------
    (2, 2) array
        Makes rad/s of m/s and rad/s.
    """
    return np.array([[1.0, -base_length / 2], [1.0, base_length / 2]]) / wheel_radius


def _heading(poses: Array) -> Array:
    angles = poses[2]
    return np.array([np.cos(angles), np.sin(angles)])


def rotations(angles: Array) -> Array:
    """Return rotations about the vertical axis.

    Parameters
    ----------
    angles : (...) array
        M angles in any shape, rad.

    Returns
    -------
    (3, 3, M) array
        A rotation matrix for each angle.
    """
    cos, sin = np.cos(np.ravel(angles)), np.sin(np.ravel(angles))
    turned = np.zeros((3, 3, cos.size))
    turned[0, 0] = turned[1, 1] = cos
    turned[0, 1], turned[1, 0] = -sin, sin
    turned[2, 2] = 1.0
    return turned
