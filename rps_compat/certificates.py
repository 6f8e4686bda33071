"""What the published barrier certificates have of their own, around the library's.

Each published certificate is one of :mod:`barrier_certificates`: which rows, on which points, with
which radius and gain. The table of who has which stands in ``docs/reference/utilities.md``. Their
own are:

- parameters that the library refuses, such as a limit of zero, since scripts rely on them;
- obstacles that are points, and keep the safety radius away;
- commands of unicycles that are mapped to points ahead of them and limited there
  (:class:`PointsAhead`);
- a warning where no velocity satisfies all rows: motors' limits hold then, and robots part as well
  as they can.

What they answer is the exact optimum.
"""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from barrier_certificates.checks import finite
from barrier_certificates.projection import ProjectionInfo, Projector, Status
from barrier_certificates.rows import Disc, LimitRows, Rows, VelocityPolygon
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate
from rps_compat import kinematics
from rps_compat.errors import RobotariumError
from rps_compat.kinematics import Array


class BoundaryError(RobotariumError, AssertionError, IndexError, TypeError, ValueError):
    """``boundary_points`` are not x_min, x_max, y_min and y_max."""


class NotFiniteError(RobotariumError, ValueError):
    """A command or pose that a certificate was asked about holds NaN or infinity."""


def boundary(points: Any) -> tuple[float, float, float, float]:
    """Read the arena (x_min, x_max, y_min, y_max) in metres, as the rows need it.

    Parameters
    ----------
    points : (4,) array-like
        What was given as ``boundary_points``, m.

    Raises
    ------
    BoundaryError
        `points` is not a sequence of four numbers.
    """
    try:
        x_min, x_max, y_min, y_max = (float(number) for number in points)
    except (TypeError, ValueError):
        raise BoundaryError(
            f"boundary_points is {points!r}, expected an array of x_min, x_max, y_min, y_max (m)"
        ) from None
    return x_min, x_max, y_min, y_max


def octagon(limit: float, first_side: float | None = None) -> LimitRows:
    """Return speed rows: the library's octagon for any limit, zero and negative ones too.

    Parameters
    ----------
    limit : float
        Speed at the octagon's corners, m/s.
    first_side : float, optional
        Distance of the side at +x, m/s, where it is not that of the others.
    """
    rows = times(limit, VelocityPolygon.octagon(1.0))
    if first_side is not None:
        rows.bounds[0] = first_side
        rows.top_speed = 1.1 * abs(first_side)
    return rows


def times(limit: float, polygon: VelocityPolygon, turning: bool = False) -> LimitRows:
    """Return the rows of a polygon so many times as large, whatever the sign.

    Parameters
    ----------
    limit : float
        How many times.
    polygon : VelocityPolygon
        The polygon, its bounds in m/s.
    turning : bool
        Whether it turns with the headings.
    """
    fastest = abs(limit) * polygon.top_speed()
    return LimitRows(polygon.normals, limit * polygon.bounds, polygon.names, turning, fastest)


def points_apart(
    radius: float,
    gain: float,
    *,
    unsafe_gain: float | None = None,
    walls: tuple[float, float, float, float] | None = None,
    limits: LimitRows | None = None,
) -> SingleIntegratorCertificate:
    """Create the certificate on points that move in any direction, for any parameters.

    Parameters
    ----------
    radius : float
        Smallest distance between two points, or a point and an obstacle (m).
    gain : float
        γ of pairs, walls and obstacles.
    unsafe_gain : float, optional
        γ of pairs that are closer than `radius` already.
    walls : tuple of four floats, optional
        The :func:`boundary`; points keep `radius` / 2 from its sides.
    limits : LimitRows, optional
        What the motors can do.
    """
    return SingleIntegratorCertificate(
        abs(radius),
        gain,
        unsafe_gain=unsafe_gain,
        boundary=walls,
        wall_margin=radius / 2,
        obstacle_margin=abs(radius),
        speed_limit=None,
        limits=limits,
        checked=False,
    )


def certify(
    certificate: SingleIntegratorCertificate | UnicycleCertificate,
    commands: Array,
    states: Array,
    obstacles: Array | None = None,
) -> tuple[Array, ProjectionInfo]:
    """Ask a certificate for the safe commands nearest to those given.

    Parameters
    ----------
    certificate : SingleIntegratorCertificate or UnicycleCertificate
        Who knows what is safe.
    commands : (2, N) array
        Commands as the certificate takes them, m/s, or m/s and rad/s.
    states : (2, N) or (3, N) array
        Positions, m, or poses, m and rad, as the certificate takes them.
    obstacles : (2, M) array, optional
        Points that stand still and keep the certificate's margin away, m.

    Returns
    -------
    safe : (2, N) array
        The safe commands.
    info : ProjectionInfo
        What was done.

    Warns
    -----
    UserWarning
        No command satisfies all rows; what is returned breaks them as little as possible.
    RuntimeWarning
        This is the certificate's first call, and something is nearer already than it would let it
        come. The published certificates are silent there.
    """
    discs = () if obstacles is None else [Disc((x, y), 0.0) for x, y in obstacles.T]
    safe, info = certificate(commands, states, discs)
    if info.unsafe_start:
        warnings.warn(
            f"the first call of a certificate finds {info.nearest} {1e3 * -info.clearance:.3g} mm "
            "nearer already than it lets them come: it guarantees nothing until they are apart",
            category=RuntimeWarning,
            stacklevel=3,
        )
    if info.status in (Status.RELAXED, Status.FAILED):
        worst = info.violated[0] if info.violated else "nothing"
        warnings.warn(
            f"no velocity keeps every robot safe: {worst} cannot be satisfied "
            f"(off by {info.violation:.3g} m/s), so robots do what they can",
            stacklevel=3,
        )
    return safe, info


@dataclass(frozen=True)
class PointsAhead:
    """A certificate on the points ahead of unicycles, for their commands.

    Parameters
    ----------
    certificate : SingleIntegratorCertificate
        What the points keep.
    distance : float
        How far ahead of the centres they lie (m).
    speed_limit : float, optional
        Wanted velocities of the points are first scaled down to this (m/s).
    turn_rate_limit : float, optional
        Turn rates are cut to ± this (rad/s) in the end.
    """

    certificate: SingleIntegratorCertificate
    distance: float
    speed_limit: float | None = None
    turn_rate_limit: float | None = None

    def __call__(
        self, commands: Array, poses: Array, obstacles: Array | None = None
    ) -> tuple[Array, ProjectionInfo]:
        """Return the safe commands nearest to those given, and what was done.

        Nearest is meant at the points.

        Parameters
        ----------
        commands : (2, N) array
            Commands (v; ω), m/s and rad/s.
        poses : (3, N) array
            Poses, m and rad.
        obstacles : (2, M) array, optional
            Points that stand still, m.

        Returns
        -------
        safe : (2, N) array
            Commands (v; ω), m/s and rad/s.
        info : ProjectionInfo
            What was done.
        """
        wanted = kinematics.point_velocity(commands, poses, self.distance)
        if self.speed_limit is not None:
            wanted = kinematics.scaled_to_norm(wanted, self.speed_limit)
        points = kinematics.projection_point(poses, self.distance)
        safe, info = certify(self.certificate, wanted, points, obstacles)
        answer = kinematics.unicycle_command(safe, poses, self.distance)
        if self.turn_rate_limit is not None:
            answer[1] = kinematics.limited(answer[1], self.turn_rate_limit)
        return answer, info


def nearest(velocities: Array, coefficients: Array, bounds: Array) -> tuple[Array, Status]:
    """Return the velocities nearest to those given that satisfy all rows.

    Parameters
    ----------
    velocities : (2, N) array
        Velocities, m/s.
    coefficients : (m, 2 N) array
        Of the rows ``coefficients @ v <= bounds``; the unknowns go robot by robot: x₁, y₁, x₂, …
    bounds : (m,) array
        Right-hand sides, m/s.

    Returns
    -------
    velocities : (2, N) array
        The nearest, m/s; zeros if nothing satisfies all rows.
    status : Status
        What became of them.
    """
    unknowns = velocities.size
    lengths = np.linalg.norm(coefficients, axis=1)
    lengths[lengths == 0] = 1.0
    rows = Rows(
        np.tile(np.arange(unknowns)[:, np.newaxis], len(bounds)),
        (coefficients / lengths[:, np.newaxis]).T,
        bounds / lengths,
        unknowns,
        np.full(len(bounds), np.inf),
        "row {}".format,
    )
    answer, info = Projector(on_infeasible="stop").project(velocities, rows)
    return answer, info.status


def require_finite(name: str, values: Array) -> None:
    """Refuse NaN and infinity.

    Parameters
    ----------
    name : str
        What the error calls it.
    values : (k, N) array
        Numbers, a column a robot.

    Raises
    ------
    NotFiniteError
        Says which robot, and what its value is.
    """
    if values.size and not finite(values):
        row, robot = (int(k) for k in np.argwhere(~np.isfinite(values))[0])
        raise NotFiniteError(
            f"{name}[{row}, {robot}] (robot {robot}) is {values[row, robot]}, expected a finite "
            "number"
        )
