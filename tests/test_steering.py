"""Arena steering turns what the flock has in common, at the walls that it was given."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.steering import ArenaSteering, SteeringParameters

#: No edge is another's mirror image, so that a wall taken for another one shows.
ARENA = (-0.7, 1.3, -0.5, 0.9)
MARGIN, STEP = 0.1, 0.05
PARAMETERS = SteeringParameters(start=2.0, reach=0.2, turn_rate=0.4, clear=0.25)
TURN = PARAMETERS.turn_rate * STEP
#: Unit vectors towards each wall, and a point that the wall makes call.
WALLS = {
    "left": ((-1.0, 0.0), (-0.45, 0.2)),
    "right": ((1.0, 0.0), (1.05, 0.2)),
    "bottom": ((0.0, -1.0), (0.3, -0.25)),
    "top": ((0.0, 1.0), (0.3, 0.65)),
}
VELOCITIES = np.array([[0.10, 0.04, 0.07], [-0.02, 0.05, 0.03]])
INPUTS = np.array([[0.3, -0.1, 0.2], [0.1, 0.4, -0.2]])


def steering():
    return ArenaSteering(PARAMETERS, ARENA, MARGIN, STEP)


def points_at(wall, offset=0.0):
    """Return three look-ahead points in the middle and one near the wall, `offset` nearer."""
    (dx, dy), (x, y) = WALLS[wall]
    return np.array([[0.3, 0.4, x + offset * dx], [0.2, 0.1, y + offset * dy]])


def rotation(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def turning_at(points, common, time=5.0):
    """Return by how much a fresh steering turns robots that all go alike."""
    velocities = np.tile(np.array(common)[:, None], (1, points.shape[1]))
    return steering().steer(time, points, 0 * velocities, velocities)[2]


def test_the_common_velocity_turns_and_relative_velocities_do_not():
    kept = steering()
    velocities, inputs = VELOCITIES, INPUTS
    for k in range(1, 6):
        inputs, turned, turning = kept.steer(5.0, points_at("right"), INPUTS, velocities)
        assert abs(turning) == pytest.approx(TURN)
        common, before = turned.mean(axis=1), velocities.mean(axis=1)
        assert_allclose(common, rotation(turning) @ before, atol=1e-15)
        apart = velocities - before[:, None]
        assert_allclose(turned - common[:, None], apart, atol=1e-15)
        # Of the inputs, what is common is turned by all that the flock was turned since the start.
        expected = rotation(k * turning) @ INPUTS.mean(axis=1)
        assert_allclose(inputs.mean(axis=1), expected, atol=1e-15)
        own = INPUTS - INPUTS.mean(axis=1)[:, None]
        assert_allclose(inputs - expected[:, None], own, atol=1e-15)
        velocities = turned


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_each_wall_of_the_given_arena_turns_the_flock_the_short_way_round(wall, side):
    toward, _ = WALLS[wall]
    slanted = rotation(side * 0.5) @ np.array(toward)
    turning = turning_at(points_at(wall), 0.05 * slanted)
    # Turned to one side of the straight way to the wall, it goes on to that side.
    assert turning == pytest.approx(side * TURN)


@pytest.mark.parametrize("wall", WALLS)
def test_a_wall_calls_within_the_reach_of_its_margin_and_not_before(wall):
    toward, (x, y) = WALLS[wall]
    left, right, bottom, top = ARENA
    gap = {"left": x - left, "right": right - x, "bottom": y - bottom, "top": top - y}[wall]
    reach = PARAMETERS.reach + MARGIN
    assert turning_at(points_at(wall, gap - reach + 1e-6), toward) != 0.0
    assert turning_at(points_at(wall, gap - reach - 1e-6), toward) == 0.0


@pytest.mark.parametrize("wall", WALLS)
def test_a_flock_that_leaves_the_wall_is_left_alone(wall):
    inward = -np.array(WALLS[wall][0])
    limit = math.acos(PARAMETERS.clear)
    for side in (1.0, -1.0):
        assert turning_at(points_at(wall), rotation(side * (limit - 1e-6)) @ inward) == 0.0
        assert turning_at(points_at(wall), rotation(side * (limit + 1e-6)) @ inward) != 0.0


def test_straight_at_a_wall_it_turns_left_and_a_flock_that_stands_is_told_to_as_well():
    assert turning_at(points_at("top"), (0.0, 0.1)) == TURN
    assert turning_at(points_at("top"), (0.0, 0.0)) == TURN


def test_in_a_corner_both_walls_push():
    corner = np.array([[0.3, 0.4, 1.05], [0.2, 0.1, 0.65]])
    # Along the top wall, it is the right wall that it must leave: to the left, over the top one.
    assert turning_at(corner, (0.1, 0.0)) == -TURN
    assert turning_at(corner, (0.0, 0.1)) == TURN
    assert turning_at(corner, (-0.1, -0.1)) == 0.0
    # Of two walls that call, the nearer one calls louder.
    nearer_right = np.array([[0.3, 0.4, 1.15], [0.2, 0.1, 0.61]])
    assert turning_at(nearer_right, (-0.1, 0.1)) == 0.0


def test_the_way_of_turning_is_kept_until_the_flock_is_clear():
    kept, points = steering(), points_at("right")

    def turning(common, points=points):
        velocities = np.tile(np.array(common)[:, None], (1, 3))
        return kept.steer(5.0, points, 0 * velocities, velocities)[2]

    assert turning((0.1, 0.01)) == TURN
    assert turning((0.1, -0.01)) == TURN  # pushed back by a neighbour: no dithering
    assert turning((-0.1, 0.0)) == 0.0
    assert turning((0.1, -0.01)) == -TURN  # clear in between: the choice is free again
    assert turning((0.1, 0.01), points_at("right", -0.2)) == 0.0  # so is it out of reach
    assert turning((0.1, 0.01)) == TURN


def test_nothing_turns_before_its_time_and_a_reset_forgets_all():
    kept, points = steering(), points_at("right")
    for time in (0.0, PARAMETERS.start):
        inputs, velocities, turning = kept.steer(time, points, INPUTS, VELOCITIES)
        assert turning == 0.0
        assert np.array_equal(inputs, INPUTS)
        assert np.array_equal(velocities, VELOCITIES)
    first = kept.steer(PARAMETERS.start + 0.01, points, INPUTS, VELOCITIES)
    assert first[2] != 0.0
    kept.steer(5.0, points, INPUTS, VELOCITIES)
    kept.reset()
    again = kept.steer(5.0, points, INPUTS, VELOCITIES)
    for one, other in zip(first, again, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("name", ["start", "reach", "turn_rate"])
def test_parameters_are_finite_and_more_than_zero(name):
    for wrong in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(ParameterError, match=f"{name}: expected finite and more than zero"):
            SteeringParameters(**{name: wrong})


@pytest.mark.parametrize("clear", [-1.0, 1.0, 1.5, -1.5, math.nan])
def test_clear_is_a_cosine(clear):
    SteeringParameters(clear=math.copysign(0.99, clear))
    with pytest.raises(ParameterError, match="clear: expected a cosine between -1 and 1"):
        SteeringParameters(clear=clear)


def test_the_papers_experiment_is_steered_so():
    assert SteeringParameters() == SteeringParameters(3.0, 0.18, 0.45, 0.2)
