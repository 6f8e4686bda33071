"""What the motors of one differential-drive robot give its projection point.

In the body frame the projection point (or look-ahead point) at distance d ahead of the axle moves
with (v, d·ω), so the limits |v| ≤ v_max, |ω| ≤ ω_max and |v ± ω L/2| ≤ R·wheel_max are sides of a
polygon of its velocities. Given the time step, they are limits on the mean velocity over the step
(see `barrier_certificates.unicycle`), which needs v = v̄ + ε and ω up to κ times faster; both grow
with the turn, so chords from no turn to the fastest bound them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from barrier_certificates.rows import VelocityPolygon


class RobotDrive(NamedTuple):
    """The numbers of one robot, named as those of a `DifferentialDrive`.

    Attributes
    ----------
    projection_distance : float
        d, how far ahead of the axle the projection point lies, m.
    speed_limit, turn_rate_limit, wheel_limit : float or None
        Largest |v| in m/s, |ω| in rad/s and wheel speed in rad/s; None means no such limit.
    wheel_radius, base_length : float
        Radius R of the wheels and distance L between them, m.
    wheel_disturbance : float
        δ, the largest unwanted speed of a wheel, rad/s.
    time_step : float
        How long a command is held, s.
    """

    projection_distance: float
    speed_limit: float | None
    turn_rate_limit: float | None
    wheel_limit: float | None
    wheel_radius: float
    base_length: float
    wheel_disturbance: float
    time_step: float

    def sides(self) -> VelocityPolygon | None:
        """Return the velocities that the motors allow, a side for each limit; None without any."""
        widest, catch_up, faster = self._sideways()
        sides: list[tuple[float, float, float, str]] = []  # normal, bound, name
        if self.speed_limit is not None:
            limit = self.speed_limit
            sides += [(1.0, side * catch_up, limit, "speed limit") for side in (1.0, -1.0)]
            sides += [(-1.0, 0.0, limit, "speed limit")]
        if math.isfinite(widest):
            sides += [(0.0, side, widest, "turn rate limit") for side in (1.0, -1.0)]
        if self.wheel_limit is not None:
            limit = self.wheel_limit * self.wheel_radius
            turn = faster * self.base_length / (2.0 * self.projection_distance)
            sides += [
                (1.0, turn + catch_up, limit, "right wheel limit"),
                (-1.0, -turn, limit, "right wheel limit"),
                (1.0, -turn - catch_up, limit, "left wheel limit"),
                (-1.0, turn, limit, "left wheel limit"),
            ]
        if not sides:
            return None
        along, across, bounds, names = zip(*sides, strict=True)
        return VelocityPolygon(np.array([along, across]), np.array(bounds), names)

    def _sideways(self) -> tuple[float, float, float]:
        """Return how fast the point can move sideways (m/s), and what a turn costs, ε and κ."""
        d = self.projection_distance
        rates = [] if self.turn_rate_limit is None else [self.turn_rate_limit]
        if self.wheel_limit is not None:
            rates.append(2.0 * self.wheel_limit * self.wheel_radius / self.base_length)
        if rates and self.time_step > 0.0:
            angle = min(min(rates) * self.time_step, 0.5 * math.pi)
            widest = d * math.sin(angle) / self.time_step
            catch_up = d * (1.0 - math.cos(angle)) / (self.time_step * widest)
            return widest, catch_up, angle / math.sin(angle)
        widest = math.inf if self.turn_rate_limit is None else self.turn_rate_limit * d
        return widest, 0.0, 1.0

    def half_axes(self) -> tuple[float, float]:
        """Return how fast the wheels may move the point on their own, along and across, m/s."""
        along = abs(self.wheel_disturbance * self.wheel_radius)
        return along, abs(along * 2.0 * self.projection_distance / self.base_length)
