r"""The flocking law on wheels: poses in, unicycle commands out, once a step.

The law moves double integrators; a robot is a unicycle that cannot go sideways.  The
bridge is the *look-ahead point* :math:`q_i = p_i + d\,e(\theta_i)` (the Robotarium's
projection point), a point d ahead of the axle that can be driven in any direction,
:math:`\dot q = v\,e + d\,\omega\,e^\perp`.  Once a step, in this order:

0.  the poses by the commands sent, corrected slowly by those that are tracked
    (`pose_filter`): robots answer late, and the law would amplify the delay; in the ideal
    simulator this changes nothing;
1.  the law at the look-ahead points, with the imprint of the first poses that were read,
    and with neighbours found by `neighbour_memory`;
2.  *arena steering* (`steering`), which is ours and not the paper's;
3.  the virtual velocity, :math:`w \leftarrow \mathrm{sat}(w + \Delta t\,u)`;
4.  w scaled into the robot's limits with its direction kept, then the nearest velocity
    that the barrier certificate admits;
5.  the command that gives the look-ahead point that velocity, and **the velocity that is
    really sent is fed back**, :math:`w \leftarrow \dot q`.

The feedback is what makes it work: a virtual velocity that is integrated open loop winds
up against the limits.  So is the scaling: a certificate alone would cut the sideways part
only, and drive robots off their course.

With ``walls="certificate"`` nothing is steered, and with ``neighbour_hysteresis=0`` besides it is
the paper's law with the certificate and nothing else.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates import ties
from barrier_certificates.per_robot import largest
from barrier_certificates.projection import Status
from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.flocking import attendance
from posflock_robotarium.flocking.checked_poses import checked_poses
from posflock_robotarium.flocking.drive_limits import limits_of, within_limits
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import (
    PAPER_EXPERIMENT,
    LawParameters,
    displacements,
    saturate,
)
from posflock_robotarium.flocking.local_certificate import local_certificate
from posflock_robotarium.flocking.local_steering import LocalSteering, as_local
from posflock_robotarium.flocking.neighbour_memory import NeighbourMemory
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.flocking.pose_filter import PoseFilter, PoseFilterParameters
from posflock_robotarium.flocking.steering import ArenaSteering, SteeringParameters

Floats = NDArray[np.float64]

#: What may keep the flock off the walls, and how figures and reports say it.
WALLS = {
    "steer": "arena steering, an addition to the paper's law",
    "certificate": "the law and the certificate, no steering",
}


def told_walls(parameters: Mapping[str, Any]) -> str:
    """Return in words what kept a flock off the walls; empty where its log does not say.

    Parameters
    ----------
    parameters : mapping
        What the log says of the run, as `Flock.parameters`.
    """
    words = WALLS.get(str(parameters.get("walls", "")), "")
    by_itself = "; each robot by what it senses and hears"
    return words + by_itself if words and parameters.get("local") is True else words


#: The robots of the paper's experiment in their arena, and what keeps them apart; limits as in its
#: Section "Experiment".  0.20 m between look-ahead points, 5 cm ahead of the axle, leaves 0.15 m
#: between the points 2.5 cm ahead that the testbed's collision test looks at (0.135 m).  The law's
#: own formations are wider, so that the certificate has nothing to do once they stand.
EXPERIMENT_CERTIFICATE = UnicycleCertificate(
    safety_radius=0.20,
    barrier_gain=2000.0,
    wall_gain=100.0,
    boundary=(-1.6, 1.6, -1.0, 1.0),
    wall_margin=0.11,
    speed_limit=0.15,
    turn_rate_limit=0.55,
)


@dataclass(frozen=True, eq=False)
class FlockStep:
    """What the flock decided at one step.

    Attributes
    ----------
    command : (2, N) array
        v in m/s and ω in rad/s, for ``set_velocities``.
    status : Status
        What the certificate said.
    intervention : float
        How far it changed a robot's velocity at most, m/s.
    clearance : float
        How far the team is from being unsafe, m: the least over pairs of look-ahead points of their
        distance less the safety radius, and over walls of the distance less the margin.
    active : tuple of str
        What bound: ``"robots 3 and 7"``, ``"robot 0 and wall +x"``, …
    turning : float
        By how much arena steering turned the common velocity in this step, rad.
    """

    command: Floats
    status: Status
    intervention: float
    clearance: float
    active: tuple[str, ...]
    turning: float

    def logged(self) -> dict[str, Any]:
        """Return the fields that go into a pose log's row."""
        return {
            "command": self.command,
            "status": self.status,
            "intervention": self.intervention,
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
        Whether the flock is steered away from walls, or the law is left alone with the
        certificate.
    certificate : UnicycleCertificate, optional
        The robots and their arena, a rectangle.  The flock asks a copy of its own, which knows the
        time step.  One with ``pair_rows=False`` makes a control run: what the law does on its own.
    steering, filtering : SteeringParameters, PoseFilterParameters
        How to steer; how far tracked poses are believed.
    neighbour_hysteresis : float
        See `neighbour_memory.NeighbourMemory`, metres; 0 is the paper's rule.
    model : Model
        Which of the paper's models; the velocity-based one is told the velocities that were sent.
    local : bool
        Whether each robot decides by what it senses within the law's radius and by one message from
        each neighbour: `local_steering`, and a certificate of its own (`local_certificate`).

    Raises
    ------
    ParameterError
        Where a parameter is not admissible, a gain of the certificate is too large for the time
        step to keep robots apart, or robots would have to see farther for it than they do.

    Warns
    -----
    UserWarning
        At the first step, where robots start closer than the certificate keeps them.

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
        neighbour_hysteresis: float = 0.15,
        model: Model = Model.POSITION,
        local: bool = False,
    ) -> None:
        if walls not in WALLS:
            raise ParameterError(f"walls: expected one of {', '.join(WALLS)}; got {walls!r}")
        if not (math.isfinite(time_step) and time_step > 0.0):
            raise ParameterError(f"time_step: expected more than 0 s, got {time_step!r}")
        self.law, self.model = law, model
        self.retuned: list[dict[str, Any]] = []
        self.time_step = time_step
        self.walls = walls
        self.local = local
        self.filter = PoseFilter(filtering or PoseFilterParameters(), time_step)
        if certificate.speed_limit is None and certificate.wheel_limit is None:
            raise ParameterError("certificate: expected a speed_limit or a wheel_limit; got none")
        self.certificate = replace(certificate, time_step=time_step)  # with a memory of its own
        if local:
            self.certificate = local_certificate(self.certificate, law.radius)
        self._limits = limits_of(self.certificate)
        self._all_rows = replace(self.certificate, pair_rows=True, connectivity=None)
        self._neighbours = NeighbourMemory(law.radius, neighbour_hysteresis)
        self.steering = steering or SteeringParameters()
        self._steering: ArenaSteering | LocalSteering
        if local:
            self.steering = hearing = as_local(self.steering)
            self._steering = LocalSteering(hearing, *_arena(certificate), time_step)
        else:
            self._steering = ArenaSteering(self.steering, *_arena(certificate), time_step)
        self.reset()
        attendance.show(self)

    def reset(self) -> None:
        """Forget the imprint and every velocity: the next step is the first."""
        self._steps = 0
        self._imprint: Floats | None = None
        self._velocity: Floats | None = None
        self._neighbours.reset()
        self._steering.reset()
        self.filter.reset()
        self.certificate.reset()

    @property
    def links(self) -> NDArray[np.bool_] | None:
        """Who was whose neighbour at the last step, (N, N); None before the first."""
        return self._neighbours.links

    def retune(self, law: LawParameters, model: Model) -> None:
        """Follow another law from the next step on; imprint, clock and velocities stay.

        `retuned` keeps what was followed from when on, for the log.

        Parameters
        ----------
        law : LawParameters
            δ, r, k and the limits.
        model : Model
            Which of the paper's models.

        Raises
        ------
        ParameterError
            Where the radius is not more than the hysteresis, or too small for a local certificate;
            the flock goes on as before.
        """
        if self.local:
            local_certificate(self.certificate, law.radius)
        self._neighbours = self._neighbours.within(law.radius)
        self.law, self.model = law, model
        time = self._steps * self.time_step
        self.retuned.append({"time": time, "law": law.as_dict(), "model": model.value})

    @property
    def hysteresis(self) -> float:
        """How far within the radius a robot has to come to count again as a neighbour, m."""
        return self._neighbours.hysteresis

    @property
    def arena(self) -> tuple[float, float, float, float]:
        """Where it keeps the robots: least and greatest x, least and greatest y, m."""
        return self._steering.arena

    def parameters(self, law: LawParameters | None = None) -> dict[str, Any]:
        """Return everything a log must say to repeat the run, ready for JSON.

        Parameters
        ----------
        law : LawParameters, optional
            What was followed in the place of the flock's own, by a team of a batch.
        """
        followed = (law or self.law).as_dict()
        return {
            "law": followed,
            "model": self.model.value,
            "time_step": self.time_step,
            "walls": self.walls,
            "local": self.local,
            "wheels": asdict(self.certificate),
            "steering": asdict(self.steering) if self.walls == "steer" else None,
            "filtering": asdict(self.filter.parameters),
            "neighbour_radius": followed["radius"],
            "neighbour_hysteresis": self.hysteresis,
            "arena": list(self.arena),
        }

    def steps_in(self, duration: float) -> int:
        """Return how many time steps a duration is, rounded.

        Parameters
        ----------
        duration : float
            The duration, s.

        Raises
        ------
        ParameterError
            Where that is not one step at least.
        """
        if not (math.isfinite(duration) and duration >= self.time_step / 2.0):
            raise ParameterError(
                f"duration: expected at least one step of {self.time_step:g} s, got {duration!r} s"
            )
        return ties.nearest_whole(duration / self.time_step)

    def step(self, poses: ArrayLike) -> FlockStep:
        """Decide the next command from the poses just read.

        Parameters
        ----------
        poses : (3, N) array
            x, y in metres and θ in radians; N from 2, the same at every step.

        Raises
        ------
        ParameterError
            Where the poses have another shape or a value that is not finite, or the law is for
            another number of robots.
        """
        attendance.show(self)
        seen = checked_poses(poses, None if self._velocity is None else self._velocity.shape[1])
        x = self.filter.update(seen)
        ahead = np.array([np.cos(x[2]), np.sin(x[2])])
        points = x[:2] + self.certificate.projection_distance * ahead
        if self._imprint is None or self._velocity is None:
            self.law.agents_must_be(points.shape[-1])
            self._imprint = displacements(points)
            self._velocity = np.zeros_like(points)
        self._steps += 1
        time = self._steps * self.time_step

        linked = self._neighbours.update(points)
        w, turning = self._velocity, 0.0
        law = self.model.input(points, w, self._imprint, time, self.law, linked)
        u = saturate(law, self.law.input_limit)
        if self.walls == "steer":
            if isinstance(self._steering, LocalSteering):
                u, w, turned = self._steering.steer(time, points, u, w, linked)
                turning = float(turned.mean())
            else:
                u, w, turning = self._steering.steer(time, points, u, w)
        w = saturate(w + self.time_step * u, self.law.speed_limit)

        certified = x
        if self.certificate.answers_late:  # by what is seen, not by what is filtered
            certified = self.certificate.stops(seen)
            ahead = np.array([np.cos(certified[2]), np.sin(certified[2])])
        possible = within_limits(w, ahead, self._limits)
        applied, info = self.certificate.project(possible, certified)
        if info.unsafe_start:
            warnings.warn(
                f"{info.nearest} start {1e3 * -info.clearance:.3g} mm closer than the certificate"
                " keeps them: it guarantees nothing until they are apart",
                stacklevel=2,
            )
        self._velocity = applied
        command = self.certificate.commands(applied, certified)
        self.certificate.sent(command)
        self.filter.moved(command)
        return FlockStep(
            command=command,
            status=info.status,
            intervention=info.intervention,
            clearance=info.clearance if self.certificate.pair_rows else self._clearance(certified),
            active=info.active,
            turning=turning,
        )

    def _clearance(self, poses: Floats) -> float:
        """Return the clearance of a team that nobody keeps apart."""
        left, right, _, _ = self._steering.arena
        # Nobody is farther than half the arena's width from every wall: something is within it.
        return self._all_rows.margins(poses, within=right - left)[0].clearance


def _arena(certificate: UnicycleCertificate) -> tuple[tuple[float, float, float, float], float]:
    """Return the arena and how far inside it look-ahead points stay, m."""
    boundary, margin = certificate.boundary, certificate.wall_margin
    if boundary is None or len(boundary) != 4 or margin is None:
        raise ParameterError(
            "certificate: expected a boundary (least x, greatest x, least y, greatest y) and a"
            f" wall_margin, which the flock is steered by; got {boundary} and {margin}"
        )
    return boundary, largest(margin)
