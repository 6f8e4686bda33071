"""Steps that last as long as on the testbed: delays are seconds, and the watchdog brakes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rps_compat.arena import Arena
from rps_compat.distributions import Curve, ProfileError, constant
from rps_compat.profiles import load_profile
from rps_compat.realism import Clock, CommandLoss, DeadTime, Disturbance, Lag, Profile, Watchdog
from rps_compat.testbed import TIME_STEP

SPEED, TURN = 0.1, 0.5


def always(seconds):
    """Return the clock whose every step lasts so long."""
    return Clock(Curve(((0.0, seconds), (1.0, seconds))))


def drive(profile, steps, command=(SPEED, TURN), seed=0):
    """Return the arena after some steps of one command, given anew in each."""
    arena = Arena(np.zeros((3, 1)), realism=profile.start(), rng=np.random.default_rng(seed))
    for _ in range(steps):
        arena.commands = np.array(command, dtype=float)[:, None]
        arena.step()
    return arena


def test_robots_drive_for_the_time_that_passes_while_the_script_counts_steps():
    arena = drive(Profile(clock=always(0.05)), 20)
    assert arena.time == pytest.approx(20 * TIME_STEP)
    assert arena.poses[2, 0] == pytest.approx(TURN * 20 * 0.05)
    np.testing.assert_allclose(arena.velocities[:, 0], np.array([SPEED, TURN]) * 0.05 / TIME_STEP)
    np.testing.assert_allclose(arena.wheel_velocities, arena.wheels(arena.velocities))


def test_a_robot_that_turns_through_a_long_step_drives_an_arc():
    x, y, heading = drive(Profile(clock=always(0.4)), 1, (0.1, 1.5)).poses[:, 0]
    assert heading == pytest.approx(0.6)
    np.testing.assert_allclose([x, y], np.array([np.sin(0.6), 1 - np.cos(0.6)]) / 15, atol=2e-3)


def test_a_step_of_nominal_length_is_a_step_as_ever():
    rest = load_profile("gritsbot_x")
    with_clock = drive(Profile(**_effects(rest), clock=always(TIME_STEP)), 60)
    np.testing.assert_array_equal(with_clock.poses, drive(rest, 60).poses)


def _effects(profile):
    return {name: getattr(profile, name) for name in profile.effects}


def test_robots_brake_in_a_stall():
    """Half a second after the last command, to within a part of the step."""
    arena = drive(Profile(clock=always(2.0), watchdog=Watchdog(0.5)), 1, (SPEED, 0.0))
    assert arena.poses[0, 0] == pytest.approx(SPEED * 0.5, abs=SPEED * TIME_STEP)


def test_a_lost_command_is_as_old_as_time_says():
    lossy = Profile(clock=always(0.2), command_loss=CommandLoss(1.0), watchdog=Watchdog(0.5))
    assert drive(lossy, 10).poses[0, 0] == 0.0


@given(st.floats(0.0, 0.4), st.lists(st.floats(0.02, 0.06), min_size=40, max_size=40))
def test_dead_time_is_seconds_however_long_steps_are(delay, lengths):
    stage = DeadTime(constant(delay)).begin(1, TIME_STEP, np.random.default_rng(0))
    command = np.array([[SPEED], [TURN]])
    way = sum(s * stage(command, np.zeros(1), s)[0, 0] for s in lengths)
    assert way == pytest.approx(SPEED * (sum(lengths) - delay), abs=1e-12)


@given(st.lists(st.floats(0.005, 0.06), min_size=1, max_size=30))
def test_lag_is_seconds_however_long_steps_are(lengths):
    """In any parts, a lag of first order leaves the same speed at the same time."""
    stage = Lag(constant(0.2)).begin(1, TIME_STEP, np.random.default_rng(0))
    way = sum(s * stage(np.array([[SPEED], [0.0]]), np.zeros(1), s)[0, 0] for s in lengths)
    total = sum(lengths)
    assert way == pytest.approx(SPEED * (total - 0.2 * (1 - np.exp(-total / 0.2))), rel=1e-9)


def test_noise_spreads_as_far_in_many_short_parts_as_in_few():
    def spread(seconds):
        stage = Disturbance(speed=0.01).begin(4000, TIME_STEP, np.random.default_rng(1))
        command, age = np.full((2, 4000), 0.1), np.zeros(4000)
        parts = round(10 * TIME_STEP / seconds)
        return np.std(sum(seconds * stage(command, age, seconds)[0] for _ in range(parts)))

    assert spread(TIME_STEP / 2) == pytest.approx(spread(TIME_STEP), rel=0.1)


def test_steps_are_drawn_as_their_quantiles_say():
    clock = Clock(Curve(((0.0, 0.02), (0.5, 0.033), (0.9, 0.035), (1.0, 0.5))))
    times = clock.begin(3, TIME_STEP, np.random.default_rng(0))
    drawn = np.array([sum(times()) for _ in range(4000)])
    assert np.mean(drawn <= 0.033) == pytest.approx(0.5, abs=0.025)
    assert np.mean(drawn <= 0.035) == pytest.approx(0.9, abs=0.02)
    assert clock.mean == pytest.approx(drawn.mean(), rel=0.05)
    assert all(max(times()) <= TIME_STEP + 1e-12 for _ in range(200))


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ((), "shares from 0 to 1"),
        (((0.0, 0.03), (0.9, 0.04)), "shares from 0 to 1"),
        (((0.0, 0.04), (1.0, 0.03)), "do not decrease"),
    ],
)
def test_quantiles_that_are_none_are_refused(points, said):
    with pytest.raises(ProfileError, match=said):
        Clock(Curve(points))
