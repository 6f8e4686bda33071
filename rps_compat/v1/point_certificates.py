"""The certificates of generation 1 for points: of single integrators, and ahead of unicycles.

What they check, when, and what they leave as the published ones do is the same for the variants
with and without walls, and with and without a gain of its own for pairs that are too close.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from barrier_certificates.single_integrator import SingleIntegratorCertificate
from rps_compat import certificates, deviations, kinematics
from rps_compat.arguments import NumberError, number
from rps_compat.arguments import matrix as require_matrix
from rps_compat.certificates import PointsAhead
from rps_compat.kinematics import HALF_TURN, Array

Filter = Callable[[Array, Array], Array]

#: Robots are 11 cm wide, so a smaller radius keeps nobody apart.
SMALLEST_RADIUS = 0.12

#: The fastest that robots can drive (m/s), and the limit of the published unicycle certificates
#: whatever their ``magnitude_limit``.
TOP_SPEED = 0.2


def single_integrator(
    barrier_gain: float,
    safety_radius: float,
    magnitude_limit: float,
    unsafe_gain: float | None = None,
    walls: tuple[Any, ...] = (),
) -> Filter:
    """Make the filter that keeps points apart which move in any direction.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    safety_radius : float
        Smallest distance between two robots (m, >= `SMALLEST_RADIUS`).
    magnitude_limit : float
        Wanted velocities are scaled down to this (m/s, > 0, <= `TOP_SPEED`).
    unsafe_gain : float, optional
        γ of pairs that are too close already; by default that of all rows.
    walls : tuple of (4,) arrays
        None, or one: x_min, x_max, y_min, y_max (m), which are checked when the filter is called.

    Returns
    -------
    callable
        From velocities (2, N) and positions (2, N) to velocities (2, N), m/s and m.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    number("barrier_gain", barrier_gain, above=0)
    number("safety_radius", safety_radius, least=SMALLEST_RADIUS)
    number("magnitude_limit", magnitude_limit, above=0, most=TOP_SPEED)

    @cache
    def certificate() -> SingleIntegratorCertificate:
        boundary = certificates.boundary(walls[0]) if walls else None
        return certificates.points_apart(
            safety_radius, barrier_gain, unsafe_gain=unsafe_gain, walls=boundary
        )

    def f(dxi: Array, x: Array) -> Array:
        require_matrix("dxi", dxi, 2)
        require_matrix("x", x, 2, dxi.shape[1])
        safe_velocities = certificate()
        wanted = kinematics.scaled_to_norm(dxi, magnitude_limit)
        if dxi.dtype.kind == "f" and deviations.as_published("certificates change their input"):
            dxi[:] = wanted
        if dxi.dtype != np.float64:
            raise NumberError(
                f"dxi holds {dxi.dtype}, expected float64: convert it with dxi.astype(float)"
            )
        certificates.require_finite("dxi", dxi)
        certificates.require_finite("x", x)
        if dxi.shape[1] == 0:
            return wanted
        return certificates.certify(safe_velocities, wanted, x.astype(float))[0]

    return f


def unicycle(
    barrier_gain: float,
    safety_radius: float,
    projection_distance: float,
    magnitude_limit: float,
    unsafe_gain: float | None = None,
    walls: tuple[Any, ...] = (),
) -> Filter:
    """Make the filter that keeps the points ahead of unicycles apart.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    safety_radius : float
        Points stay `safety_radius` + `projection_distance` apart (m, >= `SMALLEST_RADIUS`).
    projection_distance : float
        How far ahead of the centres the points lie (m, > 0).
    magnitude_limit : float
        Wanted velocities of the points are scaled down to this (m/s, > 0, <= `TOP_SPEED`).
    unsafe_gain : float, optional
        γ of pairs that are too close already; by default that of all rows.
    walls : tuple of (4,) arrays
        None, or one: x_min, x_max, y_min, y_max (m), which are checked when the filter is called.

    Returns
    -------
    callable
        From commands (v; ω) (2, N) and poses (3, N) to commands (2, N).

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    number("barrier_gain", barrier_gain, above=0)
    number("safety_radius", safety_radius, least=SMALLEST_RADIUS)
    number("projection_distance", projection_distance, above=0)
    number("magnitude_limit", magnitude_limit, above=0, most=TOP_SPEED)
    if deviations.as_published("magnitude_limit of unicycle certificates"):
        magnitude_limit = TOP_SPEED

    @cache
    def certificate() -> PointsAhead:
        boundary = certificates.boundary(walls[0]) if walls else None
        points = certificates.points_apart(
            safety_radius + projection_distance,
            barrier_gain,
            unsafe_gain=unsafe_gain,
            walls=boundary,
        )
        return PointsAhead(
            points, projection_distance, speed_limit=magnitude_limit, turn_rate_limit=HALF_TURN
        )

    def f(dxu: Array, x: Array) -> Array:
        require_matrix("dxu", dxu, 2)
        require_matrix("x", x, 3, dxu.shape[1])
        certificates.require_finite("dxu", dxu)
        certificates.require_finite("x", x)
        if dxu.shape[1] == 0:
            return dxu.astype(float)
        return certificate()(dxu, x)[0]

    return f
