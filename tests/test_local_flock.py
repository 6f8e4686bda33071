"""Robots that decide by what they sense and hear: nobody else counts, and all agree."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.batch.batch_flock import BatchFlock
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock, told_walls
from posflock_robotarium.flocking.law import LawParameters
from posflock_robotarium.flocking.local_steering import (
    LocalSteering,
    LocalSteeringParameters,
    Message,
)
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.flocking.steering import SteeringParameters
from posflock_robotarium.simulation.flock_trial import simulate

ARENA, MARGIN, STEP = (-1.6, 1.6, -1.0, 1.0), 0.1, 0.05
EARLY = LocalSteeringParameters(start=0.05)
SEEDS = st.integers(0, 2**32 - 1)


def steering(parameters=EARLY):
    return LocalSteering(parameters, ARENA, MARGIN, STEP)


def connected(rng, number):
    """Return a random connected graph: a tree in random order, and some links more."""
    linked = rng.random((number, number)) < 0.15
    order = rng.permutation(number)
    for k in range(1, number):
        linked[order[k], order[rng.integers(k)]] = True
    linked |= linked.T
    np.fill_diagonal(linked, False)
    return linked


@settings(max_examples=10)
@given(SEEDS, st.integers(2, 9))
def test_the_mean_of_the_estimates_is_the_mean_of_the_values(seed, number):
    """While values and links change; and once they stay, every estimate comes to the mean."""
    at_once = LocalSteeringParameters(smoothing=STEP)
    rng, kept, middle = np.random.default_rng(seed), steering(at_once), np.zeros((2, number))
    for _ in range(5):
        velocities, inputs = rng.normal(size=(2, 2, number))
        kept.steer(1.0, middle, inputs, velocities, connected(rng, number))
        assert_allclose(kept.sent.velocity.mean(axis=1), velocities.mean(axis=1), atol=1e-12)
    linked = connected(rng, number)
    for _ in range(400):
        kept.steer(1.0, middle, inputs, velocities, linked)
    assert_allclose(kept.sent.velocity.T, np.tile(velocities.mean(axis=1), (number, 1)), atol=1e-4)
    assert_allclose(kept.sent.input.T, np.tile(inputs.mean(axis=1), (number, 1)), atol=1e-4)


@given(SEEDS, st.integers(2, 9))
def test_whatever_robots_said_they_soon_agree_to_go_straight(seed, number):
    rng, kept = np.random.default_rng(seed), steering()
    linked, still = connected(rng, number), np.zeros((2, number))
    count = rng.integers(0, 9, number)
    kept.steer(1.0, still, still, still, linked)
    kept._sent = kept.sent._replace(turns=count)
    for _ in range(number):
        *_, turning = kept.steer(1.0, still, still, still, linked)
    assert np.unique(kept.sent.turns).size == 1
    assert kept.sent.turns[0] % 3 == 0
    assert kept.sent.turns[0] >= count.max()
    assert not turning.any()


@given(SEEDS, st.integers(2, 9), st.booleans())
def test_robots_that_would_turn_to_either_side_agree_on_one(seed, number, mirrored):
    """All near a wall, all at once, each believing something else of where the flock goes."""
    rng, kept = np.random.default_rng(seed), steering()
    linked, still = connected(rng, number), np.zeros((2, number))
    near = np.stack([np.full(number, 1.45), np.linspace(-0.3, 0.3, number)])
    aside = rng.choice([-0.01, 0.01], number)
    velocities = np.stack([np.full(number, 0.05), aside])
    if mirrored:
        near[0], velocities[0] = -near[0], -velocities[0]
    turned = []
    for _ in range(number + 3):
        *_, turning = kept.steer(1.0, near, still, velocities, linked)
        turned.append(np.sign(turning))
    assert set(np.unique(turned[0])) <= {-1.0, 1.0}
    for signs in turned[number - 1 :]:  # a message goes around in number - 1 steps
        assert np.unique(signs).size == 1
        assert signs[0] == turned[-1][0] != 0.0
    if np.unique(turned[0]).size == 2:
        assert turned[-1][0] == 1.0  # left wins
    assert np.ptp(kept.sent.angle) < number * EARLY.turn_rate * STEP


def test_a_call_goes_around_and_ends():
    """Of nine in a row one is near a wall; all hear of it, and no longer once he has left."""
    kept, still = steering(), np.zeros((2, 9))
    chain = np.abs(np.subtract.outer(np.arange(9), np.arange(9))) == 1
    points = np.zeros((2, 9))
    points[0, 0] = -1.45
    for _ in range(9):
        kept.steer(1.0, points, still, still, chain)
    heard = kept.sent.call
    assert_allclose(heard[0], 0.13 - EARLY.fading * STEP * np.arange(9), atol=1e-12)
    assert not heard[1:].any()
    for _ in range(int(0.13 / (EARLY.fading * STEP)) + 2):
        kept.steer(1.0, np.zeros((2, 9)), still, still, chain)
    assert not kept.sent.call.any()


#: Nine in a crooked row near the right wall: who is at one end neither sees nor hears the other.
ROW = np.stack([
    np.array([1.35, 1.1, 1.3, 1.0, 1.2, 0.9, 0.6, 0.3, 0.05]),
    np.array([-0.8, -0.7, -0.5, -0.4, -0.2, 0.0, 0.1, 0.15, 0.3]),
    np.linspace(-1.0, 2.0, 9),
])  # fmt: skip
LAW = LawParameters(
    distance_scale=0.05, radius=0.45, persistence=0.15, speed_limit=0.15, input_limit=0.5
)


def last_step(robot=None, rng=None, steps=12):
    """Fly some steps and one more, before which all that is one robot's was changed."""
    flock = Flock(LAW, local=True, steering=SteeringParameters(start=0.1))
    poses = ROW.copy()
    for _ in range(steps):
        decided = flock.step(poses)
        v, w = decided.command
        poses = poses + 0.033 * np.stack([v * np.cos(poses[2]), v * np.sin(poses[2]), w])
    assert decided.turning != 0.0
    if robot is not None:
        poses[:, robot] += rng.normal(0, [0.3, 0.3, 1.0])
        flock._velocity[:, robot] = rng.normal(0, 0.1, 2)
        flock.filter._poses[:, robot] += rng.normal(0, 0.1, 3)
        flock._steering._sent = Message(*(np.array(told) for told in flock._steering.sent))
        for told in flock._steering.sent:
            told[..., robot] = rng.integers(0, 9) + (told.dtype.kind == "f") * rng.normal()
    links = flock.links
    command = flock.step(poses).command
    return command, links | flock.links


UNCHANGED = last_step()


@settings(max_examples=40)
@given(SEEDS, st.integers(0, 8))
def test_whom_a_robot_neither_sees_nor_hears_changes_nothing_that_it_does(seed, robot):
    before, seen = UNCHANGED
    after, seen_then = last_step(robot, np.random.default_rng(seed))
    others = np.arange(9) != robot
    unseen = others & ~seen[:, robot] & ~seen_then[:, robot]
    assume(unseen.any())
    assert_array_equal(after[:, unseen], before[:, unseen])
    neighbours = seen[:, robot] & seen_then[:, robot]
    if neighbours.any():  # and what is seen or heard does count
        assert (after[:, neighbours] != before[:, neighbours]).any()


def test_a_flock_of_such_robots_turns_at_walls_and_stays_aligned():
    """A minute of seed 1010, in which the flock meets a wall."""
    start = random_poses(9, np.random.default_rng(1010))
    flock = Flock(local=True)
    summary = summarise(simulate(flock, start, 60.0).log)
    assert summary.local is True
    assert "each robot by what it senses and hears" in str(summary)
    assert summary.gamma_motion >= 0.99
    assert summary.mean_speed >= 0.035
    assert (summary.collisions, summary.steps_outside, summary.steps_infeasible) == (0, 0, 0)
    assert flock._steering.sent.turns.max() >= 1


def test_logs_and_figures_say_that_it_was_so():
    told = Flock(local=True).parameters()
    assert told["local"] is True
    assert told["steering"]["smoothing"] == LocalSteeringParameters().smoothing
    assert told["wheels"]["decentralised"] is True
    assert told_walls(told).endswith("; each robot by what it senses and hears")
    assert told_walls(Flock().parameters()) == "arena steering, an addition to the paper's law"
    assert told_walls({}) == ""


def test_what_does_not_go_together_is_refused():
    short = LawParameters(0.05, 0.25, 0.15, 0.15, 0.5)
    with pytest.raises(ParameterError, match=r"see 0\.25 m .* reach 0\.\d+ m"):
        Flock(short, local=True)
    flock = Flock(local=True)
    with pytest.raises(ParameterError, match="local"):
        flock.retune(short, flock.model)
    assert flock.law.radius == 0.75
    with pytest.raises(ParameterError, match="flock: it is local"):
        BatchFlock(flock, 2)
    for name, value in (("smoothing", 0.0), ("fading", -1.0), ("onset", 0.18), ("band", 1.3)):
        with pytest.raises(ParameterError, match=name):
            LocalSteeringParameters(**{name: value})
