"""Scenarios say what they promise; what a search finds travels as numbers and does as it did."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.goal_view import goal_view, look_ahead_points, swapped_places
from posflock_robotarium.learning.evolution import EvolutionSettings, evolve
from posflock_robotarium.learning.learning_curve import draw_learning_curve
from posflock_robotarium.learning.policy_files import read_policy, save_training
from posflock_robotarium.learning.scenarios.flocking import Flocking
from posflock_robotarium.learning.scenarios.navigation import Navigation
from posflock_robotarium.learning.scenarios.predator_prey import PredatorPrey
from posflock_robotarium.learning.teams import Teams, TeamSettings
from posflock_robotarium.learning.training import (
    evaluate,
    held_out_seeds,
    straight_to_goals,
    train,
)
from posflock_robotarium.new_script import ExperimentKind, write_script

NUMPY = TeamSettings(engine="numpy")


# --- What a robot sees ---------------------------------------------------------------------------


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0))
def test_what_is_seen_does_not_depend_on_where_north_is(seed, angle):
    start, goals = swapped_places(6, np.random.default_rng(seed))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = np.vstack([turn @ start[:2], start[2] + angle])
    np.testing.assert_allclose(goal_view(turned, turn @ goals), goal_view(start, goals), atol=1e-9)


def test_what_is_seen_by_hand():
    poses = np.array([[0.0, 0.3], [0.0, 0.0], [0.0, np.pi / 2]])  # one looks east, one north
    points = look_ahead_points(poses)
    np.testing.assert_allclose(points, [[0.05, 0.3], [0.0, 0.05]])
    seen = goal_view(poses, points + np.array([[0.0, -0.6], [0.15, 0.0]]))
    np.testing.assert_allclose(seen[0, :3], [0.0, 0.5, 0.15], atol=1e-12)  # left, half of 0.3 m
    np.testing.assert_allclose(seen[1, :3], [0.0, 1.0, 0.6], atol=1e-12)  # west is left of north
    # The other is 0.25 m ahead and 0.05 m to the left of one, and behind and left of the other.
    bearing, weight = np.arctan2(0.05, 0.25), 1.0 - np.hypot(0.25, 0.05) / 0.6
    for robot, angle in ((0, bearing), (1, bearing + np.pi / 2)):
        kinds = (1.0, np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle))
        np.testing.assert_allclose(seen[robot, 3:8], weight * np.array(kinds), atol=1e-12)


# --- Scenarios -----------------------------------------------------------------------------------


def test_prey_is_captured_only_after_it_was_found():
    scenario = PredatorPrey(sensing=1, capture=1, prey=1)
    far = np.array([[-1.2, -0.8], [0.0, 0.0], [0.0, 0.0]])
    teams = Teams(scenario, 2, TeamSettings(engine="numpy", initial=lambda n, rng: far))
    teams.reset([0, 1])
    memory = teams.world.memory
    memory["prey"][0] = [[-0.75], [0.05]]  # in reach of the capture robot, out of the other's sight
    memory["prey"][1] = [[-0.93], [0.0]]  # in sight, and in reach of the other
    outcome = teams.step(np.zeros((2, 2, 2)))
    assert memory["found"].tolist() == [[False], [True]]
    assert memory["captured"].tolist() == [[False], [True]]
    assert outcome.terminated.tolist() == [False, True]
    assert outcome.rewards[:, 0] == pytest.approx([-0.05 * 0.033, 6.0 - 0.05 * 0.033])
    memory["prey"][0] = [[-0.93], [0.0]]  # now both
    assert teams.step(np.zeros((2, 2, 2))).terminated.tolist() == [True, True]
    assert teams.metrics()["captured"].tolist() == [1.0, 1.0]


def test_flocking_rewards_going_one_way_and_knows_gamma():
    aligned = np.array([[-0.5, 0.0, 0.5], [0.0, 0.1, 0.0], [0.0, 0.0, 0.0]])
    apart = aligned + np.array([[0.0], [0.0], [1.0]]) * [0.0, 2.0, 4.0]
    found = {}
    for name, start in (("aligned", aligned), ("apart", apart)):
        teams = Teams(
            Flocking(robots=3), 1, dataclasses.replace(NUMPY, initial=lambda n, rng, s=start: s)
        )
        teams.reset([0])
        reward = teams.step(np.tile([1.0, 0.0], (1, 3, 1))).rewards.mean()
        found[name] = (reward, teams.metrics()["gamma"][0])
    assert found["aligned"][0] == pytest.approx(0.15 * 0.033)
    assert found["aligned"][1] == pytest.approx(1.0)
    assert found["apart"][0] < 0.5 * found["aligned"][0]
    assert found["apart"][1] < 0.1


def test_navigation_notes_when_robots_came_to_stay():
    teams = Teams(Navigation(robots=2), 1, NUMPY)
    teams.reset([0])
    world = teams.world
    world.memory["goals"][0] = look_ahead_points(world.true_poses)[0]
    teams.step(np.zeros((1, 2, 2)))
    assert teams.metrics()["time"] == pytest.approx([0.033])
    world.memory["goals"][0, 0, 1] += 1.0  # one is away again
    assert not teams.step(np.zeros((1, 2, 2))).terminated.any()
    assert teams.metrics()["time"] == pytest.approx([(0.033 + 30.0) / 2])


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Navigation(robots=3),
        lambda: Navigation(duration=0.0),
        lambda: Flocking(robots=1),
        lambda: PredatorPrey(prey=0),
        lambda: EvolutionSettings(pairs=0),
        lambda: TeamSettings(speed=float("nan")),
        lambda: Teams(Navigation(), 0),
        lambda: Teams(Navigation(), 1).step(np.zeros((1, 8, 2))),
        lambda: Teams(Navigation(robots=2), 2, NUMPY).reset([0]),
        lambda: Teams(
            Navigation(), 1, TeamSettings(initial=lambda n, rng: np.zeros((3, n + 1)))
        ).reset([0]),
        lambda: swapped_places(40, np.random.default_rng(0)),
        lambda: evolve(lambda x, k: x[:, 0] * np.nan, [0.0], EvolutionSettings(1)),
    ],
)
def test_what_makes_no_sense_is_refused(wrong):
    with pytest.raises(ParameterError, match=r"expected|fit"):
        wrong()


# --- Search, files, flight -----------------------------------------------------------------------


def test_a_search_is_the_same_from_the_same_seed_and_climbs():
    def hill(vectors, generation):
        return -np.abs(vectors - [1.0, -2.0, 0.5]).sum(axis=1)

    first, again, other = (
        evolve(hill, np.zeros(3), EvolutionSettings(60, seed=s)) for s in (3, 3, 4)
    )
    np.testing.assert_array_equal(first.vector, again.vector)
    assert (first.vector != other.vector).any()
    np.testing.assert_allclose(first.vector, [1.0, -2.0, 0.5], atol=0.35)
    assert first.scores[-1] > first.scores[0] + 2.0


def test_a_policy_travels_as_numbers(tmp_path):
    search = EvolutionSettings(generations=2, pairs=2)
    scenario = Navigation(robots=2, duration=0.3)
    training = train(scenario, search, settings=NUMPY, episodes=2, hidden=(3,))
    assert training.policy.sizes == (13, 3, 2)
    files = save_training(training, tmp_path, "mine", draw_learning_curve(training.evolution, 0.1))
    assert [file.name for file in files] == [
        "mine_weights.npy", "mine_training.npz", "mine_curve.png",
    ]  # fmt: skip
    seen = np.random.default_rng(0).normal(size=(4, 13))
    for file in files[:2]:
        np.testing.assert_array_equal(read_policy(file).act(seen), training.policy.act(seen))
    with np.load(files[1]) as archive:
        assert archive["generations"] == 2
        np.testing.assert_array_equal(archive["scores"], training.evolution.scores)
    with pytest.raises(ParameterError, match="takes 13 numbers"):
        training.policy.act(seen[:, :5])
    np.save(tmp_path / "other.npy", np.zeros(3))
    with pytest.raises(ParameterError, match="policy"):
        read_policy(tmp_path / "other.npy")
    (tmp_path / "cut.npy").write_bytes(files[0].read_bytes()[:150])
    with pytest.raises(ParameterError, match="cannot be read"):
        read_policy(tmp_path / "cut.npy")


def test_the_weights_that_come_along_are_as_good_as_it_says(tmp_path):
    script, *_ = write_script("mine", ExperimentKind.POLICY, tmp_path)
    policy = read_policy(script.with_name("mine_weights.npy"))
    found = evaluate(Navigation(duration=20.0), policy.act, held_out_seeds(3), NUMPY)
    assert found["arrived"].tolist() == [1.0, 1.0, 1.0]
    assert found["time"].mean() < 14.0
    assert found["collisions"].sum() == 0


@pytest.mark.slow
def test_training_anew_from_the_seed_reaches_the_stated_score(tmp_path):
    script, *_ = write_script("mine", ExperimentKind.POLICY, tmp_path)
    command = [sys.executable, "mine_train.py", "-o", "again"]
    told = subprocess.run(command, cwd=script.parent, capture_output=True, text=True, check=True)
    assert "generation 100 of 100" in told.stdout
    policy = read_policy(script.parent / "again" / "mine_weights.npy")
    trained = evaluate(Navigation(), policy.act, held_out_seeds(100))
    straight = evaluate(Navigation(), straight_to_goals, held_out_seeds(100))
    assert trained["arrived"].mean() > 0.98
    assert trained["time"].mean() < 0.7 * straight["time"].mean()
    assert trained["collisions"].sum() == 0
