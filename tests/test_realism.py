"""Imperfections do what their numbers say, alone and together, and stay reproducible."""

import importlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rps_compat.arena import Arena
from rps_compat.distributions import (
    Curve,
    DistributionKind,
    ProfileError,
    RobotDistribution,
    constant,
)
from rps_compat.profiles import (
    NAMES,
    load_profile,
    profile_from_toml,
    profile_text,
    profile_to_toml,
)
from rps_compat.realism import (
    EFFECTS,
    CommandLoss,
    DeadBand,
    DeadTime,
    Disturbance,
    Gains,
    HeadingOffset,
    Imperfections,
    Lag,
    Profile,
    TrackingDropout,
    TrackingJitter,
    TurnBias,
    Watchdog,
    WheelSlew,
)
from rps_compat.session import Session

STEP = 0.033


def drive(profile, commands, robots=1, seed=0, commanded=None):
    """Return the velocities (K, 2, N) really driven for commands (K, 2) alike for all robots."""
    run = Imperfections(profile)
    run.reset(np.zeros((3, robots)), STEP, np.random.default_rng(seed))
    out = []
    for k, command in enumerate(commands):
        run.commanded = True if commanded is None else commanded[k]
        wide = np.repeat(np.array(command, dtype=float)[:, None], robots, axis=1)
        out.append(run.actuate(wide, np.zeros((3, robots)), k * STEP))
    return np.array(out)


def see(profile, poses, times=1, seed=0, speed=0.0):
    """Return `times` measurements of fixed poses (3, N)."""
    run = Imperfections(profile)
    run.reset(poses, STEP, np.random.default_rng(seed))
    robots = poses.shape[1]
    run.actuate(np.stack([np.full(robots, speed), np.zeros(robots)]), poses, 0.0)
    return np.array([run.observe(poses) for _ in range(times)])


def test_ideal_is_no_realism_at_all():
    assert load_profile("ideal").effects == ()
    assert load_profile("ideal").start() is None


@given(st.floats(0.0, 0.4))
def test_dead_time_delays_by_any_number_of_seconds(seconds):
    driven = drive(Profile(dead_time=DeadTime(constant(seconds))), [(0.1, 0.0)] * 40)[:, 0, 0]
    # The distance lost is speed times delay, whatever the frames.
    assert (0.1 * 40 - driven.sum()) * STEP == pytest.approx(0.1 * seconds, abs=1e-12)


def test_lag_reaches_63_percent_after_its_time_constant():
    driven = drive(Profile(lag=Lag(constant(0.33))), [(0.1, 0.5)] * 40)[:, :, 0]
    travelled = driven[:, 0].cumsum() * STEP
    t = 0.033 * np.arange(1, 41)
    exact = 0.1 * (t - 0.33 * (1 - np.exp(-t / 0.33)))
    np.testing.assert_allclose(travelled, exact, atol=1e-12)
    np.testing.assert_allclose(driven[:, 1], 5 * driven[:, 0], atol=1e-12)


def test_gains_scale_and_depend_on_speed():
    profile = Profile(
        gains=Gains(
            RobotDistribution(DistributionKind.ROBOTS, (0.9, 1.1)),
            by_speed=Curve(((0.05, 0.5), (0.1, 1.0))),
        )
    )
    assert drive(profile, [(0.1, 0.2)], robots=2)[0, 0].tolist() == pytest.approx([0.09, 0.11])
    assert drive(profile, [(0.05, 0.2)], robots=2)[0, 0].tolist() == pytest.approx([0.0225, 0.0275])
    assert drive(profile, [(0.1, 0.2)], robots=2)[0, 1].tolist() == pytest.approx([0.2, 0.2])


def test_watchdog_brakes_after_half_a_second_without_a_command():
    driven = drive(
        Profile(watchdog=Watchdog(0.5)), [(0.1, 0.0)] * 30, commanded=[True] + [False] * 29
    )
    seconds = np.flatnonzero(driven[:, 0, 0] == 0.0)[0] * STEP
    assert 0.5 <= seconds < 0.5 + STEP + 1e-9


def test_lost_commands_leave_the_last_one_in_force_and_wake_the_watchdog():
    none_arrives = Profile(command_loss=CommandLoss(1.0))
    assert not drive(none_arrives, [(0.1, 0.0)] * 5).any()
    some = drive(Profile(command_loss=CommandLoss(0.5)), [(0.01 * k, 0.0) for k in range(400)], 4)
    late = np.array([0.01 * k for k in range(400)])[:, None] - some[:, 0]
    assert late.min() >= -1e-12
    assert 0.4 < (late > 1e-9).mean() < 0.6


def test_dead_band_switches_motors_off_below_both_thresholds():
    band = Profile(dead_band=DeadBand(1e-4, 0.01))
    assert not drive(band, [(5e-5, 0.005)]).any()
    assert drive(band, [(5e-5, 0.02)])[0, 1, 0] == 0.02


def test_wheel_slew_limits_the_change_of_a_wheel():
    driven = drive(Profile(wheel_slew=WheelSlew(10.0)), [(0.16, 0.0)] * 60)[:, 0, 0]
    np.testing.assert_allclose(np.diff(driven)[:20], 10.0 * STEP * 0.016, atol=1e-12)
    assert driven[-1] == pytest.approx(0.16)


def test_turn_bias_and_disturbance_need_running_motors():
    profile = Profile(turn_bias=TurnBias(constant(0.01)), disturbance=Disturbance(0.002, 0.02))
    assert not drive(profile, [(0.0, 0.0)] * 3).any()
    moving = drive(profile, [(0.1, 0.0)] * 4000)[:, :, 0]
    assert moving[:, 1].mean() == pytest.approx(0.01, abs=0.0015)
    assert moving.std(axis=0) == pytest.approx([0.002, 0.02], rel=0.05)


def test_heading_offset_is_constant_and_of_the_robot():
    seen = see(
        Profile(
            heading_offset=HeadingOffset(RobotDistribution(DistributionKind.UNIFORM, (-0.03, 0.02)))
        ),
        np.zeros((3, 8)),
        3,
    )
    assert (seen[0] == seen[2]).all()
    assert len(set(seen[0, 2])) == 8
    assert not seen[:, :2].any()


def test_jitter_has_the_directions_of_the_robot():
    poses = np.array([[0.0], [0.0], [np.pi / 2]])
    jitter = TrackingJitter(0.001, 0.0002, 0.003, Curve(((0.0, 1.0), (0.2, 2.0))))
    seen = see(Profile(tracking_jitter=jitter), poses, 4000, speed=0.2)[:, :, 0]
    assert seen.std(axis=0) == pytest.approx([0.0002, 0.002, 0.003], rel=0.06)


def test_dropout_repeats_the_last_pose_that_was_seen():
    run = Imperfections(Profile(tracking_dropout=TrackingDropout(0.2, 0.1)))
    run.reset(np.zeros((3, 1)), STEP, np.random.default_rng(0))
    seen = np.array([run.observe(np.full((3, 1), k * 0.001))[0, 0] for k in range(2000)])
    true = 0.001 * np.arange(2000)
    lost = seen < true - 1e-12
    assert not lost[0]
    assert 0.2 < lost.mean() < 0.7
    assert (seen[1:][lost[1:]] == seen[:-1][lost[1:]]).all()


def test_the_named_profiles_hold_the_published_numbers():
    gritsbot = load_profile("gritsbot_x")
    assert gritsbot.dead_time.seconds.values == (0.19, 0.20)
    assert 0.195 * gritsbot.dead_time.by_speed(np.array([0.05]))[0] == pytest.approx(0.24, abs=1e-3)
    assert 0.175 * gritsbot.lag.by_speed(np.array([0.2]))[0] == pytest.approx(0.12, abs=1e-3)
    assert gritsbot.gains.by_turn(np.array([0.1, 0.2, 0.3])).tolist() == [0.91, 0.99, 0.97]
    low, high = (g * gritsbot.gains.by_speed(np.array([0.05]))[0] for g in (0.98, 1.03))
    assert low >= 0.91
    assert high <= 0.97
    along = gritsbot.tracking_jitter.along
    at = gritsbot.tracking_jitter.by_speed(np.array([0.05, 0.1, 0.2]))
    assert 1000 * along * at == pytest.approx([0.40, 0.47, 0.82], abs=0.005)
    assert gritsbot.turn_bias.rate.limit == 0.017
    assert gritsbot.command_loss is None


@pytest.mark.parametrize("name", NAMES)
def test_profiles_survive_toml(name):
    profile = load_profile(name)
    assert profile_from_toml(profile_to_toml(profile)) == profile
    assert profile_from_toml(profile_text(name)) == profile


def test_every_effect_has_a_stream_of_its_own():
    profile = load_profile("harsh")
    both = profile.only("turn_bias", "disturbance")
    alone = profile.only("turn_bias")
    rng = lambda: np.random.default_rng(3)  # noqa: E731
    a, b = Imperfections(both), Imperfections(alone)
    for run in (a, b):
        run.reset(np.zeros((3, 5)), STEP, rng())
    command = np.stack([np.full(5, 0.1), np.zeros(5)])
    difference = np.array(
        [a.actuate(command, command, 0.0) - b.actuate(command, command, 0.0) for _ in range(3000)]
    )
    # Were the biases drawn anew, robots would differ by a constant of about 0.02 rad/s.
    assert np.abs(difference[:, 1].mean(axis=0)).max() < 0.004


def test_same_seed_same_bytes():
    profile = load_profile("harsh")
    commands = [(0.1, 0.2)] * 50
    first, again = drive(profile, commands, 3, seed=4), drive(profile, commands, 3, seed=4)
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != drive(profile, commands, 3, seed=5).tobytes()


def test_an_arena_takes_a_profile():
    def run():
        arena = Arena(
            np.zeros((3, 2)) + [[0.0, 0.5]] * 3,
            realism=load_profile("gritsbot_x").start(),
            rng=np.random.default_rng(1),
        )
        for _ in range(50):
            arena.observe()
            arena.commands = np.full((2, 2), 0.1)
            arena.step()
        return arena.poses.copy()

    assert run().tobytes() == run().tobytes()
    assert (run()[0] - [0.0, 0.5] < 0.1 * 50 * STEP - 0.03).all()


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[lagg]\nseconds = 0.1", "lagg"),
        ("[lag]\nsecond = 0.1", "second"),
        ("[lag]\n", "seconds is missing"),
        ("[lag]\nseconds = -0.1", "at least 0"),
        ('[lag]\nseconds = "0.1"', "expected a number"),
        ("[lag]\nseconds = { uniform = [0.2] }", "2 number"),
        ("[lag]\nseconds = { uniform = [0.2, 0.1] }", "low, high"),
        ("[lag]\nseconds = { gauss = [0.2, 0.1] }", "gauss"),
        ("[lag]\nseconds = { uniform = [0.1, 0.2], limit = 0.1 }", "limit"),
        ("[lag]\nseconds = 0.1\nby_speed = [[0.2, 1.0], [0.1, 1.0]]", "rising"),
        ("[command_loss]\nprobability = 1.5", "0 to 1"),
        ("[watchdog]\nseconds = nan", "number"),
        ("lag = 3", "table"),
        ("[lag", "TOML"),
    ],
)
def test_bad_profiles_are_refused_with_the_reason(text, named):
    with pytest.raises(ProfileError, match=named):
        profile_from_toml(text)


def test_names_that_do_not_exist_are_refused(tmp_path):
    for wrong in ("gritsbotx", tmp_path / "none.toml"):
        with pytest.raises(ProfileError):
            load_profile(wrong)
    with pytest.raises(ProfileError, match="dead_time"):
        load_profile("harsh").without("deadtime")


def test_values_of_other_robots_are_refused():
    profile = Profile(gains=Gains(RobotDistribution(DistributionKind.ROBOTS, (1.0, 1.0))))
    with pytest.raises(ProfileError, match="2 robots, but the run has 3"):
        drive(profile, [(0.1, 0.0)], robots=3)


def test_effects_are_told_in_their_order():
    assert load_profile("harsh").effects == tuple(
        name for name in EFFECTS if getattr(load_profile("harsh"), name) is not None
    )
    assert "dead_time" not in load_profile("harsh").without("dead_time").effects


def test_a_script_that_commands_once_is_braked_on_either_generation():
    for generation in (1, 2):
        module = importlib.import_module(f"rps_compat.v{generation}.robotarium")
        profile = Profile(watchdog=Watchdog(0.5))
        session = Session(initial="exact", seed=0, realism=lambda: Imperfections(profile))  # noqa: B023
        with session.active():
            r = module.Robotarium(
                number_of_robots=1,
                show_figure=False,
                sim_in_real_time=False,
                initial_conditions=np.zeros((3, 1)),
            )
        for k in range(60):
            x = r.get_poses()[0, 0]
            if k == 0:
                r.set_velocities([0], np.array([[0.1], [0.0]]))
            r.step()
        assert x == pytest.approx(0.05, abs=0.004)


def test_a_command_that_stays_the_same_is_a_command():
    arena = Arena(np.zeros((3, 1)), realism=Imperfections(Profile(watchdog=Watchdog(0.5))))
    same = np.array([[0.1], [0.0]])
    for _ in range(60):
        arena.commands = same
        arena.step()
    assert arena.poses[0, 0] == pytest.approx(0.1 * 60 * STEP)
