"""The simulator where numbers meet exactly, and what it counts, holds and hands over each step."""

import numpy as np
import pytest

from barrier_certificates.ties import TIE
from rps_compat.arena import Arena, require_finite
from rps_compat.errors import CommandError
from rps_compat.logged_violations import violations_of
from rps_compat.testbed import GRITSBOT_X
from rps_compat.violations import Violations

X_MIN, X_MAX, Y_MIN, Y_MAX = GRITSBOT_X.boundaries
TOUCHING = GRITSBOT_X.collision_diameter
AHEAD = GRITSBOT_X.collision_offset


def arena_at(*poses, **guests):
    return Arena(np.array(poses, dtype=float).T, **guests)


@pytest.mark.parametrize(
    ("wall", "outwards"),
    [((X_MIN, 0), (-1, 0)), ((X_MAX, 0), (1, 0)), ((0, Y_MIN), (0, -1)), ((0, Y_MAX), (0, 1))],
)
@pytest.mark.parametrize("beyond", [-TIE / 2, 0.0, TIE / 2, 2 * TIE, 0.1])
def test_on_the_wall_is_inside_and_beyond_it_is_outside(wall, outwards, beyond):
    x, y = np.array(wall, dtype=float) + beyond * np.array(outwards)
    arena = arena_at((0.5, 0.5, 0), (x, y, 0), (0.5, -0.5, 0))
    arena.check()
    outside = beyond > TIE
    assert arena.violations.outside_by_robot == ({1: 1} if outside else {})
    assert arena.violations.outside_steps == outside
    assert [e.worst for e in arena.violations.events] == pytest.approx([beyond] * outside)


def test_only_who_is_beyond_the_wall_is_outside():
    arena = arena_at((X_MAX, 0, 0), (X_MAX + 0.1, 0.5, 0), (0, Y_MAX, 0))
    arena.check()
    assert arena.violations.outside_by_robot == {1: 1}


@pytest.mark.parametrize("turn", [0.0, np.pi / 2])
@pytest.mark.parametrize("more", [-1e-3, -TIE / 2, 0.0, TIE / 2, 2 * TIE, 1e-3])
def test_bodies_that_touch_are_too_close(turn, more):
    """Robots face each other, side by side or one above the other; a third one stands far off."""
    apart = TOUCHING + 2 * AHEAD + more
    there = apart * np.cos(turn), apart * np.sin(turn), turn + np.pi
    facing = arena_at((0, 0, turn), there, (-1, 0.7, 0.4))
    stepped = Arena(facing.poses)
    facing.check()
    stepped.step()
    for found in (facing.violations, stepped.violations):
        assert found.close_by_robot == ({0: 1, 1: 1} if more <= TIE else {})
        assert found.close_steps == found.close_pairs == (more <= TIE)


def test_a_robot_alone_has_nobody_to_touch():
    arena = arena_at((0, 0, 0))
    arena.check()
    arena.step()
    assert arena.violations.clean
    assert arena.number_of_robots == 1


@pytest.mark.parametrize(("speed", "cut"), [(0.0, 0), (0.2, 0), (0.2 + 1e-12, 1), (0.3, 1)])
def test_wheels_at_their_limit_are_not_cut(speed, cut):
    """12.5 rad/s exactly is the limit; a last bit more is cut, but no fault."""
    checked, stepped = (arena_at((0, 0, 0), (1, 0, 0)) for _ in range(2))
    checked.commands = np.array([[0.1, speed], [0.0, 0.0]])
    checked.check()
    stepped.commands = checked.commands
    stepped.step()
    for arena in (checked, stepped):
        assert arena.violations.saturated_steps == cut
        assert arena.violations.actuator_steps == (speed == 0.3)
    np.testing.assert_allclose(
        stepped.wheel_velocities, np.tile([6.25, min(62.5 * speed, 12.5)], (2, 1)), rtol=1e-12
    )


def test_wheels_are_told_left_then_right():
    arena = arena_at((0, 0, 0))
    arena.commands = np.array([[0.1], [0.5]])
    arena.step()
    half = GRITSBOT_X.base_length / 2
    wheels = np.array([[0.1 - 0.5 * half], [0.1 + 0.5 * half]]) / GRITSBOT_X.wheel_radius
    np.testing.assert_allclose(arena.wheel_velocities, wheels)
    np.testing.assert_allclose(arena.unicycle(wheels), arena.commands)
    np.testing.assert_allclose(arena.saturate(arena.commands), arena.commands)


def test_one_command_may_be_for_all():
    heard = []

    class Ear:
        def append(self, time, poses, commands):
            heard.append(commands.copy())

    for guests in ({}, {"realism": Measures()}):
        arena = arena_at((0, 0, 0), (0, 0.5, 0), (0, -0.5, 0), recorder=Ear(), **guests)
        arena.commands = np.array([[0.1], [0.0]])
        arena.step()
        np.testing.assert_allclose(arena.poses[0], [0.0033] * 3)
        np.testing.assert_array_equal(heard.pop(), [[0.1] * 3, [0.0] * 3])
        arena.commands = np.zeros((2, 2))
        with pytest.raises(CommandError, match=r"shape \(2, 2\), but 3 robots"):
            arena.step()


class Measures:
    """Keeps what it is told, and counts how often it is asked to measure."""

    def __init__(self):
        self.measured = 0

    def reset(self, poses, time_step, rng):
        self.told = (poses.copy(), time_step, rng)

    def actuate(self, velocities, poses, time):
        assert velocities.shape == (2, poses.shape[1])
        return velocities

    def observe(self, poses):
        self.measured += 1
        return poses + 0.001 * self.measured


def test_a_pose_is_measured_once_until_the_robots_are_elsewhere():
    arena = arena_at((0, 0, 0), realism=Measures())
    first = arena.observe()
    assert arena.observe() is first
    arena.step()
    second = arena.observe()
    assert second[0, 0] == pytest.approx(0.002)
    assert arena.observe() is second
    arena.place(np.array([[1], [0], [0]]))
    assert arena.observe()[0, 0] == pytest.approx(1.003)
    arena.commands = np.array([[0.1], [0.0]])
    arena.step()
    assert arena.poses[0, 0] == pytest.approx(1.0033)  # carried there by whole numbers


def test_realism_is_told_of_the_start_and_draws_from_the_generator_given():
    mine = np.random.default_rng(3)
    poses, time_step, rng = arena_at((0.2, 0, 1), realism=Measures(), rng=mine).realism.told
    np.testing.assert_array_equal(poses, [[0.2], [0.0], [1.0]])
    assert time_step == GRITSBOT_X.time_step
    assert rng is mine
    *_, rng = arena_at((0.2, 0, 1), realism=Measures()).realism.told
    assert isinstance(rng, np.random.Generator)


def test_one_robot_turns_over_half_a_turn_while_another_does_not():
    arena = arena_at((0, 0, 3.13), (0.5, 0, 0.1))
    arena.commands = np.array([[0.0, 0.0], [3.0, 0.0]])
    arena.step()
    np.testing.assert_allclose(arena.poses[2], [3.13 + 0.099 - 2 * np.pi, 0.1])


def test_counting_starts_afresh_when_told_to():
    arena = arena_at((2, 0, 0))
    arena.step()
    assert arena.violations.outside_steps == 1
    arena.forget_violations()
    assert arena.violations == Violations()


def test_a_new_count_is_zero():
    new = Violations()
    assert new.saturated_steps == new.actuator_steps == new.largest_wheel_velocity == 0
    assert new.outside_steps == new.close_pairs == new.close_steps == 0


def test_events_that_last_to_a_step_are_seen_at_it():
    found = Violations()
    found.outside(4, np.array([0.1]))
    found.outside(6, np.array([0.1]))
    assert [e.first for e in found.lasting(6)] == [6]
    assert found.lasting(7) == []
    assert [e.first for e in found.lasting(1)] == [6]  # of each robot the last


def test_the_fastest_wheel_of_a_run_is_kept():
    found = Violations()
    for step, fastest in enumerate((15.0, 30.0, 20.0)):
        found.actuator(step, np.array([[1.0, fastest], [2.0, 3.0]]), 12.5)
    assert found.largest_wheel_velocity == 30.0
    assert [(e.robots, e.first, e.last, e.worst) for e in found.events] == [((1,), 0, 2, 30.0)]


def test_finite_commands_are_finite_however_large():
    with np.errstate(all="raise"):
        require_finite(np.array([[1e200, 0.0], [0.0, -1e200]]))
        require_finite(np.full((2, 40), -1e300))
        arena = arena_at((0, 0, 0), (1, 0, 0))
        arena.commands = np.array([[1e200, -1e300], [1e250, 1e200]])
        arena.step()
    limit = GRITSBOT_X.max_wheel_velocity
    np.testing.assert_array_equal(arena.wheel_velocities, [[-limit, -limit], [limit, -limit]])
    assert arena.violations.largest_wheel_velocity == pytest.approx(1e300 / 0.016)
    with pytest.raises(CommandError, match=r"velocity of robot 1 is inf \(velocities\[1\]\)"):
        require_finite(np.array([0.0, np.inf]))
    with pytest.raises(CommandError, match=r"turn rate of robot 1 is nan \(velocities\[1, 1\]\)"):
        require_finite(np.array([[0.1, 0.0], [0.0, np.nan]]))
    with pytest.raises(CommandError, match=r"forward speed of robot 0 is -1.7e\+308"):
        require_finite(np.array([[-1.7e308, 0.0], [0.0, 0.0]]))
    with pytest.raises(CommandError, match=r"forward speed of robot 0 is inf"):
        require_finite(np.array([[np.inf, 0.0], [-np.inf, np.nan]]))


def test_logged_poses_are_judged_where_they_are():
    poses = np.zeros((3, 3, 2))
    poses[:, 0] = [-0.5, 0.5]
    poses[1:, 2] = [0, np.pi]
    poses[1, 0] = [0, TOUCHING + 2 * AHEAD - 0.01]
    found = violations_of(poses, GRITSBOT_X, range(3))
    assert [(e.kind, e.robots, e.first, e.last) for e in found.events] == [
        ("collision", (0, 1), 1, 1)
    ]
    assert found.saturated_steps == 0
