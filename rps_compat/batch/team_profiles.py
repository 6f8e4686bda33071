"""Teams of robots that differ: which of them can be computed as one large team, and by what.

Effects take arrays of robots, and what a robot drew of a distribution is such an array already. So
teams whose profiles differ in distributions alone (a lag of 0.12 s here, between 0.1 and 0.2 s
there, a list with one value a robot elsewhere) are one large team, in which each team draws from
its own distribution. A number that all robots share, such as the size of a noise, is one number to
an effect: profiles which differ in that are computed one kind after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, cast

import numpy as np

from rps_compat.batch.random_streams import Array, RandomStreams
from rps_compat.distributions import DistributionKind, RobotDistribution, constant
from rps_compat.realism import Profile

_ANY = constant(0.0)


@dataclass(frozen=True)
class TeamDistributions(RobotDistribution):
    """A distribution for each of B teams, as that of one large team.

    Attributes
    ----------
    teams : tuple of B RobotDistribution
        What each team draws from.
    """

    teams: tuple[RobotDistribution, ...] = ()

    def draw(self, robots: int, rng: np.random.Generator) -> Array:
        """Return one value a robot, drawn team by team from the streams of `RandomStreams`."""
        own = iter(self.teams)
        streams = cast(RandomStreams, rng)
        return streams.each(robots, lambda one, number: next(own).draw(number, one))

    def require_at_least(self, least: float, name: str) -> None:
        for one in self.teams:
            one.require_at_least(least, name)


def kinds_of(profiles: Sequence[Profile | None]) -> list[tuple[Profile | None, list[int]]]:
    """Return the kinds of teams, each with the profile of the large team that its teams are.

    Parameters
    ----------
    profiles : sequence of B Profile or None
        What each team is like; None is ideal.

    Returns
    -------
    list of (Profile or None, list of int)
        Which teams are alike but for distributions, in their order, and what they are together.
    """
    if profiles and all(profile is profiles[0] for profile in profiles):
        return [(_large_team(profiles[:1]), list(range(len(profiles))))]
    kinds: dict[str, list[int]] = {}
    for team, profile in enumerate(profiles):
        kinds.setdefault(_kind(profile), []).append(team)
    return [(_large_team([profiles[team] for team in teams]), teams) for teams in kinds.values()]


def _kind(profile: Profile | None) -> str:
    """Return what teams share that can be computed as one: all but names and distributions."""
    if profile is None or not profile.effects:
        return ""
    return repr(replace(_changed(profile, lambda effect, entry: _ANY), name="", about=""))


def _large_team(profiles: Sequence[Profile | None]) -> Profile | None:
    """Return profiles of one kind as that of one large team."""
    first = profiles[0]
    if first is None or not first.effects:
        return None

    def together(effect: str, entry: str) -> RobotDistribution:
        each = tuple(getattr(getattr(profile, effect), entry) for profile in profiles)
        if all(one == each[0] for one in each):
            return cast(RobotDistribution, each[0])
        values = tuple(value for one in each for value in one.values)
        return TeamDistributions(DistributionKind.ROBOTS, values, teams=each)

    return _changed(first, together)


def _changed(profile: Profile, change: Callable[[str, str], RobotDistribution]) -> Profile:
    """Return a profile with other distributions: from the names of effect and entry."""
    effects: dict[str, Any] = {}
    for name in profile.effects:
        effect = getattr(profile, name)
        drawn = [
            e.name for e in fields(effect) if isinstance(getattr(effect, e.name), RobotDistribution)
        ]
        effects[name] = replace(effect, **{entry: change(name, entry) for entry in drawn})
    return replace(profile, **effects)
