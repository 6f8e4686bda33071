"""Rows mean what they say: unit norm, the right side, a name, and nothing lost in pruning."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from barrier_certificates.certificate_errors import NotFiniteError, ParameterError
from barrier_certificates.differential_drive import DifferentialDrive
from barrier_certificates.rows import (
    Disc,
    ObstacleRows,
    PairRows,
    RowBook,
    Scene,
    Segment,
    VelocityPolygon,
    WallRows,
    polygon,
    rectangle,
)
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)


def everything(rng, number):
    """Return a book with every kind of rows, and a scene."""
    drive = DifferentialDrive(speed_limit=0.15, turn_rate_limit=0.55, wheel_disturbance=0.3)
    disturbance = drive.disturbance()
    obstacles = [
        Disc((0.4, 0.1), 0.05, (0.01, -0.02)),
        Segment((-0.5, 0.4), (0.2, 0.6), 0.01, name="bar"),
    ]
    families = [
        drive.polygon().rows(turning=True),
        WallRows(*rectangle(ARENA), 0.06, 100.0, disturbance),
        ObstacleRows(obstacles, 0.06, 100.0, disturbance),
    ]
    heading = rng.uniform(-np.pi, np.pi, number)
    positions = rng.uniform(-0.9, 0.9, (2, number))
    scene = Scene(positions, np.stack([np.cos(heading), np.sin(heading)]))
    return RowBook(families, PairRows(0.12, 100.0, disturbance=disturbance)), scene


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 30))
def test_rows_have_unit_norm_and_all_forms_agree(seed, number):
    rng = np.random.default_rng(seed)
    book, scene = everything(rng, number)
    rows, _ = book.write(scene)
    which = np.arange(len(rows))
    dense = rows.dense(which)
    np.testing.assert_allclose(np.linalg.norm(dense, axis=1), 1.0, atol=1e-12)
    np.testing.assert_array_equal(rows.sparse(which).toarray(), dense)
    x = rng.normal(size=rows.size)
    np.testing.assert_allclose(rows.excess(x), dense @ x - rows.bound, atol=1e-12)
    some = rng.permutation(which)[: len(which) // 2]
    np.testing.assert_allclose(rows.take(some).excess(x), rows.excess(x)[some], atol=1e-12)
    assert rows.take(some).label(0) == rows.label(int(some[0]))


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.integers(2, 9))
def test_a_row_is_the_derivative_of_its_barrier(seed, number):
    """Along any velocity, ḣ + γ h³ ≥ 0 exactly where the row holds."""
    rng = np.random.default_rng(seed)
    gain, step = 100.0, 1e-7
    obstacle = Segment((-0.2, 0.0), (0.3, 0.2), 0.05, velocity=(0.03, 0.01))
    families = [ObstacleRows([obstacle], 0.06, gain)]
    pairs = PairRows(0.12, gain)
    scene = Scene(rng.uniform(-1, 1, (2, number)))
    velocity = rng.uniform(-0.3, 0.3, (2, number))
    rows, _ = RowBook(families, pairs).write(scene)
    excess = rows.excess(velocity.T.ravel())

    later = Scene(scene.positions + step * velocity)
    moved = Segment(
        *(tuple(np.array(p) + step * np.array([0.03, 0.01])) for p in obstacle.ends), 0.05
    )
    (i, j), norms = np.triu_indices(number, 1), []
    h = np.concatenate([families[0].measure(scene)[0], pairs.measure(scene, np.array([i, j]))[0]])
    distance = np.sqrt(h + np.repeat([0.11**2, 0.12**2], [number, len(i)]))
    norms = 2 * distance * np.repeat([1.0, np.sqrt(2.0)], [number, len(i)])
    after = [ObstacleRows([moved], 0.06, gain).measure(later)[0]]
    after.append(pairs.measure(later, np.array([i, j]))[0])
    rate = (np.concatenate(after) - h) / step
    np.testing.assert_allclose(-norms * excess, rate + gain * h**3, atol=1e-4)


def test_labels_name_robots_walls_and_obstacles():
    book, scene = everything(np.random.default_rng(0), 3)
    rows, _ = book.write(scene)
    names = [rows.label(k) for k in range(len(rows))]
    assert names[-1] == "robots 1 and 2"
    assert {"robot 2 and wall +x", "robot 0 and obstacle 0", "robot 1 and bar"} <= set(names)
    assert names[0] == "robot 0: speed limit"


@settings(max_examples=50)
@given(
    st.floats(0.01, 1.0), st.floats(0.1, 10.0), st.floats(1.0, 20.0), st.sampled_from([0.0, 0.033])
)
def test_sides_left_out_are_implied_by_the_others(speed, turn, wheel, step):
    polygon_ = DifferentialDrive(
        speed_limit=speed, turn_rate_limit=turn, wheel_limit=wheel, time_step=step
    ).polygon()
    assert len(polygon_.names) <= 9
    angle = np.linspace(0, 2 * np.pi, 721)
    direction = np.stack([np.cos(angle), np.sin(angle)])
    reach = 1 / (polygon_.normals.T @ direction / polygon_.bounds[:, None]).max(axis=0)
    along, across = reach * direction
    assert np.hypot(along, across).max() <= polygon_.top_speed() + 1e-9
    # On its rim every limit holds and one of them binds (with a step: binds to within the chord).
    v, w = along, across / 0.05
    if step:
        w = np.arcsin(np.clip(step * w, -1, 1)) / step
        v = along + 0.05 * (1 - np.cos(step * w)) / step
    used = np.stack(
        [np.abs(v) / speed, np.abs(w) / turn, (np.abs(v) + 0.0525 * np.abs(w)) / (0.016 * wheel)]
    ).max(axis=0)
    assert used.max() <= 1 + 1e-9
    if not step:
        np.testing.assert_allclose(used, 1.0, atol=1e-9)


@settings(max_examples=30)
@given(st.floats(0.05, 0.5), st.floats(1.0, 1e5), st.floats(0.01, 1.0))
def test_pairs_out_of_reach_cannot_break_their_row(radius, gain, speed):
    pairs = PairRows(radius, gain)
    reach = pairs.reach(speed)
    coefficient, bound = np.zeros((4, 1)), np.zeros(1)
    ends = np.array([[0], [1]])
    pairs.write(Scene(np.array([[0.0, reach * 1.001], [0.0, 0.0]])), ends, coefficient, bound)
    assert np.sqrt(2) * speed <= bound[0]
    pairs.write(Scene(np.array([[0.0, reach * 0.999], [0.0, 0.0]])), ends, coefficient, bound)
    assert np.sqrt(2) * speed > bound[0]


def test_several_robots_at_one_point_get_directions_that_agree():
    """Each can move out along its own ray, so that all rows of the heap can hold at once."""
    number = 6
    certificate = SingleIntegratorCertificate(0.05, 1.0, speed_limit=None)
    velocity, info = certificate(np.zeros((2, number)), np.zeros((2, number)))
    assert info.status == "optimal"
    apart = velocity[:, :, None] - velocity[:, None, :] + 9 * np.eye(number)
    assert np.hypot(*apart).min() > 0


@pytest.mark.parametrize(
    ("corners", "problem"),
    [
        ([[0, 1, 0.2, 0], [0, 0, 0.2, 1]], "convex"),
        ([[0, 1], [0, 0]], "expected"),
        (
            np.stack([np.cos(0.8 * np.pi * np.arange(5)), np.sin(0.8 * np.pi * np.arange(5))]),
            "convex",
        ),
    ],
    ids=["pointing inwards", "two corners", "star"],
)
def test_arenas_that_are_not_convex_are_refused(corners, problem):
    with pytest.raises(ParameterError, match=problem):
        SingleIntegratorCertificate(boundary=corners)


def test_a_polygon_may_be_given_either_way_round():
    corners = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
    closed = np.concatenate([corners, corners[:, :1]], axis=1)
    for order in (corners, corners[:, ::-1], closed):
        normals, offsets, _ = polygon(order)
        assert normals.shape == (2, 4)
        assert np.all(normals.T @ np.array([[0.5], [0.5]]) < offsets[:, None])


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"safety_radius": 0.0}, "safety_radius"),
        ({"barrier_gain": np.nan}, "barrier_gain"),
        ({"barrier_gain": "100"}, "barrier_gain"),
        ({"boundary": (1.6, -1.6, -1.0, 1.0)}, "boundary"),
        ({"boundary": "arena"}, "boundary"),
        ({"wall_margin": -0.1}, "wall_margin"),
        ({"speed_limit": -0.2}, "speed_limit"),
        ({"turn_rate_limit": np.inf}, "turn_rate_limit"),
        ({"projection_distance": 0.0}, "projection_distance"),
        ({"wheel_disturbance": -1.0}, "wheel_disturbance"),
        ({"on_infeasible": "ignore"}, "on_infeasible"),
        ({"tilt": np.nan}, "tilt"),
        ({"tilt": "left"}, "tilt"),
        ({"deadlock": True}, "deadlock"),
        ({"solver": ["nnls"]}, "solver"),
        ({"obstacles": Disc((0.0, 0.0), 0.1)}, "obstacles"),
        ({"obstacles": [(0.0, 0.0)]}, "obstacles"),
        ({"options": {"maxiter": 5}}, "options"),
    ],
    ids=lambda value: str(value),
)
def test_parameters_are_checked_and_named(wrong, named):
    with pytest.raises(ParameterError, match=named):
        UnicycleCertificate(**wrong)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Disc((0.0, 0.0), -0.1),
        lambda: Disc((np.nan, 0.0), 0.1),
        lambda: Segment((0.0, 0.0), (0.0,)),
        lambda: Disc("ab", 0.1),
        lambda: Disc(((0.0, 1.0), 0.0), 0.1),
        lambda: Disc((0.0, 0.0), None),
        lambda: SingleIntegratorCertificate()([[0.0], [0.0]], [[0.0], [0.0]], obstacles=3),
        lambda: VelocityPolygon.octagon(-0.1),
        lambda: DifferentialDrive(wheel_radius=0.0),
    ],
)
def test_obstacles_and_limits_are_checked(make):
    with pytest.raises(ParameterError, match="expected"):
        make()


def test_there_are_no_margins_or_commands_of_what_is_not_a_number():
    with pytest.raises(NotFiniteError):
        SingleIntegratorCertificate().margins([[0.0, np.nan], [0.0, 0.0]])
    with pytest.raises(NotFiniteError):
        UnicycleCertificate().commands([[np.nan], [0.0]], np.zeros((3, 1)))
    with pytest.raises(NotFiniteError):
        UnicycleCertificate().commands([[0.0], [0.0]], [[0.0], [0.0], [np.inf]])


def test_certificates_are_their_parameters_and_compare_so():
    certificate = UnicycleCertificate(0.2, boundary=ARENA, obstacles=[Disc((0, 0), 0.1)])
    same = UnicycleCertificate(0.2, boundary=np.array(ARENA), obstacles=(Disc((0.0, 0.0), 0.1),))
    assert certificate == same
    assert hash(certificate) == hash(same)
    assert certificate != dataclasses.replace(certificate, speed_limit=0.1)
    assert certificate != dataclasses.replace(certificate, safety_radius=0.1)
    assert "safety_radius=0.2, barrier_gain=100.0" in repr(certificate)
    assert dataclasses.asdict(certificate)["obstacles"][0]["radius"] == 0.1


def test_unchecked_certificates_take_any_number():
    with pytest.raises(ParameterError, match="barrier_gain"):
        SingleIntegratorCertificate(barrier_gain=-1.0)
    certificate = SingleIntegratorCertificate(0.0, -1.0, speed_limit=0.0, checked=False)
    velocity, _ = certificate([[0.1, 0.1], [0.0, 0.0]], [[0.0, 0.5], [0.0, 0.0]])
    np.testing.assert_allclose(velocity, 0.0, atol=1e-9)
    with pytest.raises(ParameterError, match="boundary"):  # what cannot be read at all
        SingleIntegratorCertificate(boundary="arena", checked=False)


def test_limits_may_be_rows_of_your_own():
    box = VelocityPolygon.box(0.2).rows()
    certificate = SingleIntegratorCertificate(limits=box)
    velocity, info = certificate([[1.0], [1.0]], [[0.0], [0.0]])
    np.testing.assert_allclose(velocity, 0.2, atol=1e-12)
    assert info.active == ("robot 0: speed limit",) * 2


def test_walls_allow_for_disturbed_wheels_unless_told_not_to():
    at_wall, ahead = [[1.4], [0.0], [0.0]], [[0.15], [0.0]]
    kept = {
        (disturbance, robust): UnicycleCertificate(
            boundary=ARENA, wheel_disturbance=disturbance, robust_walls=robust
        )(ahead, at_wall)[0][0, 0]
        for disturbance in (0.0, 0.5)
        for robust in (False, True)
    }
    assert kept[0.0, True] == kept[0.0, False] == kept[0.5, False]
    assert kept[0.5, True] == pytest.approx(kept[0.0, True] - 0.5 * 0.016)


def test_a_call_may_say_where_obstacles_are_by_now():
    """More, fewer, moved or none: only the call counts, and the certificate's own come back."""
    own = [Disc((0.3, 0.0), 0.1)]
    certificate = SingleIntegratorCertificate(obstacles=own)
    command, positions = [[0.2], [0.0]], [[0.1], [0.0]]
    free = SingleIntegratorCertificate()(command, positions)[0]
    held = certificate(command, positions)[0]
    assert held[0, 0] < 0.01
    np.testing.assert_array_equal(certificate(command, positions, [])[0], free)
    far = [Disc((3.0, 0.0), 0.1), Disc((0.0, 3.0), 0.1)]
    np.testing.assert_array_equal(certificate(command, positions, far)[0], free)
    moved = certificate(command, positions, [Disc((0.35, 0.0), 0.1)])[0]
    assert held[0, 0] < moved[0, 0] < free[0, 0]
    np.testing.assert_array_equal(certificate(command, positions)[0], held)
    assert certificate.margins(positions, 0.2, []) == []
    assert [m.what for m in certificate.margins(positions, 0.2)] == ["robot 0 and obstacle 0"]
