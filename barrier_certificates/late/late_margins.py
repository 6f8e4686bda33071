"""From ranges to distances: how far off predictions may be, and what robots may lose by it.

Every number is a worst case over the ranges of `late_robots` at the limits of speed and turn rate;
the formulas are those of ``docs/explanations/late-robots.md``, in which they have the same names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.differential_drive import DifferentialDrive
from barrier_certificates.late.late_robots import LateRobots, half, middle

__all__ = ["CommandLimits", "LateMargins", "limits_of", "limits_of_each", "margins_of", "worst_of"]

_WIDEST = math.radians(75.0)


@dataclass(frozen=True)
class CommandLimits:
    """What commands keep to, and where the certified point lies.

    Parameters
    ----------
    speed, turn_rate : float
        Largest |v|, m/s, and |ω|, rad/s, commanded.
    projection_distance : float
        d, how far ahead of the axle the projection point lies, m.
    time_step : float
        Time from one command to the next, s.
    """

    speed: float
    turn_rate: float
    projection_distance: float
    time_step: float


def limits_of(drive: DifferentialDrive, robot: int | None = None) -> CommandLimits:
    """Return what the commands of a robot keep to, its wheels' limit included.

    Parameters
    ----------
    drive : DifferentialDrive
        The robots; a certificate for unicycles is one.
    robot : int, optional
        Which robot; None is for any of a team of equal robots.

    Raises
    ------
    ParameterError
        If speed or turn rate has no limit, or robots have limits of their own and none is named.
    """
    one = drive.of_robot(robot)
    speed, rate = one.speed_limit, one.turn_rate_limit
    if one.wheel_limit is not None:
        rim = one.wheel_limit * one.wheel_radius
        turn = 2.0 * rim / one.base_length
        speed = rim if speed is None else min(speed, rim)
        rate = turn if rate is None else min(rate, turn)
    if speed is None or rate is None:
        raise ParameterError(
            "late robots need limits: expected speed_limit and turn_rate_limit, or wheel_limit"
        )
    return CommandLimits(speed, rate, one.projection_distance, one.time_step)


def limits_of_each(drive: DifferentialDrive) -> tuple[CommandLimits, ...]:
    """Return what the commands of each robot keep to; of equal robots once.

    Parameters
    ----------
    drive : DifferentialDrive
        The robots; a certificate for unicycles is one.
    """
    if drive.drives is None:
        return (limits_of(drive),)
    return tuple(limits_of(drive, robot) for robot in range(drive.drives))


@dataclass(frozen=True)
class LateMargins:
    """What ignorance of late robots costs, robot by robot.

    Attributes
    ----------
    tracking, heading, gains, timing, arcs, clock : float
        How far a predicted stop point may be off: because the tracker errs in position and in
        heading, robots are faster or slower, answer sooner or later than the middle of the ranges,
        turn in steps, and because steps last longer than the certificate is told, m.
    held : float
        What a stop point may move beside what its row allows while a command is held, m.
    spread, turning, noise : float
        How far the robot's point may be from the mean of its past stop points: because it answers
        sooner or later, turns meanwhile, and drives noisily, m.
    rest_heading : float
        How far the heading at rest may be off, rad.
    skew : float
        By how much a stop point may move in another direction than its command says, rad.
    weakest, strongest : float
        Least and greatest part of a command that moves the stop point.
    drift : float
        How fast noise moves a stop point while the robot drives, m/s.
    top_speed : float
        No stop point is faster, m/s.
    hold : float
        For how long a command may act, s.
    delay, lag : float
        Dead time and lag of predictions added up; the longest lag, s.
    """

    tracking: float
    heading: float
    gains: float
    timing: float
    arcs: float
    clock: float
    held: float
    spread: float
    turning: float
    noise: float
    rest_heading: float
    skew: float
    weakest: float
    strongest: float
    drift: float
    top_speed: float
    hold: float
    delay: float
    lag: float

    @property
    def stop_error(self) -> float:
        """How far a predicted stop point may be off in all, η, m."""
        return self.tracking + self.heading + self.gains + self.timing + self.arcs + self.clock

    def pair(self, distance: float) -> float:
        """Return by how much stop points are kept further apart than two robots' points, m.

        Parameters
        ----------
        distance : float
            What is to be kept between the robots' points, m.
        """
        each = self.stop_error + self.held + self.spread + self.turning + 2.0 * self.noise
        return 2.0 * each + self._sagitta(2.0 * self.top_speed, distance)

    def wall(self) -> float:
        """Return by how much stop points are kept further from straight walls, m."""
        # A mean of points on one side of a line is on that side: no sagitta, and no spread.
        return self.stop_error + self.held + self.turning + 2.0 * self.noise

    def obstacle(self, distance: float, speed: float = 0.0) -> float:
        """Return by how much stop points are kept further from an obstacle, m.

        Parameters
        ----------
        distance : float
            What is to be kept from its middle line, its radius included, m.
        speed : float
            How fast it moves, m/s.
        """
        # A standing one is the same at all times, so that only a moving one needs the spread.
        late = self.spread / self.top_speed * speed
        sagitta = self._sagitta(self.top_speed + speed, distance)
        return self.wall() + late + sagitta

    def _sagitta(self, speed: float, distance: float) -> float:
        """Return how far inside a circle means of points outside of it lie, at a relative speed."""
        return (speed * self.lag) ** 2 / (2.0 * distance) if self.lag else 0.0


_ENTRIES = fields(LateMargins)


def margins_of(robots: LateRobots, limits: CommandLimits) -> LateMargins:
    """Return what late robots cost.

    Parameters
    ----------
    robots : LateRobots
        What is known of them.
    limits : CommandLimits
        What their commands keep to.

    Raises
    ------
    ParameterError
        If robots know so little of where a command leads that no row can hold.
    """
    d, dt, lag = limits.projection_distance, limits.time_step, robots.lag[1]
    speed, rate = limits.speed * robots.speed_gain[1], limits.turn_rate * robots.turn_gain[1]
    hold = max(robots.longest_step, dt)
    flight = robots.dead_time[1] + lag
    timing = half(robots.dead_time) + half(robots.lag)
    # Who is told of long steps still does not know within which part of one a robot braked.
    unseen = min(hold - dt, dt if robots.told else flight)
    reach = d + speed * flight  # what an error of heading moves

    turn_error = half(robots.turn_gain) * limits.turn_rate * flight
    rest_heading = robots.heading_error + turn_error + (timing + unseen) * rate
    bias = robots.turn_bias + robots.turn_noise
    drift = robots.speed_noise + d * bias
    sideways = 0.5 * speed * lag  # what a turn moves besides d, by the speed that is left
    top_speed = math.hypot(speed, (d + sideways) * rate) + drift

    gain = 0.5 * (robots.speed_gain[1] + robots.speed_gain[0])
    uneven = abs(middle(robots.turn_gain) - gain) + half(robots.turn_gain)
    astray = (
        half(robots.speed_gain) * limits.speed
        + uneven * d * limits.turn_rate
        + speed * rate * lag  # ½ by the arc on which speeds decay, ½ by what turning adds
        + (rest_heading + 0.5 * rate * hold) * top_speed
        + drift
    )
    walk = math.sqrt(dt * (flight + dt))
    turned = robots.turn_bias * (flight + dt) + robots.turn_noise * walk
    skew, weakest, strongest = _skew(robots, sideways / d)
    skew += rest_heading + (0.5 + sideways / d) * rate * lag + rate * hold
    if not (weakest > 0.0 and skew < _WIDEST):
        raise ParameterError(
            f"with a lag of {lag:g} s and {speed:.3g} m/s a turn may move the stop point of a robot"
            f" anywhere (skew {math.degrees(skew):.0f}°); expected lower limits of speed or turn"
            " rate, a larger projection_distance, or narrower ranges"
        )
    return LateMargins(
        tracking=robots.position_error,
        heading=robots.heading_error * reach,
        gains=half(robots.speed_gain) * limits.speed * flight
        + turn_error * (d + 0.5 * speed * flight),
        timing=timing * (speed + rate * reach),
        arcs=0.5 * speed * rate * dt * flight,
        clock=unseen * (speed + rate * reach),
        held=hold * astray,
        spread=timing * top_speed,
        turning=0.5 * (speed + d * rate) * rate * lag**2,
        noise=robots.speed_noise * walk + turned * reach,
        rest_heading=rest_heading,
        skew=skew,
        weakest=weakest,
        strongest=strongest,
        drift=drift,
        top_speed=top_speed,
        hold=hold,
        delay=robots.delay,
        lag=lag,
    )


def worst_of(margins: Sequence[LateMargins]) -> LateMargins:
    """Return what the worst of some robots costs, number by number.

    Parameters
    ----------
    margins : sequence of LateMargins
        Those of each robot.
    """
    found = {entry.name: max(getattr(one, entry.name) for one in margins) for entry in _ENTRIES}
    return LateMargins(**found | {"weakest": min(one.weakest for one in margins)})


def _skew(robots: LateRobots, sideways: float) -> tuple[float, float, float]:
    """Return by how much unequal gains turn a velocity, and the least and greatest gain."""
    weakest = min(robots.speed_gain[0], robots.turn_gain[0] * (1.0 - sideways))
    strongest = max(robots.speed_gain[1], robots.turn_gain[1] * (1.0 + sideways))
    if weakest <= 0.0:
        return math.inf, weakest, strongest
    return math.asin((strongest - weakest) / (strongest + weakest)), weakest, strongest
