"""The published certificates answer the exact optimum of their rows, and change nothing."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rps_compat import deviations
from rps_compat.arguments import NotAnArrayError, NumberError, ShapeError
from rps_compat.certificates import BoundaryError, NotFiniteError
from rps_compat.placement import CrowdedError
from rps_compat.v1.utilities import barrier_certificates as first
from rps_compat.v1.utilities import barrier_certificates2 as older
from rps_compat.v2.utilities import barrier_certificates as second

cvxopt = pytest.importorskip("cvxopt")

ARENA = (-1.6, 1.6, -1.0, 1.0)
AROUND = (-1.7, 1.7, -1.1, 1.1)


class Program:
    """min ‖v − v̂‖² over rows, written out densely and solved by another solver."""

    def __init__(self, points, wanted):
        self.points, self.wanted = points, wanted
        self.robots = points.shape[1]
        self.rows, self.bounds = [], []

    def row(self, entries, bound):
        dense = np.zeros((self.robots, 2))
        for robot, direction in entries:
            dense[robot] = direction
        self.rows.append(dense.ravel())
        self.bounds.append(bound)

    def pairs(self, radius, gain, unsafe=None, loss=None):
        for i in range(self.robots):
            for j in range(i + 1, self.robots):
                offset = self.points[:, i] - self.points[:, j]
                h = offset @ offset - radius**2
                firmness = unsafe if unsafe is not None and h < 0 else gain
                lost = 0 if loss is None else loss(i, 2 * offset) + loss(j, 2 * offset)
                self.row([(i, -2 * offset), (j, 2 * offset)], firmness * h**3 - lost)
        return self

    def obstacles(self, points, radius, gain, loss):
        for i in range(self.robots):
            for point in points.T:
                offset = self.points[:, i] - point
                bound = gain * (offset @ offset - radius**2) ** 3 - loss(i, 2 * offset)
                self.row([(i, -2 * offset)], bound)
        return self

    def walls(self, arena, radius, gain):
        x_min, x_max, y_min, y_max = arena
        for i, (x, y) in enumerate(self.points.T):
            for normal, gap in (
                ((1, 0), x_max - x),
                ((-1, 0), x - x_min),
                ((0, 1), y_max - y),
                ((0, -1), y - y_min),
            ):
                self.row([(i, normal)], 0.4 * gain * (gap - radius / 2) ** 3)
        return self

    def octagon(self, limit, first_side=None):
        for i in range(self.robots):
            for k in range(8):
                angle = k * np.pi / 4
                side = first_side if k == 0 and first_side else limit * np.cos(np.pi / 8)
                self.row([(i, (np.cos(angle), np.sin(angle)))], side)
        return self

    def wheels(self, to_wheels, limit):
        for i in range(self.robots):
            for wheel in (0, 1):
                for sign in (1, -1):
                    self.row([(i, sign * to_wheels(i)[wheel])], limit)
        return self

    def solve(self):
        if not self.rows:
            return self.wanted
        rows, bounds = np.array(self.rows), np.array(self.bounds)
        lengths = np.linalg.norm(rows, axis=1)
        target = self.wanted.T.ravel()
        answer = cvxopt.solvers.qp(
            cvxopt.matrix(np.eye(target.size)),
            cvxopt.matrix(-target),
            cvxopt.matrix(rows / lengths[:, None]),
            cvxopt.matrix(bounds / lengths),
            options={"show_progress": False, "abstol": 1e-12, "reltol": 1e-11, "feastol": 1e-11},
        )
        return np.array(answer["x"]).reshape(-1, 2).T if answer["status"] == "optimal" else None


def clipped(velocities, limit):
    speed = np.maximum(np.hypot(*velocities), 1e-300)
    return velocities * np.minimum(1, limit / speed)


def ahead(poses, distance):
    return poses[:2] + distance * np.array([np.cos(poses[2]), np.sin(poses[2])])


def to_point(commands, poses, distance):
    cos, sin = np.cos(poses[2]), np.sin(poses[2])
    v, w = commands
    return np.array([cos * v - distance * sin * w, sin * v + distance * cos * w])


def to_command(velocities, poses, distance):
    cos, sin = np.cos(poses[2]), np.sin(poses[2])
    x, y = velocities
    return np.array([cos * x + sin * y, (cos * y - sin * x) / distance])


class Wheels:
    """Wheel speeds as functions of the velocity of the point ahead."""

    def __init__(self, poses, distance, radius=0.016, base=0.105):
        to_body = np.array([[radius / 2, radius / 2], [-radius / base, radius / base]])
        self.to_point = [
            np.array([[np.cos(t), -distance * np.sin(t)], [np.sin(t), distance * np.cos(t)]])
            @ to_body
            for t in poses[2]
        ]

    def inverse(self, robot):
        return np.linalg.inv(self.to_point[robot])

    def loss(self, disturbance):
        return lambda robot, row: disturbance * np.abs(row @ self.to_point[robot]).sum()


@st.composite
def teams(draw):
    robots = draw(st.integers(2, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**31 - 1)))
    spread = draw(st.sampled_from([0.3, 0.8]))
    poses = np.vstack([rng.uniform(-spread, spread, (2, robots)), rng.uniform(-3, 3, robots)])
    poses[0] *= draw(st.sampled_from([1.0, 1.9]))
    return poses, rng.normal(0, 0.2, (2, robots)), rng.normal(0, 1, robots)


def check(answer, program, expected=lambda v: v, tolerance=2e-6):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        safe = answer()
    assert np.isfinite(safe).all()
    optimum = program.solve()
    if optimum is not None:
        np.testing.assert_allclose(safe, expected(optimum), atol=tolerance, rtol=1e-5)


@given(teams(), st.sampled_from([0.13, 0.2]), st.sampled_from([30, 100.0]))
@settings(max_examples=25)
def test_single_integrators_of_generation_1(team, radius, gain):
    poses, velocities, _ = team
    x = poses[:2].copy()
    program = Program(x, clipped(velocities, 0.15)).pairs(radius, gain)
    certificate = first.create_single_integrator_barrier_certificate(gain, radius, 0.15)
    check(lambda: certificate(velocities, x), program)
    walled = first.create_single_integrator_barrier_certificate_with_boundary(gain, radius, 0.15)
    check(lambda: walled(velocities, x), program.walls(ARENA, radius, gain))
    parting = first.create_single_integrator_barrier_certificate2(gain, 1e4, radius, 0.15)
    program = Program(x, clipped(velocities, 0.15)).pairs(radius, gain, 1e4)
    check(lambda: parting(velocities, x), program, tolerance=1e-5)


@given(teams())
@settings(max_examples=25)
def test_unicycles_of_generation_1(team):
    poses, velocities, turns = team
    commands = np.vstack([velocities[0], turns])
    points = ahead(poses, 0.05)
    wanted = clipped(to_point(commands, poses, 0.05), 0.12)

    def command(v):
        v, w = to_command(v, poses, 0.05)
        return np.array([v, np.clip(w, -np.pi, np.pi)])

    program = Program(points, wanted).pairs(0.15 + 0.05, 80)
    plain = first.create_unicycle_barrier_certificate(80, 0.15, 0.05, 0.12)
    check(lambda: plain(commands, poses), program, command, 1e-4)
    walled = first.create_unicycle_barrier_certificate_with_boundary(80, 0.15, 0.05, 0.12)
    check(lambda: walled(commands, poses), program.walls(ARENA, 0.2, 80), command, 1e-4)


@given(teams())
@settings(max_examples=25)
def test_wheels_of_generation_1(team):
    poses, velocities, turns = team
    commands = np.vstack([velocities[0], turns])
    wheels = Wheels(poses, 0.05)
    obstacles = np.array([[0.5, -0.4], [0.1, -0.6]])

    def program():
        wanted = to_point(commands, poses, 0.05)
        return (
            Program(ahead(poses, 0.05), wanted)
            .pairs(0.14, 150, loss=wheels.loss(3))
            .wheels(wheels.inverse, 12.5)
        )

    def command(v):
        return to_command(v, poses, 0.05)

    settings_ = {"disturbance": 3, "safety_radius": 0.14}
    free = first.create_unicycle_differential_drive_barrier_certificate(**settings_)
    check(lambda: free(commands, poses), program(), command, 1e-4)
    walled = first.create_unicycle_differential_drive_barrier_certificate_with_boundary(**settings_)
    with_walls = program().walls(ARENA, 0.14, 150)
    check(lambda: walled(commands, poses), with_walls, command, 1e-4)
    robust = older.create_robust_barriers(d=3, safety_radius=0.14)
    with_obstacles = program().obstacles(obstacles, 0.14, 150, wheels.loss(3))
    check(lambda: robust(commands, poses, obstacles), with_obstacles, command, 1e-4)
    check(lambda: free(commands, poses, obstacles), with_obstacles, command, 1e-4)


@given(teams(), st.booleans())
@settings(max_examples=25)
def test_single_integrators_of_generation_2(team, published):
    poses, velocities, _ = team
    with deviations.all_as_published(published):
        plain = second.create_si_barrier_certificate(0.18, 60.0, 0.15)
        program = Program(poses[:2], velocities).pairs(0.18, 60)
        check(lambda: plain(velocities, poses), program.octagon(0.15, 0.15 if published else None))
        walled = second.create_si_barrier_certificate_with_boundary(0.18, 60.0, 0.15)
        program = Program(poses[:2], velocities).pairs(0.18, 60).octagon(0.15)
        check(lambda: walled(velocities, poses), program.walls(AROUND, 0.18, 60))


@given(teams())
@settings(max_examples=25)
def test_unicycles_of_generation_2(team):
    poses, velocities, turns = team
    commands = np.vstack([velocities[0], turns])

    def program(distance, radius, gain):
        wanted = to_point(commands, poses, distance)
        return Program(ahead(poses, distance), wanted).pairs(radius, gain).octagon(0.2)

    plain = second.create_uni_barrier_certificate()
    check(
        lambda: plain(commands, poses),
        program(0.05, 0.25, 100),
        lambda v: to_command(v, poses, 0.05),
        1e-4,
    )
    walled = second.create_uni_barrier_certificate_with_boundary()
    obstacles = np.array([[0.3], [0.2]])
    check(
        lambda: walled(commands, poses, obstacles),
        program(0.03, 0.18, 150)
        .walls(ARENA, 0.18, 150)
        .obstacles(obstacles, 0.18, 150, lambda *_: 0),
        lambda v: to_command(v, poses, 0.03),
        1e-4,
    )


def facing_pair():
    poses = np.array([[-0.12, 0.12], [0.0, 0.0], [0.0, np.pi]])
    return np.array([[0.2, 0.2], [0.0, 0.0]]), poses


def every_filter():
    for name in first.__all__:
        if name.startswith("create_") and "barrier" in name:
            yield pytest.param(getattr(first, name), 1, "unicycle" in name, id=f"1-{name}")
    for name in second.__all__:
        if name.startswith("create_") and "barrier" in name:
            yield pytest.param(getattr(second, name), 2, "uni" in name, id=f"2-{name}")


FILTERS = pytest.mark.parametrize(("create", "generation", "unicycles"), list(every_filter()))


STARTS_UNSAFE = pytest.mark.filterwarnings("ignore:the first call of a certificate")


@STARTS_UNSAFE
@FILTERS
def test_no_certificate_changes_its_arguments(create, generation, unicycles):
    commands, poses = facing_pair()
    commands = 3 * commands  # too fast, so that every one of them has something to do
    x = poses if unicycles else poses[:2].copy()
    kept = commands.copy(), x.copy()
    safe = create()(commands, x)
    assert np.abs(safe - commands).max() > 0.01
    np.testing.assert_array_equal(commands, kept[0])
    np.testing.assert_array_equal(x, kept[1])


@FILTERS
def test_numbers_that_are_not_finite_never_pass(create, generation, unicycles):
    commands, poses = facing_pair()
    x = poses if unicycles else poses[:2].copy()
    for where in (commands, x):
        broken = where.copy()
        broken[0, 1] = np.nan
        given_ = (broken, x) if where is commands else (commands, broken)
        if generation == 1:
            with pytest.raises(NotFiniteError, match=r"\[0, 1\] \(robot 1\) is nan"):
                create()(*given_)
        else:
            with pytest.warns(UserWarning, match=r"\(robot 1\) is nan.*all robots are stopped"):
                np.testing.assert_array_equal(create()(*given_), 0.0)


@FILTERS
def test_wrong_shapes_are_refused(create, generation, unicycles):
    commands, poses = facing_pair()
    x = poses if unicycles else poses[:2].copy()
    for bad in ((commands.T[:1], x), (commands[:, :1], x), (commands[0], x), (commands, x[:, :1])):
        with pytest.raises(ShapeError):
            create()(*bad)
    for bad in ((None, x), (commands.tolist(), x), (commands, None)):
        with pytest.raises(NotAnArrayError):
            create()(*bad)


@FILTERS
def test_nobody_is_certified_at_once(create, generation, unicycles):
    rows = 3 if unicycles else 2
    assert create()(np.zeros((2, 0)), np.zeros((rows, 0))).shape == (2, 0)


@FILTERS
def test_robots_that_overlap_part_with_a_warning_or_an_answer(create, generation, unicycles):
    poses = np.array([[0.0, 0.02, 0.01], [0.0, 0.0, 0.015], [0.0, 1.0, 2.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        safe = create()(np.zeros((2, 3)), poses if unicycles else poses[:2].copy())
    assert np.isfinite(safe).all()
    assert np.abs(safe).max() > 0


def test_the_first_call_says_what_starts_unsafe():
    certificate = second.create_si_barrier_certificate(safety_radius=0.2)
    near = np.array([[0.0, 0.15], [0.0, 0.0]])
    with pytest.warns(
        RuntimeWarning, match=r"finds robots 0 and 1 50 mm nearer already than it lets"
    ):
        certificate(np.zeros((2, 2)), near)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        certificate(np.zeros((2, 2)), near)  # said once
        second.create_si_barrier_certificate(safety_radius=0.2)(np.zeros((2, 2)), 2 * near)


@STARTS_UNSAFE
def test_the_warning_names_who_cannot_be_kept_safe():
    outside = np.array([[2.5, 0.0], [0.0, 0.0]])
    certificate = second.create_si_barrier_certificate_with_boundary()
    with pytest.warns(UserWarning, match=r"robot 0 and wall \+x cannot be satisfied"):
        safe = certificate(np.zeros((2, 2)), outside)
    assert safe[0, 0] == pytest.approx(-0.2 * np.cos(np.pi / 8))


@STARTS_UNSAFE
def test_a_single_robot_has_walls_and_limits_in_generation_2():
    at_wall = np.array([[1.5], [0.0], [0.0]])
    command = np.array([[0.3], [0.0]])
    certificate = second.create_uni_barrier_certificate_with_boundary()
    assert certificate(command, at_wall)[0, 0] < 1e-3
    free = second.create_uni_barrier_certificate()
    assert free(command, at_wall)[0, 0] == pytest.approx(0.2 * np.cos(np.pi / 8))
    with deviations.all_as_published():
        assert certificate(command, at_wall) is command


def test_obstacles_hold_in_generation_2_and_give_way_as_published():
    poses = np.array([[0.0, 1.0], [0.0, 0.0], [0.0, 0.0]])
    commands, obstacle = np.array([[0.2, 0.0], [0.0, 0.0]]), np.array([[0.215], [0.0]])
    create = second.create_uni_barrier_certificate_with_boundary
    ours = create()(commands, poses, obstacle)[0, 0]
    with deviations.all_as_published():
        published = create()(commands, poses, obstacle)[0, 0]
    assert ours < 0.002
    assert published > 10 * ours


def test_obstacles_may_move_and_change_in_number():
    poses, commands = np.zeros((3, 1)), np.array([[0.2], [0.0]])
    certificate = first.create_unicycle_differential_drive_barrier_certificate(disturbance=0)
    free = certificate(commands, poses)
    near = certificate(commands, poses, np.array([[0.23], [0.0]]))
    assert near[0, 0] < free[0, 0] / 2
    far = certificate(commands, poses, np.array([[2.0], [0.0]]))
    np.testing.assert_allclose(far, free, atol=1e-9)
    both = certificate(commands, poses, np.array([[2.0, 0.23], [0.0, 0.0]]))
    np.testing.assert_allclose(both, near, atol=1e-9)
    np.testing.assert_allclose(certificate(commands, poses), free, atol=1e-9)


def test_magnitude_limit_is_obeyed_by_unicycles_and_ignored_as_published():
    poses, commands = np.zeros((3, 1)), np.array([[0.2], [0.0]])
    create = first.create_unicycle_barrier_certificate
    assert create(magnitude_limit=0.05)(commands, poses)[0, 0] == pytest.approx(0.05)
    with deviations.all_as_published():
        assert create(magnitude_limit=0.05)(commands, poses)[0, 0] == pytest.approx(0.2)


def test_the_callers_array_is_scaled_where_that_is_wanted():
    commands, poses = facing_pair()
    commands *= 2
    with deviations.all_as_published():
        first.create_single_integrator_barrier_certificate()(commands, poses[:2].copy())
    np.testing.assert_allclose(np.hypot(*commands), 0.2)


def test_fifty_robots_get_the_answer_of_all_their_rows():
    rng = np.random.default_rng(8)
    grid = np.array([(i % 10, i // 10) for i in range(50)]).T * [[0.3], [0.36]] - [[1.35], [0.72]]
    x, velocities = grid + rng.normal(0, 0.03, grid.shape), rng.normal(0, 0.2, (2, 50))
    program = Program(x, velocities).pairs(0.15, 100).octagon(0.2).walls(AROUND, 0.15, 100)
    certificate = second.create_si_barrier_certificate_with_boundary()
    check(lambda: certificate(velocities, x), program)


@pytest.mark.parametrize("points", ["arena", 1.6, [1.6, 1.0], [[1, 2], [3, 4]]])
def test_boundaries_that_are_none_are_refused_at_the_call(points):
    commands, poses = facing_pair()
    for create in (
        first.create_unicycle_barrier_certificate_with_boundary,
        second.create_uni_barrier_certificate_with_boundary,
    ):
        certificate = create(boundary_points=points)
        with pytest.raises(BoundaryError, match="expected an array of x_min, x_max, y_min, y_max"):
            certificate(commands, poses)


def test_generation_1_refuses_what_its_robots_cannot_keep():
    with pytest.raises(NumberError, match=r"safety_radius is 0\.1, expected a number >= 0\.12"):
        first.create_single_integrator_barrier_certificate(safety_radius=0.1)
    with pytest.raises(NumberError, match=r"magnitude_limit is 0\.3, expected .* <= 0\.2"):
        first.create_unicycle_barrier_certificate(magnitude_limit=0.3)
    commands, poses = facing_pair()
    with pytest.raises(NumberError, match="dxi holds float32"):
        first.create_single_integrator_barrier_certificate()(
            commands.astype(np.float32), poses[:2].copy()
        )
    crowded = first.create_unicycle_differential_drive_barrier_certificate(max_num_robots=1)
    with pytest.raises(CrowdedError, match="2 robots, but max_num_robots is 1"):
        crowded(commands, poses)
    with pytest.raises(NumberError, match="projection_distance is 0"):
        first.create_unicycle_differential_drive_barrier_certificate(projection_distance=0)


def test_the_private_solver_that_scripts_find():
    rows, bounds = np.array([[1.0, 0, 0, 0], [1, 0, -1, 0]]), np.array([0.5, 1.0])
    answer = second._solve_qp(2, np.array([1.0, 0, -1, 0]), rows, bounds)
    np.testing.assert_allclose(answer, [[0.5, -0.5], [0, 0]], atol=1e-9)


def test_robots_may_have_to_part_faster_than_any_robot():
    rng = np.random.default_rng(4)
    x = rng.uniform(-0.3, 0.3, (2, 12))
    velocities = rng.normal(0, 0.1, (2, 12))
    certificate = first.create_single_integrator_barrier_certificate2()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "the first call of a certificate")
        safe = certificate(velocities, x)
    assert np.abs(safe).max() > 100
    optimum = Program(x, clipped(velocities, 0.2)).pairs(0.17, 100, 1e6).solve()
    np.testing.assert_allclose(safe, optimum, atol=1e-4, rtol=1e-6)
