"""Certified teams stay safe and within their limits, whatever they are commanded."""

import dataclasses

import numpy as np
import pytest
from driven_unicycles import ARENA, STEP, D, unicycle_step
from hypothesis import given
from hypothesis import strategies as st

from barrier_certificates.guarantee import largest_gain, largest_wall_gain, turning_error
from barrier_certificates.rows import Disc, Segment
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate


def ellipse_swap(certificate, clip, steps=2500):
    """Let ten unicycles swap across an ellipse; count steps beyond a limit, and with h < 0."""
    angle = 2 * np.pi * np.arange(10) / 10 + 0.02 * np.random.default_rng(1).normal(size=10)
    poses = np.stack([1.3 * np.cos(angle), 0.8 * np.sin(angle), angle + np.pi])
    goals, beyond, unsafe = -poses[:2], 0, 0
    for _ in range(steps):
        points = poses[:2] + D * np.stack([np.cos(poses[2]), np.sin(poses[2])])
        way = goals - points
        if np.hypot(*way).max() < 0.02:
            goals = -goals  # and back again
        desired = 0.15 * way / np.maximum(np.hypot(*way), 0.075)
        velocity, info = certificate.project(desired, poses)
        unsafe += info.smallest_h < 0
        _, v, w = unicycle_step(poses, velocity)
        wheels = np.abs(v) + 0.0525 * np.abs(w)
        beyond += bool(
            np.any(np.abs(v) > 0.15 + 1e-9)
            or np.any(np.abs(w) > 0.55 + 1e-9)
            or np.any(wheels > 12.5 * 0.016 + 1e-9)
        )
        if clip:
            v, w = np.clip(v, -0.15, 0.15), np.clip(w, -0.55, 0.55)
        e = np.stack([np.cos(poses[2]), np.sin(poses[2])])
        poses = poses + STEP * np.stack([v * e[0], v * e[1], w])
    return beyond, unsafe


def test_limits_belong_in_the_program_not_after_it():
    """With limits as rows nothing goes wrong; clipping afterwards breaks limits and safety."""
    inside = UnicycleCertificate(
        0.21, 500.0, boundary=ARENA, speed_limit=0.15, turn_rate_limit=0.55
    )
    assert ellipse_swap(inside, clip=False) == (0, 0)
    without = UnicycleCertificate(0.21, 500.0, boundary=ARENA, speed_limit=None, wheel_limit=None)
    beyond, unsafe = ellipse_swap(without, clip=True)
    assert beyond > 0
    assert unsafe > 0


@pytest.mark.parametrize("number", [2, 7, 20])
@pytest.mark.parametrize("unicycle", [False, True])
def test_attacking_commands_do_no_harm(number, unicycle):
    rng = np.random.default_rng(number)
    radius, limits = 0.15, {"speed_limit": 0.2}
    certificate = (
        UnicycleCertificate(radius, 100.0, boundary=ARENA, turn_rate_limit=3.6, **limits)
        if unicycle
        else SingleIntegratorCertificate(radius, 100.0, boundary=ARENA, **limits)
    )
    across = int(np.ceil(np.sqrt(number)))
    grid = np.array(np.meshgrid(np.arange(across), np.arange(across))).reshape(2, -1)[:, :number]
    poses = np.vstack([0.3 * (grid - 0.5 * (across - 1)), rng.uniform(-3, 3, (1, number))])
    for _ in range(300):
        points = poses[:2]
        if unicycle:
            points = points + D * np.stack([np.cos(poses[2]), np.sin(poses[2])])
        apart = points[:, None, :] - points[:, :, None]
        nearest = (np.hypot(*apart) + 9 * np.eye(number)).argmin(axis=1)
        attack = 5 * (points[:, nearest] - points) + rng.normal(0, 0.1, (2, number))
        if unicycle:
            velocity, info = certificate.project(attack, poses)
            poses, v, w = unicycle_step(poses, velocity)
            assert np.abs(v).max() <= 0.2 + 1e-9
            assert np.abs(w).max() <= 3.6 + 1e-9
            assert (np.abs(v) + 0.0525 * np.abs(w)).max() <= 12.5 * 0.016 + 1e-9
        else:
            velocity, info = certificate(attack, poses[:2])
            assert np.hypot(*velocity).max() <= 0.2 + 1e-9
            poses[:2] += STEP * velocity
        assert info.smallest_h >= 0
        assert info.status in ("trivial", "optimal")
        assert info.violation <= 1e-9


@pytest.mark.parametrize(
    "obstacles",
    [
        [Disc((0.1, 0.02), 0.1)],
        [Segment((0.0, -0.4), (0.0, 0.1), 0.02)],
        [Disc((0.5, 0.0), 0.05, velocity=(-0.1, 0.0)), Segment((0.1, 0.3), (0.5, 0.35))],
    ],
)
def test_robots_driven_at_obstacles_stay_clear(obstacles):
    certificate = SingleIntegratorCertificate(0.12, 200.0, obstacles=obstacles)
    positions = np.array([[-0.5, -0.5, -0.3], [-0.2, 0.05, 0.45]])
    for _ in range(400):
        velocity, info = certificate(np.tile([[0.3], [0.0]], 3), positions, obstacles)
        assert info.status != "relaxed"
        assert info.smallest_h >= 0
        positions = positions + STEP * velocity
        obstacles = [
            dataclasses.replace(o, centre=tuple(np.array(o.centre) + STEP * np.array(o.velocity)))
            if isinstance(o, Disc)
            else o
            for o in obstacles
        ]
    assert positions[0].max() > 0.5  # someone came past


def test_polygon_arena_keeps_robots_inside():
    angles = 2 * np.pi * np.arange(6) / 6
    corners = np.stack([np.cos(angles), np.sin(angles)])
    certificate = SingleIntegratorCertificate(0.15, 100.0, boundary=corners)
    positions = np.array([[0.1, -0.1, 0.0], [0.0, 0.1, -0.2]])
    rng = np.random.default_rng(0)
    command = 0.3 * rng.normal(size=(2, 3))
    for _ in range(300):
        velocity, info = certificate(command, positions)
        positions = positions + STEP * velocity
        assert info.smallest_h >= 0
    assert any("wall" in what for what in info.active)
    inner = np.cos(np.pi / 6) - 0.075
    sides = np.stack([np.cos(angles + np.pi / 6), np.sin(angles + np.pi / 6)])
    assert (sides.T @ positions).max() <= inner


def test_disturbed_wheels_cannot_break_a_certified_pair():
    """Every corner of the disturbance keeps ḣ ≥ −γ h³; without the term some corner does not."""
    rng = np.random.default_rng(3)
    broken = {0.0: 0, 0.5: 0}
    for _ in range(200):
        poses = np.vstack([rng.uniform(-0.12, 0.12, (2, 2)), rng.uniform(-3, 3, (1, 2))])
        for bound in broken:
            certificate = UnicycleCertificate(
                0.12, 150.0, speed_limit=None, wheel_limit=12.5, wheel_disturbance=bound
            )
            velocity, info = certificate.project(rng.uniform(-0.3, 0.3, (2, 2)), poses)
            if info.status not in ("trivial", "optimal") or info.smallest_h < 0:
                continue
            e = np.stack([np.cos(poses[2]), np.sin(poses[2])])
            side = np.stack([-e[1], e[0]])
            q = poses[:2] + D * e
            offset = q[:, 0] - q[:, 1]
            h = offset @ offset - 0.12**2
            for signs in np.ndindex(2, 2, 2, 2):
                left, right = 0.5 * (2 * np.array(signs).reshape(2, 2) - 1)
                extra = e * (left + right) * 0.008 + side * D * (right - left) * 0.016 / 0.105
                moved = velocity + extra
                broken[bound] += 2 * offset @ (moved[:, 0] - moved[:, 1]) < -150 * h**3 - 1e-9
    assert broken[0.5] == 0
    assert broken[0.0] > 0


def test_discrete_time_condition_is_what_decides():
    """Below the largest gain a head-on pair stays safe in steps; far above it does not."""
    radius, speed = 0.15, 0.2
    gain = largest_gain(radius, speed, STEP)

    def smallest_h(gain):
        certificate = SingleIntegratorCertificate(radius, gain, speed_limit=speed)
        worst = np.inf
        for start in np.linspace(0.16, 0.2, 41):
            positions = np.array([[-start / 2, start / 2], [0.0, 0.0]])
            for _ in range(20):
                velocity, info = certificate([[1.0, -1.0], [0.0, 0.0]], positions)
                worst = min(worst, info.smallest_h)
                positions = positions + STEP * velocity
        return worst

    assert smallest_h(gain) >= 0
    assert smallest_h(1e4 * gain) < 0
    assert largest_wall_gain(speed, STEP) > 1e4
    assert turning_error(D, 0.0, STEP) == 0


@given(
    st.floats(0.05, 1.0),
    st.floats(0.01, 1.0),
    st.floats(0.005, 0.2),
    st.floats(0.0, 1.0),
    st.floats(1e-3, 1.0),
)
def test_no_step_reaches_zero_up_to_the_largest_gain(radius, speed, step, near, share):
    """Head on and as fast as row and top speed allow, from any h: the worst of all steps."""
    gain = share * largest_gain(radius, speed, step)
    distance = radius + near * 4.0 * speed * step
    h = distance**2 - radius**2
    closing = min(2.0 * speed, gain * h**3 / (2.0 * distance))
    assert (distance - step * closing) ** 2 - radius**2 >= -1e-12


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.0))
def test_the_flocks_gain_keeps_robots_apart_from_every_safe_state(seed, near):
    """γ = 2000 at 0.20 m in steps of 33 ms: on both sides of h = 1/√(γ dt), whatever is wanted."""
    rng = np.random.default_rng(seed)
    certificate = UnicycleCertificate(
        0.20, 2000.0, speed_limit=0.15, turn_rate_limit=0.55, time_step=STEP
    )
    angle, (first, second) = rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi, 2)
    apart = 0.20 + 0.5 * near**3
    heads = np.array([[np.cos(first), np.cos(second)], [np.sin(first), np.sin(second)]])
    points = apart * np.array([[0.0, np.cos(angle)], [0.0, np.sin(angle)]])
    poses = np.vstack([points - D * heads, [first, second]])
    (v, w), info = certificate(rng.normal(0.0, 0.3, (2, 2)) * [[1.0], [4.0]], poses)
    assert info.clearance >= -1e-12
    poses += STEP * np.stack([v * np.cos(poses[2]), v * np.sin(poses[2]), w])
    points = poses[:2] + D * np.stack([np.cos(poses[2]), np.sin(poses[2])])
    assert np.hypot(*(points[:, 0] - points[:, 1])) >= 0.20 - 1e-9
