"""Train a small policy that all robots of a team share, and say how good it is.

All candidates of a generation drive at once, each in the same few episodes: one batch of
candidates × episodes teams. Episodes are new in each generation, drawn from the seed, so that
nobody learns a start by heart; what a policy is worth is measured on others, which training never
drew.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.trained_policy import TrainedPolicy
from posflock_robotarium.learning.evolution import (
    Evolution,
    EvolutionSettings,
    Progress,
    evolve,
)
from posflock_robotarium.learning.scenario import Scenario
from posflock_robotarium.learning.teams import Teams, TeamSettings

__all__ = ["HELD_OUT", "Training", "evaluate", "held_out_seeds", "straight_to_goals", "train"]

Floats = NDArray[np.float64]
#: From what robots see (..., N, D) to what they do (..., N, 2).
Acting = Callable[[Floats], Floats]

#: Seeds from here on are never trained with: policies are judged by them.
HELD_OUT = 1_000_000


@dataclass(frozen=True, eq=False)
class Training:
    """A policy, and how it was found.

    Attributes
    ----------
    policy : TrainedPolicy
        What was found.
    evolution : Evolution
        How the search went.
    search : EvolutionSettings
        How it was set up.
    episodes : int
        How many each candidate drove in a generation.
    """

    policy: TrainedPolicy
    evolution: Evolution
    search: EvolutionSettings
    episodes: int


def held_out_seeds(number: int) -> list[int]:
    """Return seeds that no training draws, to judge policies by.

    Parameters
    ----------
    number : int
        How many; always the same ones first.
    """
    return list(range(HELD_OUT, HELD_OUT + number))


def straight_to_goals(seen: Floats) -> Floats:
    """Return what a hand-written law does that drives straight to its goal: to compare with.

    Parameters
    ----------
    seen : (..., N, D) array
        What robots see; the first two numbers are the way to the goal.

    Returns
    -------
    (..., N, 2) array
        Actions.
    """
    return seen[..., :2]


def train(
    scenario: Scenario,
    search: EvolutionSettings,
    *,
    settings: TeamSettings | None = None,
    episodes: int = 3,
    hidden: Sequence[int] = (16,),
    progress: Progress = lambda done, total, score: None,
) -> Training:
    """Search for the weights of a policy that a team's robots share.

    Parameters
    ----------
    scenario : Scenario
        What robots are to do, how many they are, and what they see.
    search : EvolutionSettings
        How weights are searched for; its seed decides all of it.
    settings : TeamSettings, optional
        Where teams drive; certified, in the ideal arena, by default.
    episodes : int
        How many each candidate drives in a generation.
    hidden : sequence of int
        Sizes of the layers between what is seen and what is done.
    progress : callable, optional
        Told after each generation: how many are done, of how many, the policy's score, which is
        the sum of rewards of an episode, a robot's mean.

    Raises
    ------
    ParameterError
        Where there are no episodes.
    """
    if episodes < 1:
        raise ParameterError(f"episodes: expected one at least, got {episodes!r}")
    sizes = (scenario.observation_size, *hidden, 2)
    candidates = 2 * search.pairs + 1
    teams = Teams(scenario, candidates * episodes, settings)
    root = np.random.default_rng([search.seed, 2])

    def score(vectors: Floats, generation: int) -> Floats:
        seeds = root.integers(HELD_OUT, size=episodes).tolist() * candidates
        found = _returns(teams, seeds, lambda seen: _act_each(vectors, sizes, seen))
        means: Floats = found.reshape(candidates, episodes).mean(axis=1)
        return means

    start = 0.1 * root.standard_normal(TrainedPolicy.numbers(sizes))
    found = evolve(score, start, search, progress)
    policy = TrainedPolicy.from_vector(found.vector, sizes)
    return Training(policy, found, search, episodes)


def evaluate(
    scenario: Scenario,
    act: Acting,
    seeds: Sequence[int],
    settings: TeamSettings | None = None,
) -> dict[str, Floats]:
    """Let a policy drive an episode from each seed, to its last second; return how it fared.

    Parameters
    ----------
    scenario : Scenario
        What robots are to do, how many they are, and what they see.
    act : callable
        From what is seen (B, N, D) to actions (B, N, 2).
    seeds : sequence of B int
        `held_out_seeds` are what no training has seen.
    settings : TeamSettings, optional
        Where teams drive; certified, in the ideal arena, by default.

    Returns
    -------
    dict of (B,) arrays
        The scenario's metrics at the end, collisions and steps outside, and the ``return``: the
        sum of rewards, a robot's mean.
    """
    teams = Teams(scenario, len(seeds), settings)
    return {"return": _returns(teams, seeds, act), **teams.metrics()}


def _returns(teams: Teams, seeds: Sequence[int], act: Acting) -> Floats:
    """Drive all teams until nobody has time left; return the sum of each one's rewards, (B,)."""
    seen = teams.reset(seeds)
    total, over = np.zeros(len(seeds)), False
    while not over:
        outcome = teams.step(act(seen))
        total += outcome.rewards.mean(axis=1)
        seen = teams.observe()
        over = bool((outcome.terminated | outcome.truncated).all())
    return total


def _act_each(vectors: Floats, sizes: Sequence[int], seen: Floats) -> Floats:
    """Return the actions of P policies, each for its own teams: (P E, N, D) to (P E, N, 2)."""
    values: Floats = seen.reshape(len(vectors), -1, seen.shape[-1])
    first = 0
    for inputs, outputs in itertools.pairwise(sizes):
        last = first + inputs * outputs
        weights = vectors[:, first:last].reshape(-1, inputs, outputs)
        values = np.tanh(values @ weights + vectors[:, None, last : last + outputs])
        first = last + outputs
    return values.reshape(*seen.shape[:-1], sizes[-1])
