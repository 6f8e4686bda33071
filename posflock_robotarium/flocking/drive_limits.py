"""What the motors of a flock can do, and velocities shortened to it.

A velocity beyond the limits is scaled, so that its direction stays: a certificate that were left
to cut it would cut the sideways part only, and drive robots off their course.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.guarantee import largest_gain, largest_wall_gain
from barrier_certificates.per_robot import largest
from barrier_certificates.rows import VelocityPolygon
from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]


def limits_of(certificate: UnicycleCertificate) -> VelocityPolygon:
    """Return what the motors can do, in the body frame; refuse gains beyond the time step.

    Parameters
    ----------
    certificate : UnicycleCertificate
        One that has limits and knows its time step.

    Raises
    ------
    ParameterError
        Where robots that obey it step by step might pass through what keeps them apart, or are not
        alike: the law, the steering and the memory of the flock are for equal robots.
    """
    if certificate.team_size is not None:
        raise ParameterError(
            f"certificate: it has numbers for each of {certificate.team_size} robots, and a flock"
            " is of equal ones; expected one number of each kind for all robots"
        )
    limits, step = certificate.polygon(), certificate.time_step
    assert limits is not None  # a certificate that knows its time step has limits
    speed = limits.top_speed()
    wall_gain = certificate.barrier_gain if certificate.wall_gain is None else certificate.wall_gain
    for name, gain, most in (
        (
            "barrier_gain",
            largest(certificate.barrier_gain),
            largest_gain(certificate.safety_radius, speed, step),
        ),
        ("wall_gain", largest(wall_gain), largest_wall_gain(speed, step)),
    ):
        if gain > most:
            raise ParameterError(
                f"certificate: {name} is {gain:g}; steps of {step:g} s at {speed:.3g} m/s admit"
                f" {most:.3g} at most, or robots may pass through what keeps them apart"
            )
    return limits


def within_limits(velocity: Floats, ahead: Floats, limits: VelocityPolygon) -> Floats:
    """Return velocities shortened to what the motors can do, their directions kept.

    Parameters
    ----------
    velocity : (..., 2, N) array
        Of the look-ahead points, m/s.
    ahead : (..., 2, N) array
        Unit vectors along the headings.
    limits : VelocityPolygon
        What the motors can do.

    Returns
    -------
    (..., 2, N) array
        Velocities, m/s.
    """
    beside = np.stack([-ahead[..., 1, :], ahead[..., 0, :]], axis=-2)
    along, across = (velocity * ahead).sum(axis=-2), (velocity * beside).sum(axis=-2)
    body = np.stack([along, across], axis=-2)
    share = (limits.normals.T @ body / limits.bounds[:, None]).max(axis=-2)
    shortened: Floats = velocity / np.maximum(1.0, share)[..., None, :]
    return shortened
