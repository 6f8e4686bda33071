"""Unequal robots that answer late, stay connected, or fly in batches."""

import dataclasses

import numpy as np
import pytest
from driven_unicycles import ARENA, STEP
from hypothesis import strategies as st
from unequal_teams import (
    AHEAD,
    DRIVE,
    GAINS,
    SIZES,
    SPEEDS,
    clearances,
)

from barrier_certificates.batch import BatchCertificate
from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.late.cautious_rows import CautiousRows
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_robots import LateRobots
from barrier_certificates.rows import (
    ConnectivityParameters,
    ObstacleRows,
    RowBook,
    Scene,
)
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.flocking.errors import ParameterError as FlockParameterError
from posflock_robotarium.flocking.flock import Flock
from rps_compat.batch import BatchArena, ToGoals, rollout
from rps_compat.late_profiles import late_certificate
from rps_compat.profiles import load_profile

SEEDS = st.integers(0, 2**31 - 1)


def test_unequal_robots_that_answer_late_are_kept_apart_by_their_own_distances():
    """Commands act six steps after they are given; who does not know of it breaks a distance."""
    delay, sizes = 6, np.array([0.4, 0.15, 0.15, 0.2])
    limits = {"speed_limit": [0.1, 0.2, 0.2, 0.15], "turn_rate_limit": [0.5, 1.0, 1.0, 0.6]}
    ideal = UnicycleCertificate(sizes, [2e4, 6e4, 5e4, 4e4], time_step=STEP, **limits)
    late = LateCertificate.of(ideal, LateRobots(dead_time=(delay * STEP, delay * STEP)))
    assert str(late.guarantee()) == "kept: projection points at least 400/150/150/200 mm apart"

    def least(certificate):
        poses = np.array([[0, 0.5, -0.45, 0.1], [0, 0.1, 0, 0.5], [0, 3, 1, -1.5]])
        waiting, found = [np.zeros((2, 4))] * delay, np.inf
        first, second = np.triu_indices(4, 1)
        kept = 0.5 * (sizes[first] + sizes[second])
        for step in range(250):
            points = poses[:2] + 0.05 * np.stack([np.cos(poses[2]), np.sin(poses[2])])
            apart = np.hypot(*(points[:, first] - points[:, second])) - kept
            found = min(found, apart.min())
            gap = points[:, None, :] - points[:, :, None]
            nearest = (np.hypot(*gap) - 0.5 * sizes + 9 * np.eye(4)).argmin(axis=1)
            way = points[:, nearest] - points
            draws_back = np.where((np.arange(4) + step // 12) % 4 == 0, -1.0, 1.0)
            stops = certificate.stops(poses)
            velocity, _ = certificate.project(draws_back * way / np.hypot(*way), stops)
            waiting.append(certificate.commands(velocity, stops))
            certificate.sent(waiting[-1])
            v, w = waiting.pop(0)
            middle = poses[2] + 0.5 * STEP * w
            poses = poses + STEP * np.stack([v * np.cos(middle), v * np.sin(middle), w])
        return found

    assert least(late) >= 0.0
    assert least(late) < 0.03  # they did meet
    assert least(ideal) < 0.0


def test_what_it_costs_to_be_late_is_that_of_the_worst_robot():
    robots = LateRobots(dead_time=(0.1, 0.2), lag=(0.1, 0.15), speed_gain=(0.9, 1.1))
    numbers = {"speed_limit": (0.05, 0.2), "turn_rate_limit": (1.0, 0.4)}
    ahead = (0.1, 0.05)
    common = {"time_step": STEP, "robots": robots, "boundary": ARENA}
    team = LateCertificate((0.4, 0.1), projection_distance=ahead, **numbers, **common)
    alone = [
        LateCertificate(
            projection_distance=ahead[robot],
            **{name: value[robot] for name, value in numbers.items()},
            **common,
        ).late_margins
        for robot in (0, 1)
    ]
    for name in ("stop_error", "held", "spread", "turning", "skew", "strongest", "top_speed"):
        each = [getattr(margins, name) for margins in alone]
        assert getattr(team.late_margins, name) >= max(each)
        assert each[0] != each[1] or name == "strongest"
    assert team.late_margins.weakest == min(margins.weakest for margins in alone)
    margin = team.late_margins.pair(0.1)
    assert margin > max(margins.pair(0.25) for margins in alone)
    assert team.guarantee().stops_apart == pytest.approx((0.4 + margin, 0.1 + margin))
    assert team.guarantee().walls == (0.2, 0.05)
    apart = {m.what: m.clearance for m in team.margins([[-0.5, 0.5], [0, 0], [0, 0]], 2.0)}
    assert apart["robots 0 and 1"] == pytest.approx(1.0 - 0.05 - 0.25 - margin)


def test_late_robots_draw_apart_only_from_whom_they_are_too_close_to():
    """Two small robots may be nearer than a large one lets either come."""
    margins = LateCertificate(turn_rate_limit=1.0, time_step=STEP).late_margins
    cautious, none = CautiousRows(margins, (0.5, 0.1, 0.1)), ObstacleRows((), 0.1, 1.0)
    rows, _ = RowBook([], None).write(Scene(np.zeros((2, 3))))
    line = np.array([[0.0, 0.31, 0.45], [0.0, 0.0, 0.0]])  # kept: 0.3, 0.3 and 0.1
    assert len(cautious.added(rows, Scene(line), True, None, none)) == 0
    line[0, 1] = 0.29
    added = cautious.added(rows, Scene(line), True, None, none)
    assert {added.label(row) for row in range(len(added))} == {"robots 0 and 1"}
    assert len(added) == 16


@pytest.mark.parametrize("unicycles", [False, True])
def test_unequal_robots_stay_connected_while_they_flee_and_attack(unicycles):
    """Projection points go where they are certified, in steps."""
    links = ConnectivityParameters(0.6, gain=1e3, time_step=STEP)
    if unicycles:
        certificate = UnicycleCertificate(SIZES, GAINS, connectivity=links, **DRIVE)
    else:
        certificate = SingleIntegratorCertificate(
            SIZES, GAINS, speed_limit=SPEEDS, connectivity=links
        )
    rng = np.random.default_rng(1)
    points = np.array([[0.0, 0.45, -0.45, 0.0, 0.45], [0, 0.1, 0, -0.45, -0.3]])
    headings = rng.uniform(-3, 3, 5)
    left = least = np.inf
    for step in range(250):
        least = min(least, clearances(points).min())
        away = points - points.mean(axis=1, keepdims=True) + rng.normal(0, 0.1, (2, 5))
        desired = (1.0 if step // 60 % 2 == 0 else -1.0) * away
        if unicycles:
            ahead = AHEAD * np.stack([np.cos(headings), np.sin(headings)])
            poses = np.vstack([points - ahead, headings])
            velocity, info = certificate.project(desired, poses)
            headings = headings + STEP * certificate.commands(velocity, poses)[1]
        else:
            velocity, info = certificate(desired, points)
        points = points + STEP * velocity
        left = min(left, info.range_left)
        assert info.status in ("trivial", "optimal")
    assert left >= -1e-9
    assert least >= 0.0
    assert left < 0.05  # they did flee


def test_a_range_has_to_reach_from_the_largest_robot_to_another():
    links = ConnectivityParameters(0.3, time_step=STEP)
    SingleIntegratorCertificate((0.5, 0.5, 0.05), connectivity=links)
    with pytest.raises(ParameterError, match=r"expected more than the 0\.35 m"):
        SingleIntegratorCertificate((0.5, 0.2, 0.2), connectivity=links)
    named = ConnectivityParameters(0.3, [(0, 1)], time_step=STEP)
    SingleIntegratorCertificate((0.5, 0.05, 0.5), connectivity=named)
    with pytest.raises(ParameterError, match=r"expected more than the 0\.5 m"):
        SingleIntegratorCertificate((0.5, 0.5, 0.05), connectivity=named)
    with pytest.raises(ShapeError, match="links name robot 1"):
        SingleIntegratorCertificate([0.5], connectivity=named)([[0.0], [0.0]], [[0.0], [0.0]])


@pytest.mark.parametrize("late", [False, True])
def test_many_unequal_teams_are_answered_as_each_alone(late):
    numbers = {"safety_radius": SIZES, "barrier_gain": GAINS, "time_step": STEP, **DRIVE}
    certificate = UnicycleCertificate(**numbers)
    if late:
        certificate = LateCertificate.of(certificate, LateRobots(dead_time=(0.1, 0.2)))
    rng = np.random.default_rng(0)
    poses = np.concatenate([rng.uniform(-0.6, 0.6, (3, 2, 5)), rng.uniform(-3, 3, (3, 1, 5))], 1)
    desired = rng.normal(0, 0.2, (3, 2, 5))
    batch, each = BatchCertificate(certificate), [dataclasses.replace(certificate) for _ in poses]
    assert not batch.compiled
    np.testing.assert_array_equal(batch.distance, AHEAD)
    for _ in range(2):  # what late robots were sent is remembered
        commands, info = batch(desired, poses)
        for team, alone in enumerate(each):
            expected, told = alone(desired[team], poses[team])
            np.testing.assert_array_equal(commands[team], expected)
            assert str(info.statuses()[team]) == str(told.status)


def test_rollouts_drive_unequal_robots_to_their_goals():
    sizes, ahead = [0.3, 0.12, 0.12], [0.08, 0.03, 0.05]
    limits = {"speed_limit": [0.1, 0.2, 0.2], "turn_rate_limit": 1.5, "time_step": STEP}
    certificate = UnicycleCertificate(sizes, 1e4, projection_distance=ahead, **limits)
    poses = np.array([[[0.0, 0.6, -0.5], [0.0, 0.1, -0.2], [0.0, 3.0, 0.0]]])
    goals = poses[:, :2] + np.array([[0.1, -0.1, 0.05], [0.05, 0.2, -0.1]])
    arena = BatchArena(poses, engine="numpy")
    outcome = rollout(arena, BatchCertificate(certificate), ToGoals(goals), steps=300)
    assert outcome.clearance.min() >= 0.0
    heading = np.stack([np.cos(arena.poses[0, 2]), np.sin(arena.poses[0, 2])])
    points = arena.poses[0, :2] + np.array(ahead) * heading
    np.testing.assert_allclose(points, goals[0], rtol=0, atol=0.02)


def test_a_flock_is_of_equal_robots():
    arena = {"boundary": ARENA, "wall_margin": 0.1}
    for unequal in ({"safety_radius": (0.2, 0.3)}, {"speed_limit": (0.1, 0.2)}):
        with pytest.raises(FlockParameterError, match="numbers for each of 2 robots"):
            Flock(certificate=UnicycleCertificate(**arena, **unequal))


def test_profiles_make_certificates_of_unequal_robots_too():
    ideal = UnicycleCertificate(
        (0.3, 0.185), 2e3, speed_limit=(0.1, 0.15), turn_rate_limit=0.55, time_step=STEP
    )
    late = late_certificate(ideal, load_profile("gritsbot_x"))
    equal = dataclasses.replace(ideal, safety_radius=0.185, speed_limit=0.15)
    fastest = late_certificate(equal, load_profile("gritsbot_x"))
    assert late.robots == fastest.robots
    assert late.guarantee().pairs == (0.3, 0.185)
    assert late.late_margins.stop_error == fastest.late_margins.stop_error


def test_compiled_code_is_for_equal_robots(monkeypatch):
    monkeypatch.setattr("barrier_certificates.batch.batch_certificate.is_compiled", lambda _: True)
    assert not BatchCertificate(UnicycleCertificate((0.2, 0.1))).compiled
    with pytest.raises(ParameterError, match="one number for all robots"):
        BatchCertificate(UnicycleCertificate((0.2, 0.1)), engine="numba")
