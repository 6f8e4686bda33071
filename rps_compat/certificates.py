"""The published barrier certificates, composed from the rows of :mod:`barrier_certificates`.

Each published certificate is a selection: which rows, on which points, with which radius and gain.
The table of who has which stands in ``docs/utilities.md``. Here is what they share:

- :class:`PointCertificate` keeps points that move in any direction apart, inside and slow;
- :class:`UnicycleCertificate` maps commands to the points ahead of the robots, and back.

Unlike the certificates of :mod:`barrier_certificates`, which refuse parameters that make no sense,
these take whatever the published functions take (a gain of zero, a limit of zero), since scripts
rely on it. What they answer is the exact optimum. Where no velocity satisfies all rows, motors'
limits hold and robots part as well as they can, with a warning that names the worst row.
"""

import warnings
from typing import Any

import numpy as np

from barrier_certificates.projection import ProjectionInfo, Projector
from barrier_certificates.rows import (
    Disc,
    Family,
    LimitRows,
    ObstacleRows,
    PairRows,
    RowBook,
    Rows,
    Scene,
    WallRows,
    WheelDisturbance,
    rectangle,
)
from rps_compat import kinematics
from rps_compat.errors import RobotariumError
from rps_compat.kinematics import Array

#: Rows that ask for more than this are solved in a larger unit (m/s).
FAST = 10.0


class BoundaryError(RobotariumError, AssertionError, IndexError, TypeError, ValueError):
    """``boundary_points`` are not x_min, x_max, y_min and y_max."""


class NotFiniteError(RobotariumError, ValueError):
    """A command or pose that a certificate was asked about holds NaN or infinity."""


def boundary(points: Any) -> tuple[float, float, float, float]:
    """Read the arena (x_min, x_max, y_min, y_max) in metres, as the rows need it.

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
    """Speed rows: an octagon with its corners on the circle of `limit` (m/s).

    Parameters
    ----------
    first_side : float, optional
        Distance of the side at +x, where it is not that of the others.
    """
    angles = np.arange(8) * np.pi / 4
    bounds = np.full(8, limit * np.cos(np.pi / 8))
    fastest = abs(limit)
    if first_side is not None:
        bounds[0] = first_side
        fastest = 1.1 * abs(first_side)
    normals = np.stack([np.cos(angles), np.sin(angles)])
    return LimitRows(normals, bounds, ("speed limit",) * 8, top_speed=fastest)


def wheel_box(
    limit: float, wheel_radius: float, base_length: float, projection_distance: float
) -> LimitRows:
    """Rows that keep both wheels within ± `limit` (rad/s), on the velocity of the point ahead."""
    half_turn = base_length / (2 * projection_distance)
    sides = np.array([[1.0, -1.0, 1.0, -1.0], [half_turn, -half_turn, -half_turn, half_turn]])
    lengths = np.hypot(*sides)
    names = ("right wheel limit",) * 2 + ("left wheel limit",) * 2
    return LimitRows(sides / lengths, limit * abs(wheel_radius) / lengths, names, turning=True)


class PointCertificate:
    """The exact certificate on points that move in any direction.

    Parameters
    ----------
    radius : float
        Smallest distance between two points (m).
    gain : float
        γ of pairs, walls and obstacles.
    unsafe_gain : float, optional
        γ of pairs that are closer than `radius` already.
    walls : sequence of four floats, optional
        The arena; points keep `radius` / 2 from its sides.
    limits : LimitRows, optional
        What the motors can do.
    disturbance : WheelDisturbance, optional
        What the wheels do on their own; pairs and obstacles allow for it, walls do not.
    """

    def __init__(
        self,
        radius: float,
        gain: float,
        *,
        unsafe_gain: float | None = None,
        walls: Any = None,
        limits: LimitRows | None = None,
        disturbance: WheelDisturbance | None = None,
    ) -> None:
        self._radius, self._gain, self._disturbance = abs(radius), gain, disturbance
        self._families: list[Family] = [] if limits is None else [limits]
        self._top_speed = np.inf if limits is None else limits.top_speed
        if walls is not None:
            self._families.append(WallRows(*rectangle(boundary(walls)), radius / 2, gain))
        self._pairs = PairRows(self._radius, gain, unsafe_gain, disturbance)
        self._book = RowBook(self._families, self._pairs, self._top_speed)
        self._projector = Projector()
        self._obstacles: ObstacleRows | None = None

    def __call__(
        self,
        velocities: Array,
        points: Array,
        headings: Array | None = None,
        obstacles: Array | None = None,
    ) -> tuple[Array, ProjectionInfo]:
        """Certify.

        Parameters
        ----------
        velocities, points : array
            What is wanted and where the points are, (2, N), in m/s and m.
        headings : array, optional
            (cos θ; sin θ) (2, N), where limits or disturbance turn with the robots.
        obstacles : array, optional
            Points (2, M) that stand still and keep `radius` away.

        Returns
        -------
        velocities : array
            The safe velocities (2, N) nearest to those wanted.
        info : ProjectionInfo
            What was done.

        Warns
        -----
        UserWarning
            No velocity satisfies all rows; what is returned breaks them as little as possible.
        """
        self._place(obstacles)
        rows, _ = self._book.write(Scene(points, headings))
        safe, info = self._nearest(velocities, rows)
        if info.status in ("relaxed", "failed"):
            excess = rows.excess(np.nan_to_num(safe).T.reshape(-1))
            worst = rows.label(int(np.argmax(excess))) if len(rows) else "nothing"
            warnings.warn(
                f"no velocity keeps every robot safe: {worst} cannot be satisfied "
                f"(off by {info.violation:.3g} m/s), so robots do what they can",
                stacklevel=3,
            )
        return safe, info

    def _nearest(self, velocities: Array, rows: Rows) -> tuple[Array, ProjectionInfo]:
        """Project; in a larger unit of speed where rows ask for speeds of no robot.

        Certificates without limits may be asked to part robots at hundreds of metres a second, and
        solvers' tolerances are meant for a few. The program is the same in any unit.
        """
        unit = 1.0
        if self._top_speed == np.inf and len(rows):
            unit = float(rows.excess(velocities.T.reshape(-1)).max())
        if not unit > FAST:
            return self._projector.project(velocities, rows, self._top_speed)
        scaled = Rows(
            rows.index, rows.coefficient, rows.bound / unit, rows.size, rows.weight, rows.label
        )
        safe, info = self._projector.project(velocities / unit, scaled)
        info.violation *= unit
        info.intervention *= unit
        return safe * unit, info

    def _place(self, obstacles: Array | None) -> None:
        """Put obstacles where they are now."""
        points = () if obstacles is None else [(float(x), float(y)) for x, y in obstacles.T]
        if not points and self._obstacles is None:
            return
        discs = [Disc(point, 0.0) for point in points]
        if self._obstacles is not None and len(discs) == len(self._obstacles.names):
            self._obstacles.move(discs)
            return
        self._obstacles = (
            ObstacleRows(discs, self._radius, self._gain, self._disturbance) if discs else None
        )
        families = self._families + ([self._obstacles] if self._obstacles else [])
        self._book = RowBook(families, self._pairs, self._top_speed)
        self._projector.reset()


class UnicycleCertificate:
    """A :class:`PointCertificate` on the points ahead of unicycles, for their commands.

    Parameters
    ----------
    certificate : PointCertificate
        What the points keep.
    distance : float
        How far ahead of the centres they lie (m).
    speed_limit : float, optional
        Wanted velocities of the points are first scaled down to this (m/s).
    turn_rate_limit : float, optional
        Turn rates are cut to ± this (rad/s) in the end.
    """

    def __init__(
        self,
        certificate: PointCertificate,
        distance: float,
        *,
        speed_limit: float | None = None,
        turn_rate_limit: float | None = None,
    ) -> None:
        self._certificate = certificate
        self._distance = distance
        self._speed_limit = speed_limit
        self._turn_rate_limit = turn_rate_limit

    def __call__(
        self, commands: Array, poses: Array, obstacles: Array | None = None
    ) -> tuple[Array, ProjectionInfo]:
        """Safe commands (v; ω) (2, N) nearest to `commands` for `poses` (3, N), and what was done.

        Nearest is meant at the points; `obstacles` are points (2, M) that stand still.
        """
        wanted = kinematics.point_velocity(commands, poses, self._distance)
        if self._speed_limit is not None:
            wanted = kinematics.scaled_to_norm(wanted, self._speed_limit)
        headings = np.array([np.cos(poses[2]), np.sin(poses[2])], dtype=float)
        points = poses[:2] + self._distance * headings
        safe, info = self._certificate(wanted, points, headings, obstacles)
        answer = kinematics.unicycle_command(safe, poses, self._distance)
        if self._turn_rate_limit is not None:
            answer[1] = kinematics.limited(answer[1], self._turn_rate_limit)
        return answer, info


def nearest(velocities: Array, coefficients: Array, bounds: Array) -> tuple[Array, str]:
    """Velocities (2, N) nearest to `velocities` with `coefficients` · v <= `bounds`, and how.

    Parameters
    ----------
    coefficients : array
        (m, 2 N), the unknowns ordered robot by robot: x₁, y₁, x₂, …
    bounds : array
        (m,)

    Returns
    -------
    velocities : array
        Zeros if nothing satisfies all rows.
    status : str
        As in :class:`barrier_certificates.projection.ProjectionInfo`.
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

    Raises
    ------
    NotFiniteError
        Says which robot, and what its value is.
    """
    if not np.isfinite(values.sum()):
        row, robot = (int(k) for k in np.argwhere(~np.isfinite(values))[0])
        raise NotFiniteError(
            f"{name}[{row}, {robot}] (robot {robot}) is {values[row, robot]}, expected a finite "
            "number"
        )
