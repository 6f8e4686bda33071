"""What differential-drive robots can do, and what their wheels may do on their own.

The limits of the motors are sides of a polygon of the projection point's velocities in the body
frame, as `barrier_certificates.robot_drive` tells. Robots may be alike, or each has numbers of its
own, and so a polygon of its own.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from barrier_certificates import checks
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.per_robot import (
    PerRobot,
    check_each,
    check_limit,
    number_of,
    settle,
    team_size,
)
from barrier_certificates.robot_drive import RobotDrive
from barrier_certificates.rows import LimitRows, UnequalLimitRows, VelocityPolygon, WheelDisturbance

__all__ = ["DifferentialDrive"]

_OF_ROBOTS = tuple(name for name in RobotDrive._fields if name != "time_step")


@dataclass(frozen=True)
class DifferentialDrive:
    """Robots on two wheels, and the projection points that are certified for them.

    All numbers but the time step are one for all robots of a team, or a sequence of one for each.

    Parameters
    ----------
    projection_distance : float or (N,) array-like
        d, how far ahead of the axle the projection point lies, m.
    speed_limit, turn_rate_limit, wheel_limit : float or (N,) array-like or None
        Largest |v| in m/s, |ω| in rad/s and wheel speed in rad/s; None means no such limit.
    wheel_radius, base_length : float or (N,) array-like
        Radius R of the wheels and distance L between them, m.
    wheel_disturbance : float or (N,) array-like
        δ, the largest unwanted speed of a wheel, rad/s, that the rows have to survive.
    time_step : float
        How long a command is held, s; zero leaves the arc of turning robots out of account.

    Raises
    ------
    ParameterError
        Where a value makes no sense, numbers are for teams of different sizes, or a time step comes
        without a limit on turning.
    """

    may_differ: ClassVar[tuple[str, ...]] = _OF_ROBOTS
    """Which parameters may be sequences of one number for each robot."""

    _: KW_ONLY
    projection_distance: PerRobot = 0.05
    speed_limit: PerRobot | None = 0.2
    turn_rate_limit: PerRobot | None = None
    wheel_limit: PerRobot | None = 12.5
    wheel_radius: PerRobot = 0.016
    base_length: PerRobot = 0.105
    wheel_disturbance: PerRobot = 0.0
    time_step: float = 0.0

    def __post_init__(self) -> None:
        settle(self, self.may_differ)
        self.check()

    def check(self) -> None:
        """Refuse values that make no sense.

        Raises
        ------
        ParameterError
            If a value is out of its range, numbers are for teams of different sizes, or a time step
            is given without a limit on turning.
        """
        check_each(checks.positive, "projection_distance", self.projection_distance, "of metres")
        check_limit("speed_limit", self.speed_limit, "of m/s")
        check_limit("turn_rate_limit", self.turn_rate_limit, "of rad/s")
        check_limit("wheel_limit", self.wheel_limit, "of rad/s")
        check_each(checks.positive, "wheel_radius", self.wheel_radius, "of metres")
        check_each(checks.positive, "base_length", self.base_length, "of metres")
        check_each(checks.not_negative, "wheel_disturbance", self.wheel_disturbance, "of rad/s")
        checks.not_negative("time_step", self.time_step, "of seconds")
        team_size({name: getattr(self, name) for name in _OF_ROBOTS})
        if self.time_step and self.turn_rate_limit is None and self.wheel_limit is None:
            raise ParameterError(
                "a time step is of no use without a limit on turning; expected turn_rate_limit or "
                "wheel_limit"
            )

    def of_robot(self, robot: int | None = None) -> RobotDrive:
        """Return the numbers of one robot.

        Parameters
        ----------
        robot : int, optional
            Which one; None is for any of a team of equal robots.

        Raises
        ------
        ParameterError
            If robots have numbers of their own and none is named.
        """
        if robot is None and self.drives is not None:
            names = [name for name in _OF_ROBOTS if isinstance(getattr(self, name), tuple)]
            raise ParameterError(
                f"{', '.join(names)}: each of {self.drives} robots has its own; expected one"
                " for all here, or which robot is meant"
            )
        which = 0 if robot is None else robot
        own = (number_of(getattr(self, name), which) for name in RobotDrive._fields)
        return RobotDrive._make(own)

    def polygon(self, robot: int | None = None) -> VelocityPolygon | None:
        """Return the velocities of the projection point that the motors can give it.

        Parameters
        ----------
        robot : int, optional
            Whose; None is for any of a team of equal robots.

        Returns
        -------
        VelocityPolygon or None
            In the body frame (x ahead, y to the left), implied sides left out; None without any
            limit.
        """
        sides = self.of_robot(robot).sides()
        return None if sides is None else sides.without_idle_sides()

    def limit_rows(self) -> LimitRows | None:
        """Return the rows of what the motors of each robot can do; None without any limit."""
        number = self.drives
        if number is None:
            limits = self.polygon()
            return None if limits is None else limits.rows(turning=True)
        every = [self.of_robot(robot).sides() for robot in range(number)]
        polygons = [sides for sides in every if sides is not None]
        return UnequalLimitRows(polygons, turning=True) if polygons else None

    def disturbance(self) -> WheelDisturbance | None:
        """Return what the wheels may do to the projection points on their own, if anything."""
        number = self.drives
        if number is None:
            axes = self.of_robot().half_axes()
            return WheelDisturbance(*axes) if self.wheel_disturbance else None
        every = [self.of_robot(robot).half_axes() for robot in range(number)]
        along, across = zip(*every, strict=True)
        return WheelDisturbance(along, across) if any(along) else None

    @property
    def drives(self) -> int | None:
        """For how many robots there are numbers of their own; None where all drive alike."""
        return team_size({name: getattr(self, name) for name in _OF_ROBOTS})
