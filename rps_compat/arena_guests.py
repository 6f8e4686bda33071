"""Who may be handed to an arena, and what each has to be able to do.

A :class:`Realism` stands between command and motion and between pose and measurement. It may care
when commands stop (:class:`HearsSilence`), and how long a step really lasts (:class:`KeepsTime`). A
:class:`Recorder` is told of every step, whatever the script does.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Realism(Protocol):
    """How far reality is from the ideal arena; ``None`` in its place means ideal."""

    @abstractmethod
    def reset(self, poses: Array, time_step: float, rng: np.random.Generator) -> None:
        """Begin a run.

        Parameters
        ----------
        poses : (3, N) array
            Where the robots stand, m and rad.
        time_step : float
            Duration of a step, s.
        rng : Generator
            Where all randomness of the run is drawn from.
        """

    @abstractmethod
    def actuate(self, velocities: Array, poses: Array, time: float) -> Array:
        """Return the velocities that the robots really drive in one step.

        Parameters
        ----------
        velocities : (2, N) array
            What was commanded, cut at the wheels' limits, m/s and rad/s. Not to be changed.
        poses : (3, N) array
            True poses at the start of the step, m and rad. Not to be changed.
        time : float
            Seconds since the start of the run.

        Returns
        -------
        (2, N) array
            Forward speeds, m/s, and turn rates, rad/s.
        """

    @abstractmethod
    def observe(self, poses: Array) -> Array:
        """Return the poses as the tracking system reports them.

        Parameters
        ----------
        poses : (3, N) array
            True poses, m and rad; stay unchanged.

        Returns
        -------
        (3, N) array
            Measured poses, m and rad.
        """


class HearsSilence(Protocol):
    """A realism that cares when commands stop, as robots do that brake after half a second.

    Attributes
    ----------
    commanded
        Set by the arena before each step: whether there was a command since the last one.
    """

    commanded: bool


class KeepsTime(Protocol):
    """A realism whose steps do not last as long as they should.

    Attributes
    ----------
    seconds
        Set by the arena before it asks for velocities: for how long they will be driven.
    """

    seconds: float

    @abstractmethod
    def parts(self) -> Sequence[float]:
        """Return the seconds of the parts in which the coming step is driven, one after the other.

        Velocities are asked for anew in each; commands are new in the first only.
        """


class Recorder(Protocol):
    """What is told of every step of every arena; the pose log is one."""

    @abstractmethod
    def append(self, time: float, poses: Array, commands: Array, /) -> None:
        """Take note of one step.

        The arrays are the arena's own: copy what is kept.

        Parameters
        ----------
        time : float
            Time since the start of the run, s.
        poses : (3, N) array
            Poses as the script read them, m and rad.
        commands : (2, N) array
            Commands as given, m/s and rad/s.
        """
