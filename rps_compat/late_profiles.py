"""What a realism profile says of how late robots answer, as ranges for a late certificate.

A profile draws numbers; a certificate needs their bounds. A uniform distribution has them, a normal
one with a cut too; noise without bounds is taken at `SIGMAS` standard deviations, beyond which it
is once in 16,000 draws. A command within the dead band is predicted to move a robot and does not:
that is noise as large as the band, and where the robot comes to rest is off by it for as long as
commands are in flight. Factors that depend on speed widen the ranges by what they are up to the
limits. What has no bound at all (a command may be lost, a robot out of sight) is told in words, and
a certificate then promises nothing.
"""

from __future__ import annotations

import math

import numpy as np

from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_margins import limits_of_each
from barrier_certificates.late.late_robots import LateRobots, Range
from barrier_certificates.unicycle import UnicycleCertificate
from rps_compat.distributions import Curve, DistributionKind, RobotDistribution
from rps_compat.realism import Profile
from rps_compat.testbed import TIME_STEP

__all__ = ["SIGMAS", "late_certificate", "late_robots"]

#: Noise is taken to be no larger than so many standard deviations.
SIGMAS = 4.0


def late_robots(
    profile: Profile,
    *,
    speed_limit: float,
    turn_rate_limit: float,
    time_step: float = TIME_STEP,
    told: bool = True,
) -> LateRobots:
    """Return the ranges of a profile.

    Parameters
    ----------
    profile : Profile
        Motors and tracking of the robots.
    speed_limit, turn_rate_limit : float
        Largest |v|, m/s, and |ω|, rad/s, that will be commanded.
    time_step : float
        Nominal duration of a step, s.
    told : bool
        Whether the certificate will be told how long steps really took.

    Examples
    --------
    >>> from rps_compat.profiles import load_profile
    >>> robots = late_robots(load_profile("gritsbot_x"), speed_limit=0.15, turn_rate_limit=0.55)
    >>> robots.lag
    (0.17, 0.18)
    """
    speeds, rates = (0.0, speed_limit), (0.0, turn_rate_limit)
    dead, lag, gains = profile.dead_time, profile.lag, profile.gains
    jitter, noise, band = profile.tracking_jitter, profile.disturbance, profile.dead_band
    offset = _range(profile.heading_offset.radians) if profile.heading_offset else (0.0, 0.0)
    bias = _range(profile.turn_bias.rate) if profile.turn_bias else (0.0, 0.0)
    speed_gain = turn_gain = (1.0, 1.0)
    if gains is not None:
        speed_gain = _times(_range(gains.speed), _over(gains.by_speed, speeds))
        turn_gain = _times(_range(gains.turn), _over(gains.by_turn, rates))
    position = heading = 0.0
    if jitter is not None:
        fastest = (0.0, speed_limit * speed_gain[1])
        along = jitter.along * _over(jitter.by_speed, fastest)[1]
        position, heading = SIGMAS * math.hypot(along, jitter.lateral), SIGMAS * jitter.heading
    dead_time = _times(_range(dead.seconds), _over(dead.by_speed, speeds)) if dead else (0.0, 0.0)
    lags = _times(_range(lag.seconds), _over(lag.by_speed, speeds)) if lag else (0.0, 0.0)
    speed_noise = SIGMAS * noise.speed if noise else 0.0
    turn_noise = SIGMAS * noise.turn if noise else 0.0
    if band is not None:  # what is too small to move anything is predicted, and does not come
        flight = dead_time[1] + lags[1]
        position, heading = position + band.speed * flight, heading + band.turn * flight
        speed_noise, turn_noise = speed_noise + band.speed, turn_noise + band.turn
    return LateRobots(
        dead_time=dead_time,
        lag=lags,
        speed_gain=speed_gain,
        turn_gain=turn_gain,
        speed_noise=speed_noise,
        turn_noise=turn_noise,
        turn_bias=max(abs(bias[0]), abs(bias[1])),
        position_error=position,
        heading_error=max(abs(offset[0]), abs(offset[1])) + heading,
        longest_step=_longest(profile, time_step),
        told=told,
        unbounded=_unbounded(profile),
    )


def late_certificate(
    certificate: UnicycleCertificate,
    profile: Profile,
    *,
    told: bool = True,
    barrier_gain: float | None = None,
    wall_gain: float | None = None,
    obstacle_speed: float = 0.0,
) -> LateCertificate:
    """Return a certificate that keeps between a profile's robots what another keeps between ideal.

    Parameters
    ----------
    certificate : UnicycleCertificate
        What is kept apart, and the limits of commands; with a time step.
    profile : Profile
        Motors and tracking of the robots.
    told : bool
        Whether it will be told how long steps really took.
    barrier_gain, wall_gain : float, optional
        Gains, where they are not those of the other.
    obstacle_speed : float
        No obstacle is faster, m/s.

    Examples
    --------
    >>> from rps_compat.profiles import load_profile
    >>> ideal = UnicycleCertificate(
    ...     0.185, 2000.0, speed_limit=0.15, turn_rate_limit=0.55, time_step=0.033
    ... )
    >>> print(late_certificate(ideal, load_profile("gritsbot_x")).guarantee())
    kept: projection points at least 185 mm apart
    """
    limits = limits_of_each(certificate)
    robots = late_robots(
        profile,
        speed_limit=max(each.speed for each in limits),
        turn_rate_limit=max(each.turn_rate for each in limits),
        time_step=certificate.time_step or TIME_STEP,
        told=told,
    )
    return LateCertificate.of(
        certificate,
        robots,
        barrier_gain=barrier_gain,
        wall_gain=wall_gain,
        obstacle_speed=obstacle_speed,
    )


def _longest(profile: Profile, time_step: float) -> float:
    """Return for how long robots may drive on by one command, s."""
    if profile.clock is None:
        return 0.0
    longest = float(max(seconds for _, seconds in profile.clock.quantiles.points))
    if profile.watchdog is None:
        return longest
    return min(longest, profile.watchdog.seconds + time_step)


def _unbounded(profile: Profile) -> tuple[str, ...]:
    """Return what a profile has that no bound can be told of."""
    reasons = []
    if profile.command_loss is not None and profile.command_loss.probability:
        reasons.append(
            "commands may be lost (command_loss), so that a robot drives on by an old one"
        )
    if profile.tracking_dropout is not None and profile.tracking_dropout.probability:
        reasons.append("robots may be out of the tracker's sight (tracking_dropout)")
    if profile.wheel_slew is not None:
        reasons.append("wheels change speed no faster than a limit (wheel_slew), which is no lag")
    return tuple(reasons)


def _range(distribution: RobotDistribution) -> Range:
    """Return the least and the greatest value of a robot."""
    values = distribution.values
    if distribution.kind is DistributionKind.NORMAL:
        beyond = min(SIGMAS * values[1], distribution.limit)
        return values[0] - beyond, values[0] + beyond
    return min(values), max(values)


def _over(curve: Curve, limits: Range) -> Range:
    """Return the least and the greatest factor between two speeds."""
    at = [limits[0], limits[1], *(x for x, _ in curve.points if limits[0] < x < limits[1])]
    factors = np.broadcast_to(curve(np.array(at)), len(at))
    return float(factors.min()), float(factors.max())


def _times(one: Range, other: Range) -> Range:
    return one[0] * other[0], one[1] * other[1]
