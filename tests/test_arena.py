"""The one simulator: motion, limits, what counts as a violation, its guests."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from barrier_certificates.ties import TIE
from rps_compat.arena import Arena
from rps_compat.errors import CommandError
from rps_compat.logged_violations import violations_of
from rps_compat.profiles import load_profile
from rps_compat.report import report_on
from rps_compat.session import Session, SessionError
from rps_compat.testbed import GRITSBOT_X, GTERNAL
from rps_compat.violations import Violations


def arena_at(*poses, **guests):
    return Arena(np.array(poses, dtype=float).T, **guests)


def test_robots_drive_along_their_headings():
    arena = arena_at((0, 0, 0), (0.5, 0, np.pi / 2))
    arena.commands = np.array([[0.1, 0.15], [0.0, 0.5]])
    arena.step()
    np.testing.assert_allclose(
        arena.poses, [[0.0033, 0.5], [0, 0.00495], [0, np.pi / 2 + 0.0165]], atol=1e-15
    )


@given(
    st.floats(-1, 1),
    st.floats(-20, 20),
    st.sampled_from([GRITSBOT_X, GTERNAL]),
)
def test_wheels_never_turn_faster_than_they_can(v, w, robot):
    arena = Arena(np.zeros((3, 1)), robot)
    cut = arena.saturate(np.array([[v], [w]]))
    assert np.abs(arena.wheels(cut)).max() <= robot.max_wheel_velocity * (1 + 1e-12)
    asked = arena.wheels(np.array([[v], [w]]))
    if np.abs(asked).max() <= robot.max_wheel_velocity:
        np.testing.assert_allclose(cut, [[v], [w]], atol=1e-12)


@given(st.lists(st.floats(-4, 4), min_size=1, max_size=30))
def test_headings_stay_within_half_a_turn(turns):
    arena = arena_at((0, 0, 3.0))
    for turn in turns:
        arena.commands = np.array([[0.0], [turn]])
        arena.step()
        assert abs(arena.poses[2, 0]) <= np.pi + TIE


def test_commands_stay_until_the_next():
    arena = arena_at((0, 0, 0))
    arena.commands = np.array([[0.1], [0.0]])
    for _ in range(10):
        arena.step()
    assert arena.poses[0, 0] == pytest.approx(0.033)


@pytest.mark.parametrize(
    ("commands", "message"),
    [
        ([[0.1, np.nan], [0, 0]], "forward speed of robot 1 is nan"),
        ([[0.1, 0], [-np.inf, 0]], "turn rate of robot 0 is -inf"),
        ([[0.1, 0.1, 0.1], [0, 0, 0]], r"shape \(2, 3\), but 2 robots need \(2, 2\)"),
        ([0.1, 0.1], r"shape \(2,\)"),
    ],
)
def test_impossible_commands_are_refused_before_anything_moves(commands, message):
    arena = arena_at((0, 0, 0), (1, 0, 0))
    arena.commands = np.array(commands)
    with pytest.raises(CommandError, match=message):
        arena.step()
    np.testing.assert_array_equal(arena.poses, [[0, 1], [0, 0], [0, 0]])


def test_a_fault_is_one_event_however_long_it_lasts():
    arena = arena_at((0, 0, 0), (0.1, 0, 0), (1, 0.9999, np.pi / 2))
    arena.commands = np.array([[0, 0, 0.1], [0, 0, 0]])
    for _ in range(1000):
        arena.step()
    found = arena.violations
    assert [(e.kind, e.robots, e.first, e.last) for e in found.events] == [
        ("collision", (0, 1), 0, 999),
        ("boundary", (2,), 1, 999),
    ]
    assert found.close_by_robot == {0: 1000, 1: 1000}
    assert found.outside_steps == 999
    assert found.events[0].worst == pytest.approx(0.1)


def test_a_fault_that_returns_is_a_second_event():
    arena = arena_at((0, 0, 0))
    for k in range(6):
        arena.commands = np.array([[1.0 if k in (1, 2, 5) else 0.1], [0.0]])
        arena.step()
    assert [(e.first, e.last) for e in arena.violations.events] == [(1, 2), (5, 5)]
    assert arena.violations.actuator_steps == 3
    assert report_on(arena).largest_wheel_velocity == pytest.approx(62.5)


def test_one_sound_step_between_two_faults_makes_them_two():
    found = Violations()
    for step in (3, 4, 6):
        found.outside(step, np.array([-0.1, 0.02 * step]))
        found.close(step, np.array([0]), np.array([1]), np.array([0.1 + 0.001 * step]))
    assert [(e.kind, e.robots, e.first, e.last) for e in found.events] == [
        ("boundary", (1,), 3, 4),
        ("collision", (0, 1), 3, 4),
        ("boundary", (1,), 6, 6),
        ("collision", (0, 1), 6, 6),
    ]
    assert [e.worst for e in found.events] == pytest.approx([0.08, 0.103, 0.12, 0.106])
    assert [e.first for e in found.lasting(5)] == [6, 6]
    assert found.lasting(0) == found.events
    assert (found.outside_steps, found.outside_by_robot) == (3, {1: 3})
    assert (found.close_steps, found.close_pairs, found.close_by_robot) == (3, 3, {0: 3, 1: 3})


def test_a_run_is_clean_without_collisions_and_without_anybody_outside():
    assert Violations(actuator_steps=5, saturated_steps=5).clean
    assert not Violations(close_pairs=1).clean
    assert not Violations(outside_steps=1).clean


def test_a_wheel_at_its_limit_is_not_over_it():
    arena = arena_at((0, 0, 0), (1, 0, 0))
    arena.commands = np.array([[0.2, 0.3], [0.0, 0.0]])  # 12.5 rad/s exactly, and more
    arena.step()
    assert [(e.kind, e.robots) for e in arena.violations.events] == [("actuator", (1,))]
    assert arena.violations.largest_wheel_velocity == pytest.approx(18.75)


def test_wheels_are_cut_both_ways_and_each_for_itself():
    arena = arena_at((0, 0, 0), (0, 1, 0), (0, -1, 0))
    arena.commands = np.array([[-1.0, 0.05, 1.0], [0.0, 0.0, 0.0]])
    arena.step()
    np.testing.assert_allclose(arena.poses[0], 0.033 * np.array([-0.2, 0.05, 0.2]), atol=1e-12)
    np.testing.assert_allclose(arena.velocities[0], [-0.2, 0.05, 0.2], atol=1e-12)


def test_the_test_of_logged_poses_names_their_rows():
    poses = np.zeros((6, 3, 2))
    poses[:, 0] = [-0.5, 0.5]
    poses[3:5, 0, 1] = 1.7
    found = violations_of(poses, GTERNAL, range(6))
    assert [(e.kind, e.robots, e.first, e.last) for e in found.events] == [("boundary", (1,), 3, 4)]
    assert violations_of(poses, GTERNAL, [0, 4]).outside_steps == 1


def test_a_robot_at_half_a_turn_keeps_its_sign():
    for heading in (np.pi + TIE / 2, -np.pi - TIE / 2):
        arena = arena_at((0, 0, heading))
        arena.step()
        assert arena.poses[2, 0] == heading


def test_whole_numbers_may_be_poses():
    arena = Arena(np.zeros((3, 1), dtype=int))
    arena.commands = np.array([[0.1], [0.0]])
    arena.step()
    assert arena.poses[0, 0] == pytest.approx(0.0033)


def test_a_realism_that_cares_hears_whether_there_was_a_command():
    class Cares:
        commanded, heard = False, ()

        def reset(self, poses, time_step, rng):
            self.heard = []

        def actuate(self, velocities, poses, time):
            self.heard.append((self.commanded, time))
            return velocities

        def observe(self, poses):
            return poses

    arena = arena_at((0, 0, 0), realism=Cares())
    arena.step()
    arena.commands = np.array([[0.1], [0.0]])
    arena.step()
    arena.step()
    arena.commanded = True  # the same again, as the faces say
    arena.step()
    assert arena.realism.heard == [
        (heard, pytest.approx(0.033 * k)) for k, heard in enumerate((False, True, False, True))
    ]


def test_collisions_are_judged_ahead_of_the_centres():
    facing, apart = arena_at((0, 0, 0), (0.17, 0, np.pi)), arena_at((0, 0, np.pi), (0.1, 0, 0))
    facing.step()
    apart.step()
    assert facing.violations.close_pairs == 1
    assert apart.violations.close_pairs == 0


def test_the_recorder_hears_of_every_step_before_it_moves():
    heard = []

    class Ear:
        def append(self, time, poses, commands):
            heard.append((time, poses[0, 0], commands[0, 0]))

    arena = arena_at((0, 0, 0), recorder=Ear())
    arena.commands = np.array([[1.0], [0.0]])
    arena.step()
    arena.step()
    assert heard == [(0.0, 0.0, 1.0), (0.033, pytest.approx(0.0066), pytest.approx(0.2))]


class Sleepy:
    """Robots that drive at half speed, and a tracker that is 1 m off."""

    def reset(self, poses, time_step, rng):
        self.started = (poses.copy(), time_step, rng.random())

    def actuate(self, velocities, poses, time):
        return 0.5 * velocities

    def observe(self, poses):
        return poses + np.array([[1.0], [0.0], [0.0]])


def test_realism_stands_between_command_and_motion_and_between_pose_and_measurement():
    arena = arena_at((1.5, 0, 0), realism=Sleepy(), rng=np.random.default_rng(0))
    arena.commands = np.array([[0.1], [0.0]])
    arena.step()
    assert arena.poses[0, 0] == pytest.approx(1.5 + 0.00165)
    assert arena.observe()[0, 0] == pytest.approx(2.5 + 0.00165)
    assert arena.violations.clean, "what is measured outside is not outside"


def test_sessions_do_not_leak():
    import rps_compat

    rps_compat.install(generation=1)
    try:
        from rps.robotarium import Robotarium

        def start():
            return Robotarium(2, False, False, np.array([[0, 1.0], [0, 0], [0, 0]])).get_poses()

        with Session(initial="arrive", seed=1).active():
            first, second = start(), start()
        with Session(initial="arrive", seed=1).active():
            again = start()
        after = start()
    finally:
        rps_compat.uninstall()
    assert (first == again).all()
    assert not (first == second).all(), "each instance has its own random stream"
    assert (after == [[0, 1.0], [0, 0], [0, 0]]).all()


def test_a_session_knows_its_modes():
    with pytest.raises(SessionError, match="'fly', expected one of published"):
        Session(initial="fly")


def test_robots_are_exchanged_where_they_stand():
    arena, ideal = (arena_at((0, 0, 0), (0.5, 0, 0)) for _ in range(2))
    for step in range(20):
        for one in (arena, ideal):
            one.commands = np.full((2, one.number_of_robots), 0.1)
            one.step()
        if step == 9:
            np.testing.assert_array_equal(arena.poses, ideal.poses)
            arena.become(load_profile("gritsbot_x").start(), np.random.default_rng(0))
            assert not np.array_equal(arena.observe(), arena.poses)  # a tracker that trembles
    assert arena.steps == ideal.steps
    assert (np.abs(arena.poses[2]) < np.abs(ideal.poses[2])).all()  # motors that answer late
    arena.become(None)
    assert arena.observe() is arena.poses
