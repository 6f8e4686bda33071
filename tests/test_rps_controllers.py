"""Controllers bring robots where they should be, and say what they cannot do."""

import numpy as np
import pytest

from rps_compat import controllers, deviations, kinematics
from rps_compat.arguments import NotAnArrayError, NumberError, ShapeError
from rps_compat.v1.utilities import controllers as first
from rps_compat.v2.utilities import controllers as second
from rps_compat.v2.utilities import misc as second_misc

DT = 0.033


def starts(robots=12, seed=3):
    rng = np.random.default_rng(seed)
    low, high = np.array([-1.4, -0.9, -np.pi]), np.array([1.4, 0.9, np.pi])
    poses = rng.uniform(low[:, None], high[:, None], (3, robots))
    return poses, rng.uniform(low[:, None], high[:, None], (3, robots))


def drive(poses, command, seconds, there):
    """Drive, and say which robots have been `there`."""
    poses, arrived = poses.copy(), np.zeros(poses.shape[1], dtype=bool)
    for _ in range(int(seconds / DT)):
        v, w = command(poses)
        poses[0] += DT * v * np.cos(poses[2])
        poses[1] += DT * v * np.sin(poses[2])
        poses[2] = kinematics.wrap(poses[2] + DT * w)
        arrived |= there(poses)
    return arrived


@pytest.mark.parametrize("generation", [first, second])
def test_points_go_straight_to_their_goals(generation):
    poses, goals = starts()
    controller = generation.create_si_position_controller()
    positions = poses[:2].copy()
    for _ in range(1500):
        velocities = controller(positions, goals[:2])
        assert np.all(np.hypot(*velocities) <= 0.15 + 1e-12)
        positions = positions + DT * velocities
    np.testing.assert_allclose(positions, goals[:2], atol=1e-3)


@pytest.mark.parametrize(
    ("create", "seconds", "error"),
    [
        (first.create_clf_unicycle_position_controller, 30, 0.05),
        (lambda: second.create_uni_position_controller(projection_distance=0.03), 60, 0.04),
    ],
)
def test_unicycles_reach_positions(create, seconds, error):
    poses, goals = starts()
    controller = create()
    assert drive(
        poses,
        lambda x: controller(x, goals[:2]),
        seconds,
        lambda x: controllers.distances(x, goals) <= error,
    ).all()


@pytest.mark.parametrize(
    "create",
    [
        first.create_clf_unicycle_pose_controller,
        first.create_hybrid_unicycle_pose_controller,
        second.create_pose_controller_clf,
        second.create_pose_parking_controller_clf,
        second.create_pose_controller_hybrid,
        second.create_pose_parking_controller_hybrid,
    ],
)
def test_unicycles_reach_poses(create):
    poses, goals = starts()
    controller = create()
    at_pose = second_misc.create_at_pose()
    assert drive(poses, lambda x: controller(x, goals), 40, lambda x: at_pose(x, goals)[1]).all()


@pytest.mark.parametrize(
    "create",
    [second.create_pose_parking_controller_clf, second.create_pose_parking_controller_hybrid],
)
def test_parked_robots_stand_still(create):
    _, goals = starts()
    inside = goals + np.array([[0.01], [0.01], [0.05]])
    np.testing.assert_array_equal(create()(inside, goals), 0.0)


class TestPoseControllerAtAngleZero:
    """The published formula divides 0 by 0 there; ours takes the limit."""

    goals = np.array([[1.0, 0.3], [0.0, 0.2], [0.4, 1.0]])
    states = np.array([[0.0, 0.3], [0.0, 0.2], [0.0, 1.0]])  # looks at its goal; stands on it

    def test_the_answer_is_the_limit_of_the_formula(self):
        controller = first.create_clf_unicycle_pose_controller()
        at_zero = controller(self.states, self.goals)
        nearby = self.states + np.array([[0.0], [0.0], [1e-7]])
        assert np.isfinite(at_zero).all()
        np.testing.assert_allclose(at_zero, controller(nearby, self.goals), atol=1e-5)

    def test_it_is_not_a_number_where_the_published_answer_is_wanted(self):
        with deviations.all_as_published():
            commands = first.create_clf_unicycle_pose_controller()(self.states, self.goals)
        assert np.isnan(commands[1]).all()
        assert np.isfinite(commands[0]).all()


def test_no_wheel_turns_faster_than_its_limit_and_the_curve_is_kept():
    poses, goals = starts()
    free = first.create_clf_unicycle_pose_controller()(poses, goals)
    limited = second.create_pose_controller_clf(wheel_velocity_limit=4.0)(poses, goals)
    wheels = kinematics.wheels_from_command(0.016, 0.105) @ limited
    assert np.abs(wheels).max() <= 4.0 + 1e-9
    np.testing.assert_allclose(free[0] * limited[1], free[1] * limited[0], atol=1e-9)


class TestHybridMemory:
    goal = np.zeros((3, 1))

    def at(self, distance):
        return np.array([[-distance], [0.0], [0.0]])

    def test_a_robot_that_arrived_stays_until_it_is_moved_away(self):
        controller = second.create_pose_controller_hybrid(position_error=0.05)
        assert controller(self.at(0.045), self.goal)[0, 0] > 0  # approaches
        assert controller(self.at(0.03), self.goal)[0, 0] == 0  # has arrived
        assert controller(self.at(0.045), self.goal)[0, 0] == 0  # and stays, though farther
        assert controller(self.at(0.06), self.goal)[0, 0] == 0  # noticed here,
        assert controller(self.at(0.06), self.goal)[0, 0] > 0  # obeyed in the next step

    def test_a_handed_in_memory_is_used_and_updated_in_place(self):
        controller = second.create_pose_controller_hybrid()
        states, goals = np.zeros((3, 2)), np.zeros((3, 2))
        states[0] = -0.5
        memory = [1, 0]
        commands, returned = controller(states, goals, memory)
        assert returned is memory
        assert memory == [1, 1]
        assert commands[0, 0] > 0
        assert commands[0, 1] == 0

    def test_another_number_of_robots_starts_afresh(self):
        controller = second.create_pose_controller_hybrid()
        controller(self.goal, self.goal)
        two = np.zeros((3, 2))
        assert np.all(controller(two - [[0.025], [0.0], [0.0]], two)[0] > 0)

    def test_a_memory_of_the_wrong_length_is_refused(self):
        with pytest.raises(ShapeError, match=r"\(1,\), expected \(2,\)"):
            second.create_pose_controller_hybrid()(np.zeros((3, 2)), np.zeros((3, 2)), [1])

    def test_generation_1_keeps_no_memory(self):
        controller = first.create_hybrid_unicycle_pose_controller()
        controller(self.goal, self.goal)
        assert controller(self.at(0.03), self.goal)[0, 0] > 0

    def test_generation_1_refuses_a_negative_epsilon_once_it_matters(self):
        controller = first.create_hybrid_unicycle_pose_controller(position_epsilon=-0.02)
        states = np.array([[-0.06, -0.5], [0.0, 0.0], [0.0, 0.0]])
        with pytest.raises(first.HysteresisError, match=r"robot 0 is 0\.06 m from its goal"):
            controller(states, np.zeros((3, 2)))


@pytest.mark.parametrize("generation", [first, second])
@pytest.mark.parametrize(
    "gain", ["fast", None, 0, -1, float("nan"), np.float32(1), np.int64(1), [1.0]]
)
def test_gains_outside_their_range_are_refused(generation, gain):
    with pytest.raises(NumberError, match=r"x_velocity_gain is .* expected a number > 0"):
        generation.create_si_position_controller(x_velocity_gain=gain)


@pytest.mark.parametrize("generation", [first, second])
@pytest.mark.parametrize(
    ("states", "error", "built_in"),
    [
        ([[0.0], [0.0]], NotAnArrayError, {first: AssertionError, second: AttributeError}),
        (None, NotAnArrayError, {first: AssertionError, second: AttributeError}),
        (np.zeros((2, 3)), ShapeError, {first: AssertionError, second: AssertionError}),
        (np.zeros(2), ShapeError, {first: AssertionError, second: IndexError}),
    ],
)
def test_wrong_states_are_caught_as_scripts_catch_them(generation, states, error, built_in):
    controller = generation.create_si_position_controller()
    with pytest.raises(error) as caught:
        controller(states, np.zeros((2, 1)))
    assert isinstance(caught.value, built_in[generation])


def test_controllers_change_none_of_their_arguments():
    poses, goals = starts()
    kept = poses.copy(), goals.copy()
    first.create_clf_unicycle_pose_controller()(poses, goals)
    first.create_hybrid_unicycle_pose_controller()(poses, goals)
    second.create_pose_parking_controller_hybrid()(poses, goals)
    second.create_pose_parking_controller_clf()(poses, goals)
    np.testing.assert_array_equal(poses, kept[0])
    np.testing.assert_array_equal(goals, kept[1])
