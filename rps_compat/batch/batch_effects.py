"""Realism profiles for many teams: the effects of one team, asked for a team of all robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from rps_compat.arena import WRAPPED_BEYOND
from rps_compat.arena_guests import Array
from rps_compat.batch.random_streams import RandomStreams
from rps_compat.batch.team_profiles import kinds_of
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
    profiles: Sequence[Profile | None],
    poses: Array,
    time_step: float,
    generators: Sequence[np.random.Generator],
) -> BatchRealism | None:
    """Begin a run of each team under its profile; None where nothing is on.

    Parameters
    ----------
    profiles : sequence of B Profile or None
        Which effects each team has; None is ideal.
    poses : (B, 3, N) array
        Where the robots stand, m and rad.
    time_step : float
        Nominal duration of a step, s.
    generators : sequence of Generator
        Where each team draws from.
    """
    kinds = []
    for profile, teams in kinds_of(profiles):
        chance = [generators[team] for team in teams]
        one: BatchRealism | None = None
        if profile is not None and profile.clock is None:
            one = _OneLargeTeam(profile, poses[teams], time_step, chance)
        elif profile is not None:  # steps of different lengths have nothing in common
            each = [cast(Profile, profiles[team]) for team in teams]
            one = _EachTeam(each, poses[teams], time_step, chance)
        kinds.append((one, np.array(teams)))
    return kinds[0][0] if len(kinds) == 1 else _Kinds(kinds)


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
        profiles: Sequence[Profile],
        poses: Array,
        time_step: float,
        generators: Sequence[np.random.Generator],
    ) -> None:
        self._teams = [Imperfections(profile) for profile in profiles]
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


class _Kinds(BatchRealism):
    """Teams of several kinds, one kind after the other; None is the ideal one."""

    def __init__(self, kinds: Sequence[tuple[BatchRealism | None, NDArray[np.intp]]]) -> None:
        self._kinds = kinds

    def drive(self, commands: Array, poses: Array, time_step: float, fresh: bool) -> Array:
        velocities = commands.copy()
        for realism, teams in self._kinds:
            moved = poses[teams]
            if realism is None:
                move(commands[teams], moved, time_step)
            else:
                velocities[teams] = realism.drive(commands[teams], moved, time_step, fresh)
            poses[teams] = moved
        return velocities

    def observe(self, poses: Array) -> Array:
        seen = poses.copy()
        for realism, teams in self._kinds:
            if realism is not None:
                seen[teams] = realism.observe(poses[teams])
        return seen


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
