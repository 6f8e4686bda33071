"""Barrier certificates by the names of generation 1.

Each function below is a selection of rows, made in :mod:`rps_compat.certificates`; who has which
rows stands in ``docs/reference/utilities.md``. None of them changes its arguments.
"""

import itertools

import numpy as np
from numpy import dot

from rps_compat.arguments import number
from rps_compat.deferred import comb, matrix, qp, sparse
from rps_compat.kinematics import Array
from rps_compat.testbed import GRITSBOT_X
from rps_compat.v1.point_certificates import Filter, single_integrator, unicycle
from rps_compat.v1.utilities.transformations import (
    create_si_to_uni_dynamics,
    create_si_to_uni_dynamics_with_backwards_motion,
    create_si_to_uni_mapping,
    create_uni_to_si_dynamics,
)
from rps_compat.v1.wheel_certificate import RobustWheels, WheelFilter, robust_wheels

__all__ = [
    "comb",
    "create_si_to_uni_dynamics",
    "create_si_to_uni_dynamics_with_backwards_motion",
    "create_si_to_uni_mapping",
    "create_single_integrator_barrier_certificate",
    "create_single_integrator_barrier_certificate2",
    "create_single_integrator_barrier_certificate_with_boundary",
    "create_uni_to_si_dynamics",
    "create_unicycle_barrier_certificate",
    "create_unicycle_barrier_certificate2",
    "create_unicycle_barrier_certificate_with_boundary",
    "create_unicycle_differential_drive_barrier_certificate",
    "create_unicycle_differential_drive_barrier_certificate_with_boundary",
    "dot",
    "itertools",
    "matrix",
    "np",
    "qp",
    "sparse",
]

ARENA = np.array(GRITSBOT_X.boundaries)


def create_single_integrator_barrier_certificate(
    barrier_gain: float = 100, safety_radius: float = 0.17, magnitude_limit: float = 0.2
) -> Filter:
    """Create ``f(dxi, x)``: the safe velocities nearest to those wanted.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    safety_radius : float
        Smallest distance between two robots (m, >= 0.12).
    magnitude_limit : float
        Wanted velocities are scaled down to this (m/s, > 0, <= 0.2) before they are certified.

    Returns
    -------
    callable
        From velocities (2, N) and positions (2, N) to velocities (2, N). Raises NotAnArrayError or
        ShapeError for anything else, NumberError unless ``dxi`` holds float64, NotFiniteError for
        NaN; warns where no velocity is safe.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    return single_integrator(barrier_gain, safety_radius, magnitude_limit)


def create_single_integrator_barrier_certificate_with_boundary(
    barrier_gain: float = 100,
    safety_radius: float = 0.17,
    magnitude_limit: float = 0.2,
    boundary_points: Array = ARENA,
) -> Filter:
    """Create ``f(dxi, x)`` that keeps robots in the arena too, half a radius from its sides.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    safety_radius : float
        Smallest distance between two robots (m, >= 0.12).
    magnitude_limit : float
        Wanted velocities are scaled down to this (m/s, > 0, <= 0.2) before they are certified.
    boundary_points : (4,) array
        x_min, x_max, y_min, y_max (m); anything else raises BoundaryError when ``f`` is called.

    Returns
    -------
    callable
        As that of :func:`create_single_integrator_barrier_certificate`.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    return single_integrator(barrier_gain, safety_radius, magnitude_limit, walls=(boundary_points,))


def create_single_integrator_barrier_certificate2(
    barrier_gain: float = 100,
    unsafe_barrier_gain: float = 1e6,
    safety_radius: float = 0.17,
    magnitude_limit: float = 0.2,
) -> Filter:
    """Create ``f(dxi, x)`` that drives robots apart that are too close.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    unsafe_barrier_gain : float
        γ of pairs that are too close already, > 0.
    safety_radius : float
        Smallest distance between two robots (m, >= 0.12).
    magnitude_limit : float
        Wanted velocities are scaled down to this (m/s, > 0, <= 0.2) before they are certified.

    Returns
    -------
    callable
        As that of :func:`create_single_integrator_barrier_certificate`.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    number("unsafe_barrier_gain", unsafe_barrier_gain, above=0)
    return single_integrator(barrier_gain, safety_radius, magnitude_limit, unsafe_barrier_gain)


def create_unicycle_barrier_certificate(
    barrier_gain: float = 100,
    safety_radius: float = 0.12,
    projection_distance: float = 0.05,
    magnitude_limit: float = 0.2,
) -> Filter:
    """Create ``f(dxu, x)``: the safe commands nearest to those wanted.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    safety_radius : float
        Distance to keep (m, >= 0.12): points ahead of the robots stay `safety_radius` +
        `projection_distance` apart.
    projection_distance : float
        How far ahead of the centres these points lie (m, > 0).
    magnitude_limit : float
        Wanted velocities of the points are scaled down to this (m/s, > 0, <= 0.2).

    Returns
    -------
    callable
        From commands (v; ω) (2, N) and poses (3, N) to commands (2, N), turn rates within ± π.
        Raises NotAnArrayError or ShapeError for anything else, NotFiniteError for NaN; warns where
        no command is safe.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    return unicycle(barrier_gain, safety_radius, projection_distance, magnitude_limit)


def create_unicycle_barrier_certificate_with_boundary(
    barrier_gain: float = 100,
    safety_radius: float = 0.12,
    projection_distance: float = 0.05,
    magnitude_limit: float = 0.2,
    boundary_points: Array = ARENA,
) -> Filter:
    """Create ``f(dxu, x)`` that keeps robots in the arena too.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    safety_radius : float
        Distance to keep (m), as in :func:`create_unicycle_barrier_certificate`.
    projection_distance : float
        How far ahead of the centres the certified points lie (m).
    magnitude_limit : float
        As in :func:`create_unicycle_barrier_certificate` (m/s).
    boundary_points : (4,) array
        x_min, x_max, y_min, y_max (m); anything else raises BoundaryError when ``f`` is called.

    Returns
    -------
    callable
        As that of :func:`create_unicycle_barrier_certificate`.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    return unicycle(
        barrier_gain, safety_radius, projection_distance, magnitude_limit, walls=(boundary_points,)
    )


def create_unicycle_barrier_certificate2(
    barrier_gain: float = 500,
    unsafe_barrier_gain: float = 1e6,
    safety_radius: float = 0.12,
    projection_distance: float = 0.05,
    magnitude_limit: float = 0.2,
) -> Filter:
    """Create ``f(dxu, x)`` that drives robots apart that are too close.

    Parameters
    ----------
    barrier_gain : float
        γ of the rows, > 0: the larger, the faster robots may close in.
    unsafe_barrier_gain : float
        γ of pairs that are too close already, > 0.
    safety_radius : float
        Distance to keep (m), as in :func:`create_unicycle_barrier_certificate`.
    projection_distance : float
        How far ahead of the centres the certified points lie (m).
    magnitude_limit : float
        As in :func:`create_unicycle_barrier_certificate` (m/s).

    Returns
    -------
    callable
        As that of :func:`create_unicycle_barrier_certificate`.

    Raises
    ------
    NumberError
        A parameter is of the wrong type or outside its range.
    """
    number("unsafe_barrier_gain", unsafe_barrier_gain, above=0)
    return unicycle(
        barrier_gain, safety_radius, projection_distance, magnitude_limit, unsafe_barrier_gain
    )


def create_unicycle_differential_drive_barrier_certificate(
    max_num_obstacle_points: int = 100,
    max_num_robots: int = 30,
    disturbance: float = 5,
    wheel_vel_limit: float = 12.5,
    base_length: float = 0.105,
    wheel_radius: float = 0.016,
    projection_distance: float = 0.05,
    barrier_gain: float = 150,
    safety_radius: float = 0.17,
) -> WheelFilter:
    """Create ``robust_barriers(dxu, x, obstacles)``: safe commands that the wheels can obey.

    Parameters
    ----------
    max_num_obstacle_points, max_num_robots : int
        Most obstacles and robots that a call may have.
    disturbance : float
        Unwanted speed of a wheel (rad/s, either way) that robots stay safe under.
    wheel_vel_limit : float
        Fastest that a wheel turns (rad/s).
    base_length, wheel_radius : float
        Of the robots (m).
    projection_distance : float
        How far ahead of the centres the certified points lie (m).
    barrier_gain : float
        γ of the rows.
    safety_radius : float
        Smallest distance between two points, or a point and an obstacle (m).

    Returns
    -------
    callable
        From commands (v; ω) (2, N), poses (3, N) and obstacles (2, M), which are points, to
        commands (2, N). Raises NotAnArrayError, ShapeError, NumberError, CrowdedError or
        NotFiniteError for what it cannot certify; warns where no command is safe.

    Raises
    ------
    NumberError, ZeroDivisionError
        A parameter is not a number, or zero where robots need an extent.
    """
    return robust_wheels(
        RobustWheels(
            max_num_obstacle_points,
            max_num_robots,
            disturbance,
            wheel_vel_limit,
            base_length,
            wheel_radius,
            projection_distance,
            barrier_gain,
            safety_radius,
        ),
        published="differential drive without boundary",
    )


def create_unicycle_differential_drive_barrier_certificate_with_boundary(
    max_num_obstacle_points: int = 100,
    max_num_robots: int = 30,
    disturbance: float = 5,
    wheel_vel_limit: float = 12.5,
    base_length: float = 0.105,
    wheel_radius: float = 0.016,
    projection_distance: float = 0.05,
    barrier_gain: float = 150,
    safety_radius: float = 0.17,
    boundary_points: Array = ARENA,
) -> WheelFilter:
    """Create ``robust_barriers(dxu, x, obstacles)`` that keeps robots in the arena too.

    The walls do not allow for the disturbance, as published.

    Parameters
    ----------
    max_num_obstacle_points, max_num_robots : int
        Most obstacles and robots that a call may have.
    disturbance : float
        Unwanted speed of a wheel (rad/s, either way) that robots stay safe under.
    wheel_vel_limit : float
        Fastest that a wheel turns (rad/s).
    base_length, wheel_radius : float
        Of the robots (m).
    projection_distance : float
        How far ahead of the centres the certified points lie (m).
    barrier_gain : float
        γ of the rows.
    safety_radius : float
        Smallest distance between two points, or a point and an obstacle (m).
    boundary_points : (4,) array
        x_min, x_max, y_min, y_max (m); anything else raises BoundaryError at the call.

    Returns
    -------
    callable
        As that of :func:`create_unicycle_differential_drive_barrier_certificate`.

    Raises
    ------
    NumberError, ZeroDivisionError
        A parameter is not a number, or zero where robots need an extent.
    """
    return robust_wheels(
        RobustWheels(
            max_num_obstacle_points,
            max_num_robots,
            disturbance,
            wheel_vel_limit,
            base_length,
            wheel_radius,
            projection_distance,
            barrier_gain,
            safety_radius,
            walls=(boundary_points,),
        )
    )
