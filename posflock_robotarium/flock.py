r"""The flocking law on wheels: poses in, unicycle commands out, once a step.

The law moves double integrators; a robot is a unicycle that cannot go sideways.  The
bridge is the *projection point* :math:`q_i = p_i + d\,e(\theta_i)`, a point d ahead of the
axle that can be driven in any direction, :math:`\dot q = v\,e + d\,\omega\,e^\perp`.  Once
a step, in this order:

0.  the poses by the commands sent, corrected slowly by those that are tracked
    (`pose_filter`): robots answer late, and the law would amplify the delay; in the ideal
    simulator this changes nothing;
1.  the law at the projection points, with the imprint of the first poses that were read;
2.  *arena steering*, which is ours and not the paper's: see below;
3.  the virtual velocity, :math:`w \leftarrow \mathrm{sat}(w + \Delta t\,u)`;
4.  w scaled into the robot's limits with its direction kept, then the nearest velocity
    that the barrier certificate admits;
5.  :math:`v = \dot q\cdot e,\ \omega = \dot q\cdot e^\perp/d`, and **the velocity that is
    really sent is fed back**, :math:`w \leftarrow \dot q`.

The feedback is what makes it work: a virtual velocity that is integrated open loop winds
up against the limits.  So is the scaling: a certificate alone would cut the sideways part
only, and drive robots off their course.

The paper's flock drifts at about 0.05 m/s and meets a wall of the arena within half a
minute.  There the certificate parks it: headings stay parallel, so γ from headings still
reads 0.997, while nothing moves.  Steering turns the flock's common velocity away from the
wall and leaves all relative motion alone.  ``walls="certificate"`` is the paper's law with
the certificate and nothing else.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.errors import ParameterError
from posflock_robotarium.law import (
    PAPER_EXPERIMENT,
    LawParameters,
    displacements,
    position_based_input,
    saturate,
)
from posflock_robotarium.pose_filter import PoseFilter, PoseFilterParameters

Floats = NDArray[np.float64]

#: What may keep the flock off the walls, and how figures and reports say it.
WALLS = {
    "steer": "arena steering, an addition to the paper's law",
    "certificate": "the paper's law and the certificate alone",
}


#: The robots of the paper's experiment in their arena, and what keeps them apart: 0.17 m between
#: centres, and a projection distance on either side; limits as in its Section "Experiment".
EXPERIMENT_CERTIFICATE = UnicycleCertificate(
    safety_radius=0.27,
    boundary=(-1.6, 1.6, -1.0, 1.0),
    wall_margin=0.11,
    speed_limit=0.15,
    turn_rate_limit=0.55,
)


@dataclass(frozen=True)
class SteeringParameters:
    """How the flock's common velocity is turned away from a wall.

    Attributes
    ----------
    start : float
        Seconds from the imprint before steering may begin: the first transient is the law's.
    reach : float
        Metres from the wall margin at which a robot calls for steering.
    turn_rate : float
        rad/s by which the common velocity turns.
    clear : float
        Cosine between common velocity and the way inward at which turning stops.
    """

    start: float = 3.0
    reach: float = 0.18
    turn_rate: float = 0.45
    clear: float = 0.2

    def __post_init__(self) -> None:
        _all_positive(self, except_for=("clear",))
        if not -1.0 < self.clear < 1.0:
            raise ParameterError(f"clear: expected a cosine between -1 and 1, got {self.clear}")


@dataclass(frozen=True, eq=False)
class FlockStep:
    """What the flock decided at one step.

    Attributes
    ----------
    command : (2, N) array
        v in m/s and ω in rad/s, for ``set_velocities``.
    status : str
        What the certificate said: trivial, optimal, relaxed or failed.
    intervention : float
        How far it changed a robot's velocity at most, m/s.
    clearance : float
        How far the team is from being unsafe, m: the least over pairs of look-ahead points of their
        distance less the safety radius, and over walls of the distance less the margin.
    turning : float
        By how much arena steering turned the common velocity in this step, rad.
    """

    command: Floats
    status: str
    intervention: float
    clearance: float
    turning: float

    def logged(self) -> dict[str, Any]:
        """Return the fields that go into a pose log's row."""
        return {
            "command": self.command,
            "status": self.status,
            "moved": self.intervention,
            "clearance": self.clearance,
        }


class Flock:
    """The controller of a flock of unicycles.

    Parameters
    ----------
    law : LawParameters
        The flocking law's parameters; the paper's experiment by default.
    time_step : float
        Seconds between calls.
    walls : {"steer", "certificate"}
        Whether the flock is steered away from walls, or the paper's law is left alone with
        the certificate.
    certificate : UnicycleCertificate, optional
        The robots and their arena, a rectangle; the flock asks a copy of its own.
    steering, filtering : SteeringParameters, PoseFilterParameters
        How to steer; how far tracked poses are believed.

    Raises
    ------
    ParameterError
        Where a parameter is not admissible.

    Examples
    --------
    >>> import numpy as np
    >>> poses = np.array([[0.0, 0.4], [0.0, 0.0], [0.0, np.pi / 2]])
    >>> flock = Flock()
    >>> flock.step(poses).command.shape
    (2, 2)
    """

    def __init__(
        self,
        law: LawParameters = PAPER_EXPERIMENT,
        time_step: float = 0.033,
        walls: str = "steer",
        certificate: UnicycleCertificate = EXPERIMENT_CERTIFICATE,
        steering: SteeringParameters | None = None,
        filtering: PoseFilterParameters | None = None,
    ) -> None:
        if walls not in WALLS:
            raise ParameterError(f"walls: expected one of {', '.join(WALLS)}; got {walls!r}")
        if not (math.isfinite(time_step) and time_step > 0.0):
            raise ParameterError(f"time_step: expected more than 0 s, got {time_step!r}")
        self.law = law
        self.time_step = time_step
        self.walls = walls
        self.steering = steering or SteeringParameters()
        self.filter = PoseFilter(filtering or PoseFilterParameters(), time_step)
        self.certificate = replace(certificate)  # with a memory of its own
        self._limits = _speed_limits(certificate)
        self._arena, self._margin = _arena(certificate)
        self.reset()

    def reset(self) -> None:
        """Forget the imprint and every velocity: the next step is the first."""
        self._steps = 0
        self._imprint: Floats | None = None
        self._velocity: Floats | None = None
        self._angle = 0.0
        self._turn = 0.0
        self.filter.reset()
        self.certificate.reset()

    def parameters(self) -> dict[str, Any]:
        """Return everything a log must say to repeat the run, ready for JSON."""
        return {
            "law": self.law.as_dict(),
            "time_step": self.time_step,
            "walls": self.walls,
            "wheels": asdict(self.certificate),
            "steering": asdict(self.steering) if self.walls == "steer" else None,
            "filtering": asdict(self.filter.parameters),
            "neighbour_radius": self.law.as_dict()["radius"],
            "arena": list(self._arena),
        }

    def steps_in(self, duration: float) -> int:
        """Return how many time steps `duration` seconds are, rounded.

        Raises
        ------
        ParameterError
            Where that is not one step at least.
        """
        if not (math.isfinite(duration) and duration >= self.time_step / 2.0):
            raise ParameterError(
                f"duration: expected at least one step of {self.time_step:g} s, got {duration!r} s"
            )
        return round(duration / self.time_step)

    def step(self, poses: ArrayLike) -> FlockStep:
        """Decide the next command from the poses just read.

        Parameters
        ----------
        poses : (3, N) array
            x, y in metres and θ in radians; N from 2, the same at every step.

        Raises
        ------
        ParameterError
            Where the poses have another shape or a value that is not finite.
        """
        x = self.filter.update(self._checked(poses))
        ahead = np.array([np.cos(x[2]), np.sin(x[2])])
        beside = np.array([-ahead[1], ahead[0]])
        d = self.certificate.projection_distance
        points = x[:2] + d * ahead
        if self._imprint is None or self._velocity is None:
            self._imprint = displacements(points)
            self._velocity = np.zeros_like(points)
        self._steps += 1
        time = self._steps * self.time_step

        u = saturate(
            position_based_input(points, self._imprint, time, self.law), self.law.input_limit
        )
        w = self._velocity
        turning = 0.0
        if self.walls == "steer" and time > self.steering.start:
            turning = self._turning(points, w)
            self._angle += turning
            u = u + _turned(u.mean(axis=1), self._angle)
            w = w + _turned(w.mean(axis=1), turning)
        w = saturate(w + self.time_step * u, self.law.speed_limit)

        forward, sideways = (w * ahead).sum(axis=0), (w * beside).sum(axis=0)
        fastest, widest = self._limits
        excess = np.maximum(np.abs(forward) / fastest, np.abs(sideways) / widest)
        applied, info = self.certificate.project(w / np.maximum(1.0, excess), x)
        self._velocity = applied
        command = np.array([(applied * ahead).sum(axis=0), (applied * beside).sum(axis=0) / d])
        self.filter.moved(command)
        return FlockStep(
            command=command,
            status=info.status,
            intervention=info.intervention,
            clearance=info.clearance,
            turning=turning,
        )

    def _turning(self, points: Floats, velocity: Floats) -> float:
        """Return by how much to turn the common velocity now, rad, away from near walls."""
        left, right, bottom, top = self._arena
        x, y = points
        gaps = np.array([x.min() - left, right - x.max(), y.min() - bottom, top - y.max()])
        call = np.maximum(0.0, self.steering.reach - (gaps - self._margin))
        inward = (call[0] - call[1], call[2] - call[3])
        common = velocity.mean(axis=1)
        along = common[0] * inward[0] + common[1] * inward[1]
        lengths = math.hypot(*common) * math.hypot(*inward)
        if not call.any() or (lengths > 0.0 and along >= self.steering.clear * lengths):
            self._turn = 0.0
        elif self._turn == 0.0:
            # Latched until the flock is clear: a corner must not make it dither.
            across = common[0] * inward[1] - common[1] * inward[0]
            self._turn = 1.0 if across >= 0.0 else -1.0
        return self._turn * self.steering.turn_rate * self.time_step

    def _checked(self, poses: ArrayLike) -> Floats:
        try:
            x = np.asarray(poses, dtype=float)
        except (TypeError, ValueError) as error:
            raise ParameterError(f"poses: expected a (3, N) array, got {poses!r}") from error
        if x.ndim != 2 or x.shape[0] != 3 or x.shape[1] < 2:
            raise ParameterError(
                "poses: expected shape (3, N), x, y and θ of at least two robots (one robot"
                f" is no flock); got {x.shape}"
            )
        if self._velocity is not None and x.shape[1] != self._velocity.shape[1]:
            raise ParameterError(
                f"poses: expected {self._velocity.shape[1]} robots as at the first step,"
                f" got {x.shape[1]}; call reset() to begin another run"
            )
        if not np.isfinite(x).all():
            row, robot = np.argwhere(~np.isfinite(x))[0]
            raise ParameterError(
                f"poses: expected finite numbers, got {'xyθ'[row]} = {x[row, robot]}"
                f" of robot {robot}"
            )
        return x


def _turned(common: Floats, angle: float) -> Floats:
    """Return (R(angle) − I)·common as a column that adds to every robot's vector."""
    cosine, sine = math.cos(angle) - 1.0, math.sin(angle)
    return np.array(
        [
            [cosine * common[0] - sine * common[1]],
            [sine * common[0] + cosine * common[1]],
        ]
    )


def _speed_limits(certificate: UnicycleCertificate) -> tuple[float, float]:
    """Return how fast a projection point moves ahead and sideways at most, m/s."""
    if certificate.speed_limit is None or certificate.turn_rate_limit is None:
        raise ParameterError(
            "certificate: expected a speed_limit and a turn_rate_limit, which virtual velocities"
            f" are scaled to; got {certificate.speed_limit} and {certificate.turn_rate_limit}"
        )
    return (
        certificate.speed_limit,
        certificate.projection_distance * certificate.turn_rate_limit,
    )


def _arena(certificate: UnicycleCertificate) -> tuple[tuple[float, float, float, float], float]:
    """Return the arena and how far inside it projection points stay, m."""
    boundary, margin = certificate.boundary, certificate.wall_margin
    if boundary is None or len(boundary) != 4 or margin is None:
        raise ParameterError(
            "certificate: expected a boundary (least x, greatest x, least y, greatest y) and a"
            f" wall_margin, which the flock is steered by; got {boundary} and {margin}"
        )
    return boundary, margin


def _all_positive(parameters: Any, except_for: tuple[str, ...]) -> None:
    for field in fields(parameters):
        value = getattr(parameters, field.name)
        if field.name not in except_for and not (math.isfinite(value) and value > 0.0):
            raise ParameterError(f"{field.name}: expected finite and more than zero, got {value!r}")
