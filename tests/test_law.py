"""The law has the symmetries of the plane, and no input makes it NaN."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import (
    PAPER_EXPERIMENT,
    PAPER_SIMULATION,
    LawParameters,
    displacements,
    neighbours,
    phi,
    position_based_input,
    psi,
    saturate,
    velocity_based_input,
)

coordinates = st.floats(-20.0, 20.0, allow_subnormal=False)


@st.composite
def flocks(draw, dimensions=(2, 3), least=1):
    """Positions, first positions, velocities of one flock, and a time."""
    d = draw(st.sampled_from(dimensions))
    n = draw(st.integers(least, 8))
    states = [draw(arrays(float, (d, n), elements=coordinates)) for _ in range(3)]
    return (*states, draw(st.floats(0.01, 100.0)))


def both_inputs(p, first, v, t, parameters=PAPER_SIMULATION):
    return (
        velocity_based_input(p, v, parameters),
        position_based_input(p, displacements(first), t, parameters),
    )


def plain_inputs(p, first, v, t, q, threshold=True):
    """Compute the formulas as they are written, one agent at a time."""
    d, n = p.shape
    by_velocity, by_position = np.zeros((d, n)), np.zeros((d, n))
    for i in range(n):
        near = [j for j in range(n) if j != i and np.linalg.norm(p[:, j] - p[:, i]) < q.radius]
        k = len(near)
        gain = k / t if not threshold or t <= 1 / q.persistence else q.persistence * k
        for j in near:
            offset = p[:, j] - p[:, i]
            distance = np.linalg.norm(offset)
            pull = (1 - q.distance_scale * k / distance) * offset if distance > 0 else 0 * offset
            by_velocity[:, i] += pull + v[:, j] - v[:, i]
            by_position[:, i] += pull + gain * (offset - (first[:, j] - first[:, i]))
    return by_velocity, by_position


@given(flocks())
def test_inputs_are_the_papers_formulas(flock):
    p, first, v, t = flock
    for got, expected in zip(
        both_inputs(*flock), plain_inputs(p, first, v, t, PAPER_SIMULATION), strict=True
    ):
        assert_allclose(got, expected, rtol=1e-9, atol=1e-9 * (1 + 1 / t))


@given(flocks(), st.floats(-100, 100), st.floats(-100, 100))
def test_translation_changes_no_input(flock, x, y):
    p, first, v, t = flock
    # On a grid of 1/64 m sums are exact, so no neighbour changes by rounding.
    p, first, x, y = (np.round(64 * np.asarray(a)) / 64 for a in (p, first, x, y))
    shift = np.resize([x, y, x], (p.shape[0], 1))
    for got, expected in zip(
        both_inputs(p + shift, first + shift, v, t), both_inputs(p, first, v, t), strict=True
    ):
        assert_allclose(got, expected, atol=1e-9)


@given(flocks(dimensions=(2,)), st.sampled_from([1, 2, 3]))
def test_inputs_turn_with_the_plane(flock, quarters):
    p, first, v, t = flock
    turn = np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), quarters)
    for got, unturned in zip(
        both_inputs(turn @ p, turn @ first, turn @ v, t), both_inputs(p, first, v, t), strict=True
    ):
        assert_allclose(got, turn @ unturned, rtol=1e-9, atol=1e-9)


@given(st.floats(0, 2 * math.pi), st.integers(0, 2**32 - 1))
def test_inputs_turn_by_any_angle(angle, seed):
    rng = np.random.default_rng(seed)
    p, first, v = rng.uniform(-8, 8, (3, 2, 7))
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    for got, unturned in zip(
        both_inputs(turn @ p, turn @ first, turn @ v, 3.0),
        both_inputs(p, first, v, 3.0),
        strict=True,
    ):
        assert_allclose(got, turn @ unturned, rtol=1e-9, atol=1e-9)


@given(flocks(), st.randoms(use_true_random=False))
def test_agents_have_no_order(flock, random):
    p, first, v, t = flock
    order = list(range(p.shape[1]))
    random.shuffle(order)
    shuffled = both_inputs(p[:, order], first[:, order], v[:, order], t)
    for got, expected in zip(shuffled, both_inputs(*flock), strict=True):
        assert_allclose(got, expected[:, order], rtol=1e-9, atol=1e-9 * (1 + 1 / t))


@given(flocks(least=2))
def test_pairs_are_antisymmetric_where_neighbourhoods_are_equal(flock):
    """With everyone a neighbour of everyone, nothing moves the centroid."""
    p, first, v, t = flock
    everyone = LawParameters(0.3, 1e6, 0.1, 2.5, 5.0)
    for u in both_inputs(p, first, v, t, everyone):
        assert_allclose(u.sum(axis=1), 0.0, atol=1e-8 * (1 + np.abs(u).max()))


@given(flocks(), st.floats(1e-3, 1e3))
def test_saturation_keeps_direction_and_bound(flock, limit):
    x = flock[0]
    y = saturate(x, limit)
    length, shortened = np.linalg.norm(x, axis=0), np.linalg.norm(y, axis=0)
    assert (shortened <= limit * (1 + 1e-12)).all()
    assert (shortened <= length * (1 + 1e-12)).all()
    assert_allclose(x * shortened, y * length, atol=1e-9 * (1 + length.max()))
    assert_allclose(shortened, limit * np.tanh(length / limit), rtol=1e-9, atol=1e-15)
    assert np.array_equal(saturate(np.zeros((2, 3)), limit), np.zeros((2, 3)))


def leave_nan_in_memory(*shape):
    """Free arrays of NaN, which is where numpy puts the next ones of that size."""
    for array in [np.empty(shape) for _ in range(7)]:
        array.fill(math.nan)


@pytest.mark.parametrize("agents", [1, 3, 8])
def test_what_stands_or_coincides_is_zero_whatever_was_in_memory_before(agents):
    leave_nan_in_memory(agents)
    assert not saturate(np.zeros((2, agents)), 1.0).any()
    leave_nan_in_memory(agents, agents)
    assert (psi(np.zeros((agents, agents)), 2.0) == 1.0).all()


def test_an_agent_at_exactly_the_radius_is_no_neighbour():
    p = np.array([[0.0, 2.0, 3.9], [0.0, 0.0, 0.0]])
    assert neighbours(p, 2.0).tolist() == [[False] * 3, [False, False, True], [False, True, False]]


def test_whole_numbers_may_be_distances_counts_and_positions():
    assert_allclose(psi([1, 2, 4], 2), [-1.0, 0.0, 0.5])
    assert_allclose(phi(2, [4, 2], 1), [4.0, 2.0])
    p = [[0, 1, 2], [0, 0, 1]]
    for whole, real in zip(
        both_inputs(p, np.zeros((2, 3), dtype=int), p, 2),
        both_inputs(np.array(p, dtype=float), np.zeros((2, 3)), np.array(p, dtype=float), 2.0),
        strict=True,
    ):
        assert_allclose(whole, real, rtol=1e-12)


def test_coincident_agents_contribute_nothing_and_no_nan():
    p = np.zeros((2, 3))
    assert np.array_equal(velocity_based_input(p, p, PAPER_SIMULATION), p)
    assert np.array_equal(position_based_input(p, displacements(p), 1.0, PAPER_SIMULATION), p)


def test_repulsion_is_bounded_at_contact():
    """At distance → 0 the pair term tends to −δ·|N| times the unit vector."""
    u = velocity_based_input([[0.0, 1e-9], [0.0, 0.0]], np.zeros((2, 2)), PAPER_EXPERIMENT)
    assert_allclose(u, [[-0.12, 0.12], [0.0, 0.0]], atol=1e-8)


def test_alignment_gain_stops_decaying_at_one_over_k():
    assert phi(0.5, 4, 0.1) == 8.0
    assert phi(10.0, 4, 0.1) == pytest.approx(0.4)
    assert phi(80.0, 4, 0.1) == pytest.approx(0.4)
    assert phi(80.0, 4, None) == pytest.approx(0.05)


def test_psi_changes_sign_at_the_rest_distance():
    assert_allclose(psi([1.0, 2.0, 4.0], 2.0), [-1.0, 0.0, 0.5])


def test_without_threshold_only_late_inputs_differ():
    rng = np.random.default_rng(0)
    p, first = rng.uniform(-5, 5, (2, 2, 6))
    for t, same in ((9.0, True), (11.0, False)):
        inputs = [
            position_based_input(p, displacements(first), t, PAPER_SIMULATION, threshold=threshold)
            for threshold in (True, False)
        ]
        assert np.array_equal(*inputs) is same


def test_parameters_may_differ_between_agents():
    p = np.array([[0.0, 1.0, 2.5], [0.0, 0.0, 0.0]])
    reach = np.array([0.5, 2.0, 2.0])
    assert neighbours(p, reach).sum(axis=1).tolist() == [0, 2, 1]
    per_agent = LawParameters(np.full(3, 0.5), np.full(3, 7.5), 0.1, 2.5, 5.0)
    assert_allclose(
        velocity_based_input(p, p, per_agent), velocity_based_input(p, p, PAPER_SIMULATION)
    )


def test_each_agent_counts_those_within_its_own_radius():
    """Who sees whom is not mutual, so that rows and columns cannot be taken for each other."""
    rng = np.random.default_rng(5)
    p, first, v = rng.uniform(-3, 3, (3, 4, 2, 5))
    scale, radius = np.array([0.2, 0.5, 0.3, 0.7, 0.4]), np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    mixed = LawParameters(scale.tolist(), radius.tolist(), 0.3, 2.5, 5.0)
    for time in (2.0, 20.0):
        got = both_inputs(p, first, v, time, mixed)
        for member in range(4):
            for i in range(5):
                alike = LawParameters(scale[i], radius[i], 0.3, 2.5, 5.0)
                expected = plain_inputs(p[member], first[member], v[member], time, alike)
                for one, other in zip(got, expected, strict=True):
                    assert_allclose(one[member, :, i], other[:, i], rtol=1e-9)


def test_only_agents_that_are_sensed_count():
    rng = np.random.default_rng(6)
    p, first, v = rng.uniform(-3, 3, (3, 2, 5))
    seen = ~np.eye(5, dtype=bool)
    seen[:, 4] = seen[4, :] = False  # nobody senses the last one, nor it anybody
    for together, apart in zip(
        (
            velocity_based_input(p, v, PAPER_SIMULATION, detected=seen),
            position_based_input(p, displacements(first), 2.0, PAPER_SIMULATION, detected=seen),
        ),
        both_inputs(p[:, :4], first[:, :4], v[:, :4], 2.0),
        strict=True,
    ):
        assert_allclose(together[:, :4], apart, rtol=1e-12)
        assert not together[:, 4].any()
    far = p + 100.0 * np.arange(5)  # who is sensed and out of reach is no neighbour either
    everybody = np.ones((5, 5), dtype=bool)
    assert not velocity_based_input(far, v, PAPER_SIMULATION, detected=everybody).any()


def test_the_papers_parameters():
    names = ("distance_scale", "radius", "persistence", "speed_limit", "input_limit")
    for parameters, values in (
        (PAPER_SIMULATION, (0.5, 7.5, 0.1, 2.5, 5.0)),
        (PAPER_EXPERIMENT, (0.12, 0.75, 0.15, 0.15, 0.5)),
    ):
        assert parameters.as_dict() == dict(zip(names, values, strict=True))


def test_parameters_are_told_as_plain_numbers_however_they_were_given():
    given = LawParameters([0, 1], np.float32(2), 1, 3, np.array([4, 5]))
    assert given.as_dict() == {
        "distance_scale": [0.0, 1.0],
        "radius": 2.0,
        "persistence": 1.0,
        "speed_limit": 3.0,
        "input_limit": [4.0, 5.0],
    }
    told = [*given.as_dict()["input_limit"], given.persistence, given.radius]
    assert {type(number) for number in told} == {float}


def test_a_batch_of_flocks_is_its_members():
    rng = np.random.default_rng(1)
    p, first, v = rng.uniform(-8, 8, (3, 5, 2, 6))
    batch = both_inputs(p, first, v, 2.0)
    for member in range(5):
        for got, expected in zip(
            batch, both_inputs(p[member], first[member], v[member], 2.0), strict=True
        ):
            assert_allclose(got[member], expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"radius": -1.0}, "radius: expected finite and more than zero, got -1.0"),
        ({"distance_scale": math.nan}, "distance_scale: expected finite and zero or more"),
        ({"persistence": 0.0}, "persistence"),
        ({"speed_limit": "fast"}, "speed_limit: expected numbers, got 'fast'"),
        ({"persistence": np.ones(3)}, "persistence: expected a number, got an array"),
        ({"radius": 0.0}, "radius: expected finite and more than zero, got 0.0"),
        ({"radius": np.array([1.0, 0.0])}, "radius: expected finite and more than zero"),
        ({"radius": np.array([1.0, math.inf])}, "radius: expected finite and more than zero"),
        ({"input_limit": math.inf}, "input_limit: expected finite"),
        ({"distance_scale": -1e-9}, "distance_scale: expected finite and zero or more"),
        ({"radius": np.ones((2, 2))}, "expected a number or one number per agent, got an array of"),
    ],
)
def test_parameters_that_mean_nothing_are_refused(change, words):
    values = {"distance_scale": 0.5, "radius": 7.5, "persistence": 0.1}
    values |= {"speed_limit": 2.5, "input_limit": 5.0}
    with pytest.raises(ParameterError, match=words):
        LawParameters(**(values | change))


def test_states_that_mean_nothing_are_refused():
    p = np.zeros((2, 3))
    with pytest.raises(ParameterError, match=r"got \(3,\)"):
        velocity_based_input(np.zeros(3), np.zeros(3), PAPER_SIMULATION)
    for shape in ((1, 3), (4, 3), (2, 0), (5, 2, 0)):
        with pytest.raises(ParameterError, match=r"expected shape .* with d = 2 or 3"):
            velocity_based_input(np.zeros(shape), np.zeros(shape), PAPER_SIMULATION)
    with pytest.raises(ParameterError, match="positions: expected numbers"):
        velocity_based_input("here", p, PAPER_SIMULATION)
    with pytest.raises(ParameterError, match="got nan for agent 1"):
        velocity_based_input([[0.0, math.nan], [0.0, 0.0]], np.zeros((2, 2)), PAPER_SIMULATION)
    with pytest.raises(ParameterError, match="velocities: expected the shape of positions"):
        velocity_based_input(p, np.zeros((2, 2)), PAPER_SIMULATION)
    with pytest.raises(ParameterError, match=r"imprint: expected shape \(2, 3, 3\)"):
        position_based_input(p, np.zeros((2, 2, 2)), 1.0, PAPER_SIMULATION)
    with pytest.raises(ParameterError, match="time: expected more than 0 s"):
        position_based_input(p, displacements(p), 0.0, PAPER_SIMULATION)
    per_agent = LawParameters(np.full(4, 0.5), 7.5, 0.1, 2.5, 5.0)
    with pytest.raises(ParameterError, match="expected one value for each of 3 agents, got 4"):
        velocity_based_input(p, p, per_agent)
