"""Logs as people have them: nominal times, stalls, teleports, commands that teach little."""

import dataclasses

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.simulated_testbed import (
    Truth,
    drive,
    nominal,
    random_commands,
    random_truth,
    real_steps,
    simulated_testbed,
)
from posflock_robotarium.calibration import FittedParameter, calibrate, resimulate, retimed
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.logs.run import Run
from rps_compat.profiles import load_profile

ROWS = 700
#: A run without a stall beyond the watchdog's patience.
SEED = 13


@pytest.fixture(scope="module")
def real():
    """Return a log of steps as they were and what is true of its robots."""
    return simulated_testbed(SEED, robots=3, rows=ROWS)


def save(log, path):
    np.savez(path, t=log.t, poses=log.poses, commands=log.commands)
    return path


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def left_out(found):
    return {(entry.kind, entry.robot) for entry in found.left_out}


def holds(estimate, true):
    return estimate.low <= true <= estimate.high


# --- Times -----------------------------------------------------------------------------------


def test_real_step_times_are_taken_as_they_are(real, tmp_path):
    log, truth = real
    assert np.diff(log.t).max() > 9 * np.median(np.diff(log.t))
    done = run("calibrate", save(log, tmp_path / "run.npz"), "-o", tmp_path / "lab.toml")
    assert done.exit_code == 0, done.output
    assert "longest 3" in done.output
    assert "as recorded" in done.output
    profile = load_profile(tmp_path / "lab.toml")
    assert profile.dead_time.seconds.values[0] == pytest.approx(truth.dead_time, abs=0.01)
    assert profile.lag.seconds.values[0] == pytest.approx(truth.lag, rel=0.1)
    assert profile.gains.speed.values == pytest.approx(truth.speed_gain, rel=0.01)
    assert "as recorded" in profile.about


def test_dead_time_and_lag_are_seconds_not_samples():
    rng = np.random.default_rng(4)
    truth, commands = random_truth(rng, 2), random_commands(rng, 500, 2)
    t = np.cumsum(rng.choice([0.012, 0.033, 0.09], 500))
    found = calibrate(Run("uneven", t, drive(t, commands, truth, rng), commands))
    assert found.dead_time.value == pytest.approx(truth.dead_time, abs=0.003)
    assert found.lag.value == pytest.approx(truth.lag, rel=0.03)
    assert [e.value for e in found.speed_gain] == pytest.approx(truth.speed_gain, rel=0.005)


def test_nominal_times_are_told_with_the_bias_that_they_cause(real, tmp_path):
    log, _ = real
    done = run("calibrate", save(nominal(log), tmp_path / "run.npz"), "-o", tmp_path / "lab.toml")
    assert done.exit_code == 0
    for text in (done.stderr, load_profile(tmp_path / "lab.toml").about):
        assert "a nominal time, not a measured one" in text
        assert "5 to 8 % faster" in text
        assert "stalls that the times hide" in text


def test_stalls_that_nominal_times_hide_are_found_and_do_not_bias(real):
    """Each of them is as good as ten steps in one row: left in, they would add 4 % to a gain."""
    log, truth = real
    found = calibrate(nominal(log))
    stalls = np.flatnonzero(np.diff(log.t) > 0.1)
    assert f"stalls that the times hide ({len(stalls)}, at" in " ".join(found.warnings)
    for name in ("speed_gain", "turn_gain"):
        values = [estimate.value for estimate in getattr(found, name)]
        assert values == pytest.approx(getattr(truth, name), rel=0.015)


def test_what_is_known_of_the_steps_can_be_given(real, tmp_path):
    log, truth = real
    known = nominal(log)
    slow = retimed(known, 0.035)
    assert calibrate(known, 0.035).times == "steps of 35 ms, as given"
    assert calibrate(known, 0.035).speed_gain == calibrate(slow, 0.035).speed_gain
    path = save(known, tmp_path / "run.npz")
    np.savetxt(tmp_path / "steps.txt", np.diff(log.t))
    done = run("calibrate", path, "--step-times", tmp_path / "steps.txt", "-o", tmp_path / "a.toml")
    assert done.exit_code == 0, done.output
    assert "as given" in done.output
    assert load_profile(tmp_path / "a.toml").gains.speed.values == pytest.approx(
        truth.speed_gain, rel=0.01
    )
    np.save(tmp_path / "steps.npy", log.t)
    options = ("--step-times", tmp_path / "steps.npy", "-o", tmp_path / "b.toml")
    assert run("calibrate", path, *options).exit_code == 0
    for wrong in (np.diff(log.t)[:5], -np.diff(log.t)):
        np.savetxt(tmp_path / "steps.txt", wrong)
        options = ("--step-times", tmp_path / "steps.txt", "-o", tmp_path / "c.toml")
        assert isinstance(run("calibrate", path, *options).exception, LogError | ParameterError)
    both = ("--dt", 0.033, "--step-times", tmp_path / "steps.npy", "-o", tmp_path / "c.toml")
    assert isinstance(run("calibrate", path, *both).exception, ParameterError)
    assert not (tmp_path / "c.toml").exists()


def test_useless_times_are_answered_with_the_option(real):
    log, _ = real
    with pytest.raises(LogError, match=r"4e-06 s apart.*--dt"):
        calibrate(retimed(log, 4e-6))
    with pytest.raises(LogError, match=r"faster than their wheels turn.*--dt"):
        calibrate(dataclasses.replace(log, poses=log.poses * np.array([100, 100, 1])[:, None]))


def test_rows_missing_from_an_even_clock_are_no_stall(real):
    log, truth = real
    kept = np.r_[0:200, 230:ROWS]
    gap = Run("gap", log.t[kept], log.poses[kept], log.commands[kept])
    found = calibrate(Run("gap", 0.033 * kept, gap.poses, gap.commands))
    assert any("stalls or gaps (1, at 6.6" in warning for warning in found.warnings)
    assert found.dead_time.value == pytest.approx(truth.dead_time, abs=0.02)


def test_a_log_that_begins_in_motion_is_told_from_one_that_begins_at_rest(real):
    log, truth = real
    cut = Run("cut", log.t[100:], log.poses[100:], log.commands[100:])
    assert holds(calibrate(cut).dead_time, truth.dead_time)


def test_a_log_of_real_steps_is_driven_again_at_its_own_times(real):
    log, _ = real
    again = resimulate(log, calibrate(log).profile())
    np.testing.assert_array_equal(again.t, log.t)
    apart = np.linalg.norm(again.poses[:150, :2] - log.poses[:150, :2], axis=1)
    assert apart.max() < 0.03


# --- Teleports -------------------------------------------------------------------------------


def lost_as(value):
    def damage(poses):
        poses[200:260, :, 1] = value

    return damage


def frozen(poses):
    poses[200:260, :, 1] = poses[199, :, 1]


def swapped(poses):
    poses[200:260, :, [0, 1]] = poses[200:260, :, [1, 0]]


def swapped_for_good(poses):
    poses[400:, :, [0, 1]] = poses[400:, :, [1, 0]]


def elsewhere(poses):
    poses[200:260, :2, 1] += 0.5


@pytest.mark.parametrize(
    ("damage", "rows"),
    [
        (lost_as(0.0), 60),
        (lost_as(-9999.0), 60),
        (frozen, 61),
        (swapped, 120),
        (swapped_for_good, 600),
        (elsewhere, 60),
    ],
)
def test_poses_that_are_no_robots_are_left_out_and_counted(damage, rows):
    log, truth = simulated_testbed(12, robots=3, rows=ROWS)
    log.poses[:, 0] += 0.7 * np.arange(3)
    damage(log.poses)
    found = calibrate(log)
    assert f"not of the robot they are written for ({rows})" in " ".join(found.warnings)
    assert "jumps faster than wheels turn" in " ".join(found.warnings)
    assert holds(found.dead_time, truth.dead_time)
    for estimate, true in zip(found.speed_gain, truth.speed_gain, strict=True):
        assert estimate.value == pytest.approx(true, rel=0.01)


def test_one_teleport_of_a_robot_that_was_carried_costs_one_row():
    log, truth = simulated_testbed(12, robots=3, rows=ROWS)
    log.poses[300:, 0, 0] += 3.0
    found = calibrate(log)
    assert found.warnings[-1].startswith("jumps faster than wheels turn (1; robot 0: 1)")
    assert holds(found.speed_gain[0], truth.speed_gain[0])


# --- What a log does not determine -----------------------------------------------------------


def taught(speed, turn, rows=ROWS, start=0, seed=5):
    """Drive two robots by these commands, (rows, 2) each or None for random ones."""
    rng = np.random.default_rng(seed)
    gains, bias = np.array([0.95, 1.05]), np.array([0.01, -0.01])
    truth = Truth(0.2, 0.15, gains, gains[::-1], bias, np.zeros(2))
    commands = random_commands(rng, rows, 2)
    for row, given in enumerate((speed, turn)):
        if given is not None:
            commands[:, row] = given
    t = np.concatenate([[0.0], np.cumsum(real_steps(rng, rows - 1))])
    poses = drive(t, commands, truth, rng)
    return Run("taught", t[start:], poses[start:], commands[start:]), truth


def test_a_robot_that_never_turned_has_everything_else():
    log, truth = taught(None, 0.0)
    found = calibrate(log)
    assert left_out(found) == {(FittedParameter.TURN_GAIN, 0), (FittedParameter.TURN_GAIN, 1)}
    assert found.turn_gain == (None, None)
    assert [e.value for e in found.speed_gain] == pytest.approx(truth.speed_gain, rel=0.01)
    assert [e.value for e in found.turn_bias] == pytest.approx(truth.turn_bias, abs=0.003)
    assert found.profile().gains.turn.values == (1.0,)
    assert "Not determined: the turn gain of robot 0: too little turning" in found.profile().about


def test_a_circle_does_not_tell_the_turn_gain_from_a_bias():
    """What is left out widens the interval of what it could hide in."""
    log, truth = taught(None, 0.5)
    found = calibrate(log)
    assert {(FittedParameter.TURN_BIAS, 0), (FittedParameter.TURN_BIAS, 1)} <= left_out(found)
    assert "cannot tell it from the turn gain of robot 0" in str(found.left_out[0])
    for estimate, true in zip(found.turn_gain, truth.turn_gain, strict=True):
        assert holds(estimate, true)
        assert 0.04 < estimate.high - estimate.value < 0.1
    assert found.profile().turn_bias is None


def test_constant_commands_in_a_log_that_begins_in_motion_give_gains_only():
    log, truth = taught(0.1, 0.4, start=120)
    found = calibrate(log)
    assert {(FittedParameter.DEAD_TIME, None), (FittedParameter.LAG, None)} < left_out(found)
    assert (found.dead_time, found.lag) == (None, None)
    for estimate, true in zip(found.speed_gain, truth.speed_gain, strict=True):
        assert holds(estimate, true)
    profile = found.profile()
    assert (profile.dead_time, profile.lag) == (None, None)


def test_a_robot_that_turned_on_the_spot_has_no_speed_gain_of_its_own():
    speed = random_commands(np.random.default_rng(1), ROWS, 2)[:, 0]
    speed[:, 1] = 0.0
    log, truth = taught(speed, None)
    found = calibrate(log)
    assert left_out(found) == {(FittedParameter.SPEED_GAIN, 1), (FittedParameter.HEADING_OFFSET, 1)}
    assert holds(found.speed_gain[0], truth.speed_gain[0])
    given = found.profile().gains.speed.values
    assert given == (found.speed_gain[0].value, found.speed_gain[0].value)


def test_nothing_determined_is_an_error_and_no_file(tmp_path):
    log, _ = taught(0.0, 0.0)
    done = run("calibrate", save(log, tmp_path / "run.npz"), "-o", tmp_path / "lab.toml")
    assert isinstance(done.exception, LogError)
    assert "determines nothing of how its robots follow" in str(done.exception)
    assert not (tmp_path / "lab.toml").exists()


def test_a_useless_interval_is_not_written_as_a_fit(tmp_path):
    """Two seconds of a slow ramp under noise: the lag could be anything."""
    rows = 90
    ramp = np.linspace(0.0, 0.004, rows)[:, None] * np.ones(2)
    log, _ = taught(ramp, 0.0, rows=rows)
    done = run("calibrate", save(log, tmp_path / "run.npz"), "-o", tmp_path / "lab.toml")
    text = (tmp_path / "lab.toml").read_text() if done.exit_code == 0 else ""
    assert "[lag]" not in text
    assert "the lag: " in (done.output or "") + str(done.exception)
