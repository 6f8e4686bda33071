r"""What a certificate guarantees, and what of that is left when time comes in steps.

In continuous time, ``ḣ ≥ −γ h³`` with ``h(0) ≥ 0`` keeps ``h ≥ 0`` for ever: near zero the right
side vanishes faster than h. It starts from ``h(0) ≥ 0``: a certificate's first answer says whether
that holds (``info.unsafe_start``).

A controller acts in steps of dt. Two robots D apart with velocities that differ by Δv are
``D + dt Δv`` apart after a step, so their h becomes

    h + 2 dt D·Δv + dt² ‖Δv‖²  ≥  h − dt γ h³  =  h (1 − γ dt h²),

and there are two cases:

- ``h ≤ 1/√(γ dt)``: the bracket is not negative, and h stays at least zero because of the row;
- ``h > 1/√(γ dt)``: the row alone would let the pair through. But these robots are far apart, and
  none is faster than s: a step cannot bring them to r if they are at least ``r + 2 s dt`` apart.

The two cases meet if every h below which one step at top speed reaches zero is of the first kind,
``(r + 2 s dt)² − r² ≤ 1/√(γ dt)``. That is the largest gain, far above any in use at the testbed's
0.033 s: with r = 0.20 m, γ = 2000 and s = 0.153 m/s, ``1/√(γ dt)`` is 0.123 m², or 0.40 m of
distance, of which a step can take 10 mm. A wall is the same with ``g − dt 0.4 γ g³``. Of two
unequal robots r is what these two keep, and 2 s the sum of their speeds.

A link, which keeps two robots within a range, needs no such condition: its rows know the time step,
and give at most half of what is left away (`barrier_certificates.rows.links`).

The guarantee is for velocities that are *executed as certified*. Clipping them afterwards, a delay,
wheels that slip and poses measured with an error all void it; so does the arc that a projection
point moves on while its robot turns (`turning_error`), unless the certificate knows the time step.
What a certificate can guarantee of robots like that stands in `barrier_certificates.late`.
"""

from __future__ import annotations

import math
from itertools import combinations

from barrier_certificates import checks
from barrier_certificates.per_robot import (
    PerRobot,
    check_each,
    largest,
    number_of,
    settled,
    team_size,
)

__all__ = ["largest_gain", "largest_wall_gain", "turning_error"]


def largest_gain(safety_radius: PerRobot, top_speed: PerRobot, time_step: float) -> float:
    """Return the largest γ that keeps pairs safe in steps.

    Parameters
    ----------
    safety_radius : float or (N,) array-like
        Smallest distance between two positions, m; of unequal robots, half of the one's and half of
        the other's.
    top_speed : float or (N,) array-like
        No robot is faster, m/s: none of the team, or each.
    time_step : float
        Time for which a velocity is held, s.

    Raises
    ------
    ParameterError
        If a number is not positive, or numbers are for teams of different sizes.

    Examples
    --------
    >>> round(largest_gain(0.15, 0.2, 0.033))
    1772943
    >>> round(largest_gain((0.3, 0.1, 0.1), (0.1, 0.2, 0.2), 0.033))   # one is large and slow
    1840178
    """
    radius, speed = settled("safety_radius", safety_radius), settled("top_speed", top_speed)
    check_each(checks.positive, "safety_radius", radius, "of metres")
    check_each(checks.positive, "top_speed", speed, "of m/s")
    checks.positive("time_step", time_step, "of seconds")
    number = team_size({"safety_radius": radius, "top_speed": speed})
    found: list[float] = []
    for one, other in combinations(range(number or 2), 2) if number != 1 else [(0, 0)]:
        kept = 0.5 * (number_of(radius, one) + number_of(radius, other))
        closing = number_of(speed, one) + number_of(speed, other)
        reachable = (kept + closing * time_step) ** 2 - kept**2
        found.append(1.0 / (time_step * reachable**2))
    return min(found)


def largest_wall_gain(top_speed: PerRobot, time_step: float) -> float:
    """Return the largest γ that keeps robots inside straight walls in steps; see `largest_gain`.

    Parameters
    ----------
    top_speed : float or (N,) array-like
        Largest speed of a robot, m/s: of all, or of each.
    time_step : float
        Time from one command to the next, s.

    Returns
    -------
    float
        The gain γ, 1/(m² s).

    Raises
    ------
    ParameterError
        If either is not positive.
    """
    speed = settled("top_speed", top_speed)
    check_each(checks.positive, "top_speed", speed, "of m/s")
    checks.positive("time_step", time_step, "of seconds")
    return 1.0 / (0.4 * time_step * (largest(speed) * time_step) ** 2)


def turning_error(projection_distance: float, turn_rate: float, time_step: float) -> float:
    """Return how far a projection point strays from its straight step while its robot turns, m.

    A step turns the heading by ω dt, so the point ends on an arc: ``d (1 − cos ω dt)`` behind.

    Parameters
    ----------
    projection_distance : float
        Distance d of the projection point ahead of the axle, m.
    turn_rate : float
        Rate of turning ω, rad/s.
    time_step : float
        Time from one command to the next, dt, s.

    Raises
    ------
    ParameterError
        If a value is out of its range.

    Examples
    --------
    >>> f"{1e6 * turning_error(0.05, 0.55, 0.033):.1f} micrometres"
    '8.2 micrometres'
    """
    checks.positive("projection_distance", projection_distance, "of metres")
    checks.not_negative("turn_rate", turn_rate, "of rad/s")
    checks.positive("time_step", time_step, "of seconds")
    return projection_distance * (1.0 - math.cos(turn_rate * time_step))
