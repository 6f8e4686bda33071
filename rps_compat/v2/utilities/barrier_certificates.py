"""Barrier certificates by the names of generation 2.

Each function below is a selection of rows, made in :mod:`rps_compat.certificates`; who has which
rows stands in ``docs/reference/utilities.md``. None of them changes its arguments.
"""

import math
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.projection import Status
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from rps_compat import certificates, deviations
from rps_compat.arguments import NumberError, number, scalar
from rps_compat.arguments import matrix as require_matrix
from rps_compat.certificates import NotFiniteError, PointsAhead
from rps_compat.deferred import matrix, qp, sparse
from rps_compat.kinematics import Array
from rps_compat.testbed import GTERNAL
from rps_compat.v2.utilities.transformations import (
    create_si_to_uni_mapping,
    create_uni_to_si_mapping,
)

__all__ = [
    "create_si_barrier_certificate",
    "create_si_barrier_certificate_with_boundary",
    "create_si_to_uni_mapping",
    "create_uni_barrier_certificate",
    "create_uni_barrier_certificate_with_boundary",
    "create_uni_to_si_mapping",
    "math",
    "matrix",
    "np",
    "qp",
    "sparse",
    "warnings",
]

Filter = Callable[[Array, Array], Array]

#: Walls where none are given: the arena for unicycles, and 10 cm around it for single integrators.
ARENA = GTERNAL.boundaries
AROUND_ARENA = (-1.7, 1.7, -1.1, 1.1)


class ObstacleFilter(Protocol):
    """A function of commands and poses that may be told of obstacles."""

    def __call__(self, dxu: Array, x: Array, obstacles: Array | None = ...) -> Array:
        """Return the safe commands nearest to those wanted.

        Parameters
        ----------
        dxu : (2, N) array
            Commands (v; ω), m/s and rad/s.
        x : (3, N) array
            Poses, m and rad.
        obstacles : (2, M) array, optional
            Points that stand still, m.

        Returns
        -------
        (2, N) array
            Commands (v; ω), m/s and rad/s.
        """


def create_si_barrier_certificate(
    safety_radius: float = 0.15, barrier_gain: float = 100.0, magnitude_limit: float = 0.2
) -> Filter:
    """Create ``barrier_certificate(dxi, x)``: the safe velocities nearest to those wanted.

    Parameters
    ----------
    safety_radius : float
        Smallest distance between two robots (m).
    barrier_gain : float
        γ of the rows: the larger, the faster robots may close in.
    magnitude_limit : float
        No velocity leaves the octagon within the circle of this radius (m/s).

    Returns
    -------
    callable
        From velocities (2, N) and positions or poses (2 or 3, N) to velocities (2, N). Raises
        NotAnArrayError, ShapeError or NumberError for what it cannot certify; warns where no
        velocity is safe, and stops the robots where a number is not finite.
    """
    return _single_integrator(safety_radius, barrier_gain, magnitude_limit)


def create_si_barrier_certificate_with_boundary(
    safety_radius: float = 0.15,
    barrier_gain: float = 100.0,
    magnitude_limit: float = 0.2,
    boundary_points: Array | None = None,
) -> Filter:
    """Create ``barrier_certificate(dxi, x)`` that has walls too, to keep half a radius from.

    Parameters
    ----------
    safety_radius : float
        Smallest distance between two robots (m).
    barrier_gain : float
        γ of the rows: the larger, the faster robots may close in.
    magnitude_limit : float
        No velocity leaves the octagon within the circle of this radius (m/s).
    boundary_points : (4,) array, optional
        x_min, x_max, y_min, y_max (m), by default 10 cm outside the arena; anything else raises
        BoundaryError at the call.

    Returns
    -------
    callable
        As that of :func:`create_si_barrier_certificate`.
    """
    walls = AROUND_ARENA if boundary_points is None else boundary_points
    return _single_integrator(safety_radius, barrier_gain, magnitude_limit, walls)


def create_uni_barrier_certificate(
    barrier_gain: float = 100.0,
    safety_radius: float = 0.15,
    projection_distance: float = 0.05,
    velocity_magnitude_limit: float = 0.2,
) -> Filter:
    """Create ``barrier_unicycle(dxu, x)``: the safe commands nearest to those wanted.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows: the larger, the faster robots may close in.
    safety_radius : float
        Distance to keep (m): points ahead of the robots stay `safety_radius` + 2
        `projection_distance` apart, so centres stay `safety_radius` apart.
    projection_distance : float
        How far ahead of the centres these points lie (m, > 0).
    velocity_magnitude_limit : float
        No point leaves the octagon of velocities within the circle of this radius (m/s).

    Returns
    -------
    callable
        From commands (v; ω) (2, N) and poses (3, N) to commands (2, N). Raises NotAnArrayError,
        ShapeError or NumberError for what it cannot certify; warns where no command is safe, and
        stops the robots where a number is not finite.

    Raises
    ------
    NumberError
        `projection_distance` is outside its range.
    """
    certified = _unicycle(
        safety_radius, barrier_gain, projection_distance, velocity_magnitude_limit
    )

    def barrier_unicycle(dxu: Array, x: Array) -> Array:
        return certified(dxu, x)

    return barrier_unicycle


def create_uni_barrier_certificate_with_boundary(
    safety_radius: float = 0.12,
    barrier_gain: float = 150.0,
    projection_distance: float = 0.03,
    velocity_magnitude_limit: float = 0.2,
    boundary_points: Array | None = None,
) -> ObstacleFilter:
    """Create ``barrier_unicycle(dxu, x, obstacles)`` that keeps robots in the arena too.

    Parameters
    ----------
    safety_radius : float
        Distance to keep (m), as in :func:`create_uni_barrier_certificate`.
    barrier_gain : float
        γ of the rows: the larger, the faster robots may close in.
    projection_distance : float
        How far ahead of the centres the certified points lie (m, > 0).
    velocity_magnitude_limit : float
        No point leaves the octagon of velocities within the circle of this radius (m/s).
    boundary_points : (4,) array, optional
        x_min, x_max, y_min, y_max (m), by default the arena; anything else raises BoundaryError at
        the call. Points ahead keep half their radius from its sides.

    Returns
    -------
    callable
        As that of :func:`create_uni_barrier_certificate`; `obstacles` (2, M) are points that stand
        still, and are kept off like robots.

    Raises
    ------
    NumberError
        `projection_distance` is outside its range, or `safety_radius` is not a number.
    """
    scalar("safety_radius", safety_radius)
    walls = ARENA if boundary_points is None else boundary_points
    certified = _unicycle(
        safety_radius, barrier_gain, projection_distance, velocity_magnitude_limit, walls
    )

    def barrier_unicycle(dxu: Array, x: Array, obstacles: Array | None = None) -> Array:
        return certified(dxu, x, obstacles)

    return barrier_unicycle


def _single_integrator(
    safety_radius: Any, barrier_gain: Any, magnitude_limit: Any, walls: Any = None
) -> Filter:
    certificate = _point_certificate(safety_radius, barrier_gain, magnitude_limit, walls)

    def barrier_certificate(dxi: Array, x: Array) -> Array:
        require_matrix("dxi", dxi, 2)
        require_matrix("x", x, 2, dxi.shape[1], more_rows=True)
        if dxi.dtype == np.float32:
            raise NumberError("dxi holds float32, expected float64: use dxi.astype(float)")
        if _left_alone(dxi):
            return dxi
        if not _finite(dxi, x[:2]):
            return np.zeros(dxi.shape)
        safe, info = certificates.certify(certificate(), dxi.astype(float), x[:2].astype(float))
        return dxi if dxi.shape[1] == 1 and info.status is Status.TRIVIAL else safe

    return barrier_certificate


def _unicycle(
    safety_radius: Any,
    barrier_gain: Any,
    projection_distance: Any,
    velocity_magnitude_limit: Any,
    walls: Any = None,
) -> ObstacleFilter:
    number("projection_distance", projection_distance, above=0)

    @cache
    def certificate() -> PointsAhead:
        scalar("safety_radius", safety_radius)
        radius = safety_radius + 2 * projection_distance
        points = _point_certificate(radius, barrier_gain, velocity_magnitude_limit, walls)()
        return PointsAhead(points, projection_distance)

    def barrier_unicycle(dxu: Array, x: Array, obstacles: Array | None = None) -> Array:
        require_matrix("dxu", dxu, 2)
        require_matrix("x", x, 3, dxu.shape[1])
        if obstacles is not None:
            require_matrix("obstacles", obstacles, 2)
        if _left_alone(dxu):
            return dxu
        if not _finite(dxu, x):
            return np.zeros(dxu.shape)
        robots = dxu.shape[1]
        if obstacles is not None and deviations.as_published("obstacles"):
            dxu, x = _with_obstacles(dxu, x, obstacles, projection_distance)
            return certificate()(dxu, x)[0][:, :robots]
        safe, info = certificate()(dxu, x, obstacles)
        return dxu if robots == 1 and info.status is Status.TRIVIAL else safe

    return barrier_unicycle


def _point_certificate(
    radius: Any, gain: Any, limit: Any, walls: Any
) -> Callable[[], SingleIntegratorCertificate]:
    """Defer the certificate to its first use, where wrong parameters are reported."""

    @cache
    def build() -> SingleIntegratorCertificate:
        scalar("safety_radius", radius)
        scalar("barrier_gain", gain)
        scalar("velocity_magnitude_limit", limit)
        lopsided = walls is None and deviations.as_published("speed limit towards +x")
        return certificates.points_apart(
            radius,
            gain,
            walls=None if walls is None else certificates.boundary(walls),
            limits=certificates.octagon(limit, first_side=limit if lopsided else None),
        )

    return build


def _with_obstacles(
    dxu: Array, x: Array, obstacles: Array, projection_distance: float
) -> tuple[Array, Array]:
    """Commands and poses with obstacles as further robots, whose points ahead they are."""
    still = np.zeros((2, obstacles.shape[1]))
    poses = np.vstack([obstacles, np.zeros(obstacles.shape[1])])
    poses[0] -= projection_distance
    return np.hstack([dxu, still]), np.hstack([x, poses])


def _solve_qp(
    N: int, vhat: NDArray[np.float64], A: NDArray[np.float64], b: NDArray[np.float64]
) -> Array:
    """Solve min ‖v − v̂‖² over A v ≤ b for 2 `N` unknowns, and return v as (2, N).

    Private as published, yet found by scripts that import everything. Unknowns are ordered robot by
    robot, (x₁, y₁, x₂, …); where no v satisfies all rows, a warning says so and zeros come back.
    """
    wanted = np.reshape(np.asarray(vhat, dtype=float), (2, N), order="F")
    safe, status = certificates.nearest(wanted, np.asarray(A, dtype=float), np.ravel(b))
    if status is Status.FAILED:
        warnings.warn("no velocity satisfies all rows; all robots are stopped", stacklevel=2)
    return safe


def _left_alone(commands: Array) -> bool:
    """Whether there is nobody to certify."""
    return commands.shape[1] == 0 or (
        commands.shape[1] == 1 and deviations.as_published("certificate of a single robot")
    )


def _finite(commands: Array, states: Array) -> bool:
    """Whether all numbers are finite; warns, as published, if not."""
    try:
        certificates.require_finite("dxu", commands)
        certificates.require_finite("x", states)
    except NotFiniteError as error:
        warnings.warn(f"{error}; all robots are stopped", stacklevel=3)
        return False
    return True
