"""The simulated testbed: where the robots are, how they move, and what counts as a violation.

A team of differential-drive robots stands in a rectangle. Once per time step each robot gets a
forward speed v and a turn rate ω. The motors know wheels only, so the command is converted to the
two wheel speeds

    ω_left = (2 v - L ω) / 2R        ω_right = (2 v + L ω) / 2R        (R wheel radius, L axle)

each is cut at the motors' limit, and what is left is converted back. The pose then moves along the
unicycle model, by one explicit Euler step of 33 ms, which is what the published simulators do:

    x ← x + dt v cos θ        y ← y + dt v sin θ        θ ← θ + dt ω

Three things are counted, at the poses from which a step starts: wheels asked to turn faster than
they can, robots outside the rectangle, and pairs too close. Two robots are too close when the
points a little ahead of their centres (where the body's middle is) are nearer than the collision
diameter. :class:`Arena` knows nothing of the API's two generations: `rps_compat.v1` and
`rps_compat.v2` give it their names and units.

Two kinds of guests may be handed in, a `Realism` and a `Recorder`: see `rps_compat.arena_guests`.
"""

from math import hypot
from typing import cast

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import TIE
from barrier_certificates.wall_distance import wall_distances
from rps_compat.arena_guests import HearsSilence, KeepsTime, Realism, Recorder
from rps_compat.errors import CommandError
from rps_compat.testbed import GRITSBOT_X, RobotModel
from rps_compat.violations import Violations

Array = NDArray[np.float64]

_TWO = np.array(2.0)
# A robot that stops at half a turn keeps the sign that it came with, whatever its last bit.
WRAPPED_BEYOND = float(np.pi) + TIE


class Arena:
    """A team of robots in the simulated testbed.

    A step is thirty operations on small arrays, so what counts is what numpy costs for each: hence
    ``argmin`` instead of ``min``, six times faster on nine numbers.

    Parameters
    ----------
    poses : (3, N) array
        Initial poses, m and rad. Copied.
    robot : RobotModel
        Dimensions and limits.
    realism : Realism, optional
        Imperfections of motors and tracking; None is the ideal arena.
    recorder : Recorder, optional
        Is told of every step.
    rng : Generator, optional
        Where `realism` draws from; needed only with one.

    Attributes
    ----------
    poses : (3, N) array
        True poses now, changed in place by :meth:`step`, m and rad.
    commands : (2, N) array
        Velocities commanded, m/s and rad/s; after a step those that the wheels admit, as the
        testbed holds them until the next command.
    commanded : bool
        Whether somebody has commanded since the last step: another array in `commands` is a
        command, and whoever writes into that array sets this.
    velocities : (2, N) array
        Velocities really driven in the last step, m/s and rad/s: the way over the nominal time.
    wheel_velocities : (2, N) array
        How fast the wheels really turned in it, in the same sense, left then right, rad/s.
    steps : int
        Steps done.
    steps_to_start : int
        How many of them drove the robots to initial conditions.
    driving_to_start : bool
        Whether such a drive is under way.
    violations : Violations
        What would be held against the run on the testbed.
    """

    def __init__(
        self,
        poses: Array,
        robot: RobotModel = GRITSBOT_X,
        *,
        realism: Realism | None = None,
        recorder: Recorder | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        self.poses: Array = np.array(poses, dtype=float)
        robots = self.poses.shape[1]
        self.robot = robot
        self.recorder = recorder
        self.commands: Array = np.zeros((2, robots))
        self.commanded = False
        self._held = self.commands
        self.velocities: Array = self.commands
        self.wheel_velocities: Array = self.commands
        self.steps = self.steps_to_start = 0
        self.driving_to_start = False
        self.time = 0.0
        self.violations = Violations()
        self._observed: Array | None = None  # as seen since the last step
        self._pairs = np.triu_indices(robots, 1)
        self._bodies = np.empty(robots, dtype=complex)  # the plane as complex numbers
        self.become(realism, rng)

    @property
    def robot(self) -> RobotModel:
        """Dimensions and limits of the robots; they may be changed between two steps."""
        return self._robot

    @robot.setter
    def robot(self, robot: RobotModel) -> None:
        self._robot = robot
        radius, axle = robot.wheel_radius, robot.base_length
        # As arrays without dimensions: numpy takes longer to convert a number than to multiply.
        self._axle, self._per_radius = np.array(axle), np.array(1 / (2 * radius))
        self._half_radius, self._radius_per_axle = np.array(radius / 2), np.array(radius / axle)
        self._ahead, self._time_step = np.array(robot.collision_offset), np.array(robot.time_step)
        # On the wall is inside, touching is too close.
        x_min, x_max, y_min, y_max = robot.boundaries
        self._walls = x_min - TIE, x_max + TIE, y_min - TIE, y_max + TIE
        self._too_close = robot.collision_diameter + TIE

    def become(self, realism: Realism | None, rng: np.random.Generator | None = None) -> None:
        """Have other imperfections from now on, as if the robots were exchanged where they stand.

        What the old ones had in them, such as commands on their way, is gone.

        Parameters
        ----------
        realism : Realism or None
            The imperfections; None is the ideal arena.
        rng : Generator, optional
            Where they draw from; by default one of its own that nobody has seeded.
        """
        self.realism = realism
        self._listener = cast(HearsSilence, realism) if hasattr(realism, "commanded") else None
        self._timer = cast(KeepsTime, realism) if hasattr(realism, "parts") else None
        self._observed = None
        if realism is not None:
            realism.reset(self.poses, self._robot.time_step, rng or np.random.default_rng())

    @property
    def number_of_robots(self) -> int:
        """How many robots stand in the arena."""
        return int(self.poses.shape[1])

    @property
    def is_commanded(self) -> bool:
        """Whether there was a command since the last step."""
        return self.commanded or self.commands is not self._held

    def observe(self) -> Array:
        """Poses (3, N) as the tracking system reports them; without realism the live true poses."""
        if self.realism is None:
            return self.poses
        if self._observed is None:
            self._observed = self.realism.observe(self.poses)
        return self._observed

    def wheels(self, velocities: Array) -> Array:
        """Return how fast the wheels of robots turn.

        Parameters
        ----------
        velocities : (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.

        Returns
        -------
        (2, N) array
            Wheel speeds, left then right, rad/s.
        """
        forward, axle = _TWO * velocities[0], self._axle * velocities[1]
        out: Array = np.empty((2, velocities.shape[1]))
        np.subtract(forward, axle, out=out[0])
        np.add(forward, axle, out=out[1])
        out *= self._per_radius
        return out

    def unicycle(self, wheels: Array) -> Array:
        """Return the velocities of robots whose wheels turn.

        Parameters
        ----------
        wheels : (2, N) array
            Wheel speeds, left then right, rad/s.

        Returns
        -------
        (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """
        left, right = wheels
        out: Array = np.empty((2, wheels.shape[1]))
        forward, turn = out
        np.add(left, right, out=forward)
        forward *= self._half_radius
        np.subtract(right, left, out=turn)
        turn *= self._radius_per_axle
        return out

    def saturate(self, velocities: Array) -> Array:
        """Return velocities with each wheel cut at its limit, as the motors do.

        Parameters
        ----------
        velocities : (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.

        Returns
        -------
        (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """
        limit = self.robot.max_wheel_velocity
        return self.unicycle(np.clip(self.wheels(velocities), -limit, limit))

    def place(self, poses: Array) -> None:
        """Put the robots somewhere, as if carried there.

        Parameters
        ----------
        poses : (3, N) array
            Where they stand, m and rad.
        """
        self.poses = np.array(poses, dtype=float)
        self._observed = None

    def check(self) -> None:
        """Count what is wrong at the present poses and commands, without moving."""
        speeds = np.abs(self.wheels(self._checked(self.commands)))
        if speeds.max() > self.robot.max_wheel_velocity:
            self.violations.actuator(self.steps, speeds, self.robot.max_wheel_velocity)
        self._check_places(np.cos(self.poses[2]), np.sin(self.poses[2]))

    def forget_violations(self) -> None:
        """Start counting afresh."""
        self.violations = Violations()

    def step(self) -> None:
        """Count violations, cut the commands at the wheels, drive for one time step.

        Raises
        ------
        CommandError
            Commands that are not finite, or not of shape (2, N) (or (2, 1), alike for all). The
            robots have not moved then.
        """
        poses, robot = self.poses, self._robot
        commands = self._checked(self.commands)
        wheels = self.wheels(commands)
        limit = robot.max_wheel_velocity
        speeds = np.abs(wheels)
        if not speeds.item(speeds.argmax()) <= limit:  # a NaN is the largest and takes this path
            require_finite(commands)
            self.violations.actuator(self.steps, speeds, limit)
            np.minimum(wheels, limit, out=wheels)
            np.maximum(wheels, -limit, out=wheels)
        cosine, sine = np.cos(poses[2]), np.sin(poses[2])
        self._check_places(cosine, sine)
        if self.recorder is not None:
            self.recorder.append(self.time, self.observe(), self._for_all(commands))
        admitted = self.unicycle(wheels)
        fresh = self.is_commanded
        self.commands = self._held = admitted
        self.commanded = False
        if self.realism is None:
            self.velocities, self.wheel_velocities = admitted, wheels
            self._drive(admitted, self._time_step, cosine, sine)
        else:
            self.velocities = self._drive_really(self.realism, self._for_all(admitted), fresh)
            self.wheel_velocities = self.wheels(self.velocities)
        self._observed = None
        self.steps += 1
        self.time = self.steps * robot.time_step

    def _checked(self, commands: Array) -> Array:
        robots = self.poses.shape[1]
        if commands.shape in ((2, robots), (2, 1)):
            return commands
        raise CommandError(
            f"velocities have shape {commands.shape}, but {robots} robots need (2, {robots}): "
            "a row of forward speeds in m/s, a row of turn rates in rad/s"
        )

    def _for_all(self, commands: Array) -> Array:
        return np.broadcast_to(commands, (2, self.poses.shape[1]))

    def _check_places(self, cosine: Array, sine: Array) -> None:
        x, y, _ = self.poses
        x_min, x_max, y_min, y_max = self._walls
        if (
            x[x.argmin()] < x_min
            or x[x.argmax()] > x_max
            or y[y.argmin()] < y_min
            or y[y.argmax()] > y_max
        ):
            self.violations.outside(self.steps, -wall_distances(self.poses, self._robot.boundaries))
        i, j = self._pairs
        if not len(i):
            return
        bodies, reach = self._bodies, self._too_close
        bodies.real = x + self._ahead * cosine
        bodies.imag = y + self._ahead * sine
        distances = np.abs(bodies[i] - bodies[j])
        if distances[distances.argmin()] <= reach:
            close = np.flatnonzero(distances <= reach)
            self.violations.close(self.steps, i[close], j[close], distances[close])

    def _drive_really(self, realism: Realism, commands: Array, fresh: bool) -> Array:
        """Drive a step under imperfections; return the velocities (2, N) that it came to."""
        nominal = self._robot.time_step
        way = np.zeros(commands.shape)
        for seconds in (nominal,) if self._timer is None else self._timer.parts():
            if self._listener is not None:
                self._listener.commanded = fresh
            if self._timer is not None:
                self._timer.seconds = seconds
            driven = realism.actuate(commands, self.poses, self.time)
            heading = self.poses[2]
            self._drive(driven, np.array(seconds), np.cos(heading), np.sin(heading))
            way += seconds / nominal * driven
            fresh = False
        return way

    def _drive(self, velocities: Array, seconds: Array, cosine: Array, sine: Array) -> None:
        x, y, theta = self.poses
        distance = seconds * velocities[0]
        x += distance * cosine
        y += distance * sine
        theta += seconds * velocities[1]
        turned = np.abs(theta)
        if turned[turned.argmax()] > WRAPPED_BEYOND:
            np.arctan2(np.sin(theta), np.cos(theta), out=theta)


#: Beyond this a velocity counts as infinite: the wheels' speeds could not be told any more.
_LARGEST = 1e300


def require_finite(velocities: Array) -> None:
    """Refuse velocities that are not finite, naming robot and value.

    Parameters
    ----------
    velocities : (2, N) array
        Forward speeds, m/s, and turn rates, rad/s.

    Raises
    ------
    CommandError
        If one is NaN or infinite, or beyond 1e300.
    """
    # A length is finite only where all its parts are, and cheaper than asking each. NaN fails both
    # comparisons; the length of many that are nearly too large is asked again, part by part.
    if hypot(*velocities.ravel().tolist()) <= _LARGEST:
        return
    drivable = np.abs(velocities) <= _LARGEST
    if drivable.all():
        return
    where = tuple(int(k) for k in np.argwhere(~drivable)[0])
    what = ("forward speed", "turn rate")[where[0] % 2] if len(where) == 2 else "velocity"
    place = ", ".join(map(str, where))
    raise CommandError(
        f"the {what} of robot {where[-1]} is {velocities[where]} (velocities[{place}]): only "
        "finite velocities can be driven; look for a division by zero or a missing value"
    )
