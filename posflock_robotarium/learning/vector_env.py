"""Teams as `gymnasium` environments: many at once, or one.

A team is one agent here: it sees (N, D) numbers, does (N, 2), and gets the mean of its robots'
rewards. `TeamVectorEnv` steps B teams in one call and does what gymnasium's own `SyncVectorEnv` of
B single `TeamEnv` would, number by number.

Seeds are gymnasium's: ``reset(seed=s)`` gives team i the seed s + i, and later episodes of a team
follow from it. When a team that is over begins anew is the autoreset mode, which stands in
``metadata["autoreset_mode"]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.learning.libraries import LearningLibraryError
from posflock_robotarium.learning.rendering import TeamPictures
from posflock_robotarium.learning.scenario import Scenario
from posflock_robotarium.learning.teams import Teams, TeamSettings

try:
    import gymnasium
    from gymnasium.spaces import Box, Space
    from gymnasium.utils.seeding import np_random
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ImportError as error:
    raise LearningLibraryError("an environment of gymnasium", error.name) from error

__all__ = ["TeamEnv", "TeamVectorEnv"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Singles = NDArray[np.float32]

_RENDER_MODES = (None, "rgb_array")
_FRAMES = 30  # a second


def spaces_of(scenario: Scenario) -> tuple[Space[Singles], Space[Singles]]:
    """Return what a team sees and does, as spaces.

    Parameters
    ----------
    scenario : Scenario
        What robots are to do, how many they are, and what they see.

    Returns
    -------
    seen : Box of an (N, D) array
        What robots see.
    done : Box of an (N, 2) array
        What they do.
    """
    bound = scenario.observation_bound
    shape = (scenario.robots, scenario.observation_size)
    seen: Any = Box(-bound, bound, shape, np.float32)
    done: Any = Box(-1.0, 1.0, (scenario.robots, 2), np.float32)
    return seen, done


def require_render_mode(mode: str | None) -> None:
    """Refuse a way of showing teams that there is not.

    Parameters
    ----------
    mode : str, optional
        What was asked for.

    Raises
    ------
    ParameterError
        Where it is neither None nor "rgb_array".
    """
    if mode not in _RENDER_MODES:
        raise ParameterError(f"render_mode: expected None or 'rgb_array', got {mode!r}")


def episode_seed(rng: np.random.Generator) -> int:
    """Return the seed of the next episode, drawn from an environment's own stream.

    Parameters
    ----------
    rng : numpy.random.Generator
        Seeded at ``reset(seed=…)``, and drawn from once an episode.
    """
    return int(rng.integers(2**31))


class TeamEnv(gymnasium.Env[Singles, Singles]):
    """One team as a `gymnasium.Env`.

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
    >>> env = TeamEnv(Navigation(robots=4), TeamSettings(engine="numpy"))
    >>> seen, info = env.reset(seed=0)
    >>> seen.shape, env.action_space.shape
    ((4, 13), (4, 2))
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": _FRAMES}  # noqa: RUF012  # as gymnasium declares it

    def __init__(
        self,
        scenario: Scenario,
        settings: TeamSettings | None = None,
        render_mode: str | None = None,
    ) -> None:
        require_render_mode(render_mode)
        self.teams = Teams(scenario, 1, settings)
        self.render_mode = render_mode
        self.observation_space, self.action_space = spaces_of(scenario)
        self._pictures = TeamPictures(self.teams)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Singles, dict[str, Any]]:
        """Begin an episode.

        Parameters
        ----------
        seed : int, optional
            Of this episode and those that follow; None goes on with the stream.
        options : dict of (...) arrays, optional
            Not used.

        Returns
        -------
        seen : (N, D) array
            What each robot sees.
        info : dict
            The scenario's metrics, numbers.
        """
        super().reset(seed=seed)
        seen = self.teams.reset([episode_seed(self.np_random)])
        return seen[0].astype(np.float32), self._info()

    def step(self, action: Singles) -> tuple[Singles, float, bool, bool, dict[str, Any]]:
        """Do as told for one step.

        Parameters
        ----------
        action : (N, 2) array
            Ahead and left, from -1 to 1.

        Returns
        -------
        seen : (N, D) array
            What each robot sees.
        reward : float
            Mean of the robots'.
        terminated, truncated : bool
            Whether all is done; whether time is over.
        info : dict
            The scenario's metrics, numbers.
        """
        outcome = self.teams.step(np.asarray(action)[None])
        return (
            self.teams.observe()[0].astype(np.float32),
            float(outcome.rewards[0].mean()),
            bool(outcome.terminated[0]),
            bool(outcome.truncated[0]),
            self._info(),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Return the arena from above as a (360, 560, 3) array; None without a render mode."""
        if self.render_mode is None:
            return None
        return self._pictures.of(0)

    def _info(self) -> dict[str, Any]:
        return {name: float(values[0]) for name, values in self.teams.metrics().items()}


class TeamVectorEnv(VectorEnv[Singles, Singles, NDArray[Any]]):
    """B teams as a `gymnasium.vector.VectorEnv`, all stepped in one call.

    Parameters
    ----------
    scenario : Scenario
        What robots are to do, how many they are, and what they see.
    num_envs : int
        How many teams, B.
    settings : TeamSettings, optional
        Where teams drive; certified, in the ideal arena, by default.
    autoreset_mode : AutoresetMode or str
        ``NextStep``: a team that is over begins anew at the next step, whose action is not used.
        ``SameStep``: at once; what was seen last is in ``final_obs``, the metrics in
        ``final_info``. ``Disabled``: by ``reset(options={"reset_mask": mask})``.
    render_mode : {"rgb_array"}, optional
        Whether `render` returns pictures.

    Raises
    ------
    ParameterError
        Where there is no such mode.
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int,
        settings: TeamSettings | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        super().__init__()
        require_render_mode(render_mode)
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = ", ".join(repr(mode.value) for mode in AutoresetMode)
            raise ParameterError(
                f"autoreset_mode: expected one of {modes}, got {autoreset_mode!r}"
            ) from None
        self.metadata = TeamEnv.metadata | {"autoreset_mode": self.autoreset_mode}
        self.teams = Teams(scenario, num_envs, settings)
        self.num_envs, self.render_mode = num_envs, render_mode
        self.single_observation_space, self.single_action_space = spaces_of(scenario)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._streams: list[np.random.Generator] = [np_random(None)[0] for _ in range(num_envs)]
        self._over: Flags = np.zeros(num_envs, dtype=bool)
        self._begun = False
        self._pictures = TeamPictures(self.teams)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Singles, dict[str, Any]]:
        """Begin episodes.

        Parameters
        ----------
        seed : int or sequence of B int, optional
            Team i gets seed + i, or its own; None goes on with its stream.
        options : dict of (B,) arrays, optional
            ``reset_mask``: which teams begin anew, booleans; all without.

        Returns
        -------
        seen : (B, N, D) array
            What each robot sees.
        info : dict of (B,) arrays
            The scenario's metrics, and by ``_name`` whose they are.

        Raises
        ------
        ParameterError
            Where seeds or mask are not for so many teams.
        """
        seeds = [None if seed is None else seed + i for i in range(self.num_envs)] if (
            seed is None or isinstance(seed, (int, np.integer))
        ) else list(seed)  # fmt: skip
        if len(seeds) != self.num_envs:
            raise ParameterError(f"seed: expected {self.num_envs}, one a team, got {len(seeds)}")
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, dtype=bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
            raise ParameterError(
                f"reset_mask: expected ({self.num_envs},) booleans, one of them true at least, got"
                f" {mask.dtype} of shape {mask.shape}"
            )
        for team in np.flatnonzero(mask).tolist():
            if seeds[team] is not None:
                self._streams[team] = np_random(seeds[team])[0]
        if mask.all():
            self.teams.reset([episode_seed(stream) for stream in self._streams])
            self._begun = True
        elif not self._begun:
            raise ParameterError("reset_mask: expected all teams at the first reset")
        else:
            self._restart(mask)
        self._over = self._over & ~mask
        return self._seen(), self._info(mask)

    def step(
        self, actions: Singles
    ) -> tuple[Singles, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Do as told for one step, in all teams.

        Parameters
        ----------
        actions : (B, N, 2) array
            Ahead and left, from -1 to 1.

        Returns
        -------
        seen : (B, N, D) array
            What each robot sees.
        rewards : (B,) array
            Mean of each team's robots.
        terminated, truncated : (B,) boolean array
            Whose work is done; whose time is over.
        info : dict of (B,) arrays
            The scenario's metrics, and by ``_name`` whose they are.

        Raises
        ------
        ParameterError
            Where a team that is over was not reset, in the mode ``Disabled``.
        """
        anew = self._over.copy()
        if anew.any() and self.autoreset_mode is AutoresetMode.DISABLED:
            raise ParameterError(
                f"teams {np.flatnonzero(anew).tolist()} are over: expected"
                ' reset(options={"reset_mask": mask}) before the next step'
            )
        outcome = self.teams.step(actions)
        rewards = outcome.rewards.mean(axis=1)
        terminated, truncated = outcome.terminated.copy(), outcome.truncated.copy()
        if anew.any():  # NEXT_STEP: these did not take this step
            self._restart(anew)
            rewards[anew], terminated[anew], truncated[anew] = 0.0, False, False
        self._over = terminated | truncated
        everyone = np.ones(self.num_envs, dtype=bool)
        if not self._over.any() or self.autoreset_mode is not AutoresetMode.SAME_STEP:
            return self._seen(), rewards, terminated, truncated, self._info(everyone)
        over, last, final = self._over, self._seen(), self._info(self._over)
        self._restart(over)
        self._over = np.zeros(self.num_envs, dtype=bool)
        kept = np.full(self.num_envs, None, dtype=object)
        for team in np.flatnonzero(over).tolist():
            kept[team] = last[team]
        ended = {"final_obs": kept, "_final_obs": over, "final_info": final, "_final_info": over}
        return self._seen(), rewards, terminated, truncated, self._info(everyone) | ended

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return the arenas from above, a (360, 560, 3) array each; None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(self._pictures.of(team) for team in range(self.num_envs))

    def _restart(self, which: Flags) -> None:
        chosen = np.flatnonzero(which)
        self.teams.restart(chosen, [episode_seed(self._streams[team]) for team in chosen.tolist()])

    def _seen(self) -> Singles:
        return self.teams.observe().astype(np.float32)

    def _info(self, which: Flags) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, values in self.teams.metrics().items():
            found[name], found[f"_{name}"] = np.where(which, values, 0.0), which.copy()
        return found
