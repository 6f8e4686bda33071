"""Each metric on flocks whose answer is known without computing it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from posflock_robotarium.alignment import metrics
from posflock_robotarium.flocking.errors import ParameterError

SQUARE = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]])


def test_parallel_agents_are_aligned_and_opposed_ones_are_not():
    parallel = np.tile([[1.0], [2.0]], (1, 4))
    assert metrics.alignment(parallel, SQUARE, 9.0).gamma == pytest.approx(1.0)
    opposed = parallel * [1, -1, 1, -1]
    # Each agent has one neighbour with it and two against it.
    assert metrics.alignment(opposed, SQUARE, 9.0).gamma == pytest.approx(-1 / 3)


def test_alignment_hears_neighbours_only():
    opposed = np.array([[1.0, 1.0, -1.0, -1.0], [0.0] * 4])
    apart = np.array([[0.0, 0.1, 9.0, 9.1], [0.0] * 4])
    assert metrics.alignment(opposed, apart, 1.0).gamma == pytest.approx(1.0)


def test_agents_without_direction_or_neighbours_are_left_out():
    v = np.array([[1.0, 1.0, 0.0, 1.0], [0.0] * 4])
    p = np.array([[0.0, 0.1, 0.2, 50.0], [0.0] * 4])
    found = metrics.alignment(v, p, 1.0)
    assert found.gamma == pytest.approx(1.0)
    assert found.counted == 2
    nobody = metrics.alignment(0 * v, p, 1.0)
    assert math.isnan(nobody.gamma)
    assert nobody.counted == 0
    assert metrics.alignment(v * 1e-3, p, 1.0, slowest=0.01).counted == 0


@given(st.integers(0, 2**32 - 1), st.integers(1, 9), st.floats(0.1, 10.0))
def test_gamma_is_a_mean_cosine(seed, n, radius):
    rng = np.random.default_rng(seed)
    v, p = rng.normal(size=(2, 5, 2, n))
    found = metrics.alignment(v, p, radius)
    known = found.gamma[~np.isnan(found.gamma)]
    assert ((known >= -1.0) & (known <= 1.0)).all()
    assert np.array_equal(np.isnan(found.gamma), found.counted == 0)
    # Direction alone counts.
    assert_allclose(metrics.alignment(3.7 * v, p, radius).gamma, found.gamma, atol=1e-12)


def test_distances_of_a_square():
    assert metrics.nearest_neighbour_distance(SQUARE) == pytest.approx(1.0)
    assert metrics.smallest_distance(SQUARE) == pytest.approx(1.0)
    assert metrics.cohesive_radius(SQUARE) == pytest.approx(math.sqrt(0.5))
    spread = [1.0, math.sqrt(2)]
    variance = np.var(np.repeat(spread, [4, 2]))
    assert metrics.pairwise_distance_variance(SQUARE) == pytest.approx(variance)
    assert metrics.wall_distance(SQUARE, (-1.0, 3.0, -2.0, 1.5)) == pytest.approx(0.5)
    assert metrics.wall_distance(SQUARE, (-1.0, 0.9, -2.0, 1.5)) == pytest.approx(-0.1)


def test_a_rigid_motion_changes_no_pairwise_distance():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    assert metrics.pairwise_change_variance(turn @ SQUARE + 3.0, SQUARE) == pytest.approx(0.0)
    grown = metrics.pairwise_change_variance(2 * SQUARE, SQUARE)
    assert grown == pytest.approx(metrics.pairwise_distance_variance(SQUARE))


def test_groups_are_counted():
    p = np.array([[0.0, 0.5, 1.0, 5.0, 5.5], [0.0] * 5])
    assert metrics.connected_components(np.stack([p, 10 * p]), 0.6).tolist() == [2, 5]
    assert metrics.connected_components(p, np.array([0.1, 0.1, 0.6, 0.1, 0.1])) == 4


def test_fastest_wheel_is_the_outer_one():
    wheel = (0.15 + 0.55 * 0.0525) / 0.016
    assert metrics.fastest_wheel([[0.1, -0.15], [0.0, 0.55]], 0.016, 0.105) == pytest.approx(wheel)


def test_velocities_of_a_straight_line_are_exact_by_both_estimators():
    t = 0.033 * np.arange(40)
    track = np.stack([np.outer(t, [0.1, -0.2]), np.outer(t, [0.0, 0.05])], axis=1)
    expected = np.tile([[0.1, -0.2], [0.0, 0.05]], (40, 1, 1))
    assert_allclose(metrics.velocities_by_differences(track, 0.033), expected, atol=1e-12)
    assert_allclose(metrics.smoothed_velocities(track, 0.033), expected, atol=1e-12)


def test_smoothing_restores_directions_that_differences_lose():
    """The testbed's tracking jitter: 0.47 mm along the track at 0.05 m/s."""
    rng = np.random.default_rng(0)
    t = 0.033 * np.arange(600)
    straight = np.stack([np.outer(t, np.full(9, 0.05)), np.zeros((600, 9))], axis=1)
    straight[:, 1] += np.linspace(0, 2, 9)
    tracked = straight + rng.normal(scale=0.0005, size=straight.shape)
    raw = metrics.alignment(metrics.velocities_by_differences(tracked, 0.033), tracked, 9.0)
    smooth = metrics.alignment(metrics.smoothed_velocities(tracked, 0.033), tracked, 9.0)
    assert smooth.gamma.mean() > 0.999
    assert raw.gamma.mean() < 0.93


@pytest.mark.parametrize(
    "call",
    [
        lambda: metrics.alignment(np.zeros(3), np.zeros(3), 1.0),
        lambda: metrics.alignment(np.ones((2, 3)), np.ones((2, 4)), 1.0),
        lambda: metrics.smoothed_velocities(np.zeros((5, 2, 3)), 0.1),
        lambda: metrics.smoothed_velocities(np.zeros((50, 2, 3)), 0.1, points=4),
        lambda: metrics.pairwise_distance_variance(np.zeros((2, 1))),
    ],
)
def test_wrong_shapes_are_named(call):
    with pytest.raises(ParameterError, match="expected"):
        call()


def test_algebraic_connectivity_of_many_agents_is_that_of_the_whole_matrix():
    rng = np.random.default_rng(3)
    p = rng.uniform(-2.0, 2.0, (3, 2, 210))
    p[1, :, 7] = np.nan
    p[2, 0, :50] += 9.0  # these have left
    links = np.linalg.norm(p[:, :, None, :] - p[:, :, :, None], axis=1) < 0.8
    links[:, range(210), range(210)] = False
    laplacians = -links.astype(float)
    laplacians[:, range(210), range(210)] = links.sum(axis=2)
    values = np.linalg.eigvalsh(laplacians)
    expected = [values[0, 1], values[1, 2], 0.0]
    assert_allclose(metrics.algebraic_connectivity(p, 0.8), expected, atol=1e-9)
    assert min(expected[:2]) > 0.1


@pytest.mark.parametrize("points", [3, 5, 11])
def test_smoothing_follows_a_quadratic_to_both_ends(points):
    t = 0.05 * np.arange(points + 6)
    track = np.stack([1 + 2 * t - 3 * t**2, 0.5 * t**2])[:, np.newaxis].transpose(2, 0, 1)
    expected = np.stack([2 - 6 * t, t])[:, np.newaxis].transpose(2, 0, 1)
    assert_allclose(metrics.smoothed_velocities(track, 0.05, points), expected, atol=1e-12)


@pytest.mark.parametrize("agents", [7, 230])
def test_gamma_without_each_agent_is_that_of_the_others(agents):
    """Counted from what each means to its neighbours, in a flock some of which nobody sees."""
    rng = np.random.default_rng(agents)
    side = np.sqrt(agents / 2)
    p, v = rng.uniform(0, side, (3, 2, agents)), rng.standard_normal((3, 2, agents))
    p[:, :, 2] = v[:, :, 2] = np.nan
    v[:, :, 4] = 1e-3
    found = metrics.alignment_without_each(v, p, 1.0, slowest=0.01)
    for n in range(0, agents, 1 + agents // 7):
        left = v.copy()
        left[:, :, n] = np.nan
        there = metrics.alignment(left, p, 1.0, slowest=0.01).gamma
        np.testing.assert_allclose(found[:, n], there, atol=1e-12)
