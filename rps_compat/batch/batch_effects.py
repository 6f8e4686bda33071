"""A realism profile for many teams: the effects of one team, asked for a team of all robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, cast

import numpy as np

from rps_compat.arena import WRAPPED_BEYOND
from rps_compat.arena_guests import Array
from rps_compat.batch.random_streams import RandomStreams
from rps_compat.realism import Imperfections, Profile


class BatchRealism(Protocol):
    """What stands between command and motion, and between pose and measurement, of B teams."""

    def drive(self, commands: Array, poses: Array, time_step: float, fresh: bool) -> Array:
        """Move poses by one step, in place.

        Parameters
        ----------
        commands : (B, 2, N) array
            What was commanded, cut at the wheels' limits, m/s and rad/s.
        poses : (B, 3, N) array
            True poses, m and rad; they are moved.
        time_step : float
            Nominal duration of a step, s.
        fresh : bool
            Whether there was a command since the last step.

        Returns
        -------
        (B, 2, N) array
            Velocities really driven, m/s and rad/s: the way over the nominal time.
        """

    def observe(self, poses: Array) -> Array:
        """Return the poses as the tracking system reports them.

        Parameters
        ----------
        poses : (B, 3, N) array
            True poses, m and rad.

        Returns
        -------
        (B, 3, N) array
            Measured poses, m and rad.
        """


def begin(
    profile: Profile, poses: Array, time_step: float, generators: Sequence[np.random.Generator]
) -> BatchRealism | None:
    """Begin a run of each team under a profile; None where nothing is on.

    Parameters
    ----------
    profile : Profile
        Which effects there are.
    poses : (B, 3, N) array
        Where the robots stand, m and rad.
    time_step : float
        Nominal duration of a step, s.
    generators : sequence of Generator
        Where each team draws from.
    """
    if not profile.effects:
        return None
    if profile.clock is not None:  # steps of different lengths have nothing in common
        return _EachTeam(profile, poses, time_step, generators)
    return _OneLargeTeam(profile, poses, time_step, generators)


class _OneLargeTeam(BatchRealism):
    """All robots as one team: steps last the same for all."""

    def __init__(
        self,
        profile: Profile,
        poses: Array,
        time_step: float,
        generators: Sequence[np.random.Generator],
    ) -> None:
        self._realism = Imperfections(profile)
        roots = [int(generator.integers(2**63)) for generator in generators]
        robots = poses.shape[0] * poses.shape[2]
        self._realism.begin(robots, time_step, lambda name: _streams(roots, name))

    def drive(self, commands: Array, poses: Array, time_step: float, fresh: bool) -> Array:
        self._realism.commanded = fresh
        self._realism.seconds = time_step
        driven = self._realism.actuate(together(commands), together(poses), 0.0)
        velocities = apart(driven, poses.shape[0])
        move(velocities, poses, time_step)
        return velocities

    def observe(self, poses: Array) -> Array:
        return apart(self._realism.observe(together(poses)), poses.shape[0])


class _EachTeam(BatchRealism):
    """Team by team, as they would be alone."""

    def __init__(
        self,
        profile: Profile,
        poses: Array,
        time_step: float,
        generators: Sequence[np.random.Generator],
    ) -> None:
        self._teams = [Imperfections(profile) for _ in generators]
        for realism, stood, generator in zip(self._teams, poses, generators, strict=True):
            realism.reset(stood, time_step, generator)

    def drive(self, commands: Array, poses: Array, time_step: float, fresh: bool) -> Array:
        velocities = np.zeros(commands.shape)
        for team, realism in enumerate(self._teams):
            realism.commanded = fresh
            for seconds in realism.parts():
                realism.seconds = seconds
                driven = realism.actuate(commands[team], poses[team], 0.0)
                move(driven[None], poses[team : team + 1], seconds)
                velocities[team] += seconds / time_step * driven
                realism.commanded = False
        return velocities

    def observe(self, poses: Array) -> Array:
        return np.stack([one.observe(seen) for one, seen in zip(self._teams, poses, strict=True)])


def move(velocities: Array, poses: Array, seconds: float, heading: Array | None = None) -> None:
    """Move poses along the unicycle model by one explicit Euler step, in place.

    Parameters
    ----------
    velocities : (B, 2, N) array
        Forward speeds, m/s, and turn rates, rad/s.
    poses : (B, 3, N) array
        Poses, m and rad.
    seconds : float
        How long they are driven, s.
    heading : (2, B, N) array, optional
        Cosines and sines of the headings, where they are known.
    """
    angle = poses[:, 2].copy()
    cosine, sine = (np.cos(angle), np.sin(angle)) if heading is None else heading
    distance = seconds * velocities[:, 0]
    poses[:, 0] += distance * cosine
    poses[:, 1] += distance * sine
    angle += seconds * velocities[:, 1]
    beyond = (np.abs(angle) > WRAPPED_BEYOND).any(axis=1)
    if beyond.any():
        turned = angle[beyond]
        angle[beyond] = np.arctan2(np.sin(turned), np.cos(turned))
    poses[:, 2] = angle


def together(arrays: Array) -> Array:
    """Return arrays of B teams as that of one large team.

    Parameters
    ----------
    arrays : (B, d, N) array
        Team by team.

    Returns
    -------
    (d, B N) array
        Side by side.
    """
    return np.ascontiguousarray(arrays.swapaxes(0, 1)).reshape(arrays.shape[1], -1)


def apart(array: Array, teams: int) -> Array:
    """Return the array of one large team as those of B teams.

    Parameters
    ----------
    array : (d, B N) array
        Side by side.
    teams : int
        Number of teams, B.

    Returns
    -------
    (B, d, N) array
        Team by team.
    """
    return np.ascontiguousarray(array.reshape(array.shape[0], teams, -1).swapaxes(0, 1))


def _streams(roots: list[int], name: str) -> np.random.Generator:
    streams = RandomStreams([Imperfections.stream(root, name) for root in roots])
    return cast(np.random.Generator, streams)  # does what effects ask of a generator
