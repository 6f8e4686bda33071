"""A team as a `pettingzoo.ParallelEnv`: every robot an agent that sees, acts and is rewarded alone.

Agents are called ``robot_0``, ``robot_1``, … and begin and end together, when the team's task is
done or its time over.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.learning.libraries import LearningLibraryError
from posflock_robotarium.learning.rendering import TeamPictures
from posflock_robotarium.learning.scenario import Scenario
from posflock_robotarium.learning.teams import Teams, TeamSettings

try:
    from gymnasium.spaces import Box
    from gymnasium.utils.seeding import np_random
    from pettingzoo import ParallelEnv
except ImportError as error:
    raise LearningLibraryError("an environment of pettingzoo", error.name) from error

from posflock_robotarium.learning.vector_env import episode_seed, require_render_mode

__all__ = ["TeamParallelEnv"]

Singles = NDArray[np.float32]


class TeamParallelEnv(ParallelEnv[str, Singles, Singles]):  # type: ignore[misc]  # untyped there
    """One team, an agent a robot.

    Parameters
    ----------
    scenario : Scenario
        What robots are to do, how many they are, and what they see.
    settings : TeamSettings, optional
        Where the team drives; certified, in the ideal arena, by default.
    render_mode : {"rgb_array"}, optional
        Whether `render` returns a picture.

    Examples
    --------
    >>> from posflock_robotarium.learning.scenarios.navigation import Navigation
    >>> env = TeamParallelEnv(Navigation(robots=2), TeamSettings(engine="numpy"))
    >>> seen, infos = env.reset(seed=0)
    >>> sorted(seen), seen["robot_0"].shape
    (['robot_0', 'robot_1'], (13,))
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"], "name": "robotarium_v0"}

    def __init__(
        self,
        scenario: Scenario,
        settings: TeamSettings | None = None,
        render_mode: str | None = None,
    ) -> None:
        require_render_mode(render_mode)
        self.teams = Teams(scenario, 1, settings)
        self.render_mode = render_mode
        self.possible_agents = [f"robot_{robot}" for robot in range(scenario.robots)]
        self.agents: list[str] = []
        bound, size = scenario.observation_bound, scenario.observation_size
        self.observation_spaces = {
            agent: Box(-bound, bound, (size,), np.float32) for agent in self.possible_agents
        }
        self.action_spaces = {
            agent: Box(-1.0, 1.0, (2,), np.float32) for agent in self.possible_agents
        }
        self._stream = np_random(None)[0]
        self._pictures = TeamPictures(self.teams)

    def observation_space(self, agent: str) -> Box:
        """Return what an agent sees.

        Parameters
        ----------
        agent : str
            One of `possible_agents`, ``robot_0`` and so on.
        """
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Box:
        """Return what an agent can do.

        Parameters
        ----------
        agent : str
            One of `possible_agents`, ``robot_0`` and so on.
        """
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Singles], dict[str, dict[str, Any]]]:
        """Begin an episode.

        Parameters
        ----------
        seed : int, optional
            Of this episode and those that follow; None goes on with the stream.
        options : dict of (...) arrays, optional
            Not used.

        Returns
        -------
        seen : dict of (D,) arrays
            What each agent sees.
        infos : dict of dict
            The scenario's metrics, the same for all.
        """
        if seed is not None:
            self._stream = np_random(seed)[0]
        self.agents = self.possible_agents[:]
        self.teams.reset([episode_seed(self._stream)])
        return self._seen(), self._infos(self.agents)

    def step(
        self, actions: dict[str, Singles]
    ) -> tuple[
        dict[str, Singles],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Do as told for one step.

        Parameters
        ----------
        actions : dict of (2,) arrays
            Ahead and left of each agent, from -1 to 1.

        Returns
        -------
        seen : dict of (D,) arrays
            What each agent sees.
        rewards : dict of str to float
            Each agent's own.
        terminated, truncated : dict of str to bool
            Whether all is done; whether time is over.
        infos : dict of dict
            The scenario's metrics, the same for all.

        Raises
        ------
        ParameterError
            Where an agent has no action, or the episode is over.
        """
        if not self.agents:
            raise ParameterError("the episode is over: expected reset() before the next step")
        missing = sorted(set(self.agents) - set(actions))
        if missing:
            raise ParameterError(f"actions: expected one for each agent, none for {missing}")
        told = self.agents
        outcome = self.teams.step(np.stack([actions[agent] for agent in told])[None])
        rewards = dict(zip(told, outcome.rewards[0].tolist(), strict=True))
        terminated, truncated = bool(outcome.terminated[0]), bool(outcome.truncated[0])
        seen, infos = self._seen(), self._infos(told)
        if terminated or truncated:
            self.agents = []
        return seen, rewards, dict.fromkeys(told, terminated), dict.fromkeys(told, truncated), infos

    def render(self) -> NDArray[np.uint8] | None:
        """Return the arena from above as a (360, 560, 3) array; None without a render mode."""
        if self.render_mode is None:
            return None
        return self._pictures.of(0)

    def _seen(self) -> dict[str, Singles]:
        rows = self.teams.observe()[0].astype(np.float32)
        return dict(zip(self.possible_agents, rows, strict=True))

    def _infos(self, agents: list[str]) -> dict[str, dict[str, Any]]:
        numbers = {name: float(values[0]) for name, values in self.teams.metrics().items()}
        return {agent: dict(numbers) for agent in agents}
