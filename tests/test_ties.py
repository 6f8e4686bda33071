"""Where numbers are equal but for their last bits, a stated rule decides, and no last bit.

Every test asks the same of inputs that differ by one to four units in the last place. Each fails
when `TIE` is nothing.
"""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from last_bits import TOUCHING, neighbours_of, shifted

from barrier_certificates import ties
from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.deadlock import DeadlockMonitor, DeadlockParameters
from barrier_certificates.rows.walls import polygon
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from rps_compat import controllers, graphs, kinematics, sensors
from rps_compat.arena import Arena
from rps_compat.command_effects import DeadBand, Watchdog
from rps_compat.errors import InitialConditionsError
from rps_compat.initial import check_distances, warn_of_outside
from rps_compat.report import report_on
from rps_compat.testbed import GTERNAL
from rps_compat.v1.utilities import transformations as first
from rps_compat.v2.utilities import transformations as second


def one_answer(answers):
    """Assert that all are equal, and return it."""
    answers = list(answers)
    assert all(answer == answers[0] for answer in answers), answers
    return answers[0]


@given(st.floats(-1e3, 1e3), st.integers(-4, 4))
def test_a_number_and_its_neighbours_are_equal(number, ulps):
    other = float(shifted(number, ulps))
    assert ties.within(other, number)
    assert ties.reached(other, number)
    assert not ties.beyond(other, number)
    assert not ties.short_of(other, number)


@given(st.floats(-1e3, 1e3), st.floats(1e-6, 1e3))
def test_numbers_that_differ_are_told_apart(number, difference):
    assert ties.beyond(number + difference, number)
    assert ties.short_of(number - difference, number)


def test_nothing_is_known_of_a_number_that_is_none():
    assert not any(
        compare(a, b)
        for compare in (ties.within, ties.beyond, ties.reached, ties.short_of)
        for a, b in ((np.nan, 0.0), (0.0, np.nan))
    )


def test_the_first_of_equal_numbers_is_the_smallest_and_the_largest():
    for values in neighbours_of([3.0, 1.0, 2.0, 1.0, 3.0]):
        assert ties.first_smallest(values) == 1
        assert ties.first_largest(values) == 0
        assert sorted(range(5), key=lambda k: ties.rank(values[k])) == [1, 3, 2, 0, 4]


@pytest.mark.parametrize(("value", "down", "nearest"), [(2.5, 2, 3), (29.0, 29, 29), (0.5, 0, 1)])
def test_counts_do_not_hang_on_a_last_bit(value, down, nearest):
    assert one_answer(ties.whole(float(v)) for v in neighbours_of(value)) == down
    assert one_answer(ties.nearest_whole(float(v)) for v in neighbours_of(value)) == nearest


# The arena: where robots are, and what counts as a violation.


@pytest.mark.parametrize(
    ("x", "y"), [(1.6, 0.0), (-1.6, 0.0), (0.0, 1.0), (0.0, -1.0), (1.6, 1.0), (-1.6, -1.0)]
)
def test_a_robot_on_the_wall_is_inside(x, y):
    for poses in neighbours_of([[x], [y], [0.3]]):
        arena = Arena(poses, GTERNAL)
        arena.step()
        assert arena.violations.clean
        warn_of_outside(poses, GTERNAL)  # a warning is an error here


@pytest.mark.parametrize("course", [0.0, 0.7, np.pi / 2, 3.0])
def test_robots_that_touch_are_too_close(course):
    cos, sin = TOUCHING * np.cos(course), TOUCHING * np.sin(course)
    face_to_face = [[0.1, 0.1 + cos], [0.2, 0.2 + sin], [course, course + np.pi]]
    for poses in neighbours_of(face_to_face):
        arena = Arena(poses, GTERNAL)
        arena.step()
        assert arena.violations.close_pairs == 1
        with pytest.raises(InitialConditionsError, match="too close"):
            check_distances(poses, GTERNAL, apart=True)


def test_the_first_of_pairs_as_close_is_named():
    square = [[0.0, 0.1, 0.1, 0.0], [0.0, 0.0, 0.1, 0.1], [0.3, 0.3, 0.3, 0.3]]
    for poses in neighbours_of(square):
        with pytest.raises(InitialConditionsError, match="robots 0 and 1"):
            check_distances(poses, GTERNAL, apart=True)


def test_wheels_at_their_limit_are_not_over_it():
    # Straight at 0.2 m/s, and turning on the spot as fast as the wheels can.
    fastest = 2 * GTERNAL.wheel_radius * GTERNAL.max_wheel_velocity / GTERNAL.base_length
    for commands in neighbours_of([[0.2, 0.0, 0.1], [0.0, fastest, fastest / 2]]):
        arena = Arena(np.array([[-1.0, 0.0, 1.0], [0.0] * 3, [0.0] * 3]), GTERNAL)
        arena.commands = commands
        arena.step()
        assert arena.violations.actuator_steps == 0
        assert arena.violations.events == []
        assert report_on(arena).steps_over_actuator_limits == 0


@pytest.mark.parametrize("heading", [np.pi, -np.pi])
def test_a_heading_of_half_a_turn_keeps_its_sign(heading):
    for poses in neighbours_of([[0.0], [0.0], [heading]]):
        arena = Arena(poses, GTERNAL)
        arena.step()
        assert np.sign(arena.poses[2, 0]) == np.sign(heading)


def test_sensors_read_the_end_of_a_wall_and_what_is_just_in_reach():
    wall = np.array([[[0.5, 0.0], [0.5, 0.3]]])
    ahead = np.zeros((3, 1))
    for poses in neighbours_of([[0.2], [0.0], [0.0]]):
        # The ray meets the very end of the wall, at the very end of its reach.
        assert sensors.cast_rays(poses, wall, ahead, 0.3)[0, 0] == pytest.approx(0.3)
    for poses in neighbours_of([[0.5], [0.1], [0.0]]):
        assert sensors.cast_rays(poses, wall, ahead, 0.3)[0, 0] == pytest.approx(0.0)
    for poses in neighbours_of([[0.0, 0.5], [0.055, 0.0], [0.0, 0.0]]):
        met = sensors.cast_rays(poses, None, ahead, 1.0, robot_diameter=0.11)
        assert met[0, 0] == pytest.approx(0.5)


def test_motors_take_commands_at_the_dead_band_and_brake_when_time_is_up():
    rng = np.random.default_rng(0)
    band = DeadBand(speed=0.01, turn=0.1).begin(1, 0.033, rng)
    for command in neighbours_of([[0.01], [0.0]]):
        assert band(command, np.zeros(1), 0.033)[0, 0] == pytest.approx(0.01)
    dog = Watchdog(0.5).begin(1, 0.1, rng)
    for age in neighbours_of([0.1 + 0.1 + 0.1 + 0.1 + 0.1]):
        assert not dog(np.array([[0.1], [0.0]]), age, 0.1).any()


# The API: which way, who, how many.


def opposite(headings, speed=0.1):
    """Velocities (2, N) straight back, and poses (3, N)."""
    velocities = -speed * np.array([np.cos(headings), np.sin(headings)])
    return velocities, np.array([np.zeros_like(headings), np.zeros_like(headings), headings])


@pytest.mark.parametrize(
    "create",
    [first.create_si_to_uni_dynamics, second.create_si_to_uni_dynamics],
    ids=["generation 1", "generation 2"],
)
def test_a_robot_told_to_go_straight_back_turns_through_the_heading_zero(create):
    headings = np.concatenate([np.linspace(-np.pi, np.pi, 41), [0.0, 1.3778, 1.4147, -1.21]])
    to_command = create(1.0, 2.0)
    velocities, poses = opposite(headings)
    for v, p in zip(neighbours_of(velocities), neighbours_of(poses), strict=True):
        rates = to_command(v, p)[1]
        right = headings > 1e-6
        np.testing.assert_allclose(rates[right], -4.0)
        np.testing.assert_allclose(rates[~right], 4.0)


def test_off_the_tie_a_robot_turns_the_shorter_way():
    headings = np.array([2.0, 2.0, -2.0, -2.0])
    velocities, poses = opposite(headings)
    poses[2] += [1e-6, -1e-6, 1e-6, -1e-6]
    for create in (first.create_si_to_uni_dynamics, second.create_si_to_uni_dynamics):
        np.testing.assert_array_equal(np.sign(create()(velocities, poses)[1]), [1, -1, 1, -1])


def test_a_velocity_beside_the_robot_is_met_backwards():
    headings = np.linspace(-3.0, 3.0, 13)
    to_command = second.create_si_to_uni_dynamics_with_backwards_motion(1.0, 2.0)
    for side in (1.0, -1.0):
        velocities, poses = opposite(headings + side * np.pi / 2)
        poses[2] = headings
        for v, p in zip(neighbours_of(velocities), neighbours_of(poses), strict=True):
            np.testing.assert_allclose(to_command(v, p)[1], side * 2.0)


@pytest.mark.parametrize("turn", [np.pi, -np.pi])
def test_half_a_turn_keeps_its_sign(turn):
    for angle in neighbours_of([turn]):
        assert np.sign(kinematics.wrap(angle)[0]) == np.sign(turn)
    goals = np.array([[0.3], [0.2], [turn / 2]])
    for states in neighbours_of([[0.3], [0.2], [-turn / 2]]):
        command = controllers.turn_on_the_spot(goals, states, 1.0, 0.1)
        assert command[1, 0] == pytest.approx(turn)


@pytest.mark.parametrize("heading", [0.7, np.pi, 1.0, -2.0])
def test_a_goal_straight_behind_is_turned_to_one_way(heading):
    goal = [[0.3 - 0.5 * np.cos(heading)], [0.2 - 0.5 * np.sin(heading)], [heading]]
    states = [[0.3], [0.2], [heading]]
    pairs = zip(neighbours_of(goal), neighbours_of(states), strict=True)
    ways = [controllers.command_to_pose(g, s, 1.0, 2.7, 0.4) for g, s in pairs]
    np.testing.assert_allclose(ways, [ways[0]] * len(ways), atol=1e-6)


def test_robots_at_the_radius_are_disk_neighbours():
    for positions in neighbours_of([[0.1, 0.3, 0.1, 0.5], [0.1, 0.1, 0.3, 0.1]]):
        assert graphs.disk_neighbors(positions, 0, 0.2).tolist() == [1, 2]


# Certificates: who is held for how long, what is near, what is an arena.


def test_margins_are_told_in_one_order():
    certificate = SingleIntegratorCertificate(safety_radius=0.2, boundary=(-1, 1, -1, 1))
    square = [[0.3, -0.3, -0.3, 0.3], [0.3, 0.3, -0.3, -0.3]]
    labels = one_answer(
        [margin.what for margin in certificate.margins(p, within=0.6)]
        for p in neighbours_of(square)
    )
    assert labels[:4] == ["robots 0 and 1", "robots 0 and 3", "robots 1 and 2", "robots 2 and 3"]


def test_a_robot_is_stuck_when_its_patience_is_over_and_not_before():
    desired, nothing = np.array([[0.1], [0.0]]), np.zeros((2, 1))
    for (step,) in neighbours_of([0.1]):
        monitor = DeadlockMonitor(DeadlockParameters(time_step=float(step), patience=0.3))
        stuck = []
        for _ in range(4):
            monitor.watch(desired, desired, nothing)
            stuck.append(bool(monitor.stuck(1)[0]))
        assert stuck == [False, False, False, True]


def test_a_polygon_may_be_closed_by_a_corner_that_is_the_first_but_for_a_bit():
    angles = np.linspace(0.0, 2.0 * np.pi, 7)  # sin(2π) is not 0
    for corners in neighbours_of([np.cos(angles), np.sin(angles)]):
        assert polygon(corners)[0].shape == (2, 6)


def test_corners_on_a_line_are_no_corners():
    for corners in neighbours_of([[0.0, 0.1, 0.3, 0.3, 0.0], [0.0, 0.1, 0.3, 0.6, 0.6]]):
        with pytest.raises(ParameterError, match="convex"):
            polygon(corners)


def test_neighbours_of_a_number_lie_on_both_sides_of_it():
    for compare, number in itertools.product((np.less, np.greater), (TOUCHING, 0.2, 12.5)):
        assert len({bool(compare(v, number)) for v in neighbours_of(number)}) == 2
