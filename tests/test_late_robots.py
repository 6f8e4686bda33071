"""Robots that answer late: stop points, what errors cost, and what is kept in spite of them."""

import dataclasses

import numpy as np
import pytest
from driven_unicycles import ARENA, STEP, D
from hypothesis import given, settings
from hypothesis import strategies as st

from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.late.cautious_rows import CautiousRows
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_robots import LateRobots
from barrier_certificates.late.stop_prediction import StopPrediction
from barrier_certificates.projection import Projector
from barrier_certificates.rows import ObstacleRows, Rows, Scene
from barrier_certificates.unicycle import UnicycleCertificate
from rps_compat.arena import Arena
from rps_compat.command_effects import DeadBand, DeadTime
from rps_compat.distributions import DistributionKind, RobotDistribution, constant
from rps_compat.late_profiles import late_certificate, late_robots
from rps_compat.motor_effects import Gains, Lag
from rps_compat.profiles import load_profile
from rps_compat.realism import Profile
from rps_compat.testbed import GTERNAL
from rps_compat.tracking_effects import HeadingOffset

SPEED, TURN = 0.15, 0.55
LIMITS = np.array([[SPEED], [TURN]])
IDEAL = UnicycleCertificate(
    0.185, 2000.0, boundary=ARENA, speed_limit=SPEED, turn_rate_limit=TURN, time_step=STEP
)
GRITSBOT = load_profile("gritsbot_x")


def between(low, high):
    return RobotDistribution(DistributionKind.UNIFORM, (low, high))


def ahead(poses):
    return poses[:2] + D * np.stack([np.cos(poses[2]), np.sin(poses[2])])


def come_to_rest(profile, certificate, seed, robots=6):
    """Drive wildly, then stop; return the stop points predicted and true, and the headings' gap."""
    rng = np.random.default_rng(seed)
    start = np.vstack([np.arange(robots) * 2.0, np.zeros(robots), rng.uniform(-3, 3, robots)])
    arena = Arena(start, GTERNAL, realism=profile.start(), rng=np.random.default_rng([seed, 1]))
    hold = int(rng.integers(1, 25))
    for step in range(int(rng.integers(1, 40))):
        if step % hold == 0:
            commands = rng.choice([-1.0, 0.0, 0.3, 1.0], (2, robots)) * LIMITS
        arena.commands = commands.copy()
        arena.step()
        certificate.sent(commands)
    predicted = certificate.stops(arena.observe())
    for _ in range(70):
        arena.commands = np.zeros((2, robots))
        arena.step()
    turned = predicted[2] - arena.poses[2]
    return ahead(predicted), ahead(arena.poses), np.abs(np.arctan2(np.sin(turned), np.cos(turned)))


@pytest.mark.parametrize(("dead", "lag"), [(0.0, 0.1), (0.2, 0.0), (0.21, 0.17), (0.4, 0.25)])
def test_where_known_robots_come_to_rest_is_predicted(dead, lag):
    profile = Profile(
        dead_time=DeadTime(constant(dead)), lag=Lag(constant(lag)), gains=Gains(constant(0.9))
    )
    certificate = late_certificate(IDEAL, profile)
    margins = certificate.late_margins
    assert margins.stop_error == margins.arcs < 1e-3  # the arena's robots turn in steps
    for seed in range(4):
        predicted, true, _ = come_to_rest(profile, certificate, seed)
        certificate.reset()
        assert np.hypot(*(predicted - true)).max() <= margins.stop_error


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.4), st.floats(0.0, 0.2), st.floats(0.0, 0.1))
def test_robots_come_to_rest_within_the_error_that_their_ranges_leave(seed, dead, lag, spread):
    """Each robot has numbers of its own anywhere in the ranges, as long as it drives."""
    profile = Profile(
        dead_time=DeadTime(between(dead, dead + 0.5 * spread)),
        lag=Lag(between(lag, lag + 0.3 * spread)),
        gains=Gains(between(1 - spread, 1 + spread), between(1 - spread, 1)),
        heading_offset=HeadingOffset(between(-0.3 * spread, 0.5 * spread)),
    )
    certificate = late_certificate(dataclasses.replace(IDEAL, barrier_gain=1.0), profile)
    predicted, true, turned = come_to_rest(profile, certificate, seed)
    assert np.hypot(*(predicted - true)).max() <= certificate.late_margins.stop_error + 1e-5
    assert turned.max() <= certificate.late_margins.rest_heading + 1e-4


def test_commands_that_are_too_small_to_move_a_robot_are_allowed_for():
    """All that is in flight lies within the dead band, so that the robot rests where it is."""
    band = DeadBand(speed=0.005, turn=0.08)
    profile = Profile(dead_time=DeadTime(constant(0.3)), lag=Lag(constant(0.1)), dead_band=band)
    certificate, here = late_certificate(IDEAL, profile), np.array([[0.3], [-0.2], [0.7]])
    certificate.stops(here)
    for _ in range(30):
        certificate.sent(np.array([[0.99 * band.speed], [0.99 * band.turn]]))
        predicted = certificate.stops(here)
    margins = certificate.late_margins
    assert 0.02 < abs(predicted[2, 0] - here[2, 0]) <= margins.rest_heading
    assert 1e-3 < np.hypot(*(ahead(predicted) - ahead(here)))[0] <= margins.stop_error
    assert margins.drift >= band.speed + D * band.turn  # and while it drives


def test_who_is_told_to_stop_leaves_its_stop_point_where_it_is():
    profile = Profile(dead_time=DeadTime(constant(0.2)), lag=Lag(constant(0.15)))
    certificate = late_certificate(IDEAL, profile)
    arena = Arena(np.zeros((3, 1)), GTERNAL, realism=profile.start(), rng=np.random.default_rng(0))
    seen = []
    for step in range(60):
        arena.commands = LIMITS * (step < 20)
        certificate.sent(arena.commands)
        arena.step()
        seen.append(ahead(certificate.stops(arena.observe())))
    assert np.hypot(*(seen[-1] - seen[19])).max() < certificate.late_margins.arcs
    assert np.hypot(*(seen[19] - seen[10])).max() > 0.03


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.4))
def test_a_robots_place_is_the_mean_of_its_stop_points_but_for_turning(seed, lag):
    """T ẏ = P − y for the stop points P gives y within ½ v ω T² of the place p."""
    rng, dt = np.random.default_rng(seed), 2e-3
    place, mean, heading = np.zeros(2), np.zeros(2), 0.0
    v = w = 0.0
    for step in range(500):
        if step % 75 == 0:
            wish_v, wish_w = rng.choice([-1, 0, 1], 2) * LIMITS[:, 0]
        turn = w * lag
        chord = lag * v * np.sinc(turn / (2 * np.pi))
        stop = place + chord * np.array(
            [np.cos(heading + 0.5 * turn), np.sin(heading + 0.5 * turn)]
        )
        assert np.hypot(*(place - mean)) <= 0.5 * SPEED * TURN * lag**2 + 1e-3
        mean = mean + dt / lag * (stop - mean)
        place = place + dt * v * np.array([np.cos(heading), np.sin(heading)])
        heading += dt * w
        v, w = v + dt / lag * (wish_v - v), w + dt / lag * (wish_w - w)


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 0.4), st.floats(0.0, 0.3), st.floats(0.02, 0.3))
def test_means_of_points_outside_a_circle_lie_no_deeper_than_the_sagitta(seed, radius, speed, lag):
    rng, dt = np.random.default_rng(seed), 0.01
    side = np.where(np.cumsum(rng.random(600) < 0.02) % 2, 1.0, -1.0)
    angle = np.cumsum(side) * speed * dt / radius
    path = radius * np.stack([np.cos(angle), np.sin(angle)])
    weights = np.exp(-dt * np.arange(600) / lag)
    mean = path @ weights / weights.sum()
    assert np.hypot(*mean) >= radius - (speed * lag) ** 2 / (2.0 * radius) - 1e-3


@given(st.integers(0, 2**32 - 1))
def test_cautious_rows_let_nobody_approach_whatever_is_true_within_the_bounds(seed):
    rng = np.random.default_rng(seed)
    certificate = late_certificate(IDEAL, GRITSBOT)
    margins, radius = certificate.late_margins, certificate.guarantee().stops_apart
    angle, distance = rng.uniform(-np.pi, np.pi), rng.uniform(0.6, 1.0) * radius
    apart = np.array([np.cos(angle), np.sin(angle)])
    points = np.stack([np.zeros(2), distance * apart], axis=1)
    none = Rows(
        np.zeros((4, 0), dtype=int), np.zeros((4, 0)), np.zeros(0), 4, np.zeros(0), lambda row: ""
    )
    rows = CautiousRows(margins, radius).added(
        none, Scene(points), True, None, ObstacleRows((), 0.1, 1.0)
    )
    assert len(rows) == 16
    assert rows.label(3) == "robots 0 and 1"
    velocity, info = Projector().project(rng.uniform(-0.15, 0.15, (2, 2)), rows)  # at some corner
    assert info.status in ("trivial", "optimal")
    doubt = np.arcsin(2 * margins.stop_error / distance)
    turns = (doubt + margins.skew) * np.linspace(-1, 1, 9)
    parts = np.array([margins.weakest, 1.0, margins.strongest])
    away = np.stack([np.cos(angle + turns), np.sin(angle + turns)])
    leaving = (parts[:, None, None] * (away.T @ velocity)).reshape(-1, 2)  # of either robot
    worst = leaving[:, 1].min() - leaving[:, 0].max()  # the first leaves the other way
    assert worst >= 2.0 * margins.drift - 1e-7


def drive(certificate, profile, steps, wish_of, robots=4, seed=0):
    """Drive late robots; return the least true distance of projection points, and the statuses."""
    start = np.array([[-0.4, 0.4, 0.0, 0.0], [0.0, 0.0, 0.5, -0.5], [0.0, np.pi, -1.5, 1.5]])[
        :, :robots
    ]
    arena = Arena(start, GTERNAL, realism=profile.start(), rng=np.random.default_rng(seed))
    least, statuses = np.inf, set()
    first, second = np.triu_indices(robots, 1)
    for step in range(steps):
        points = ahead(arena.poses)
        least = min(least, np.hypot(*(points[:, first] - points[:, second])).min())
        seen = arena.observe()
        poses = certificate.stops(seen)
        velocity, info = certificate.project(wish_of(points, step), poses)
        arena.commands = certificate.commands(velocity, poses)
        certificate.sent(arena.commands)
        statuses.add(str(info.status))
        arena.step()
    return least, statuses


def attack(points, step):
    """Everybody at his nearest neighbour; every twelve steps some draw back."""
    apart = points[:, None, :] - points[:, :, None]
    way = points[:, (np.hypot(*apart) + 9 * np.eye(points.shape[1])).argmin(axis=1)] - points
    sign = np.where((np.arange(points.shape[1]) + step // 12) % 4 == 0, -1.0, 1.0)
    return sign * way / np.hypot(*way)


def test_late_robots_under_attack_are_kept_apart_as_promised():
    certificate = late_certificate(IDEAL, GRITSBOT, barrier_gain=2e4)
    promise = certificate.guarantee().pairs
    least, _ = drive(certificate, GRITSBOT, 300, attack)
    assert promise == IDEAL.safety_radius
    assert least >= promise
    assert drive(IDEAL, GRITSBOT, 300, attack)[0] < promise  # who does not know of it breaks it
    assert least < certificate.guarantee().stops_apart + 0.02  # they did meet


def test_robots_that_obey_at_once_cost_nothing_but_what_a_step_turns():
    certificate = LateCertificate.of(IDEAL, LateRobots())
    assert certificate.late_margins.stop_error == 0.0
    assert certificate.guarantee().stops_apart - IDEAL.safety_radius < 2e-4
    poses = np.array([[0.0, 0.5], [0.0, 0.0], [1.0, 2.0]])
    assert np.array_equal(certificate.stops(poses), poses)
    certificate.sent(np.ones((2, 2)) * 0.1)
    assert np.array_equal(certificate.stops(poses), poses)


def test_too_close_at_the_start_stops_or_parts_but_never_approaches():
    profile = Profile(dead_time=DeadTime(constant(0.2)), lag=Lag(constant(0.1)))
    certificate = late_certificate(IDEAL, profile)
    start = np.array([[0.0, 0.15, 0.3], [0.0, 0.02, 0.0], [0.0, np.pi, 2.0]])
    arena = Arena(start, GTERNAL, realism=profile.start(), rng=np.random.default_rng(0))

    def nearest():
        points = ahead(arena.poses)
        return np.hypot(*(points[:, [0, 0, 1]] - points[:, [1, 2, 2]])).min()

    before = nearest()
    for _ in range(150):
        commands, info = certificate(np.tile([[0.15], [0.0]], 3), arena.observe())
        arena.commands = commands
        arena.step()
        assert nearest() >= before - 1e-3
    assert nearest() > before + 0.02
    assert info.clearance > -0.1


def test_who_is_wedged_waits_and_the_others_go_on():
    robots = LateRobots(dead_time=(0.2, 0.2), lag=(0.1, 0.1), speed_noise=0.05)
    certificate = LateCertificate.of(IDEAL, robots)
    gap = 0.5 * certificate.guarantee().stops_apart
    # Three in a row, side by side, too close for anyone to move as fast as noise might push it.
    x = np.array([-1.0, -1.0 + gap, -1.0 + 2 * gap, 1.0])
    poses = np.vstack([x, np.zeros(4), [0.5 * np.pi] * 3 + [0.0]])
    commands, info = certificate(np.tile([[0.1], [0.2]], 4), poses)
    assert not commands[:, :3].any()
    assert commands[:, 3] == pytest.approx([0.1, 0.2])
    assert info.status == "optimal"
    assert info.intervention > 0.1


def test_a_step_that_took_longer_is_taken_into_account():
    robots = LateRobots(dead_time=(0.2, 0.2), longest_step=0.5)
    late = StopPrediction(robots, STEP)
    late.sent(np.array([[0.1], [0.0]]))
    still = np.zeros((3, 1))
    assert late.stops(still)[0, 0] == pytest.approx(0.1 * STEP)
    late.elapsed(0.1)  # the command acted longer than it was meant to
    assert late.stops(still)[0, 0] == pytest.approx(0.01)
    late.elapsed(2.0)  # and then the watchdog stopped the robot; all is in the pose seen
    assert late.stops(still)[0, 0] == pytest.approx(0.0, abs=1e-12)


def test_what_has_no_bound_is_named_and_nothing_promised():
    kept = late_certificate(IDEAL, GRITSBOT).guarantee()
    assert str(kept) == (
        "kept: projection points at least 185 mm apart, them at least 92 mm inside the walls"
    )
    harsh = late_certificate(dataclasses.replace(IDEAL, barrier_gain=1.0), load_profile("harsh"))
    assert harsh.guarantee().cannot[0].startswith("commands may be lost")
    assert "nothing is promised" in str(harsh.guarantee())
    relaxed = dataclasses.replace(late_certificate(IDEAL, GRITSBOT), on_infeasible="relax")
    assert "on_infeasible" in relaxed.guarantee().cannot[0]


def test_parameters_that_cannot_be_kept_are_refused():
    with pytest.raises(ParameterError, match=r"barrier_gain is 2000; .* admit \d+ at most"):
        late_certificate(IDEAL, load_profile("gternal"))
    fast = dataclasses.replace(IDEAL, speed_limit=0.2, turn_rate_limit=3.6)
    with pytest.raises(ParameterError, match="stop point"):
        LateCertificate.of(fast, LateRobots(lag=(0.35, 0.35)))
    free = dataclasses.replace(IDEAL, speed_limit=None, wheel_limit=None)
    with pytest.raises(ParameterError, match="late robots need limits"):
        LateCertificate.of(free, LateRobots())
    with pytest.raises(ParameterError, match="time_step"):
        LateCertificate(0.2, speed_limit=0.1, turn_rate_limit=0.5)
    for wrong in ({"lag": (0.2, 0.1)}, {"speed_gain": (0.0, 1.0)}, {"turn_noise": np.nan}):
        with pytest.raises(ParameterError, match=next(iter(wrong))):
            LateRobots(**wrong)
    certificate = late_certificate(IDEAL, GRITSBOT)
    with pytest.raises(ShapeError):
        certificate.stops(np.zeros((2, 3)))
    with pytest.raises(ParameterError, match="elapsed"):
        certificate.stops(np.zeros((3, 3)), elapsed=0.0)


def test_ranges_of_a_profile_are_those_up_to_the_limits():
    robots = late_robots(GRITSBOT, speed_limit=SPEED, turn_rate_limit=TURN)
    assert robots.dead_time == pytest.approx((0.19, 0.2 * 1.23))
    assert robots.lag == pytest.approx((0.17, 0.18))
    assert robots.speed_gain == pytest.approx((0.98 * 0.935, 1.03))
    assert robots.turn_gain == pytest.approx((0.91, 0.99))
    assert (robots.turn_bias, robots.longest_step) == (0.017, 0.0)
    assert late_robots(
        load_profile("gternal"), speed_limit=SPEED, turn_rate_limit=TURN
    ).longest_step == pytest.approx(0.5 + STEP)
    ideal = late_robots(load_profile("ideal"), speed_limit=SPEED, turn_rate_limit=TURN)
    assert ideal == LateRobots()
