"""What the published certificates refuse, warn of and leave unchanged, and what limits them."""

import warnings

import numpy as np
import pytest

from rps_compat import deviations
from rps_compat.arguments import NotAnArrayError, NumberError, ShapeError
from rps_compat.certificates import BoundaryError, NotFiniteError
from rps_compat.placement import CrowdedError
from rps_compat.v1.utilities import barrier_certificates as first
from rps_compat.v2.utilities import barrier_certificates as second


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
