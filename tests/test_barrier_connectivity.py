"""Teams that stay connected: rows of links against calculus, another solver, and a closed loop."""

import warnings
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from driven_unicycles import ARENA, STEP, D
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.sparse.csgraph import minimum_spanning_tree

from barrier_certificates.batch import BatchCertificate
from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.rows import ConnectivityParameters
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

RADIUS, RANGE, SPEED = 0.12, 0.4, 0.2
SEEDS = st.integers(0, 2**32 - 1)


def stretched_team(rng, number, reach=RANGE):
    """Return positions of a safe, connected team, whose links are near the range or anywhere."""
    points = np.zeros((2, 1))
    while points.shape[1] < number:
        distance = reach - rng.choice([0.0, 1e-6, 1e-3, 0.1]) * rng.random()
        angle, middle = rng.uniform(-np.pi, np.pi), points[:, rng.integers(points.shape[1])]
        new = middle + (distance - 1e-12) * np.array([np.cos(angle), np.sin(angle)])
        if np.hypot(*(points - new[:, None])).min() > RADIUS:
            points = np.column_stack([points, new])
    return points


def is_connected(points, reach=RANGE):
    """Return whether a walk from robot 0 along links comes to every robot."""
    reached, waiting = {0}, [0]
    while waiting:
        robot = waiting.pop()
        distance = np.hypot(*(points - points[:, robot : robot + 1]))
        new = set(np.flatnonzero(distance <= reach + 1e-9).tolist()) - reached
        reached |= new
        waiting += new
    return len(reached) == points.shape[1]


def certificate_of(links="tree", gain=100.0, time_step=STEP, **more):
    connectivity = ConnectivityParameters(RANGE, links, gain=gain, time_step=time_step)
    return SingleIntegratorCertificate(RADIUS, 500.0, connectivity=connectivity, **more)


@given(SEEDS, st.integers(2, 6))
def test_rows_are_the_derivatives_of_their_barriers(seed, number):
    rng = np.random.default_rng(seed)
    points, velocity = stretched_team(rng, number), rng.normal(0, 0.2, (2, number))
    # One end is a little beyond range now and then: its row holds the link as long as it is.
    points[:, -1] *= rng.uniform(0.9, 1.1)
    every = tuple(combinations(range(number), 2))
    certificate = replace(certificate_of(every, gain=70.0, time_step=0.0), pair_rows=False)
    _, info = certificate(np.zeros((2, number)), points)
    first = 8 * number  # after the sides of the octagon
    assert info.rows.label(first) == "robots 0 and 1 in range"
    excess = info.rows.excess(velocity.T.reshape(-1))[first:]

    def barriers(time):
        moved = points + time * velocity
        return np.array([RANGE**2 - ((moved[:, i] - moved[:, j]) ** 2).sum() for i, j in every])

    derivative = (barriers(1e-3) - barriers(-1e-3)) / 2e-3  # exact, since h is quadratic
    length = np.sqrt(RANGE**2 - barriers(0.0))
    asked = -derivative - 70.0 * np.maximum(barriers(0.0), 0.0) ** 3
    assert_allclose(excess, asked / (2 * np.sqrt(2) * length), atol=1e-9)


@settings(max_examples=150)
@given(SEEDS, st.booleans())
def test_whatever_two_robots_do_within_their_rows_no_step_leads_out_of_range(seed, lost):
    """Sideways above all, for which the row of continuous time is blind; whatever the gain."""
    rng = np.random.default_rng(seed)
    step = rng.choice([0.01, 0.033, 0.25])
    length = RANGE + (0.3 * rng.random() if lost else -(10 ** rng.uniform(-12, -1)))
    angle = rng.uniform(-np.pi, np.pi)
    points = (
        0.5 * length * np.array([[-np.cos(angle), np.cos(angle)], [-np.sin(angle), np.sin(angle)]])
    )
    certificate = certificate_of(gain=10 ** rng.uniform(0, 12), time_step=step)
    turn = angle + rng.choice([-1, 1]) * (np.pi / 2 - rng.exponential(0.1))
    wish = np.outer([np.cos(turn), np.sin(turn)], [-1.0, 1.0])
    velocity, info = certificate(wish, points)
    assert info.status == "optimal"
    after = points + step * velocity
    assert np.hypot(*(after[:, 0] - after[:, 1])) <= max(RANGE, length) + 1e-9 * step
    assert info.disconnected_start == lost


def links_by_hand(points, links, gain, step):
    """Return rows and bounds of links, from the formulas of the documentation."""
    number, rows = points.shape[1], []
    sine = 2 * SPEED * step / RANGE
    for i, j in links:
        offset = points[:, i] - points[:, j]
        length = np.hypot(*offset)
        h = max(RANGE**2 - length**2, 0.0)
        room = gain * h**3 / (2 * length)
        if step:
            room = min(room, max(RANGE - length, 0.0) / (2 * step))
        for s in (sine, -sine) if step else (0.0,):
            c = np.sqrt(1 - s**2)
            x, y = np.array([[c, -s], [s, c]]) @ offset / length
            dense = np.zeros((number, 2))
            dense[i], dense[j] = (x, y), (-x, -y)
            rows.append((dense.ravel(), room * c))
    return rows


def nearest_by_cvxpy(wish, points, links, gain, step):
    """Return the optimum of the team's program, as on a blackboard."""
    cvxpy = pytest.importorskip("cvxpy")
    number = points.shape[1]
    rows = links_by_hand(points, links, gain, step)
    for i, j in combinations(range(number), 2):
        dense, offset = np.zeros((number, 2)), points[:, i] - points[:, j]
        dense[i], dense[j] = -2 * offset, 2 * offset
        rows.append((dense.ravel(), 500.0 * (offset @ offset - RADIUS**2) ** 3))
    for i in range(number):
        for angle in np.arange(8) * np.pi / 4:
            dense = np.zeros((number, 2))
            dense[i] = np.cos(angle), np.sin(angle)
            rows.append((dense.ravel(), SPEED * np.cos(np.pi / 8)))
    normals, bounds = np.array([a for a, _ in rows]), np.array([b for _, b in rows])
    length = np.linalg.norm(normals, axis=1)
    velocity = cvxpy.Variable(2 * number)
    problem = cvxpy.Problem(
        cvxpy.Minimize(cvxpy.sum_squares(velocity - wish.T.ravel())),
        [(normals / length[:, None]) @ velocity <= bounds / length],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        tight = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), 1e-14)
        problem.solve(solver=cvxpy.CLARABEL, **tight)
    return velocity.value.reshape(-1, 2).T


@settings(max_examples=40)
@given(SEEDS, st.integers(2, 6), st.booleans())
def test_answers_are_those_of_a_program_written_by_hand(seed, number, in_steps):
    rng = np.random.default_rng(seed)
    points, wish = stretched_team(rng, number), rng.normal(0, 0.2, (2, number))
    length = np.hypot(*(points[:, :, None] - points[:, None, :]))
    tree = np.stack(minimum_spanning_tree(length).nonzero()).T
    gain, step = 10 ** rng.uniform(1, 5), STEP if in_steps else 0.0
    velocity, info = certificate_of(gain=gain, time_step=step)(wish, points)
    assert info.status in ("trivial", "optimal")
    assert_allclose(velocity, nearest_by_cvxpy(wish, points, tree, gain, step), atol=1e-7)
    assert_allclose(info.range_left, RANGE - length[tree[:, 0], tree[:, 1]].max(), atol=1e-12)


@given(SEEDS, st.integers(1, 12), st.sampled_from(["tree", "all"]), st.booleans())
def test_a_safe_connected_team_may_always_stand_still(seed, number, links, alone):
    points = stretched_team(np.random.default_rng(seed), number)
    bounds = (points[0].min() - 0.06, points[0].max() + 0.06, -9.0, 9.0)  # walls touch, too
    certificate = certificate_of(links, boundary=bounds, decentralised=alone)
    _, info = certificate(np.zeros((2, number)), points)
    assert info.status == "trivial"
    assert info.clearance >= -1e-12
    assert info.range_left >= 0
    assert not info.disconnected_start


@given(SEEDS, st.integers(2, 8))
def test_another_order_of_the_robots_changes_nothing(seed, number):
    rng = np.random.default_rng(seed)
    points, wish = rng.uniform(-0.5, 0.5, (2, number)), rng.normal(0, 0.2, (2, number))
    order = rng.permutation(number)
    certificate = certificate_of()
    velocity, info = certificate(wish, points)
    certificate.reset()
    other, told = certificate(wish[:, order], points[:, order])
    assert_allclose(told.range_left, info.range_left, atol=1e-12)
    if info.status != "relaxed":
        assert_allclose(other, velocity[:, order], atol=1e-7)


def drive(certificate, poses, steps=300, seed=5):
    """Pull a team apart: leaders to all sides, wishes that change; return what happened."""
    rng, number = np.random.default_rng(seed), poses.shape[1]
    angle = 2 * np.pi * np.arange(number) / number
    away, apart, seen = 0.2 * np.stack([np.cos(angle), np.sin(angle)]), 0, []
    for step in range(steps):
        if step % 60 == 0:
            wish = away if step % 120 == 0 else rng.normal(0, 0.15, (2, number))
        points = poses[:2]
        if isinstance(certificate, UnicycleCertificate):
            points = points + D * np.stack([np.cos(poses[2]), np.sin(poses[2])])
            velocity, info = certificate.project(wish, poses)
            v, w = certificate.commands(velocity, poses)
            middle = poses[2] + 0.5 * STEP * w
            arc = STEP * v * np.sinc(0.5 * STEP * w / np.pi)
            poses = poses + np.stack([arc * np.cos(middle), arc * np.sin(middle), STEP * w])
        else:
            velocity, info = certificate(wish, poses[:2])
            poses = poses + STEP * np.vstack([velocity, np.zeros(number)])
        seen.append(info)
        apart += not is_connected(points)
    return apart, seen


@pytest.mark.parametrize("links", ["tree", "all"])
@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize("kind", [SingleIntegratorCertificate, UnicycleCertificate])
def test_a_team_that_is_pulled_apart_stays_connected(kind, alone, links):
    options = {"boundary": ARENA, "speed_limit": SPEED, "decentralised": alone}
    if kind is UnicycleCertificate:
        options |= {"turn_rate_limit": 3.6, "time_step": STEP}
    grid = np.array(np.meshgrid(np.arange(3), np.arange(3))).reshape(2, -1)
    poses = np.vstack([0.25 * (grid - 1.0), np.zeros((1, 9))])
    step = None if kind is UnicycleCertificate else STEP
    connectivity = ConnectivityParameters(RANGE, links, gain=1e5, time_step=step)
    connected = kind(RADIUS, 500.0, connectivity=connectivity, **options)
    apart, seen = drive(connected, poses)
    assert not apart
    assert {str(info.status) for info in seen} <= {"trivial", "optimal"}
    assert min(info.range_left for info in seen) >= -1e-9
    assert min(info.range_left for info in seen) < 0.01  # they are really held
    assert min(info.clearance for info in seen) >= 0
    assert any("in range" in name for info in seen for name in info.active)
    apart, seen = drive(replace(connected, connectivity=None), poses)
    assert apart > 100
    assert seen[-1].range_left == np.inf


def range_left_with_bad_wheels(certificate, push):
    """Pull two robots apart whose wheels turn faster than told; return the least that is left."""
    poses = np.array([[-0.1, 0.1], [0.0, 0.0], [np.pi, 0.0]])  # back to back
    least = np.inf
    for _ in range(150):
        heading = np.stack([np.cos(poses[2]), np.sin(poses[2])])
        velocity, _ = certificate.project([[-0.2, 0.2], [0.02, 0.02]], poses)
        v, w = certificate.commands(velocity + push * heading, poses)
        poses = poses + STEP * np.stack([v * heading[0], v * heading[1], w])
        points = poses[:2] + D * np.stack([np.cos(poses[2]), np.sin(poses[2])])
        least = min(least, RANGE - np.hypot(*(points[:, 0] - points[:, 1])))
    return least


def test_wheels_that_turn_faster_than_told_do_not_break_links():
    certificate = UnicycleCertificate(
        RADIUS, 500.0, speed_limit=0.15, turn_rate_limit=2.0, time_step=STEP,
        wheel_disturbance=0.5, connectivity=ConnectivityParameters(RANGE, gain=1e6),
    )  # fmt: skip
    push = certificate.disturbance().along
    assert range_left_with_bad_wheels(certificate, push) >= 0
    assert range_left_with_bad_wheels(replace(certificate, wheel_disturbance=0.0), push) < -1e-3


def test_a_start_that_is_not_connected_is_told_and_gets_no_worse():
    """Two robots here, two there: each two stay linked, and their parts do not drift farther."""
    points = np.array([[-0.5, -0.3, 0.3, 0.5], [0.0, 0.0, 0.0, 0.0]])
    wish = np.array([[-0.2, -0.2, 0.2, 0.2], [0.1, 0.0, 0.0, -0.1]])
    for links in ("tree", "all"):
        certificate, places = certificate_of(links, gain=1e4), points
        for step in range(100):
            velocity, info = certificate(wish, places)
            assert info.disconnected_start == (step == 0)
            assert info.status == "optimal"
            assert info.longest_link == "robots 1 and 2 in range"
            assert RANGE - 0.6 - 1e-9 <= info.range_left < -0.19
            assert not info.unsafe_start
            assert info.clearance > 0
            places = places + STEP * velocity
        # Whoever brings them together has their link kept from then on.
        for step in range(200):
            toward = -np.sign(places) if step < 60 else np.sign(places)
            velocity, info = certificate(0.1 * toward, places)
            places = places + STEP * velocity
        assert is_connected(places)
        assert info.range_left >= -1e-9
        certificate.reset()
        assert not certificate(wish, places)[1].disconnected_start


def test_links_that_are_given_are_kept_and_no_others():
    points = np.array([[0.0, 0.39, 0.0], [0.0, 0.0, 0.3]])
    wish = np.array([[0.0, 0.15, 0.0], [0.0, 0.0, 0.15]])
    certificate = certificate_of([(1, 0)])
    velocity, info = certificate(wish, points)
    assert set(info.active) == {"robots 0 and 1 in range"}
    assert_allclose(velocity[:, 2], wish[:, 2], atol=1e-12)  # goes where it likes
    assert certificate.connectivity.links == ((0, 1),)
    assert certificate.reach() == max(RANGE, replace(certificate, connectivity=None).reach())
    assert certificate_of().reach() == np.inf
    with pytest.raises(ShapeError, match="links name robot 1, but the team has 1"):
        certificate([[0.0], [0.0]], [[0.0], [0.0]])


def test_reports_of_earlier_calls_keep_their_names_and_margins_change_no_tree():
    certificate = certificate_of()
    chain = np.array([[0.0, 0.39, 0.78], [0.0, 0.0, 0.0]])
    pull = np.array([[-0.2, 0.0, 0.2], [0.0, 0.0, 0.0]])
    _, info = certificate(pull, chain)
    names = info.active
    assert set(names) == {"robots 0 and 1 in range", "robots 1 and 2 in range"}
    assert info.nearest == "robots 0 and 1"  # what may collide; links are told apart
    assert info.longest_link in names
    other = chain[:, [1, 0, 2]]
    found = certificate.margins(other, within=0.02)
    assert [(m.what, round(m.clearance, 9)) for m in found] == [
        ("robots 0 and 1 in range", 0.01), ("robots 0 and 2 in range", 0.01),
    ]  # fmt: skip
    assert_allclose([m.h for m in found], RANGE**2 - 0.39**2)
    assert certificate(pull, chain)[1].active == names
    certificate(pull, other)
    assert info.active == names


def test_robots_that_overlap_part_although_links_pull():
    """Links are given up before robots collide, and hardly at all where nothing is wrong."""
    points = np.array([[0.0, 0.02, 0.42, -0.37], [0.0, 0.0, 0.0, 0.0]])
    certificate = certificate_of([(1, 2), (0, 3)], unsafe_gain=1e7)
    velocity, info = certificate([[0.0, 0.0, 0.2, -0.01], [0.0] * 4], points)
    assert info.status == "relaxed"
    assert info.unsafe_start
    assert velocity[0, 1] - velocity[0, 0] > 0.2  # a speed of 0.4 m/s is the most there is
    assert velocity[0, 2] - velocity[0, 1] < 1e-4


def test_what_is_not_a_number_leaves_nothing_known_of_links():
    _, info = certificate_of()([[np.nan, 0.0], [0.0, 0.0]], [[0.0, 0.3], [0.0, 0.0]])
    assert info.status == "failed"
    assert np.isnan(info.range_left)
    assert info.longest_link is None


def test_large_teams_and_teams_that_change_their_size():
    certificate, rng = certificate_of(), np.random.default_rng(0)
    for number in (45, 3, 1, 45):  # large teams write near pairs alone
        points = stretched_team(rng, number)
        velocity, info = certificate(rng.normal(0, 0.2, (2, number)), points)
        assert info.status in ("trivial", "optimal")
        assert is_connected(points + STEP * velocity)
        assert (info.longest_link is None) == (number == 1)


def test_many_teams_are_answered_as_each_alone():
    certificate, rng = certificate_of(), np.random.default_rng(1)
    batch, each = BatchCertificate(certificate), [replace(certificate) for _ in range(3)]
    assert not batch.compiled
    points = np.stack([stretched_team(rng, 5) for _ in each])
    for _ in range(5):
        wishes = rng.normal(0, 0.2, (3, 2, 5))
        velocities, _ = batch(wishes, points)
        for one, wish, place, velocity in zip(each, wishes, points, velocities, strict=True):
            assert_array_equal(velocity, one(wish, place)[0])
        points = points + STEP * velocities
    with pytest.raises(ParameterError, match="connectivity"):
        BatchCertificate(certificate, engine="numba")
