"""What a differential-drive robot can do, and what its wheels may do on their own.

In the body frame the projection point (or look-ahead point) at distance d ahead of the axle moves
with (v, d·ω), so the limits |v| ≤ v_max, |ω| ≤ ω_max and |v ± ω L/2| ≤ R·wheel_max are sides of a
polygon of its velocities. Given the time step, they are limits on the mean velocity over the step
(see `barrier_certificates.unicycle`), which needs v = v̄ + ε and ω up to κ times faster; both grow
with the turn, so chords from no turn to the fastest bound them.
"""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass

import numpy as np

from barrier_certificates import checks
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.rows import VelocityPolygon, WheelDisturbance

__all__ = ["DifferentialDrive"]


@dataclass(frozen=True)
class DifferentialDrive:
    """A robot on two wheels, and the projection point that is certified for it.

    Parameters
    ----------
    projection_distance : float
        d, how far ahead of the axle the projection point lies, m.
    speed_limit, turn_rate_limit, wheel_limit : float or None
        Largest |v| in m/s, |ω| in rad/s and wheel speed in rad/s; None means no such limit.
    wheel_radius, base_length : float
        Radius R of the wheels and distance L between them, m.
    wheel_disturbance : float
        δ, the largest unwanted speed of a wheel, rad/s, that the rows have to survive.
    time_step : float
        How long a command is held, s; zero leaves the arc of turning robots out of account.

    Raises
    ------
    ParameterError
        Where a value makes no sense, or a time step comes without a limit on turning.
    """

    _: KW_ONLY
    projection_distance: float = 0.05
    speed_limit: float | None = 0.2
    turn_rate_limit: float | None = None
    wheel_limit: float | None = 12.5
    wheel_radius: float = 0.016
    base_length: float = 0.105
    wheel_disturbance: float = 0.0
    time_step: float = 0.0

    def __post_init__(self) -> None:
        self.check()

    def check(self) -> None:
        """Refuse values that make no sense.

        Raises
        ------
        ParameterError
            If a value is out of its range, or a time step is given without a limit on turning.
        """
        checks.positive("projection_distance", self.projection_distance, "of metres")
        checks.positive_or_none("speed_limit", self.speed_limit, "of m/s, or None")
        checks.positive_or_none("turn_rate_limit", self.turn_rate_limit, "of rad/s, or None")
        checks.positive_or_none("wheel_limit", self.wheel_limit, "of rad/s, or None")
        checks.positive("wheel_radius", self.wheel_radius, "of metres")
        checks.positive("base_length", self.base_length, "of metres")
        checks.not_negative("wheel_disturbance", self.wheel_disturbance, "of rad/s")
        checks.not_negative("time_step", self.time_step, "of seconds")
        if self.time_step and self.turn_rate_limit is None and self.wheel_limit is None:
            raise ParameterError(
                "a time step is of no use without a limit on turning; expected turn_rate_limit or "
                "wheel_limit"
            )

    def polygon(self) -> VelocityPolygon | None:
        """Return the velocities of the projection point that the motors can give it.

        Returns
        -------
        VelocityPolygon or None
            In the body frame (x ahead, y to the left), implied sides left out; None without any
            limit.
        """
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
        polygon = VelocityPolygon(np.array([along, across]), np.array(bounds), names)
        return polygon.without_idle_sides()

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

    def disturbance(self) -> WheelDisturbance | None:
        """Return what the wheels may do to the projection point on their own, if anything."""
        if self.wheel_disturbance == 0.0:
            return None
        along = abs(self.wheel_disturbance * self.wheel_radius)
        across = abs(along * 2.0 * self.projection_distance / self.base_length)
        return WheelDisturbance(along, across)
