"""A certificate for robots that answer late, and what it guarantees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from barrier_certificates import checks
from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate import RowAllowance
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.guarantee import largest_gain, largest_wall_gain
from barrier_certificates.late.cautious_rows import CautiousRows
from barrier_certificates.late.late_margins import (
    LateMargins,
    limits_of_each,
    margins_of,
    worst_of,
)
from barrier_certificates.late.late_robots import LateRobots
from barrier_certificates.late.stop_prediction import StopPrediction
from barrier_certificates.late.waiting import WaitingProjector
from barrier_certificates.per_robot import PerRobot, largest, smallest, widened
from barrier_certificates.projection import Policy, ProjectionInfo, Projector
from barrier_certificates.rows import Obstacle, Rows, Scene
from barrier_certificates.rows.obstacles import moved
from barrier_certificates.unicycle import UnicycleCertificate

__all__ = ["LateCertificate", "LateGuarantee"]


@dataclass(frozen=True)
class LateGuarantee:
    """What a certificate keeps between late robots, and what it cannot promise.

    Parameters
    ----------
    pairs : float or (N,) array-like or None
        Projection points of two robots are kept at least this far apart, m; of unequal robots half
        of the one's and half of the other's; None without pairs.
    walls : float or (N,) array-like or None
        And this far inside the walls, m; None without walls.
    obstacles : float or (N,) array-like or None
        And this far from obstacles, m; None without obstacles.
    stops_apart : float or (N,) array-like
        How far the certificate keeps their stop points apart for that, m, likewise.
    cannot : tuple of str
        Why nothing is promised; empty where something is.
    """

    pairs: PerRobot | None
    walls: PerRobot | None
    obstacles: PerRobot | None
    stops_apart: PerRobot
    cannot: tuple[str, ...] = ()

    def __str__(self) -> str:
        if self.cannot:
            return "nothing is promised: " + "; ".join(self.cannot)
        kept = [
            f"{what} at least {_millimetres(distance)} {where}"
            for what, distance, where in (
                ("projection points", self.pairs, "apart"),
                ("them", self.walls, "inside the walls"),
                ("them", self.obstacles, "from obstacles"),
            )
            if distance is not None
        ]
        return "kept: " + ", ".join(kept) if kept else "nothing is kept from anything"


def _millimetres(distance: PerRobot) -> str:
    """Return a distance in words; of unequal robots that of each, in their order."""
    numbers = distance if isinstance(distance, tuple) else (distance,)
    return "/".join(f"{1e3 * number:.0f}" for number in numbers) + " mm"


@dataclass(frozen=True)
class LateCertificate(UnicycleCertificate):
    """The safe commands nearest to the desired ones, for unicycles that answer late.

    Call it once a step with desired commands and the poses tracked; it remembers what it returned
    as sent. Whoever sends something else tells it by `sent`; whoever wants velocities of projection
    points certified uses `stops`, then `project` and `commands` with these, then `sent`.

    Radius and margins are what is kept between the true projection points. Between stop points it
    keeps more, by `margins_of` for the robots given, of unequal ones for the worst; `info` tells of
    stop points. Where no velocity
    satisfies all rows, robots that are too close stop, and where that is not enough everybody,
    which keeps stop points where they are.

    Parameters
    ----------
    on_infeasible : {"relax", "stop", "raise"}
        The guarantee is for ``"stop"``.
    robots : LateRobots
        How late and how exactly they answer.
    obstacle_speed : float
        No obstacle is faster, m/s.

    Raises
    ------
    ParameterError
        If the time step or a limit of speed or turning is missing, a gain is too large for the
        longest step, or robots know too little of where a command leads.

    Examples
    --------
    >>> import numpy as np
    >>> robots = LateRobots(dead_time=(0.19, 0.2), lag=(0.17, 0.18))
    >>> certificate = LateCertificate(
    ...     0.2, 2000.0, speed_limit=0.15, turn_rate_limit=0.55, time_step=0.033, robots=robots
    ... )
    >>> print(certificate.guarantee())
    kept: projection points at least 200 mm apart
    >>> poses = np.array([[-0.2, 0.2], [0.0, 0.0], [0.0, np.pi]])   # face to face
    >>> commands, info = certificate([[0.15, 0.15], [0.0, 0.0]], poses)
    >>> print(info.status)
    optimal
    """

    answers_late: ClassVar[bool] = True

    _: KW_ONLY
    on_infeasible: Policy = "stop"
    robots: LateRobots = field(default_factory=LateRobots)
    obstacle_speed: float = 0.0

    @classmethod
    def of(
        cls,
        certificate: UnicycleCertificate,
        robots: LateRobots,
        *,
        barrier_gain: PerRobot | None = None,
        wall_gain: PerRobot | None = None,
        obstacle_speed: float = 0.0,
    ) -> LateCertificate:
        """Return a certificate for late robots that keeps what another keeps for ideal ones.

        Parameters
        ----------
        certificate : UnicycleCertificate
            What is kept apart, and the limits.
        robots : LateRobots
            How late and how exactly they answer.
        barrier_gain, wall_gain : float or (N,) array-like, optional
            Gains, where they are not those of the other.
        obstacle_speed : float
            No obstacle is faster, m/s.
        """
        given = {
            entry.name: getattr(certificate, entry.name)
            for entry in fields(UnicycleCertificate)
            if entry.name != "on_infeasible"
        }
        given["barrier_gain"] = certificate.barrier_gain if barrier_gain is None else barrier_gain
        given["wall_gain"] = certificate.wall_gain if wall_gain is None else wall_gain
        return cls(**given, robots=robots, obstacle_speed=obstacle_speed)

    def check(self) -> None:
        """Refuse parameters that make no sense."""
        super().check()
        checks.not_negative("obstacle_speed", self.obstacle_speed, "of m/s")
        if self.decentralised:
            raise ParameterError(
                "decentralised is True; a certificate for late robots is computed for the team,"
                " which stops whoever is too close together"
            )
        if self.connectivity is not None:
            raise ParameterError(
                f"connectivity is {self.connectivity!r}; expected None: a certificate for late"
                " robots keeps no links, since robots may be farther apart than their stop points"
            )
        checks.positive("time_step", self.time_step, "of seconds")
        margins = self.late_margins
        step, speed = margins.hold, margins.top_speed
        faster = max(self.robots.gain, 1.0)
        radius = self._stops_apart
        wall_gain = self.barrier_gain if self.wall_gain is None else self.wall_gain
        for name, gain, most in (
            ("barrier_gain", self.barrier_gain, largest_gain(radius, speed, step)),
            ("wall_gain", wall_gain, largest_wall_gain(speed, step)),
        ):
            firmest = largest(gain)
            if firmest * faster > most:
                raise ParameterError(
                    f"{name} is {firmest:g}; robots that drive on for {step:g} s at {speed:.3g} m/s"
                    f" admit {most / faster:.3g} at most"
                )

    @cached_property
    def late_margins(self) -> LateMargins:
        """What it costs that robots are late."""
        return worst_of([margins_of(self.robots, limits) for limits in limits_of_each(self)])

    def guarantee(self) -> LateGuarantee:
        """Return what is kept between the true projection points, if it holds at the start."""
        cannot = list(self.robots.unbounded)
        if self.on_infeasible != "stop":
            cannot.append(f"on_infeasible is {self.on_infeasible!r}, expected 'stop'")

        def kept(margin: PerRobot | None) -> PerRobot:
            numbers = self._half_radius(margin)
            return tuple(numbers.tolist()) if isinstance(numbers, np.ndarray) else numbers

        return LateGuarantee(
            self.safety_radius if self.pair_rows else None,
            None if self.boundary is None else kept(self.wall_margin),
            kept(self.obstacle_margin) if self.obstacles else None,
            self._stops_apart,
            tuple(cannot),
        )

    def _allowance(self) -> RowAllowance:
        margins, near = self.late_margins, np.min(self._half_radius(self.obstacle_margin))
        return RowAllowance(
            # The smaller a distance, the more is lost on a curve around it.
            margins.pair(smallest(self.safety_radius)),
            margins.wall(),
            margins.obstacle(max(float(near), 1e-3), self.obstacle_speed),
            unsafe_gain=0.0,  # what is unsafe is the business of cautious rows
        )

    @cached_property
    def _stops_apart(self) -> PerRobot:
        """How far stop points are kept apart, m."""
        return widened(self.safety_radius, self._allowance().pairs)

    @cached_property
    def _prediction(self) -> StopPrediction:
        return StopPrediction(self.robots, self.time_step)

    @cached_property
    def _cautious(self) -> CautiousRows:
        return CautiousRows(self.late_margins, self._stops_apart)

    def reset(self) -> None:
        """Forget the steps so far: the robots have stood still."""
        super().reset()
        self._prediction.reset()

    def stops(self, poses: Any, elapsed: float | None = None) -> FloatArray:
        """Return where robots would come to rest if they were told to stop now.

        Parameters
        ----------
        poses : (3, N) array
            Poses as tracked, m and rad.
        elapsed : float, optional
            Time since the last command was sent, s; the time step if None.

        Returns
        -------
        (3, N) array
            Poses at rest, m and rad.

        Raises
        ------
        ShapeError
            If the shape does not fit.
        """
        if elapsed is not None:
            checks.positive("elapsed", elapsed, "of seconds")
            self._prediction.elapsed(elapsed)
        return self._prediction.stops(checks.columns("poses", poses, 3, self.team_size))

    def sent(self, commands: Any) -> None:
        """Take note of the commands that robots are sent.

        Parameters
        ----------
        commands : (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.

        Raises
        ------
        ShapeError, NotFiniteError
            If the shape does not fit, or anything is NaN or infinite.
        """
        commands = checks.columns("commands", commands, 2, self.team_size)
        checks.require_finite("commands", commands)
        self._prediction.sent(commands)

    def __call__(
        self,
        desired: Any,
        poses: Any,
        obstacles: Sequence[Obstacle] | None = None,
        elapsed: float | None = None,
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe unicycle commands nearest to the desired ones; they count as sent.

        Parameters
        ----------
        desired : (2, N) array
            Unicycle commands: v in m/s and ω in rad/s.
        poses : (3, N) array
            Poses as tracked, m and rad.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, instead of those of the certificate.
        elapsed : float, optional
            Time since the last command was sent, s; the time step if None.
        """
        commands, info = super().__call__(desired, self.stops(poses, elapsed), obstacles)
        self._prediction.sent(commands)
        return commands, info

    def _certify(
        self, desired: FloatArray, scene: Scene, obstacles: Sequence[Obstacle] | None
    ) -> tuple[FloatArray, ProjectionInfo]:
        # What a command does it does after the delay, when obstacles have moved on.
        now = self.obstacles if obstacles is None else obstacles
        later = moved(now, self.late_margins.delay)
        return super()._certify(desired, scene, later)

    def _projector(self) -> Projector:
        return WaitingProjector(super()._projector(), self._cautious)

    def _all_rows(self, rows: Rows, scene: Scene) -> Rows:
        memory = self._memory
        return self._cautious.added(rows, scene, self.pair_rows, memory.walls, memory.obstacles)
