"""Teams of unequal robots: each has its own size, gains, margins, limits and wheels."""

import dataclasses

import numpy as np
import pytest
from driven_unicycles import ARENA, STEP
from hypothesis import given, settings
from hypothesis import strategies as st
from unequal_teams import (
    AHEAD,
    DRIVE,
    GAINS,
    SIZES,
    SPEEDS,
    clearances,
    drawn_team,
    optimum,
    program_of,
)

from barrier_certificates.batch import BatchCertificate
from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.differential_drive import DifferentialDrive
from barrier_certificates.guarantee import largest_gain, largest_wall_gain
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.rows import (
    Disc,
    RowBook,
    Scene,
    UnequalLimitRows,
    UnequalPairRows,
    VelocityPolygon,
)
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

SEEDS = st.integers(0, 2**31 - 1)


@settings(max_examples=40)
@given(SEEDS, st.integers(1, 6), st.booleans())
def test_the_answer_is_the_optimum_of_the_program_written_out_robot_by_robot(
    seed, robots, unicycles
):
    team = drawn_team(seed, robots)
    velocity, info = team.ask(team.certificate(unicycles))
    expected = optimum(program_of(team, unicycles))
    if expected is None:
        assert info.status == "relaxed"
    else:
        assert info.status in ("trivial", "optimal")
        np.testing.assert_allclose(velocity, expected, rtol=0, atol=1e-7)


@settings(max_examples=15)
@given(SEEDS, st.sampled_from(["relax", "stop"]), st.booleans())
def test_one_number_for_all_is_a_sequence_of_that_number(seed, policy, alone):
    """Whatever can be given for each robot; also with arcs of turning robots and unsafe starts."""
    team = drawn_team(seed, 4, spread=0.5)
    given_to_all = {name: value[0] for name, value in team.numbers.items()}
    more = {"on_infeasible": policy, "decentralised": alone, "obstacles": [Disc((0.1, 0.1), 0.1)]}
    drives = {"time_step": STEP, "boundary": ARENA}
    for unicycles in (False, True):
        kind = UnicycleCertificate if unicycles else SingleIntegratorCertificate
        names, also = set(kind.may_differ), more | (drives if unicycles else {})
        each = {name: [value] * 4 for name, value in given_to_all.items() if name in names}
        equal = kind(**{name: given_to_all[name] for name in each}, **also)
        unequal = kind(**each, **also)
        assert unequal.team_size == 4
        assert equal.team_size is None
        (one, told), (other, heard) = team.ask(equal), team.ask(unequal)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)
        assert (told.status, told.nearest) == (heard.status, heard.nearest)
        assert told.clearance == pytest.approx(heard.clearance, abs=1e-12)
        assert told.smallest_h == pytest.approx(heard.smallest_h, abs=1e-12)
        assert unequal.reach() == pytest.approx(equal.reach())
        states = team.poses if unicycles else team.poses[:2]
        margins, others = equal.margins(states, 0.3), unequal.margins(states, 0.3)
        assert [margin.what for margin in margins] == [margin.what for margin in others]


@settings(max_examples=15)
@given(SEEDS, st.integers(2, 6), st.booleans(), st.booleans())
def test_robots_in_another_order_get_the_same_answers(seed, robots, unicycles, alone):
    team = drawn_team(seed, robots)
    order = np.random.default_rng(seed).permutation(robots)
    velocity, info = team.ask(team.certificate(unicycles, decentralised=alone))
    moved = team.take(order)
    again, same = moved.ask(moved.certificate(unicycles, decentralised=alone))
    np.testing.assert_allclose(again, velocity[:, order], rtol=0, atol=1e-7)
    assert same.status == info.status
    assert same.clearance == pytest.approx(info.clearance, abs=1e-12)


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize("unicycles", [False, True])
def test_a_large_slow_robot_and_small_fast_ones_under_attack_stay_safe(unicycles, alone):
    """All drive at whoever is nearest; h of each pair's own distance, walls and limits are kept."""
    given_both = {"boundary": ARENA, "decentralised": alone}
    if unicycles:
        certificate = UnicycleCertificate(SIZES, GAINS, time_step=STEP, **DRIVE, **given_both)
    else:
        certificate = SingleIntegratorCertificate(SIZES, GAINS, speed_limit=SPEEDS, **given_both)
    rng = np.random.default_rng(3)
    poses = np.array([[0.0, 0.9, -0.8, 0.0, 0.6], [0.0, 0.5, 0.3, -0.7, -0.5], [0, 1, 2, 3, 4.0]])
    least = np.inf
    for _ in range(250):
        heading = np.stack([np.cos(poses[2]), np.sin(poses[2])])
        points = poses[:2] + (AHEAD * heading if unicycles else 0.0)
        least = min(least, clearances(points).min())
        assert least >= 0.0
        room = np.array([[ARENA[1]], [ARENA[3]]]) - 0.5 * SIZES
        assert np.all(np.abs(points) <= room)
        gap = points[:, None, :] - points[:, :, None]
        nearest = (np.hypot(*gap) - 0.5 * SIZES + 9 * np.eye(5)).argmin(axis=1)
        attack = 5 * (points[:, nearest] - points) + rng.normal(0, 0.1, (2, 5))
        if unicycles:
            velocity, info = certificate.project(attack, poses)
            v, w = certificate.commands(velocity, poses)
            assert np.all(np.abs(v) <= SPEEDS + 1e-8)
            assert np.all(np.abs(w) <= np.array(DRIVE["turn_rate_limit"]) + 1e-8)
            rim = np.abs(v) + 0.5 * np.array(DRIVE["base_length"]) * np.abs(w)
            wheels = np.array(DRIVE["wheel_limit"]) * np.array(DRIVE["wheel_radius"])
            assert np.all(rim <= wheels + 1e-8)
            poses = poses + STEP * np.stack([v * heading[0], v * heading[1], w])
        else:
            velocity, info = certificate(attack, poses[:2])
            assert np.all(np.hypot(*velocity) <= SPEEDS + 1e-9)
            poses[:2] += STEP * velocity
        assert info.status in ("trivial", "optimal")
        assert info.violation <= 1e-9
        assert info.clearance >= 0.0
    assert least < 0.03  # they did meet


def test_of_two_the_more_cautious_gain_counts_and_the_sooner_parting():
    apart, together = [[0.0, 0.2], [0.0, 0.0]], [[0.0, 0.1], [0.0, 0.0]]
    closing = [[1.0, -1.0], [0.0, 0.0]]

    def closes(states, **gains):
        velocity, _ = SingleIntegratorCertificate(0.15, speed_limit=None, **gains)(closing, states)
        return velocity[0, 0] - velocity[0, 1]

    assert closes(apart, barrier_gain=(50.0, 900.0)) == pytest.approx(
        closes(apart, barrier_gain=50.0)
    )
    parting = {"barrier_gain": 100.0, "unsafe_gain": (50.0, 900.0)}
    assert closes(together, **parting) == pytest.approx(
        closes(together, barrier_gain=100.0, unsafe_gain=900.0)
    )
    assert closes(together, barrier_gain=(50.0, 900.0)) == pytest.approx(
        closes(together, barrier_gain=50.0)
    )


def test_by_default_margins_are_each_robots_own_half():
    sizes = (0.4, 0.1)
    certificate = SingleIntegratorCertificate(
        sizes, boundary=ARENA, obstacles=[Disc((0.0, 0.0), 0.1)]
    )
    margins = {m.what: m.clearance for m in certificate.margins([[1.2, -0.3], [0.5, 0.0]], 2.0)}
    assert margins["robot 0 and wall +x"] == pytest.approx(0.4 - 0.2)
    assert margins["robot 1 and wall -x"] == pytest.approx(1.3 - 0.05)
    assert margins["robot 1 and obstacle 0"] == pytest.approx(0.3 - 0.1 - 0.05)
    assert margins["robots 0 and 1"] == pytest.approx(np.hypot(1.5, 0.5) - 0.25)


@settings(max_examples=6)
@given(SEEDS, st.floats(0.6, 4.0))
def test_of_large_teams_the_pair_of_least_clearance_is_told_however_far_apart(seed, spread):
    """Only near pairs are looked at; but two large robots may be nearer than two small ones."""
    rng = np.random.default_rng(seed)
    sizes = rng.choice([0.02, 0.5], 45)
    points = 2.0 * spread * rng.uniform(-1, 1, (2, 45))
    certificate = SingleIntegratorCertificate(sizes, 1000.0, speed_limit=0.1)
    _, info = certificate(np.zeros((2, 45)), points)
    first, second = np.triu_indices(45, 1)
    apart = np.hypot(*(points[:, first] - points[:, second])) - (sizes[first] + sizes[second]) / 2
    pair = apart.argmin()
    assert info.clearance == pytest.approx(apart[pair], abs=1e-12)
    assert info.nearest == f"robots {first[pair]} and {second[pair]}"


def test_two_large_robots_beyond_reach_are_told_where_they_are_nearer_than_those_within():
    sizes = np.full(42, 0.02)
    sizes[2:4] = 0.6
    certificate = SingleIntegratorCertificate(sizes, 1000.0, speed_limit=0.1)
    reach = certificate.reach()
    far = 4.0 * np.arange(42)
    points = np.stack([far, np.zeros(42)])
    points[:, 1] = far[0] + 0.95 * reach, 0.0
    points[:, 3] = far[2] + 1.05 * reach, 0.0
    _, info = certificate(np.zeros((2, 42)), points)
    assert info.nearest == "robots 2 and 3"
    assert info.clearance == pytest.approx(1.05 * reach - 0.6)


@settings(max_examples=20)
@given(SEEDS)
def test_pairs_out_of_reach_cannot_break_their_row(seed):
    rng = np.random.default_rng(seed)
    sizes, gains = rng.uniform(0.05, 0.5, 4), 10.0 ** rng.uniform(1, 4, 4)
    rows, speed = UnequalPairRows(sizes, gains), rng.uniform(0.01, 1.0)
    reach = 1.0001 * rows.reach(speed)
    pairs = np.array(np.triu_indices(4, 1))
    coefficient, bound = np.zeros((4, 6)), np.zeros(6)
    line = np.stack([reach * np.arange(4.0), np.zeros(4)])
    rows.write(Scene(line), pairs, coefficient, bound)
    assert np.all(np.sqrt(2.0) * speed <= bound)


@settings(max_examples=30)
@given(SEEDS, st.floats(1e-3, 0.2))
def test_no_step_reaches_zero_up_to_the_largest_gain_of_any_pair(seed, step):
    rng = np.random.default_rng(seed)
    sizes, speeds = rng.uniform(0.05, 0.5, 3), rng.uniform(0.02, 0.5, 3)
    gain = largest_gain(sizes, speeds, step)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        kept, closing = 0.5 * (sizes[i] + sizes[j]), step * (speeds[i] + speeds[j])
        apart = kept + np.linspace(0.0, 2.0 * closing, 200)
        h = apart**2 - kept**2
        nearer = np.minimum(
            step * gain * h**3 / (2.0 * apart), closing
        )  # what the row lets it come
        assert ((apart - nearer) ** 2 - kept**2 >= -1e-9).all()
    both = [largest_gain(*(v[[i, j]] for v in (sizes, speeds)), step) for i, j in ((0, 1), (0, 2))]
    assert gain <= min(both)
    assert largest_gain([0.2] * 3, 0.1, step) == largest_gain(0.2, 0.1, step)
    assert largest_wall_gain(speeds, step) == largest_wall_gain(speeds.max(), step)


def test_unequal_robots_at_one_point_get_a_direction_and_others_keep_theirs():
    """Also those that are a millimetre apart, which is no point."""
    positions = np.array([[0.2, 0.2, -0.3, -0.301], [0.0, 0.0, 0.1, 0.1]])
    equal = SingleIntegratorCertificate(0.15, 1e4, unsafe_gain=1e6)
    unequal = dataclasses.replace(equal, safety_radius=[0.15] * 4)
    (one, told), (other, heard) = (c(np.zeros((2, 4)), positions) for c in (equal, unequal))
    assert told.status == heard.status == "relaxed"
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)
    assert np.hypot(*(other[:, 0] - other[:, 1])) > 0.1
    assert other[0, 2] > 0.1
    assert other[0, 3] < -0.1


def test_who_overlaps_parts_within_the_limits_of_each():
    """Where nothing is safe, motors still do what they can and no more."""
    certificate = SingleIntegratorCertificate(SIZES, 1e4, speed_limit=SPEEDS)
    positions = 0.05 * np.array([[0, 1, 0, -1, 0], [0, 0, 1, 0, -1.0]])
    velocity, info = certificate(np.zeros((2, 5)), positions)
    assert info.status == "relaxed"
    assert np.all(np.hypot(*velocity) <= SPEEDS + 1e-9)
    assert np.all((velocity * positions).sum(axis=0)[1:] > 0.0)  # outward
    stopping = dataclasses.replace(certificate, on_infeasible="stop")
    assert not stopping(np.zeros((2, 5)), positions)[0].any()


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"safety_radius": (0.1, -0.2)}, "safety_radius of robot 1 is -0.2; expected a positive"),
        ({"speed_limit": (0.1, None)}, "speed_limit of robot 1 is nan; expected a positive number"),
        ({"barrier_gain": (np.inf, 1.0)}, "barrier_gain of robot 0 is inf"),
        ({"wall_margin": ()}, r"wall_margin is \(\); expected one number for all robots, or"),
        ({"base_length": [[0.1, 0.2]]}, "base_length is .*; expected one number for all robots"),
        ({"wheel_radius": {"left": 0.1}}, "wheel_radius is .*; expected one number for all"),
        ({"turn_rate_limit": ["fast"]}, "turn_rate_limit is .*; expected one number for all"),
        ({"safety_radius": (0.1, 0.2), "wheel_limit": (1.0, 2.0, 3.0)},
         "wheel_limit has numbers for 3 robots, but safety_radius for 2; expected as many in both"),
        ({"safety_radius": (0.1, 0.2), "decentralised": True, "shares": (1.0, 2.0, 3.0)},
         "shares has numbers for 3 robots, but safety_radius for 2"),
        ({"safety_radius": (0.1, 0.2), "checked": False}, "expected one number .* or checked=True"),
        ({"time_step": (0.1, 0.1)}, "time_step"),
        ({"tilt": (0.1, 0.1)}, "tilt"),
    ],
)  # fmt: skip
def test_numbers_that_are_for_no_team_are_refused(wrong, told):
    with pytest.raises(ParameterError, match=told):
        UnicycleCertificate(**wrong)


def test_teams_of_another_size_are_refused():
    poses, zeros = np.zeros((3, 4)), np.zeros((2, 4))
    poses[0] = np.arange(4)
    for certificate in (
        UnicycleCertificate((0.2, 0.1, 0.1)),
        UnicycleCertificate(projection_distance=(0.2, 0.1, 0.1)),
        LateCertificate((0.2, 0.1, 0.1), turn_rate_limit=1.0, time_step=STEP),
    ):
        asked = [
            lambda c=certificate: c(zeros, poses),
            lambda c=certificate: c.project(zeros, poses),
            lambda c=certificate: c.commands(zeros, poses),
            lambda c=certificate: c.margins(poses),
            lambda c=certificate: BatchCertificate(c)(zeros[None], poses[None]),
        ]
        if certificate.answers_late:
            asked += [lambda c=certificate: c.stops(poses), lambda c=certificate: c.sent(zeros)]
        for ask in asked:
            with pytest.raises(ShapeError, match=r"for each of 3 robots; expected \(., 3\)"):
                ask()
    points = SingleIntegratorCertificate(speed_limit=(0.1, 0.2))
    with pytest.raises(ShapeError, match="for each of 2 robots"):
        points(zeros, poses[:2])
    with pytest.raises(ShapeError, match="for each of 2 robots"):
        points.margins(poses[:2])
    octagons = UnequalLimitRows([VelocityPolygon.octagon(0.1), VelocityPolygon.octagon(0.2)])
    with pytest.raises(ShapeError, match="for 2 robots, but the team has 4"):
        SingleIntegratorCertificate(limits=octagons)(zeros, poses[:2])
    with pytest.raises(ShapeError, match="for 2 robots, but the team has 4"):
        UnequalPairRows((0.1, 0.2), 1.0).measure(Scene(poses[:2]), np.array([[0], [1]]))
    with pytest.raises(ShapeError, match="for 2 robots, but the team has 4"):
        RowBook([], UnequalPairRows((0.1, 0.2), 1.0)).write(Scene(poses[:2]))


def test_rows_of_your_own_for_unequal_robots_are_checked():
    with pytest.raises(ParameterError, match="shapes"):
        UnequalPairRows((0.1, 0.2), (1.0, 2.0, 3.0))
    with pytest.raises(ParameterError, match=r"shape \(\)"):
        UnequalPairRows(0.1, 1.0)
    with pytest.raises(ParameterError, match="polygon of robot 1"):
        UnequalLimitRows([VelocityPolygon.octagon(0.1), VelocityPolygon.box(0.1)])


def test_gains_are_asked_of_numbers_that_make_sense():
    with pytest.raises(ParameterError, match=r"top_speed of robot 1 is -0\.1"):
        largest_gain(0.2, (0.1, -0.1), STEP)
    with pytest.raises(ParameterError, match=r"safety_radius of robot 0 is 0\.0"):
        largest_gain((0.0, 0.1), 0.1, STEP)
    with pytest.raises(ParameterError, match="top_speed has numbers for 3 robots"):
        largest_gain((0.1, 0.1), (0.1, 0.1, 0.1), STEP)
    with pytest.raises(ParameterError, match="top_speed of robot 0 is nan"):
        largest_wall_gain((np.nan, 0.1), STEP)
    assert largest_gain([0.2], [0.1], STEP) == largest_gain(0.2, 0.1, STEP)


def test_a_drive_tells_of_the_robot_that_is_meant():
    drive = DifferentialDrive(speed_limit=(0.1, 0.2), base_length=(0.1, 0.2))
    assert drive.drives == 2
    alone = DifferentialDrive(speed_limit=0.2, base_length=0.2).polygon()
    np.testing.assert_array_equal(drive.polygon(1).normals, alone.normals)
    np.testing.assert_array_equal(drive.polygon(1).bounds, alone.bounds)
    with pytest.raises(ParameterError, match="speed_limit, base_length: each of 2 robots has its"):
        drive.polygon()
    with pytest.raises(ParameterError, match="base_length has numbers for 3 robots"):
        DifferentialDrive(speed_limit=(0.1, 0.2), base_length=(0.1, 0.1, 0.2))


def test_certificates_of_unequal_robots_are_their_parameters():
    array = SingleIntegratorCertificate(np.array([0.2, 0.1]), speed_limit=[0.1, 0.3])
    same = SingleIntegratorCertificate((0.2, 0.1), speed_limit=(0.1, 0.3))
    assert array == same
    assert hash(array) == hash(same)
    assert "safety_radius=(0.2, 0.1)" in repr(array)
    assert dataclasses.replace(same, safety_radius=0.2).team_size == 2
    assert dataclasses.replace(same, safety_radius=0.2, speed_limit=0.1).team_size is None
