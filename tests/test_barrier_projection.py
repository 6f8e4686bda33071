"""The projection is the exact optimum, whoever solves it, and it leaves its inputs alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from barrier_certificates.certificate_errors import (
    InfeasibleError,
    NotFiniteError,
    ParameterError,
    ShapeError,
)
from barrier_certificates.rows import Disc
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)


def test_safe_command_is_returned_as_it_is():
    certificate = SingleIntegratorCertificate(boundary=ARENA)
    command = np.array([[0.1, -0.1], [0.0, 0.05]])
    velocity, info = certificate(command, [[-1.0, 1.0], [0.0, 0.0]])
    assert info.status == "trivial"
    assert info.active == ()
    assert velocity is not command
    np.testing.assert_array_equal(velocity, command)


def test_rows_say_what_they_stand_for():
    certificate = SingleIntegratorCertificate(boundary=ARENA)
    positions = [[-0.08, 0.08, 1.5], [0.0, 0.0, 0.0]]
    _, info = certificate([[0.15, -0.15, 0.15], [0.0, 0.0, 0.0]], positions)
    assert set(info.active) == {"robots 0 and 1", "robot 2 and wall +x"}
    assert info.smallest_h == pytest.approx(0.16**2 - 0.15**2)
    assert info.clearance == pytest.approx(0.01)


def test_what_is_nearest_is_told_in_metres_and_by_name():
    """A wall at 1 cm is nearer than a pair at 2 cm, whose h in m² is the smaller number."""
    certificate = SingleIntegratorCertificate(boundary=ARENA)
    positions = [[-0.085, 0.085, 1.515], [0.0, 0.0, 0.0]]
    _, info = certificate(np.zeros((2, 3)), positions)
    assert info.nearest == "robot 2 and wall +x"
    assert info.clearance == pytest.approx(0.01)
    assert info.smallest_h == pytest.approx(0.01)
    _, info = certificate(np.zeros((2, 2)), np.array(positions)[:, :2])
    assert info.nearest == "robots 0 and 1"
    assert info.clearance == pytest.approx(0.02)
    assert info.smallest_h == pytest.approx(0.17**2 - 0.15**2)
    post = [Disc((0.0, 0.3), 0.1), Disc((0.1, 0.1), 0.02, name="post")]
    _, info = certificate(np.zeros((2, 2)), np.array(positions)[:, :2], post)
    assert info.nearest == "robot 1 and post"
    assert info.clearance == pytest.approx(np.hypot(0.015, 0.1) - 0.095)


def test_nothing_is_nearest_where_there_is_nothing_or_nothing_known():
    _, info = SingleIntegratorCertificate()(np.zeros((2, 1)), np.zeros((2, 1)))
    assert (info.nearest, info.clearance, info.smallest_h) == (None, np.inf, np.inf)
    _, info = SingleIntegratorCertificate()(np.zeros((2, 1)), np.full((2, 1), np.nan))
    assert (info.nearest, info.violated, info.active) == (None, (), ())


def test_what_has_to_give_way_is_named_the_furthest_from_holding_first():
    certificate = SingleIntegratorCertificate(boundary=ARENA, barrier_gain=1e4)
    positions = [[2.0, 0.0, 0.14], [0.0, 0.0, 0.0]]
    velocity, info = certificate(np.zeros((2, 3)), positions)
    assert info.status == "relaxed"
    assert info.violated == ("robot 0 and wall +x",)
    worst = info.rows.excess(velocity.T.ravel())
    assert info.violation == worst.max() == worst[info.broken[0]]


@pytest.mark.parametrize("solver", ["auto", "nnls", "clarabel"])
def test_whoever_solves_tells_what_binds_and_how_far_it_intervened(solver):
    certificate = SingleIntegratorCertificate(boundary=ARENA, solver=solver)
    positions = [[-0.08, 0.08, 1.5, 0.0], [0.0, 0.0, 0.0, 0.6]]
    command = np.array([[0.15, -0.15, 0.15, 0.02], [0.0, 0.0, 0.0, 0.0]])
    for _ in range(2):  # the second time with what bound last time
        velocity, info = certificate(command, positions)
        assert info.status == "optimal"
        assert set(info.active) == {"robots 0 and 1", "robot 2 and wall +x"}
        assert info.solver == ("active set" if solver == "auto" else solver)
        assert info.iterations >= 1
        assert 0.0 <= info.violation <= 1e-8
        moved = np.hypot(*(velocity - command)).max()
        assert info.intervention == pytest.approx(moved, abs=1e-12)
        np.testing.assert_allclose(velocity[:, 3], command[:, 3], atol=1e-6)


def test_inputs_are_left_alone():
    poses = np.array([[-0.2, 0.2], [0.0, 0.0], [0.0, np.pi]])
    command = np.array([[0.2, 0.2], [0.0, 1.0]])
    before = poses.copy(), command.copy()
    UnicycleCertificate()(command, poses)
    np.testing.assert_array_equal(poses, before[0])
    np.testing.assert_array_equal(command, before[1])


def test_wrong_shapes_and_parameters_are_refused():
    with pytest.raises(ShapeError, match=r"expected \(3, N\)"):
        UnicycleCertificate()(np.zeros((2, 3)), np.zeros((2, 3)))
    with pytest.raises(ShapeError, match="3 robots"):
        UnicycleCertificate()(np.zeros((2, 3)), np.zeros((3, 2)))
    with pytest.raises(ParameterError, match="safety_radius"):
        UnicycleCertificate(safety_radius=-1.0)
    with pytest.raises(ParameterError, match="expected 'auto'"):
        SingleIntegratorCertificate(solver="simplex")


def test_policies_where_nothing_is_safe():
    positions = np.array([[1.65, 1.62], [0.0, 0.001]])
    command = np.zeros((2, 2))
    with pytest.raises(InfeasibleError, match="robots 0 and 1"):
        SingleIntegratorCertificate(boundary=ARENA, barrier_gain=1e4, on_infeasible="raise")(
            command, positions
        )
    velocity, info = SingleIntegratorCertificate(
        boundary=ARENA, barrier_gain=1e4, on_infeasible="stop"
    )(command, positions)
    assert info.status == "failed"
    assert not velocity.any()
    certificate = SingleIntegratorCertificate(boundary=ARENA, barrier_gain=1e4)
    velocity, info = certificate(command, positions)
    assert info.status == "relaxed"
    assert info.violation > 0
    assert np.hypot(*velocity).max() <= 0.2 + 1e-9
    assert velocity[0, 1] < velocity[0, 0]  # they part
    for _ in range(300):
        velocity, info = certificate(command, positions)
        positions = positions + 0.033 * velocity
    assert info.status != "relaxed"
    assert info.clearance > -0.01  # apart and inside, as far as a cubic barrier goes in 10 s


@pytest.mark.parametrize("ends", [(-0.05, 0.10), (-0.02, 0.13), (-0.1, 0.1)])
def test_a_robot_between_two_that_overlap_is_not_pushed_by_the_one_that_overlaps_more(ends):
    """Both pairs ask for more than anybody can do, so both are given all that there is."""
    certificate = SingleIntegratorCertificate(barrier_gain=1e6, speed_limit=0.15)
    positions = [[ends[0], 0.0, ends[1]], [0.0, 0.0, 0.0]]
    velocity, info = certificate(np.zeros((2, 3)), positions)
    assert info.status == "relaxed"
    np.testing.assert_allclose(velocity[0], velocity[0, 2] * np.array([-1, 0, 1]), atol=1e-6)
    assert velocity[0, 2] > 0.13
    assert info.violated == ("robots 0 and 1", "robots 1 and 2")


def test_options_are_for_a_solver_that_is_named():
    with pytest.raises(ParameterError, match="expected its name too"):
        SingleIntegratorCertificate(options={"max_iter": 50})
    certificate = SingleIntegratorCertificate(solver="clarabel", options={"max_iter": 50})
    velocity, info = certificate([[0.15, -0.15], [0.0, 0.0]], [[-0.08, 0.08], [0.0, 0.0]])
    assert info.solver == "clarabel"
    assert velocity[0, 0] < 0.15


def test_not_a_number_stops_the_team():
    command = np.array([[0.1, np.nan], [0.0, 0.0]])
    positions = np.array([[-1.0, 1.0], [0.0, 0.0]])
    velocity, info = SingleIntegratorCertificate()(command, positions)
    assert info.status == "failed"
    assert not velocity.any()
    assert np.isnan([info.violation, info.intervention, info.smallest_h, info.clearance]).all()
    with pytest.raises(NotFiniteError):
        SingleIntegratorCertificate(on_infeasible="raise")(command, positions)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 6))
def test_no_other_point_found_by_a_general_optimiser_is_nearer(seed, number):
    """The optimum beats what a general-purpose optimiser finds from the same rows."""
    random = np.random.default_rng(seed)
    positions = random.uniform(-0.35, 0.35, (2, number))
    command = random.uniform(-0.2, 0.2, (2, number))
    certificate = SingleIntegratorCertificate(safety_radius=0.12, on_infeasible="relax")
    velocity, info = certificate(command, positions)
    if info.status == "relaxed":
        return
    rows = info.rows
    every = rows.dense(np.arange(len(rows)))
    found = minimize(
        lambda x: ((x - command.T.ravel()) ** 2).sum(),
        np.zeros(2 * number),
        jac=lambda x: 2 * (x - command.T.ravel()),
        constraints={
            "type": "ineq",
            "fun": lambda x: rows.bound - every @ x,
            "jac": lambda x: -every,
        },
        options={"ftol": 1e-14, "maxiter": 300},
    )
    if found.success and np.all(every @ found.x - rows.bound <= 1e-9):
        assert ((velocity - command) ** 2).sum() <= found.fun + 1e-10


def test_rows_that_bound_last_time_may_all_be_idle_now():
    """Remembered rows that all pull, beside a broken one, must not leave nothing to solve."""
    certificate = SingleIntegratorCertificate()
    fresh = SingleIntegratorCertificate()
    positions = np.array([[-0.08, 0.08, 1.0], [0.0, 0.0, 0.0]])
    certificate([[0.1, -0.1, 0.0], [0.0, 0.0, 0.0]], positions)
    command = np.array([[-0.1, 0.1, 0.3], [0.0, 0.0, 0.0]])
    velocity, info = certificate(command, positions)
    assert info.status == "optimal"
    np.testing.assert_allclose(velocity, fresh(command, positions)[0], atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 12))
def test_memory_never_changes_a_result(seed, number):
    random = np.random.default_rng(seed)
    remembering = SingleIntegratorCertificate(boundary=(-0.6, 0.6, -0.6, 0.6))
    for _ in range(5):
        positions = random.uniform(-0.5, 0.5, (2, number))
        command = random.uniform(-0.3, 0.3, (2, number))
        fresh = SingleIntegratorCertificate(boundary=(-0.6, 0.6, -0.6, 0.6))
        expected, expected_info = fresh(command, positions)
        velocity, info = remembering(command, positions)
        assert info.status == expected_info.status
        np.testing.assert_allclose(velocity, expected, atol=1e-8)


@pytest.mark.parametrize("speed", [1e5, 1e9, 1e20, 1e300])
def test_absurd_commands_keep_the_limits(speed):
    certificate = SingleIntegratorCertificate(boundary=ARENA)
    velocity, info = certificate([[speed, 0.1], [0.3 * speed, 0.0]], [[0.0, 1.0], [0.0, 0.0]])
    assert info.status == "optimal"
    assert info.violation <= 1e-9
    assert info.intervention == pytest.approx(np.hypot(1, 0.3) * speed, rel=1e-6, abs=0.2)
    corner = 0.2 * np.array([np.cos(np.pi / 4), np.sin(np.pi / 4)])  # of the octagon, or its side
    assert np.hypot(*velocity[:, 0]) <= 0.2 + 1e-9
    assert velocity[:, 0] @ [1, 0.3] >= corner @ [1, 0.3]
    np.testing.assert_allclose(velocity[:, 1], [0.1, 0.0], atol=1e-9)
    commands, info = UnicycleCertificate()([[speed], [0.0]], np.zeros((3, 1)))
    assert info.violation <= 1e-9
    assert commands[0, 0] == pytest.approx(0.2, abs=1e-9)


@pytest.mark.parametrize("distance", [1.0, 100.0, 1e4, 1e6])
def test_robots_come_back_from_however_far_outside(distance):
    certificate = SingleIntegratorCertificate(boundary=ARENA)
    velocity, info = certificate([[0.1], [0.1]], [[1.6 + distance], [0.0]])
    assert info.status == "relaxed"
    assert velocity[0, 0] < -0.18
    assert np.hypot(*velocity[:, 0]) <= 0.2 + 1e-9
