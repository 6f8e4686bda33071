"""What the parameters of a certificate do: walls, obstacles, gains, tilt, time step."""

import dataclasses

import numpy as np
import pytest
from driven_unicycles import ARENA, STEP, D, unicycle_step
from hypothesis import given, settings
from hypothesis import strategies as st

from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.deadlock import DeadlockParameters
from barrier_certificates.rows import Disc
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate


def test_one_robot_has_walls_obstacles_and_limits_too():
    post = Disc((0.0, 0.0), 0.1, name="post")
    certificate = SingleIntegratorCertificate(boundary=ARENA, obstacles=[post])
    velocity, info = certificate([[1.0], [0.0]], [[-0.18], [0.0]])
    assert "robot 0 and post" in info.active
    assert velocity[0, 0] < 0.01
    velocity, info = certificate([[1.0], [0.0]], [[1.52], [0.5]])
    assert "robot 0 and wall +x" in info.active
    velocity, info = certificate([[1.0], [0.0]], [[1.0], [0.5]])
    assert info.active == ("robot 0: speed limit",)


@pytest.mark.parametrize("unicycle", [False, True])
def test_tilting_resolves_an_exact_deadlock_and_stays_certified(unicycle):
    def swap(tilt):
        options = {"deadlock": DeadlockParameters(STEP), "tilt": tilt}
        certificate = (
            UnicycleCertificate(0.21, 500.0, turn_rate_limit=0.55, speed_limit=0.15, **options)
            if unicycle
            else SingleIntegratorCertificate(0.21, 500.0, speed_limit=0.15, **options)
        )
        poses = np.array([[-0.6, 0.6], [0.0, 0.0], [0.0, np.pi]])
        goals, flagged = -poses[:2], False
        for step in range(1200):
            points = poses[:2]
            if unicycle:
                points = points + D * np.stack([np.cos(poses[2]), np.sin(poses[2])])
            way = goals - points
            if np.hypot(*way).max() < 0.02:
                return step, flagged
            desired = 0.15 * way / np.maximum(np.hypot(*way), 0.075)
            if unicycle:
                velocity, info = certificate.project(desired, poses)
                poses, _, _ = unicycle_step(poses, velocity)
            else:
                velocity, info = certificate(desired, poses[:2])
                poses[:2] += STEP * velocity
            flagged = flagged or info.deadlocked
            assert info.smallest_h >= 0
            assert info.violation <= 1e-9
        return None, flagged

    arrived, flagged = swap(tilt=0.3)
    assert arrived is not None
    assert flagged
    arrived, flagged = swap(tilt=0.0)
    assert arrived is None
    assert flagged


def test_parameters_can_be_changed_and_memory_reset():
    certificate = SingleIntegratorCertificate(0.15)
    positions, command = [[-0.1, 0.1], [0.0, 0.0]], [[0.2, -0.2], [0.0, 0.0]]
    assert certificate(command, positions)[1].status == "optimal"
    certificate = dataclasses.replace(certificate, safety_radius=0.02)
    slow = [[0.005, -0.005], [0.0, 0.0]]
    velocity, info = certificate(slow, positions)
    assert info.status == "trivial"
    certificate.reset()
    np.testing.assert_array_equal(certificate(slow, positions)[0], velocity)
    with pytest.raises(dataclasses.FrozenInstanceError):
        certificate.safety_radius = 0.3


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 8), st.sampled_from([0.3, 3.6, 20.0]))
def test_with_the_time_step_projection_points_land_where_they_should(seed, number, turn):
    """However fast robots turn, a step moves projection points straight, and keeps all limits."""
    rng = np.random.default_rng(seed)
    certificate = UnicycleCertificate(
        0.12, 1e3, boundary=ARENA, turn_rate_limit=turn, time_step=STEP
    )
    poses = np.vstack([rng.uniform(-0.5, 0.5, (2, number)), rng.uniform(-3, 3, (1, number))])
    velocity, info = certificate.project(rng.uniform(-0.5, 0.5, (2, number)), poses)
    v, w = certificate.commands(velocity, poses)
    if info.status in ("trivial", "optimal"):
        assert np.abs(v).max() <= 0.2 + 1e-9
        assert np.abs(w).max() <= turn + 1e-9
        assert (np.abs(v) + 0.0525 * np.abs(w)).max() <= 12.5 * 0.016 + 1e-9
    e = np.stack([np.cos(poses[2]), np.sin(poses[2])])
    after = poses + STEP * np.stack([v * e[0], v * e[1], w])
    landed = after[:2] + D * np.stack([np.cos(after[2]), np.sin(after[2])])
    np.testing.assert_allclose(landed, poses[:2] + D * e + STEP * velocity, atol=1e-12)
    again, _ = certificate(np.stack([v, w]), poses)
    np.testing.assert_allclose(again, [v, w], atol=1e-8)  # a certified command passes as it is


def test_a_time_step_needs_a_limit_on_turning():
    with pytest.raises(ParameterError, match="turn_rate_limit or wheel_limit"):
        UnicycleCertificate(time_step=STEP, wheel_limit=None)


def test_walls_have_a_gain_of_their_own():
    at_wall, fast = np.array([[1.4], [0.0]]), np.array([[0.2], [0.0]])

    def speed(**gains):
        certificate = SingleIntegratorCertificate(0.2, boundary=ARENA, **gains)
        return certificate(fast, at_wall)[0][0, 0]

    gap = 1.6 - 1.4 - 0.1
    assert speed(barrier_gain=100.0) == pytest.approx(0.4 * 100.0 * gap**3)
    assert speed(barrier_gain=1e4, wall_gain=100.0) == speed(barrier_gain=100.0)
    with pytest.raises(ParameterError, match="wall_gain"):
        SingleIntegratorCertificate(wall_gain=-1.0)


def test_a_control_run_keeps_walls_and_limits_but_nobody_apart():
    certificate = SingleIntegratorCertificate(0.2, boundary=ARENA, pair_rows=False)
    velocity, info = certificate([[0.1, -0.1, 0.2], [0, 0, 0]], [[0, 0.2, 1.4999], [0, 0, 0]])
    assert velocity[:, :2] == pytest.approx(np.array([[0.1, -0.1], [0, 0]]))
    assert velocity[0, 2] < 1e-6
    assert info.nearest == "robot 2 and wall +x"
