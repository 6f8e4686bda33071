"""How the Robotarium instances of this process are built: one object, set by whoever runs scripts.

A script says ``Robotarium(number_of_robots=9, ...)`` and nothing about seeds, imperfections or
logs. The runner, a verifier or a test says those things once, in a :class:`Session`, and every
instance made while it is active obeys::

    with Session(initial="exact", recorder=lambda robots: my_log).active():
        runpy.run_path("script.py")

Nothing of one instance reaches the next: each gets its own arena, its own random stream and its
own recorder.
"""

import contextlib
from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, get_args

import numpy as np

from rps_compat.arena import Arena, Array
from rps_compat.arena_guests import Realism, Recorder
from rps_compat.errors import RobotariumError
from rps_compat.testbed import RobotModel

Initial = Literal["published", "exact", "arrive", "drive"]


class StepListener(Protocol):
    """What is told of the end of each step of each instance."""

    @abstractmethod
    def after_step(self, time_step: float, /) -> None:
        """Take note that a step is done.

        Parameters
        ----------
        time_step : float
            Its duration, s.
        """


class SessionError(RobotariumError, ValueError):
    """A session asked for something that does not exist."""


@dataclass
class Session:
    """What every Robotarium instance made while it is active has in common.

    Attributes
    ----------
    initial
        How robots come to their initial conditions: "published" as each generation does it
        (generation 1 starts there, generation 2 drives there unless ``skip_initialization``),
        "exact" starts there, "arrive" starts within the testbed's arrival error of 5 cm and
        0.2 rad, "drive" drives there.
    seed
        Seed of everything random that is not the script's own: imperfections, arrival errors.
    realism
        Makes the imperfections of one instance; None is the ideal arena.
    recorder
        Makes what records one instance, from its number of robots; None records nothing.
    created
        Is told of each new instance.
    wait
        Whether ``sim_in_real_time=True`` really waits: True, False, or None for only where
        somebody can see it, in a window.
    process
        Numbers that tell the random streams of a child process of the script from others'; none in
        its own process.
    pace
        Is told of the end of each step, in place of waiting; None waits as `wait` says.
    instances : int
        How many have asked for their random stream so far.

    Raises
    ------
    SessionError
        If there is no such `initial`.
    """

    initial: Initial = "published"
    seed: int | None = None
    realism: Callable[[], Realism | None] | None = None
    recorder: Callable[[int], Recorder] | None = None
    created: Callable[[Any], None] | None = None
    wait: bool | None = None
    process: tuple[int, ...] = ()
    pace: StepListener | None = None
    instances: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        if self.initial not in get_args(Initial):
            raise SessionError(
                f"initial is {self.initial!r}, expected one of {', '.join(get_args(Initial))}"
            )

    def generator(self) -> np.random.Generator:
        """Make the random stream of one more instance: its own, the same for the same seed.

        Without a seed it follows numpy's global generator, so that a script that seeds that is
        repeatable.
        """
        stream = self.instances
        self.instances += 1
        if self.seed is None:
            return np.random.default_rng(np.random.randint(2**31))  # noqa: NPY002
        return np.random.default_rng([self.seed, stream, *self.process])

    def mode(self, published: Literal["exact", "drive"]) -> Literal["exact", "arrive", "drive"]:
        """Return how an instance comes to its initial conditions.

        Parameters
        ----------
        published : {"exact", "drive"}
            What the API would do.
        """
        return published if self.initial == "published" else self.initial

    def arena(
        self, poses: Array, robot: RobotModel, rng: Callable[[], np.random.Generator]
    ) -> Arena:
        """Make the arena of one instance.

        Parameters
        ----------
        poses : (3, N) array
            Where the robots stand, m and rad.
        robot : RobotModel
            Dimensions and limits of the robots, and the arena.
        rng : callable
            Makes the random stream of its imperfections.
        """
        return Arena(
            poses,
            robot,
            realism=None if self.realism is None else self.realism(),
            recorder=None if self.recorder is None else self.recorder(poses.shape[1]),
            rng=None if self.realism is None else rng(),
        )

    @contextlib.contextmanager
    def active(self) -> Iterator["Session"]:
        """Let this session build the instances of the ``with`` block; sessions may be nested."""
        global _current
        before, _current = _current, self
        try:
            yield self
        finally:
            _current = before


_current = Session()


def use(session: Session) -> None:
    """Let a session build the instances from now on; what is active in a block stays.

    Parameters
    ----------
    session : Session
        What later instances have in common.
    """
    global _current
    _current = session


def current() -> Session:
    """Session that is active; by default everything as published, and ideal."""
    return _current
