"""Certified teams stay safe, within their limits, and come back from states that are not safe."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from barrier_certificates.certificate_errors import InfeasibleError, ParameterError
from barrier_certificates.deadlock import DeadlockParameters
from barrier_certificates.guarantee import largest_gain, largest_wall_gain, turning_error
from barrier_certificates.rows import Disc, Segment
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)
STEP = 0.033
D = 0.05  # projection distance


def unicycle_step(poses, velocity):
    """Move unicycles by what their projection points shall do; return poses, v, ω."""
    e = np.stack([np.cos(poses[2]), np.sin(poses[2])])
    v, w = (velocity * e).sum(axis=0), (e[0] * velocity[1] - e[1] * velocity[0]) / D
    return poses + STEP * np.stack([v * e[0], v * e[1], w]), v, w


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


UNSAFE = {
    "1 mm of overlap": [[-0.0745, 0.0745], [0.0, 0.0]],
    "half the radius": [[-0.0375, 0.0375], [0.0, 0.0]],
    "0.9 of the radius": [[-0.0075, 0.0075], [0.0, 0.0]],
    "coincident": [[0.3, 0.3], [0.2, 0.2]],
    "three coincident": [[0.3, 0.3, 0.3], [0.2, 0.2, 0.2]],
    "half a metre outside": [[2.1, 0.0], [0.0, 0.0]],
    "outside a corner": [[2.0, -2.0], [1.5, -1.5]],
    "packed into a corner": [[1.55, 1.52, 1.58, 1.5], [0.95, 0.97, 0.91, 0.93]],
    "coincident in a corner": [[1.6, 1.6], [1.0, 1.0]],
}


@pytest.mark.parametrize("positions", UNSAFE.values(), ids=UNSAFE.keys())
def test_relaxed_answers_part_robots_and_bring_them_back(positions):
    certificate = SingleIntegratorCertificate(0.15, 1e4, boundary=ARENA)
    positions = np.array(positions)
    command = np.full(positions.shape, 0.1)
    first = None
    for _ in range(400):
        velocity, info = certificate(command, positions)
        first = first or info
        assert np.all(np.isfinite(velocity))
        assert np.hypot(*velocity).max() <= 0.2 + 1e-9
        if info.status == "optimal":
            assert info.violation <= 1e-9
        positions = positions + STEP * velocity
    assert first.clearance < 0
    # A cubic barrier undoes the last millimetres ever more slowly.
    assert info.clearance > -0.01
    assert info.clearance > first.clearance
    assert info.status == "optimal"


@pytest.mark.parametrize("which", UNSAFE)
@pytest.mark.parametrize("policy", ["relax", "stop", "raise"])
def test_a_state_without_safe_velocity_is_never_called_optimal(which, policy):
    """At a gain this high no overlap can be undone at the demanded rate within the limits."""
    certificate = SingleIntegratorCertificate(
        0.15, 100.0, unsafe_gain=1e9, boundary=ARENA, on_infeasible=policy
    )
    positions = np.array(UNSAFE[which])
    command = np.zeros(positions.shape)
    if which == "1 mm of overlap":  # the one that can be undone in time
        assert certificate(command, positions)[1].status == "optimal"
        return
    if policy == "raise":
        with pytest.raises(InfeasibleError, match="wall" if "outside" in which else "robots"):
            certificate(command, positions)
        return
    velocity, info = certificate(command, positions)
    assert np.all(np.isfinite(velocity))
    assert np.hypot(*velocity).max() <= 0.2 + 1e-9
    assert info.violation > 1e-9
    assert info.status == ("relaxed" if policy == "relax" else "failed")


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["positions", "command"])
def test_what_is_not_a_number_stops_the_team(value, where):
    positions = np.array([[-0.5, 0.5, 0.0], [0.0, 0.0, 0.5]])
    command = np.full((2, 3), 0.1)
    (positions if where == "positions" else command)[0, 1] = value
    velocity, info = SingleIntegratorCertificate(boundary=ARENA)(command, positions)
    assert info.status == "failed"
    assert not velocity.any()


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


def test_margins_name_what_is_near():
    certificate = SingleIntegratorCertificate(boundary=ARENA, obstacles=[Disc((0.0, 0.5), 0.1)])
    margins = certificate.margins([[-0.1, 0.1, 1.5], [0.0, 0.0, 0.0]], within=0.1)
    assert [m.what for m in margins] == ["robot 2 and wall +x", "robots 0 and 1"]
    assert margins[0].clearance == pytest.approx(0.025)
    assert margins[1].h == pytest.approx(0.2**2 - 0.15**2)


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


@pytest.mark.parametrize("which", UNSAFE)
def test_relaxed_unicycles_stay_within_what_their_motors_can_do(which):
    certificate = UnicycleCertificate(
        0.15, 100.0, unsafe_gain=1e9, boundary=ARENA, turn_rate_limit=3.6, time_step=STEP
    )
    points = np.array(UNSAFE[which])
    heading = np.linspace(-2, 2, points.shape[1])
    poses = np.vstack([points - D * np.stack([np.cos(heading), np.sin(heading)]), heading])
    first = None
    for _ in range(400):
        velocity, info = certificate.project(np.zeros(points.shape), poses)
        first = first or info
        v, w = certificate.commands(velocity, poses)
        assert np.abs(v).max() <= 0.2 + 1e-9
        assert np.abs(w).max() <= 3.6 + 1e-9
        assert (np.abs(v) + 0.0525 * np.abs(w)).max() <= 12.5 * 0.016 + 1e-9
        assert info.status in ("trivial", "optimal", "relaxed")
        assert info.status != "optimal" or info.violation <= 1e-9
        poses = poses + STEP * np.stack([v * np.cos(poses[2]), v * np.sin(poses[2]), w])
    assert info.clearance > max(first.clearance, -0.06)


def test_the_first_call_says_whether_the_team_starts_unsafe():
    certificate = SingleIntegratorCertificate(0.2, boundary=ARENA, wall_margin=0.1)
    still, near = np.zeros((2, 2)), np.array([[0.0, 0.15], [0.0, 0.0]])
    _, info = certificate(still, near)
    assert info.unsafe_start
    assert info.nearest == "robots 0 and 1"
    assert info.clearance == pytest.approx(-0.05)
    assert not certificate(still, near)[1].unsafe_start, "said at the first call alone"
    certificate.reset()
    assert not certificate(still, 2 * near)[1].unsafe_start
    assert not certificate(still, near)[1].unsafe_start, "it was safe at the first call"
    certificate.reset()
    _, info = certificate(still, 2 * near + [[1.3], [0.0]])
    assert info.unsafe_start
    assert info.nearest == "robot 1 and wall +x"


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
