"""Environments for learners: their libraries' own tests; many teams are many single ones."""

import sys
import warnings

import numpy as np
import pytest

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.learning.scenarios.flocking import Flocking
from posflock_robotarium.learning.scenarios.navigation import Navigation
from posflock_robotarium.learning.scenarios.predator_prey import PredatorPrey
from posflock_robotarium.learning.teams import Teams, TeamSettings
from rps_compat.profiles import load_profile

gymnasium = pytest.importorskip("gymnasium")
pettingzoo = pytest.importorskip("pettingzoo")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import SyncVectorEnv  # noqa: E402
from pettingzoo.test import parallel_api_test, parallel_seed_test  # noqa: E402

from posflock_robotarium.learning.parallel_env import TeamParallelEnv  # noqa: E402
from posflock_robotarium.learning.vector_env import TeamEnv, TeamVectorEnv  # noqa: E402

SCENARIOS = [
    Navigation(robots=4, duration=0.4),
    Flocking(robots=3, duration=0.4),
    PredatorPrey(prey=3, duration=0.4),
]
IDEAL = TeamSettings(engine="numpy")
REAL = TeamSettings(engine="numpy", realism=load_profile("gritsbot_x"))


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: type(s).__name__)
def test_the_libraries_own_tests_find_nothing(scenario):
    name = f"posflock/{type(scenario).__name__}-v0"
    gymnasium.register(name, TeamEnv, kwargs={"scenario": scenario, "settings": IDEAL})
    check_env(gymnasium.make(name, render_mode="rgb_array").unwrapped)
    parallel_api_test(TeamParallelEnv(scenario, IDEAL), num_cycles=30)
    parallel_seed_test(lambda: TeamParallelEnv(scenario, REAL), num_cycles=15)


@pytest.mark.parametrize(
    ("settings", "mode"), [(IDEAL, "NextStep"), (REAL, "SameStep")], ids=["ideal", "real"]
)
@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: type(s).__name__)
def test_many_teams_are_what_gymnasium_makes_of_single_ones(scenario, settings, mode):
    many = TeamVectorEnv(scenario, 3, settings, mode)
    single = SyncVectorEnv([lambda: TeamEnv(scenario, settings)] * 3, autoreset_mode=mode)
    assert many.metadata["autoreset_mode"] == single.metadata["autoreset_mode"]
    assert many.observation_space == single.observation_space
    assert many.action_space == single.action_space
    rng = np.random.default_rng(0)
    (seen, info), (other, told) = many.reset(seed=5), single.reset(seed=5)
    for step in range(30):
        np.testing.assert_allclose(seen, other, atol=1e-6)
        assert set(info) == set(told)
        for name in told:
            if name not in ("final_obs", "final_info"):
                np.testing.assert_allclose(info[name], told[name], atol=1e-6)
            elif name == "final_obs":
                for ours, theirs in zip(info[name], told[name], strict=True):
                    assert (ours is None) == (theirs is None)
                    assert ours is None or np.allclose(ours, theirs, atol=1e-6)
            else:
                assert set(info[name]) == set(told[name])
        if step == 7:  # teams out of step with each other
            for env in (many.teams, *(single.envs[k].teams for k in (1,))):
                env.world.time[1 if env is many.teams else 0] += 0.2
        actions = rng.uniform(-1, 1, many.action_space.shape).astype(np.float32)
        seen, *outcome, info = many.step(actions)
        other, *expected, told = single.step(actions)
        for ours, theirs in zip(outcome, expected, strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-6)


def test_without_autoreset_who_is_over_waits_to_be_reset():
    env = TeamVectorEnv(Navigation(robots=2, duration=0.1), 2, IDEAL, "Disabled")
    env.reset(seed=0)
    env.teams.world.time[0] += 0.05
    actions = np.zeros(env.action_space.shape, dtype=np.float32)
    truncated = np.zeros(2, dtype=bool)
    while not truncated.any():
        _, _, _, truncated, _ = env.step(actions)
    assert truncated.tolist() == [True, False]
    with pytest.raises(ParameterError, match=r"teams \[0\] are over"):
        env.step(actions)
    _, info = env.reset(options={"reset_mask": truncated})
    assert info["_arrived"].tolist() == [True, False]
    assert env.teams.world.time.tolist() == [0.0, pytest.approx(0.066)]
    with pytest.raises(ParameterError, match="booleans"):
        env.reset(options={"reset_mask": np.zeros(2, dtype=bool)})


def test_a_certificate_keeps_apart_whom_chance_would_let_collide():
    def collisions(certificate):
        settings = TeamSettings(certificate=certificate, engine="numpy")
        teams = Teams(Navigation(robots=4, duration=8.0), 2, settings)
        seen = teams.reset([1, 2])
        for _ in range(240):
            teams.step(seen[..., :2])
            seen = teams.observe()
        return teams.metrics()["collisions"].sum()

    assert collisions(TeamSettings().certificate) == 0
    assert collisions(None) > 0


def test_pictures_show_robots_and_goals_where_they_are():
    env = TeamVectorEnv(Navigation(robots=2), 2, IDEAL, render_mode="rgb_array")
    env.reset(seed=0)
    first, second = env.render()
    assert first.shape == (360, 560, 3)
    assert first.dtype == np.uint8
    assert (first != second).any()
    blue = (first[..., 2] > 150) & (first[..., 0] < 60)  # the robots' colour
    assert blue.sum() > 2 * 100
    assert TeamVectorEnv(Navigation(robots=2), 1, IDEAL).render() is None
    with pytest.raises(ParameterError, match="rgb_array"):
        TeamEnv(Navigation(robots=2), IDEAL, "human")


@pytest.mark.parametrize(
    ("module", "missing"),
    [("vector_env", "gymnasium"), ("parallel_env", "pettingzoo"), ("parallel_env", "gymnasium")],
)
def test_without_its_library_an_interface_names_the_extra(module, missing, monkeypatch):
    for name in list(sys.modules):
        if name.partition(".")[0] == missing or name.endswith(("vector_env", "parallel_env")):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(ImportError, match=r"pip install 'posflock-robotarium\[learn\]'"):
        __import__(f"posflock_robotarium.learning.{module}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Teams(Navigation(robots=2), 1, IDEAL).reset([0]).shape == (1, 2, 13)
