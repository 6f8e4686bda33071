"""Robots that certify themselves: exact each, and together inside what the team's rows admit."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from barrier_certificates.batch import BatchCertificate
from barrier_certificates.certificate_errors import InfeasibleError, ParameterError, ShapeError
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_robots import LateRobots
from barrier_certificates.projection.plane_points import PlaneRows, nearest_points
from barrier_certificates.rows import Disc
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)
SEEDS = st.integers(0, 2**32 - 1)


def best_of_all(target, normals, bounds):
    """Return the nearest admitted point out of all that can be it; None where none is admitted."""
    sides = list(zip(normals.T, bounds, strict=True))
    candidates = [target, *(target - (n @ target - b) * n for n, b in sides)]
    for (n, b), (m, c) in combinations(sides, 2):
        if abs(n[0] * m[1] - n[1] * m[0]) > 1e-9:
            candidates.append(np.linalg.solve(np.array([n, m]), np.array([b, c])))
    admitted = [x for x in candidates if (normals.T @ x <= bounds + 1e-9).all()]
    return min(admitted, key=lambda x: np.hypot(*(x - target)), default=None)


@given(SEEDS, st.integers(1, 9))
def test_the_point_of_each_program_is_the_nearest_one(seed, rows):
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-np.pi, np.pi, (rows, 6))
    angles[:, ::2] = np.round(angles[:, ::2] * 4 / np.pi) * np.pi / 4  # parallel sides, too
    normals, bounds = np.stack([np.cos(angles), np.sin(angles)]), rng.normal(0.2, 0.5, (rows, 6))
    bounds[rng.random((rows, 6)) < 0.1] = np.inf  # programs with fewer rows
    targets = rng.normal(size=(2, 6))
    found = nearest_points(targets, PlaneRows(normals, bounds))
    for k in range(6):
        there = np.isfinite(bounds[:, k])
        best = best_of_all(targets[:, k], normals[:, there, k], bounds[there, k])
        assert found.settled[k] == (best is not None)
        if best is not None:
            assert_allclose(found.points[:, k], best, atol=1e-7)


def team(seed, unicycles, number):
    """Return a decentralised certificate, commands and poses of a crowded team."""
    rng = np.random.default_rng(seed)
    options = {
        "boundary": ARENA,
        "speed_limit": 0.2,
        "obstacles": [Disc((0.2, 0.1), 0.1)],
        "decentralised": True,
        "shares": rng.uniform(0.2, 3.0, number) if rng.random() < 0.5 else None,
    }
    gain = 10 ** rng.uniform(1, 4)
    if unicycles:
        disturbed = rng.choice([0.0, 0.3])
        options |= {"turn_rate_limit": 3.0, "wheel_disturbance": disturbed}
        certificate = UnicycleCertificate(0.12, gain, **options)
    else:
        certificate = SingleIntegratorCertificate(0.12, gain, **options)
    size = 0.12 * np.sqrt(number)
    poses = np.vstack([rng.uniform(-size, size, (2, number)), rng.uniform(-3, 3, (1, number))])
    return certificate, rng.normal(0, 0.2, (2, number)), poses


def asked(certificate, velocity, poses):
    if isinstance(certificate, UnicycleCertificate):
        return certificate.project(velocity, poses)
    return certificate(velocity, poses[:2])


@settings(max_examples=60)
@given(SEEDS, st.booleans(), st.sampled_from([1, 2, 5, 9, 45]))
def test_what_robots_choose_by_themselves_satisfies_the_teams_rows(seed, unicycles, number):
    """Also in large teams, whose far pairs are not written at all."""
    certificate, command, poses = team(seed, unicycles, number)
    velocity, info = asked(certificate, command, poses)
    if info.status not in ("trivial", "optimal"):
        return
    joint = replace(certificate, decentralised=False, shares=None)
    again, told = asked(joint, velocity, poses)
    assert told.rows.excess(velocity.T.reshape(-1)).max() <= 1e-9
    assert told.status == "trivial"
    assert_array_equal(again, velocity)
    assert info.violation <= 1e-9
    # The team's optimum is at least as near, all robots together.
    nearest, _ = asked(joint, command, poses)
    assert np.square(nearest - command).sum() <= np.square(velocity - command).sum() + 1e-9
    assert (info.clearance, info.nearest) == (told.clearance, told.nearest)


def test_two_robots_head_on_share_what_is_left():
    """Half and half; or as their shares are, and the row of the pair binds either way."""
    positions, command = np.array([[-0.1, 0.1], [0.0, 0.0]]), np.array([[0.2, -0.2], [0.0, 0.0]])
    h = 0.2**2 - 0.15**2
    room = 100.0 * h**3 / (2 * 0.2)  # of closing speed
    for shares, first in ((None, 0.5), ((3.0, 1.0), 0.75)):
        certificate = SingleIntegratorCertificate(decentralised=True, shares=shares)
        velocity, info = certificate(command, positions)
        assert_allclose(velocity[0], [first * room, (first - 1.0) * room], atol=1e-12)
        assert info.status == "optimal"
        assert info.active == ("robots 0 and 1",)
        assert info.intervention == pytest.approx(0.2 - min(first, 1 - first) * room)


def test_who_follows_another_is_held_where_the_team_would_let_him_go():
    """The price: a robot counts on nothing that another does."""
    positions, command = np.array([[-0.1, 0.1], [0.0, 0.0]]), np.full((2, 2), [[0.1], [0.0]])
    joint = SingleIntegratorCertificate()
    assert joint(command, positions)[1].status == "trivial"
    velocity, info = replace(joint, decentralised=True)(command, positions)
    assert info.status == "optimal"
    assert velocity[0, 0] < 0.01
    assert_array_equal(velocity[:, 1], command[:, 1])


@pytest.mark.parametrize("unicycles", [False, True])
def test_teams_under_attack_stay_safe(unicycles):
    rng = np.random.default_rng(4)
    options = {"boundary": ARENA, "speed_limit": 0.2, "decentralised": True}
    certificate = (
        UnicycleCertificate(0.15, 500.0, time_step=0.033, turn_rate_limit=3.6, **options)
        if unicycles
        else SingleIntegratorCertificate(0.15, 500.0, **options)
    )
    grid = np.array(np.meshgrid(np.arange(3), np.arange(3))).reshape(2, -1)
    poses = np.vstack([0.27 * (grid - 1.0), rng.uniform(-3, 3, (1, 9))])
    for _ in range(150):
        attack = rng.normal(0, 0.05, (2, 9)) - 3.0 * poses[:2]
        velocity, info = asked(certificate, attack, poses)
        assert info.status in ("trivial", "optimal")
        assert info.smallest_h >= 0
        if unicycles:
            v, w = certificate.commands(velocity, poses)
            middle = poses[2] + 0.5 * 0.033 * w
            arc = 0.033 * v * np.sinc(0.5 * 0.033 * w / np.pi)
            poses = poses + np.stack([arc * np.cos(middle), arc * np.sin(middle), 0.033 * w])
        else:
            poses[:2] += 0.033 * velocity


OVERLAP = np.array([[0.0, 0.05, 0.02, -0.9], [0.0, 0.0, 0.04, 0.0]])


def test_policies_are_for_the_robots_that_have_no_safe_velocity():
    """Three overlap and cannot part as fast as their rows ask; the fourth drives on."""
    command = np.full((2, 4), 0.1)
    relaxing = SingleIntegratorCertificate(
        0.3, 1e5, speed_limit=0.2, decentralised=True, boundary=ARENA
    )
    velocity, info = relaxing(command, OVERLAP)
    assert info.status == "relaxed"
    assert set(info.violated) <= {"robots 0 and 1", "robots 0 and 2", "robots 1 and 2"}
    assert info.violated
    assert info.violation > 1e-3
    assert np.hypot(*velocity).max() <= 0.2 + 1e-9
    assert velocity[0, 0] < 0 < velocity[0, 1]  # they part
    velocity, info = replace(relaxing, on_infeasible="stop")(command, OVERLAP)
    assert info.status == "failed"
    assert_array_equal(velocity, [[0, 0, 0, 0.1], [0, 0, 0, 0.1]])
    with pytest.raises(InfeasibleError, match="robots 0 and 1"):
        replace(relaxing, on_infeasible="raise")(command, OVERLAP)


def test_numbers_that_are_none_stop_everybody():
    certificate = SingleIntegratorCertificate(decentralised=True)
    velocity, info = certificate([[np.nan, 0.1], [0.0, 0.0]], [[0.0, 0.5], [0.0, 0.0]])
    assert info.status == "failed"
    assert_array_equal(velocity, np.zeros((2, 2)))
    huge = np.array([[1e300, 0.1], [0.0, 0.0]])  # a direction, and no more
    velocity, info = replace(certificate, speed_limit=0.2)(huge, [[0.0, 0.5], [0.0, 0.0]])
    assert info.status == "optimal"
    assert np.hypot(*velocity).max() <= 0.2 + 1e-9


def test_robots_beyond_reach_change_nothing():
    certificate = SingleIntegratorCertificate(0.15, 100.0, speed_limit=0.2, decentralised=True)
    reach = certificate.reach()
    near = np.array([[0.0, 0.17, 0.0], [0.0, 0.0, 0.17]])
    command = np.full((2, 4), [[0.1], [0.1]])
    answers = []
    for angle, speed in ((0.0, 0.1), (2.0, -0.2), (4.0, 0.0)):
        far = (reach + 0.2) * np.array([[np.cos(angle)], [np.sin(angle)]])
        command[:, 3] = speed
        answers.append(certificate(command, np.hstack([near, far]))[0][:, 0])
    assert_array_equal(answers[1], answers[0])
    assert_array_equal(answers[2], answers[0])
    # A robot that takes the smaller part has to see farther.
    assert replace(certificate, shares=(1.0, 9.0)).reach() > reach
    assert replace(certificate, pair_rows=False).reach() == 0.0
    assert SingleIntegratorCertificate(speed_limit=None).reach() == np.inf


@pytest.mark.parametrize("shares", [(1.0, 0.0), (), "ab", [[1.0, 2.0]], (1.0, np.nan)])
def test_shares_that_are_none_are_refused(shares):
    with pytest.raises(ParameterError, match="shares are"):
        SingleIntegratorCertificate(decentralised=True, shares=shares)


def test_what_does_not_go_together_is_refused():
    with pytest.raises(ParameterError, match="decentralised=True"):
        SingleIntegratorCertificate(shares=(1.0, 2.0))
    three = SingleIntegratorCertificate(decentralised=True, shares=(1.0, 2.0, 1.0))
    with pytest.raises(ShapeError, match="shares are for 3 robots, but the team has 2"):
        three(np.zeros((2, 2)), [[0.0, 0.5], [0.0, 0.0]])
    with pytest.raises(ParameterError, match="computed for the team"):
        LateCertificate(
            0.2, 2000.0, speed_limit=0.15, turn_rate_limit=0.55, time_step=0.033,
            robots=LateRobots(dead_time=(0.19, 0.2)), decentralised=True,
        )  # fmt: skip


def test_many_teams_are_answered_as_each_alone():
    certificate, command, poses = team(3, False, 5)
    batch = BatchCertificate(certificate)
    assert not batch.compiled
    commands, states = np.stack([command, -command]), np.stack([poses[:2], poses[:2]])
    velocities, _ = batch(commands, states)
    for k in range(2):
        assert_array_equal(velocities[k], replace(certificate)(commands[k], states[k])[0])
    with pytest.raises(ParameterError, match="whole team"):
        BatchCertificate(certificate, engine="numba")
