"""How a real testbed differs from the ideal simulator, as effects that compose.

Between a command and the motion lie a radio, a motor controller, two wheels and a floor; between
a pose and its measurement lie a camera and a tracker. Each imperfection here is one small frozen
dataclass. :class:`Profile` is a set of them, at most one of a kind, and its :meth:`Profile.start`
makes the object that an :class:`~rps_compat.arena.Arena` takes as ``realism``. The commands of a
step pass the motor effects in this order,

    command loss → watchdog → dead time → motor dead band → gains → lag → wheel slew
    → turn bias → disturbance,

and poses pass heading offset → tracking jitter → tracking dropout.

Every effect draws from a stream of its own, named after it, so that switching one on or off
leaves the random numbers of the others as they were: what changes between two runs is the effect.

``gritsbot_x`` holds numbers fitted to published open-loop runs of GRITSBot X robots. They were
few robots: it is a plausible testbed, not a certified one.

========================  ====================================================================
effect                    fitted on GRITSBot X open-loop runs
========================  ====================================================================
dead time, from rest      0.19 to 0.20 s; 0.24 s at 0.05 m/s
first-order lag           0.12 s at 0.2 m/s, 0.17 to 0.18 s at 0.10 to 0.15 m/s
speed gain                0.98 to 1.03 robot to robot from 0.1 m/s; 0.92 to 0.96 at 0.05 m/s
turn gain                 0.91, 0.99, 0.97 at 0.1, 0.2, 0.3 rad/s
turn bias                 σ 0.010 rad/s, largest 0.017, drawn anew every run
heading offset            −32 to +21 mrad, of the robot
tracking jitter           lateral 0.2 to 0.4 mm; along 0.40, 0.47, 0.82 mm at 0.05, 0.1,
                          0.2 m/s; heading 0.8 to 1.8 mrad
velocity residual         1 to 2.4 mm/s and 11 to 24 mrad/s
========================  ====================================================================

The dead time was measured from rest; here it holds always, which is the cautious reading. The
watchdog (0.5 s) is the testbed's published figure, the dead band that of the GTernal firmware.
Command loss, dropout and wheel slew have no published figures: they are off in ``gritsbot_x`` and
guesses in ``harsh``.

Examples
--------
>>> from rps_compat.profiles import load_profile
>>> profile = load_profile("gritsbot_x")
>>> profile.only("dead_time", "lag").effects
('dead_time', 'lag')
>>> profile.without("watchdog").watchdog is None
True
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rps_compat.arena import GRITSBOT_X
from rps_compat.draws import FLAT, ONE, Curve, Draw, ProfileError, require

Array = NDArray[np.float64]
#: Takes commands (2, N) and each robot's seconds since its last command (N,), which it may
#: change in place; gives the commands (2, N) handed on.
MotorStage = Callable[[Array, Array], Array]
#: Takes poses (3, N) and true forward speeds (N,); gives the poses (3, N) handed on.
TrackingStage = Callable[[Array, Array], Array]

#: The GTernal firmware switches its motors off below both.
OFF_SPEED, OFF_TURN = 1e-4, 0.01


class MotorEffect(Protocol):
    """An imperfection between command and motion."""

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw this run's numbers and return what one step does."""


class TrackingEffect(Protocol):
    """An imperfection between pose and measurement."""

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Draw this run's numbers and return what one measurement does."""


# --- Between command and motion ----------------------------------------------------------------


@dataclass(frozen=True)
class CommandLoss:
    """A command misses its robot, which goes on with the last that arrived.

    Attributes
    ----------
    probability : float
        Of each command to each robot, from 0 to 1.
    """

    probability: float

    def __post_init__(self) -> None:
        require(0 <= self.probability <= 1, "command_loss.probability", self.probability, "0 to 1")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Start with robots that stand still and have heard nothing."""
        held, silence = np.zeros((2, robots)), np.zeros(robots)

        def lose(velocities: Array, age: Array) -> Array:
            arrived = (age == 0) & (rng.random(robots) >= self.probability)
            held[:, arrived] = velocities[:, arrived]
            silence[:] = np.where(arrived, 0.0, silence + time_step)
            age[:] = silence
            out: Array = held.copy()
            return out

        return lose


@dataclass(frozen=True)
class Watchdog:
    """A robot brakes that has heard no command for a while.

    Attributes
    ----------
    seconds : float
        Of silence; the testbed brakes after 0.5.
    """

    seconds: float = 0.5

    def __post_init__(self) -> None:
        require(self.seconds > 0, "watchdog.seconds", self.seconds, "more than 0 s")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Start with no silence."""

        def brake(velocities: Array, age: Array) -> Array:
            silent = age >= self.seconds
            return _stopped(velocities, silent)

        return brake


@dataclass(frozen=True)
class DeadTime:
    """A command takes effect only some time after it was given.

    The delay is any number of seconds: in the step in which a command takes over, old and new
    share the step in proportion.

    Attributes
    ----------
    seconds : Draw
        Per robot.
    by_speed : Curve
        Factor on it, at the commanded forward speed in m/s.
    """

    seconds: Draw
    by_speed: Curve = FLAT

    def __post_init__(self) -> None:
        self.seconds.require_at_least(0.0, "dead_time.seconds")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's dead time; the past is standing still."""
        steps = self.seconds.draw(robots, rng) / time_step
        length = int(np.ceil(steps.max(initial=0.0) * self.by_speed.largest)) + 2
        past = np.zeros((length, 2, robots))
        now, each = -1, np.arange(robots)

        def delay(velocities: Array, age: Array) -> Array:
            nonlocal now
            now = (now + 1) % length
            past[now] = velocities
            late = steps * self.by_speed(np.abs(velocities[0]))
            whole = late.astype(int)
            share = late - whole
            newer = past[(now - whole) % length, :, each].T
            older = past[(now - whole - 1) % length, :, each].T
            out: Array = share * older + (1 - share) * newer
            return out

        return delay


@dataclass(frozen=True)
class DeadBand:
    """Motors stay off for commands below both thresholds.

    Attributes
    ----------
    speed : float
        Of |v|, m/s.
    turn : float
        Of |ω|, rad/s.
    """

    speed: float = OFF_SPEED
    turn: float = OFF_TURN

    def __post_init__(self) -> None:
        require(self.speed >= 0, "dead_band.speed", self.speed, "0 m/s or more")
        require(self.turn >= 0, "dead_band.turn", self.turn, "0 rad/s or more")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Nothing to remember."""

        def rest(velocities: Array, age: Array) -> Array:
            off = (np.abs(velocities[0]) < self.speed) & (np.abs(velocities[1]) < self.turn)
            return _stopped(velocities, off)

        return rest


@dataclass(frozen=True)
class Gains:
    """Robots drive and turn a little faster or slower than they are told.

    Attributes
    ----------
    speed, turn : Draw
        Factors on v and ω, per robot.
    by_speed, by_turn : Curve
        Further factors, at the commanded |v| in m/s and |ω| in rad/s.
    """

    speed: Draw = ONE
    turn: Draw = ONE
    by_speed: Curve = FLAT
    by_turn: Curve = FLAT

    def __post_init__(self) -> None:
        self.speed.require_at_least(0.0, "gains.speed")
        self.turn.require_at_least(0.0, "gains.turn")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's two gains."""
        speed, turn = self.speed.draw(robots, rng), self.turn.draw(robots, rng)

        def scale(velocities: Array, age: Array) -> Array:
            out = np.empty_like(velocities)
            out[0] = speed * self.by_speed(np.abs(velocities[0])) * velocities[0]
            out[1] = turn * self.by_turn(np.abs(velocities[1])) * velocities[1]
            return out

        return scale


@dataclass(frozen=True)
class Lag:
    """Speeds approach what is commanded exponentially.

    The step is integrated exactly: what is handed on is the mean velocity over it.

    Attributes
    ----------
    seconds : Draw
        Time constant, per robot.
    by_speed : Curve
        Factor on it, at the commanded forward speed in m/s.
    """

    seconds: Draw
    by_speed: Curve = FLAT

    def __post_init__(self) -> None:
        self.seconds.require_at_least(0.0, "lag.seconds")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's time constant; start at rest."""
        base = self.seconds.draw(robots, rng)
        state = np.zeros((2, robots))

        def follow(velocities: Array, age: Array) -> Array:
            ratio = np.maximum(base * self.by_speed(np.abs(velocities[0])) / time_step, 1e-9)
            left = np.exp(-1 / ratio)
            gap = state - velocities
            state[:] = velocities + left * gap
            out: Array = velocities + ratio * (1 - left) * gap
            return out

        return follow


@dataclass(frozen=True)
class WheelSlew:
    """A wheel cannot change its speed faster than its motor allows.

    Attributes
    ----------
    limit : float
        Largest change of a wheel's speed, rad/s².
    """

    limit: float

    def __post_init__(self) -> None:
        require(self.limit > 0, "wheel_slew.limit", self.limit, "more than 0 rad/s²")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Start at rest."""
        # Both wheels, times R: v ∓ ω L/2.
        change = self.limit * time_step * GRITSBOT_X.wheel_radius
        half = GRITSBOT_X.base_length / 2
        rim = np.zeros((2, robots))

        def slew(velocities: Array, age: Array) -> Array:
            v, w = velocities[0], half * velocities[1]
            rim[:] += np.clip(np.stack([v - w, v + w]) - rim, -change, change)
            return np.stack([(rim[0] + rim[1]) / 2, (rim[1] - rim[0]) / (2 * half)])

        return slew


@dataclass(frozen=True)
class TurnBias:
    """A robot that is told to drive straight drives a wide curve.

    Attributes
    ----------
    rate : Draw
        rad/s, per robot and run, while the motors are on.
    """

    rate: Draw

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Draw each robot's bias."""
        rate = self.rate.draw(robots, rng)

        def turn(velocities: Array, age: Array) -> Array:
            out: Array = velocities.copy()
            out[1] += np.where(_on(velocities), rate, 0.0)
            return out

        return turn


@dataclass(frozen=True)
class Disturbance:
    """What the model does not explain: white noise on both velocities while the motors are on.

    Attributes
    ----------
    speed, turn : float
        Standard deviations per step, m/s and rad/s.
    """

    speed: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        require(self.speed >= 0, "disturbance.speed", self.speed, "0 m/s or more")
        require(self.turn >= 0, "disturbance.turn", self.turn, "0 rad/s or more")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> MotorStage:
        """Nothing to draw before the first step."""
        scale = np.array([[self.speed], [self.turn]])

        def disturb(velocities: Array, age: Array) -> Array:
            noise = scale * rng.standard_normal((2, robots))
            return velocities + np.where(_on(velocities), noise, 0.0)

        return disturb


def _stopped(velocities: Array, which: NDArray[np.bool_]) -> Array:
    """Return velocities (2, N) with those of robots `which` (N,) set to zero."""
    if not which.any():
        return velocities
    out: Array = velocities.copy()
    out[:, which] = 0.0
    return out


def _on(velocities: Array) -> NDArray[np.bool_]:
    """Whose motors turn, (N,), at velocities (2, N)."""
    on: NDArray[np.bool_] = (np.abs(velocities[0]) >= OFF_SPEED) | (
        np.abs(velocities[1]) >= OFF_TURN
    )
    return on


# --- Between pose and measurement --------------------------------------------------------------


@dataclass(frozen=True)
class HeadingOffset:
    """The marker sits askew on the robot, so its tracked heading is off by a constant.

    Attributes
    ----------
    radians : Draw
        Per robot.
    """

    radians: Draw

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Draw each robot's offset."""
        offset = self.radians.draw(robots, rng)

        def skew(poses: Array, speeds: Array) -> Array:
            out: Array = poses.copy()
            out[2] = _wrapped(out[2] + offset)
            return out

        return skew


@dataclass(frozen=True)
class TrackingJitter:
    """White noise on tracked poses, in the robot's own directions.

    Attributes
    ----------
    along, lateral : float
        Standard deviations along and across the heading, metres.
    heading : float
        Standard deviation, radians.
    by_speed : Curve
        Factor on `along`, at the true forward speed in m/s.
    """

    along: float = 0.0
    lateral: float = 0.0
    heading: float = 0.0
    by_speed: Curve = FLAT

    def __post_init__(self) -> None:
        for name in ("along", "lateral", "heading"):
            require(getattr(self, name) >= 0, f"tracking_jitter.{name}", getattr(self, name), "≥ 0")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Nothing to draw before the first measurement."""

        def jitter(poses: Array, speeds: Array) -> Array:
            along, lateral, heading = rng.standard_normal((3, robots))
            along *= self.along * self.by_speed(speeds)
            lateral *= self.lateral
            cosine, sine = np.cos(poses[2]), np.sin(poses[2])
            out = np.empty_like(poses)
            out[0] = poses[0] + cosine * along - sine * lateral
            out[1] = poses[1] + sine * along + cosine * lateral
            out[2] = _wrapped(poses[2] + self.heading * heading)
            return out

        return jitter


@dataclass(frozen=True)
class TrackingDropout:
    """The tracker loses a robot now and then, and repeats its last pose meanwhile.

    Attributes
    ----------
    probability : float
        That a robot is lost, per robot and measurement.
    seconds : float
        How long it stays lost, on average (exponential).
    """

    probability: float
    seconds: float = 0.1

    def __post_init__(self) -> None:
        name = "tracking_dropout"
        require(0 <= self.probability <= 1, f"{name}.probability", self.probability, "0 to 1")
        require(self.seconds > 0, f"{name}.seconds", self.seconds, "more than 0 s")

    def begin(self, robots: int, time_step: float, rng: np.random.Generator) -> TrackingStage:
        """Start with every robot in sight."""
        last: Array | None = None
        until = np.zeros(robots)
        time = 0.0

        def drop(poses: Array, speeds: Array) -> Array:
            nonlocal last, time
            chance, length = rng.random(robots), rng.exponential(self.seconds, robots)
            if last is None:  # the tracker has to see a robot once before it can lose it
                last = poses.copy()
            else:
                starts = (until <= time) & (chance < self.probability)
                until[starts] = time + length[starts]
                seen = until <= time
                last[:, seen] = poses[:, seen]
            time += time_step
            out: Array = last.copy()
            return out

        return drop


def _wrapped(angles: Array) -> Array:
    return np.arctan2(np.sin(angles), np.cos(angles))


# --- Profiles ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Profile:
    """A set of imperfections, at most one of a kind; None means that one is absent.

    Attributes
    ----------
    name : str
        What reports call it.
    about : str
        Where its numbers come from.
    """

    name: str = "ideal"
    about: str = "No imperfection: identical to the published simulators."
    command_loss: CommandLoss | None = None
    watchdog: Watchdog | None = None
    dead_time: DeadTime | None = None
    dead_band: DeadBand | None = None
    gains: Gains | None = None
    lag: Lag | None = None
    wheel_slew: WheelSlew | None = None
    turn_bias: TurnBias | None = None
    disturbance: Disturbance | None = None
    heading_offset: HeadingOffset | None = None
    tracking_jitter: TrackingJitter | None = None
    tracking_dropout: TrackingDropout | None = None

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that are on, in the order in which they act."""
        return tuple(name for name in EFFECTS if getattr(self, name) is not None)

    def without(self, *names: str) -> Profile:
        """Return the same with these effects off."""
        _require_effects(names)
        kept = [name for name in self.effects if name not in names]
        called = self.name + "".join(f" without {name}" for name in names)
        return replace(self.only(*kept), name=called)

    def only(self, *names: str) -> Profile:
        """Return the same with all other effects off."""
        _require_effects(names)
        off = {name: None for name in EFFECTS if name not in names}
        return replace(self, name=f"{self.name}, only {', '.join(names)}", **off)  # type: ignore[arg-type]

    def start(self) -> Imperfections | None:
        """Return what an arena takes as ``realism`` for one run; None where nothing is on."""
        return Imperfections(self) if self.effects else None


#: Every effect's name in a profile, in the order in which they act.
EFFECTS: tuple[str, ...] = tuple(
    entry.name for entry in fields(Profile) if entry.name not in ("name", "about")
)
_TRACKING = ("heading_offset", "tracking_jitter", "tracking_dropout")


def _require_effects(names: tuple[str, ...]) -> None:
    for name in names:
        if name not in EFFECTS:
            raise ProfileError(
                f"no effect is called {name!r}; the effects are {', '.join(EFFECTS)}"
            )


class Imperfections:
    """One run under a profile: the arena's ``realism``.

    The same profile and generator give the same run, and an effect's draws do not depend on
    which other effects are on.

    Attributes
    ----------
    commanded : bool
        Whether there was a command since the last step; the arena sets it before each step, and
        the watchdog counts the steps for which it is False.
    """

    def __init__(self, profile: Profile) -> None:
        self.profile = profile
        self.commanded = True
        self._motors: list[MotorStage] = []
        self._tracking: list[TrackingStage] = []
        self._speeds = np.zeros(0)
        self._age = np.zeros(0)
        self._time_step = 0.0

    def reset(self, poses: Array, time_step: float, rng: np.random.Generator) -> None:
        """Begin a run of robots at `poses` (3, N), drawing all randomness from `rng`."""
        robots = poses.shape[1]
        root = int(rng.integers(2**63))
        self._time_step = time_step
        self._speeds, self._age = np.zeros(robots), np.zeros(robots)
        self._motors, self._tracking = [], []
        for name in self.profile.effects:
            effect = getattr(self.profile, name)
            stream = np.random.default_rng([root, zlib.crc32(name.encode())])
            stages = self._tracking if name in _TRACKING else self._motors
            stages.append(effect.begin(robots, time_step, stream))

    def actuate(self, velocities: Array, poses: Array, time: float) -> Array:
        """Velocities (2, N) really driven in this step, of those commanded, m/s and rad/s."""
        if self.commanded:
            self._age[:] = 0.0
        else:
            self._age += self._time_step
        age = self._age.copy()
        driven = velocities
        for stage in self._motors:
            driven = stage(driven, age)
        self._speeds = np.abs(driven[0])
        return driven

    def observe(self, poses: Array) -> Array:
        """Poses (3, N) as the tracking system reports true `poses` (3, N), which stay unchanged."""
        seen: Array = poses.copy()
        for stage in self._tracking:
            seen = stage(seen, self._speeds)
        return seen
