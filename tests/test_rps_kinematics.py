"""From velocities of points to commands of unicycles, and back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rps_compat import kinematics
from rps_compat.v1.utilities import transformations as first
from rps_compat.v2.utilities import transformations as second

NUMBERS = st.floats(-5, 5, allow_nan=False)
DISTANCES = st.floats(0.01, 0.5)


def columns(rows):
    return st.integers(1, 6).flatmap(lambda n: arrays(float, (rows, n), elements=NUMBERS))


@st.composite
def commands_and_poses(draw):
    robots = draw(st.integers(1, 6))
    return (
        draw(arrays(float, (2, robots), elements=NUMBERS)),
        draw(arrays(float, (3, robots), elements=NUMBERS)),
    )


@given(commands_and_poses(), DISTANCES)
def test_a_point_ahead_can_move_in_any_direction(pair, distance):
    velocities, poses = pair
    commands = kinematics.unicycle_command(velocities, poses, distance)
    back = kinematics.point_velocity(commands, poses, distance)
    np.testing.assert_allclose(back, velocities, atol=1e-12)


@given(columns(3), DISTANCES)
def test_centre_and_point_ahead_invert_each_other(poses, distance):
    points = kinematics.projection_point(poses, distance)
    np.testing.assert_allclose(kinematics.center_of(points, poses, distance), poses[:2], atol=1e-12)
    np.testing.assert_allclose(np.hypot(*(points - poses[:2])), distance, rtol=1e-9)


@given(commands_and_poses(), DISTANCES)
def test_point_velocity_is_how_fast_the_point_moves(pair, distance):
    commands, poses = pair
    dt = 1e-6
    moved = poses.copy()
    middle = poses[2] + commands[1] * dt / 2
    moved[:2] += dt * commands[0] * np.array([np.cos(middle), np.sin(middle)])
    moved[2] += dt * commands[1]
    before = kinematics.projection_point(poses, distance)
    after = kinematics.projection_point(moved, distance)
    np.testing.assert_allclose(
        (after - before) / dt, kinematics.point_velocity(commands, poses, distance), atol=1e-4
    )


@given(columns(2), st.floats(0, 2))
def test_scaling_keeps_directions_and_the_callers_array(velocities, limit):
    before = velocities.copy()
    scaled = kinematics.scaled_to_norm(velocities, limit)
    np.testing.assert_array_equal(velocities, before)
    assert np.all(np.hypot(*scaled) <= limit * (1 + 1e-12))
    cross = velocities[0] * scaled[1] - velocities[1] * scaled[0]
    np.testing.assert_allclose(cross, 0, atol=1e-9)
    slow = np.hypot(*velocities) <= limit
    np.testing.assert_array_equal(scaled[:, slow], velocities[:, slow])


@given(arrays(float, 4, elements=st.floats(-50, 50)))
def test_wrapped_angles_are_the_same_angles(angles):
    wrapped = kinematics.wrap(angles)
    assert np.all(np.abs(wrapped) <= np.pi)
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angles), atol=1e-9)


def test_cutting_turn_rates_does_not_hide_nan():
    cut = kinematics.limited(np.array([np.nan, 5.0, -5.0, 0.5]), 1.0)
    np.testing.assert_array_equal(cut, [np.nan, 1.0, -1.0, 0.5])


@pytest.mark.parametrize("generation", [first, second])
def test_a_velocity_to_the_left_turns_at_the_limit(generation):
    to_command = generation.create_si_to_uni_dynamics(angular_velocity_limit=2.0)
    commands = to_command(np.array([[0.0], [0.1]]), np.zeros((3, 1)))
    np.testing.assert_allclose(commands, [[0.0], [2.0]], atol=1e-12)


@given(commands_and_poses())
def test_driving_backwards_saves_turning_in_generation_2(pair):
    velocities, poses = pair
    backwards = second.create_si_to_uni_dynamics_with_backwards_motion(1, 2.0)(velocities, poses)
    forwards = second.create_si_to_uni_dynamics(1, 2.0)(velocities, poses)
    assert np.all(np.abs(backwards[1]) <= 2.0 + 1e-9)
    np.testing.assert_allclose(np.abs(backwards[0]), np.abs(forwards[0]), atol=1e-12)


def test_generation_1_cuts_turn_rates_and_generation_2_does_not():
    velocities, poses = np.array([[0.0], [1.0]]), np.zeros((3, 1))
    assert first.create_si_to_uni_mapping(0.05)[0](velocities, poses)[1, 0] == np.pi
    assert second.create_si_to_uni_mapping(0.05)[0](velocities, poses)[1, 0] == pytest.approx(20)
