"""B teams at a task, a step after the other: the core of every interface, by numpy alone.

An action is where a robot's look-ahead point is to go, ahead and to the left, in units of the top
speed: the command (v, ω) in units of 0.15 m/s and of 3 rad/s. It is held for one step of the
testbed, 0.033 s; a certificate changes what is unsafe, and the arena drives. Without a certificate
robots may meet, which is counted.

Teams begin anew one by one. In the ideal arena a team's columns are written over. Where something
has a past that cannot be (motors and random numbers under a realism profile, a certificate that
predicts or watches for deadlocks), teams which begin at one moment get an arena of their own, a
*cohort*; of it, those that have begun anew since only stand there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates import ties
from barrier_certificates.batch import BatchCertificate, Engine
from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE
from posflock_robotarium.flocking.goal_view import LOOK_AHEAD
from posflock_robotarium.learning.scenario import Flags, Floats, Initial, Scenario, World
from rps_compat.batch import BatchArena
from rps_compat.realism import Profile
from rps_compat.testbed import GRITSBOT_X, RobotModel

__all__ = ["CERTIFIED", "StepOutcome", "TeamSettings", "Teams"]

Indices = NDArray[np.intp]

#: What keeps robots apart as by default: what the nine robots fly with.
CERTIFIED = replace(EXPERIMENT_CERTIFICATE, time_step=GRITSBOT_X.time_step)


@dataclass(frozen=True)
class TeamSettings:
    """Where teams drive, and who watches over them.

    Attributes
    ----------
    certificate : UnicycleCertificate, optional
        What keeps robots apart and inside; None lets them do as they are told.
    realism : Profile, optional
        Imperfections of motors and tracking; None is the ideal arena.
    initial : callable, optional
        Where robots start, instead of as the scenario has it: from their number and a Generator
        to poses (3, N), m and rad.
    speed : float
        What an action of 1 means, m/s.
    robot : RobotModel
        The robots, their arena, and the time step.
    engine : {"auto", "numba", "numpy"}
        Who computes; ``"auto"`` is compiled where numba is installed.
    threads : int, optional
        How many parts of the teams are computed side by side at most; one for each processor if
        None.

    Raises
    ------
    ParameterError
        Where the speed is none.
    """

    certificate: UnicycleCertificate | None = CERTIFIED
    realism: Profile | None = None
    initial: Initial | None = None
    speed: float = 0.15
    robot: RobotModel = GRITSBOT_X
    engine: Engine = "auto"
    threads: int | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.speed < np.inf:
            raise ParameterError(f"speed: expected more than 0 m/s, got {self.speed!r}")

    @property
    def has_a_past(self) -> bool:
        """Whether motors or certificate remember earlier steps of a team."""
        watched = self.certificate
        remembers = watched is not None and (watched.answers_late or watched.deadlock is not None)
        return self.realism is not None or remembers


@dataclass(frozen=True, eq=False)
class StepOutcome:
    """What a step was worth.

    Attributes
    ----------
    rewards : (B, N) array
        To each robot.
    terminated : (B,) boolean array
        Teams that have done what there was to do.
    truncated : (B,) boolean array
        Teams that have not, and whose time is over.
    intervention : (B,) array
        How far the certificate changed a velocity at most, m/s; 0 without one.
    """

    rewards: Floats
    terminated: Flags
    truncated: Flags
    intervention: Floats


class Teams:
    """B teams at one task.

    Parameters
    ----------
    scenario : Scenario
        What robots are to do, how many they are, and what they see.
    teams : int
        How many, B.
    settings : TeamSettings, optional
        Where they drive; certified, in the ideal arena, by default.

    Attributes
    ----------
    world : World
        All teams now.

    Raises
    ------
    ParameterError
        Where there are no teams.

    Examples
    --------
    >>> from posflock_robotarium.learning.scenarios.navigation import Navigation
    >>> teams = Teams(Navigation(robots=4), 2, TeamSettings(engine="numpy"))
    >>> teams.reset([0, 1]).shape
    (2, 4, 13)
    >>> outcome = teams.step(np.zeros((2, 4, 2)))
    >>> outcome.rewards.shape, bool(outcome.terminated.any())
    ((2, 4), False)
    """

    def __init__(
        self, scenario: Scenario, teams: int, settings: TeamSettings | None = None
    ) -> None:
        if teams < 1:
            raise ParameterError(f"teams: expected one at least, got {teams!r}")
        self.scenario, self.teams = scenario, teams
        self.settings = settings or TeamSettings()
        self._cohorts: list[_Cohort] = []
        self._world: World | None = None

    @property
    def world(self) -> World:
        """All teams now.

        Raises
        ------
        ParameterError
            Before the first `reset`.
        """
        if self._world is None:
            raise ParameterError("teams have not begun: expected reset(seeds) first")
        return self._world

    def reset(self, seeds: Sequence[int]) -> Floats:
        """Let all teams begin anew; return what is seen.

        Parameters
        ----------
        seeds : sequence of B int
            What each team's start and imperfections are drawn from.

        Returns
        -------
        (B, N, D) array
            What each robot sees.

        Raises
        ------
        ParameterError
            Where there are not as many seeds as teams, or initial poses are none.
        """
        begun = self._begin(seeds, self.teams)
        poses = begun.pop("poses").astype(float)
        self._cohorts = [_Cohort(np.arange(self.teams), poses, seeds, self.settings)]
        seen = self._cohorts[0].arena.observe().copy()
        actions = np.zeros((self.teams, self.scenario.robots, 2))
        step = self.settings.robot.time_step
        self._world = World(
            seen, poses.copy(), poses.copy(), actions, np.zeros(self.teams), step, begun
        )
        return self.observe()

    def restart(self, teams: ArrayLike, seeds: Sequence[int]) -> Floats:
        """Let some teams begin anew; return what all see.

        Parameters
        ----------
        teams : (K,) array
            Which teams.
        seeds : sequence of K int
            What each of them is drawn from.

        Returns
        -------
        (B, N, D) array
            What each robot sees.

        Raises
        ------
        ParameterError
            Where there are not as many seeds as teams that begin anew.
        """
        world, chosen = self.world, np.asarray(teams, dtype=np.intp)
        begun = self._begin(seeds, chosen.size)
        poses = begun.pop("poses").astype(float)
        if not self.settings.has_a_past:
            self._cohorts[0].arena.restart(chosen, poses)
            seen = poses
        else:
            for cohort in self._cohorts:
                cohort.leave(chosen)
            fresh = _Cohort(chosen, poses, seeds, self.settings)
            self._cohorts = [c for c in self._cohorts if c.present.any()] + [fresh]
            seen = fresh.arena.observe()
        world.poses[chosen], world.true_poses[chosen], world.before[chosen] = seen, poses, poses
        world.actions[chosen], world.time[chosen] = 0.0, 0.0
        for name, values in begun.items():
            world.memory[name][chosen] = values
        return self.observe()

    def observe(self) -> Floats:
        """Return what each robot sees now, (B, N, D) array.

        Raises
        ------
        ParameterError
            Where the scenario's arrays are of another shape than it says.
        """
        seen = self.scenario.observe(self.world)
        expected = (self.teams, self.scenario.robots, self.scenario.observation_size)
        if seen.shape != expected:
            raise ParameterError(
                f"{type(self.scenario).__name__}.observe: expected an array of shape {expected},"
                f" got {seen.shape}"
            )
        return seen

    def metrics(self) -> dict[str, Floats]:
        """Return how each team fares, dict of (B,) arrays: the scenario's words, and its safety.

        ``collisions`` and ``outside`` are steps that began with a pair too close, or with a robot
        outside of the arena.
        """
        found = dict(self.scenario.metrics(self.world))
        found["collisions"], found["outside"] = np.zeros((2, self.teams))
        for cohort in self._cohorts:
            violations, here = cohort.arena.violations, cohort.present
            found["collisions"][cohort.teams[here]] = violations.close_steps[here]
            found["outside"][cohort.teams[here]] = violations.outside_steps[here]
        return found

    def step(self, actions: ArrayLike) -> StepOutcome:
        """Do as told for one step of the testbed.

        Parameters
        ----------
        actions : (B, N, 2) array
            Ahead and left, cut at -1 and 1.

        Raises
        ------
        ParameterError
            Where actions have another shape, or are not finite. Nobody has moved then.
        """
        world = self.world
        wished = np.asarray(actions, dtype=float)
        if wished.shape != world.actions.shape or not np.isfinite(wished).all():
            raise ParameterError(
                f"actions: expected finite numbers of shape {world.actions.shape}, ahead and left"
                f" for each robot of each team, got shape {wished.shape}"
            )
        world.actions[...] = np.clip(wished, -1.0, 1.0)
        world.before[...] = world.true_poses
        ahead, left = np.moveaxis(world.actions, 2, 0)
        commands = self.settings.speed * np.stack([ahead, left / LOOK_AHEAD], axis=1)
        intervention = np.zeros(self.teams)
        for cohort in self._cohorts:
            cohort.step(commands, world, intervention)
        world.time += world.time_step
        self.scenario.advance(world)
        terminated = self.scenario.done(world)
        over: Flags = ties.reached(world.time, self.scenario.duration)
        rewards = self.scenario.reward(world)
        return StepOutcome(rewards, terminated, over & ~terminated, intervention)

    def _begin(self, seeds: Sequence[int], teams: int) -> dict[str, Floats]:
        """Return what scenarios of these seeds begin with, stacked."""
        if len(seeds) != teams:
            raise ParameterError(f"seeds: expected {teams}, one for each team, got {len(seeds)}")
        initial = self.settings.initial
        begun = [self.scenario.begin(np.random.default_rng(seed), initial) for seed in seeds]
        expected = (3, self.scenario.robots)
        for one in begun:
            if one["poses"].shape != expected or not np.isfinite(one["poses"]).all():
                raise ParameterError(
                    f"initial poses: expected finite numbers of shape {expected}, got shape"
                    f" {one['poses'].shape}"
                )
        return {name: np.stack([one[name] for one in begun]) for name in begun[0]}


class _Cohort:
    """Teams that began at one moment, in one arena."""

    def __init__(
        self, teams: Indices, poses: Floats, seeds: Sequence[int], settings: TeamSettings
    ) -> None:
        self.teams = teams
        self.present = np.ones(teams.size, dtype=bool)
        engine, threads = settings.engine, settings.threads
        chance = [np.random.default_rng([seed, 1]) for seed in seeds]
        self.arena = BatchArena(
            poses,
            settings.robot,
            realism=settings.realism,
            seeds=chance,
            engine=engine,
            threads=threads,
        )
        self.certificate: BatchCertificate | None = None
        if settings.certificate is not None:
            self.certificate = BatchCertificate(
                settings.certificate, engine=engine, threads=threads
            )

    def leave(self, teams: Indices) -> None:
        """Forget teams that begin anew elsewhere."""
        self.present &= ~np.isin(self.teams, teams)

    def step(self, commands: Floats, world: World, intervention: Floats) -> None:
        """Drive for one step, and write what became of it into the world."""
        here, teams = self.present, self.teams[self.present]
        wished = np.where(here[:, None, None], commands[self.teams], 0.0)
        if self.certificate is not None:
            wished, info = self.certificate(wished, self.arena.observe())
            intervention[teams] = info.intervention[here]
        self.arena.commands = wished
        self.arena.step()
        world.true_poses[teams] = self.arena.poses[here]
        world.poses[teams] = self.arena.observe()[here]
