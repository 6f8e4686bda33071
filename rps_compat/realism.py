"""How a real testbed differs from the ideal simulator, as effects that compose.

Between a command and the motion lie a radio, a motor controller, two wheels and a floor; between
a pose and its measurement lie a camera and a tracker. Each imperfection here is one small frozen
dataclass. :class:`Profile` is a set of them, at most one of a kind, and its :meth:`Profile.start`
makes the object that an :class:`~rps_compat.arena.Arena` takes as ``realism``. The commands of a
step pass the motor effects in this order,

    clock → command loss → watchdog → dead time → motor dead band → gains → lag → wheel slew
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

import numpy as np

from rps_compat.arena_guests import HearsSilence, KeepsTime, Realism
from rps_compat.command_effects import CommandLoss, DeadBand, DeadTime, Watchdog
from rps_compat.distributions import ProfileError
from rps_compat.motor_effects import (
    Array,
    Disturbance,
    Gains,
    Lag,
    MotorStage,
    TurnBias,
    WheelSlew,
)
from rps_compat.step_times import Clock, StepParts
from rps_compat.tracking_effects import (
    HeadingOffset,
    TrackingDropout,
    TrackingJitter,
    TrackingStage,
)

__all__ = [
    "EFFECTS",
    "Clock",
    "CommandLoss",
    "DeadBand",
    "DeadTime",
    "Disturbance",
    "Gains",
    "HeadingOffset",
    "Imperfections",
    "Lag",
    "Profile",
    "TrackingDropout",
    "TrackingJitter",
    "TurnBias",
    "Watchdog",
    "WheelSlew",
]


@dataclass(frozen=True)
class Profile:
    """A set of imperfections, at most one of a kind; None means that one is absent.

    Attributes
    ----------
    name : str
        What reports call it.
    about : str
        Where its numbers come from.
    clock : Clock, optional
        Steps that do not take the time that they should.
    command_loss : CommandLoss, optional
        Commands that do not arrive.
    watchdog : Watchdog, optional
        Robots that stop when they hear nothing.
    dead_time : DeadTime, optional
        Commands that act late.
    dead_band : DeadBand, optional
        Commands too small to move.
    gains : Gains, optional
        Robots faster or slower than told.
    lag : Lag, optional
        Motors that need time to follow.
    wheel_slew : WheelSlew, optional
        Wheels that speed up no faster than a limit.
    turn_bias : TurnBias, optional
        Robots that drive in curves when told to go straight.
    disturbance : Disturbance, optional
        Noise of the motion.
    heading_offset : HeadingOffset, optional
        Headings that are measured off by a constant.
    tracking_jitter : TrackingJitter, optional
        Noise of measured poses.
    tracking_dropout : TrackingDropout, optional
        Robots out of the tracker's sight.
    """

    name: str = "ideal"
    about: str = "No imperfection: identical to the published simulators."
    clock: Clock | None = None
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
        """Return the same with these effects off.

        Parameters
        ----------
        *names : str
            Names of effects, as the attributes are called.
        """
        _require_effects(names)
        kept = [name for name in self.effects if name not in names]
        called = self.name + "".join(f" without {name}" for name in names)
        return replace(self.only(*kept), name=called)

    def only(self, *names: str) -> Profile:
        """Return the same with all other effects off.

        Parameters
        ----------
        *names : str
            Names of effects, as the attributes are called.
        """
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


class Imperfections(Realism, HearsSilence, KeepsTime):
    """One run under a profile: the arena's ``realism``.

    The same profile and generator give the same run, and an effect's draws do not depend on
    which other effects are on.

    Parameters
    ----------
    profile : Profile
        Which effects there are.

    Attributes
    ----------
    commanded : bool
        Whether there was a command since the last step; the arena sets it before each step, and
        the watchdog counts the time for which it is False.
    seconds : float
        For how long the velocities asked for are driven; the arena sets it before each part.
    """

    def __init__(self, profile: Profile) -> None:
        self.profile = profile
        self.commanded = True
        self.seconds = 0.0
        self._times: StepParts = tuple
        self._motors: list[MotorStage] = []
        self._tracking: list[TrackingStage] = []
        self._speeds = np.zeros(0)
        self._age = np.zeros(0)
        self._before = 0.0  # seconds of the part before

    def reset(self, poses: Array, time_step: float, rng: np.random.Generator) -> None:
        """Begin a run."""
        root = int(rng.integers(2**63))
        self.begin(poses.shape[1], time_step, lambda name: self.stream(root, name))

    def begin(
        self, robots: int, time_step: float, stream_of: Callable[[str], np.random.Generator]
    ) -> None:
        """Begin a run with a random stream for each effect.

        Parameters
        ----------
        robots : int
            Number of robots, N.
        time_step : float
            Duration of a step, s.
        stream_of : callable
            From an effect's name to its stream.
        """
        self.seconds = self._before = time_step
        self._times = lambda: (time_step,)
        self._speeds, self._age = np.zeros(robots), np.zeros(robots)
        self._motors, self._tracking = [], []
        for name in self.profile.effects:
            effect = getattr(self.profile, name)
            begun = effect.begin(robots, time_step, stream_of(name))
            if name == "clock":
                self._times = begun
            else:
                (self._tracking if name in _TRACKING else self._motors).append(begun)

    @staticmethod
    def stream(root: int, name: str) -> np.random.Generator:
        """Return the random stream of one effect.

        Parameters
        ----------
        root : int
            What a run drew first.
        name : str
            The effect's name.
        """
        return np.random.default_rng([root, zlib.crc32(name.encode())])

    def parts(self) -> tuple[float, ...]:
        """Return the seconds of the parts in which the coming step is driven."""
        return self._times()

    def actuate(self, velocities: Array, poses: Array, time: float) -> Array:
        """Return the velocities that the robots really drive, on average over `seconds`."""
        if self.commanded:
            self._age[:] = 0.0
        else:
            self._age += self._before
        self._before = self.seconds
        age = self._age.copy()
        driven = velocities
        for stage in self._motors:
            driven = stage(driven, age, self.seconds)
        self._speeds = np.abs(driven[0])
        return driven

    def observe(self, poses: Array) -> Array:
        """Return the poses as the tracking system reports them."""
        seen: Array = poses.copy()
        for stage in self._tracking:
            seen = stage(seen, self._speeds)
        return seen
