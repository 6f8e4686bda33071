"""Imperfections for many teams: a profile's effects are asked for one team of all robots.

What is not a profile, or has steps of different lengths, is asked team by team.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from rps_compat.arena import WRAPPED_BEYOND
from rps_compat.arena_guests import Array, HearsSilence, KeepsTime, Realism
from rps_compat.batch.random_streams import RandomStreams
from rps_compat.batch.team_profiles import kinds_of
from rps_compat.realism import Imperfections, Profile

#: What a team may be given: effects to begin, or what an arena of its own takes; None is ideal.
TeamRealism: TypeAlias = Profile | Realism | None


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
    given: Sequence[TeamRealism],
    poses: Array,
    time_step: float,
    generators: Sequence[np.random.Generator],
) -> BatchRealism | None:
    """Begin a run of each team under its imperfections; None where nothing is on.

    Parameters
    ----------
    given : sequence of B Profile, Realism or None
        Which effects each team has, or what imperfections; None is ideal.
    poses : (B, 3, N) array
        Where the robots stand, m and rad.
    time_step : float
        Nominal duration of a step, s.
    generators : sequence of Generator
        Where each team draws from.
    """
    profiles = {t: one for t, one in enumerate(given) if one is None or isinstance(one, Profile)}
    own = [team for team in range(len(given)) if team not in profiles]
    kinds: list[tuple[BatchRealism | None, NDArray[np.intp]]] = []
    if own:
        realisms = [cast(Realism, given[team]) for team in own]
        chance = [generators[team] for team in own]
        kinds.append((_EachTeam(realisms, poses[own], time_step, chance), np.array(own)))
    profiled = list(profiles)
    for profile, places in kinds_of(list(profiles.values())):
        teams = [profiled[place] for place in places]
        chance = [generators[team] for team in teams]
        one: BatchRealism | None = None
        if profile is not None and profile.clock is None:
            one = _OneLargeTeam(profile, poses[teams], time_step, chance)
        elif profile is not None:  # steps of different lengths have nothing in common
            each = [Imperfections(cast(Profile, profiles[team])) for team in teams]
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
        teams: Sequence[Realism],
        poses: Array,
        time_step: float,
        generators: Sequence[np.random.Generator],
    ) -> None:
        self._teams = tuple(teams)
        self._steps = 0
        for realism, stood, generator in zip(self._teams, poses, generators, strict=True):
            realism.reset(stood, time_step, generator)

    def drive(self, commands: Array, poses: Array, time_step: float, fresh: bool) -> Array:
        velocities, time = np.zeros(commands.shape), self._steps * time_step
        self._steps += 1
        for team, realism in enumerate(self._teams):
            timer = cast(KeepsTime, realism) if hasattr(realism, "parts") else None
            for part, seconds in enumerate((time_step,) if timer is None else timer.parts()):
                if hasattr(realism, "commanded"):
                    cast(HearsSilence, realism).commanded = fresh and part == 0
                if timer is not None:
                    timer.seconds = seconds
                driven = realism.actuate(commands[team], poses[team], time)
                move(driven[None], poses[team : team + 1], seconds)
                velocities[team] += seconds / time_step * driven
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
