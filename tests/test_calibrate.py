"""Known imperfections are found again, with intervals that hold them."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.simulated_testbed import DISTURBANCE, JITTER, simulated_testbed
from posflock_robotarium.calibration import Estimate, calibrate, delayed, resimulate
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.convert import write_pose_log
from posflock_robotarium.logs.readers import read_pose_log
from posflock_robotarium.logs.run import Run
from rps_compat.arena import Arena
from rps_compat.distributions import constant
from rps_compat.profiles import profile_from_toml, profile_to_toml
from rps_compat.realism import DeadTime, Imperfections, Lag, Profile


@pytest.fixture(scope="module")
def fitted():
    """Return a log of 25 s, what is true of its robots, and the fit."""
    log, truth = simulated_testbed(3, robots=3, rows=750)
    return log, truth, calibrate(log)


def test_a_fit_finds_the_truth(fitted):
    _, truth, found = fitted
    assert found.dead_time.value == pytest.approx(truth.dead_time, abs=0.033)
    assert found.lag.value == pytest.approx(truth.lag, rel=0.20)
    for name in ("speed_gain", "turn_gain"):
        values = [e.value for e in getattr(found, name)]
        assert values == pytest.approx(list(getattr(truth, name)), rel=0.02)
    assert [e.value for e in found.turn_bias] == pytest.approx(list(truth.turn_bias), abs=0.005)
    assert [e.value for e in found.heading_offset] == pytest.approx(
        list(truth.heading_offset), abs=0.01
    )
    for estimate, true in zip(
        (found.jitter.along, found.jitter.lateral, found.jitter.heading), JITTER, strict=True
    ):
        assert estimate.value == pytest.approx(true, rel=0.1)
    assert found.disturbance.speed.value == pytest.approx(DISTURBANCE[0], rel=0.4)
    assert found.disturbance.turn.value == pytest.approx(DISTURBANCE[1], rel=0.25)
    assert found.left_out == found.warnings == ()


def test_intervals_hold_their_value(fitted):
    found = fitted[2]
    for estimate in (found.dead_time, found.lag, *found.speed_gain, *found.turn_bias):
        assert isinstance(estimate, Estimate)
        assert estimate.low < estimate.value < estimate.high


def test_what_was_fitted_is_a_profile(fitted):
    found = fitted[2]
    profile = found.profile("lab")
    assert profile_from_toml(profile_to_toml(profile)) == profile
    assert profile.dead_time.seconds.values == (found.dead_time.value,)
    pooled = found.profile(pooled=True)
    assert len(pooled.gains.speed.draw(20, np.random.default_rng(0))) == 20


def test_simulating_with_it_repeats_the_run(fitted, tmp_path):
    log, _, found = fitted
    again = resimulate(log, found.profile())
    ideal = resimulate(log, Profile())

    def apart(other):
        return float(np.abs(other.poses[:150, :2] - log.poses[:150, :2]).max())

    assert apart(again) < apart(ideal) / 3
    path = write_pose_log(again, tmp_path / "again")
    read = read_pose_log(path)
    np.testing.assert_array_equal(read.poses, again.poses)
    assert read.parameters["resimulated_with"] == "calibrated"


def test_what_a_certificate_said_of_other_poses_is_unknown_of_simulated_ones():
    log = plain_log(80)
    said = dataclasses.replace(
        log,
        status=np.full(80, "optimal"),
        intervention=np.full(80, 0.01),
        clearance=np.full(80, 0.2),
        parameters={"law": {"radius": 0.75}, "ended": {"how": "failed"}, "simulated": False},
    )
    again = resimulate(said, Profile(), seed=5)
    np.testing.assert_allclose(again.poses, log.poses, atol=1e-12)  # ideal robots drove it, too
    np.testing.assert_array_equal(again.commands, log.commands)
    assert (again.status, again.intervention, again.clearance) == (None, None, None)
    assert (again.ending, again.simulated) == (None, True)
    kept = {name: again.parameters[name] for name in ("law", "seed", "time_step")}
    assert kept == {"law": {"radius": 0.75}, "seed": 5, "time_step": pytest.approx(0.033)}


def test_the_model_is_the_one_that_is_simulated():
    """Steps of any length, against the simulator's at a time step that divides all of them."""
    rng = np.random.default_rng(0)
    fine, lengths = 0.01, rng.integers(1, 40, 60)
    commands = rng.uniform(-0.2, 0.2, (60, 2, 3))
    run = Imperfections(Profile(dead_time=DeadTime(constant(0.21)), lag=Lag(constant(0.13))))
    run.reset(np.zeros((3, 3)), fine, rng)
    driven = [run.actuate(u, np.zeros((3, 3)), 0.0) for u in np.repeat(commands, lengths, axis=0)]
    ends = np.concatenate([[0], np.cumsum(lengths)])
    expected = [np.mean(driven[a:b], axis=0) for a, b in pairwise(ends)]
    np.testing.assert_allclose(expected, delayed(commands, 0.21, 0.13, fine * lengths), atol=1e-12)


def test_what_moved_before_the_log_goes_on_in_it():
    steady = np.full((30, 2, 1), 0.1)
    np.testing.assert_allclose(delayed(steady, 0.2, 0.1, 0.033, before=steady[0]), 0.1)
    assert delayed(steady, 0.2, 0.1, 0.033)[5, 0, 0] == 0.0


@given(
    steps=st.lists(st.floats(0.004, 2.0), min_size=2, max_size=12),
    share=st.floats(0.05, 0.95),
    dead_time=st.floats(0.0, 0.6),
    lag=st.floats(1e-4, 0.6),
    seed=st.integers(0, 99),
)
def test_a_step_cut_in_two_drives_the_same_way(steps, share, dead_time, lag, seed):
    """And no way is lost: the state is off its input by what has not been driven yet."""
    lengths = np.array(steps)
    commands = np.random.default_rng(seed).uniform(-1, 1, (len(steps), 1))
    ways = lengths * delayed(commands, dead_time, lag, lengths)[:, 0]
    cut = np.stack([share * lengths, (1 - share) * lengths], axis=1).ravel()
    halves = cut * delayed(np.repeat(commands, 2, axis=0), dead_time, lag, cut)[:, 0]
    np.testing.assert_allclose(halves.reshape(-1, 2).sum(axis=1), ways, atol=1e-10)
    stopped = np.append(commands, 0.0)[:, None]
    long_after = np.append(lengths, dead_time + 40 * lag)
    driven = (long_after * delayed(stopped, dead_time, lag, long_after)[:, 0]).sum()
    assert driven == pytest.approx(float(lengths @ commands[:, 0]), abs=1e-9)


def plain_log(rows=100, smooth=False):
    rng = np.random.default_rng(0)
    commands = np.zeros((rows, 2, 2))
    commands[:, 0] = rng.uniform(0.0, 0.1, (rows, 2))
    commands[:, 1] = rng.uniform(-0.5, 0.5, (rows, 2))
    if smooth:
        waves = np.sin(np.arange(rows)[:, None] * 0.033 * np.array([0.7, 1.1]))
        commands[:, 0], commands[:, 1] = 0.05 + 0.03 * waves, 0.5 * waves[:, ::-1]
    arena = Arena(np.zeros((3, 2)))
    poses = np.empty((rows, 3, 2))
    for k in range(rows):
        poses[k] = arena.observe()
        arena.commands = commands[k].copy()
        arena.step()
    return Run("log", np.arange(rows) * 0.033, poses, commands)


@pytest.mark.parametrize("smooth", [False, True])
def test_ideal_robots_have_no_imperfections(smooth):
    """Smooth commands leave residuals so regular that no jitter at all is likeliest."""
    found = calibrate(plain_log(400, smooth=smooth))
    assert found.dead_time.value + (found.lag.value if found.lag else 0.0) < 0.003
    assert [e.value for e in found.speed_gain] == pytest.approx([1.0, 1.0], abs=1e-3)
    for estimate in (*vars(found.jitter).values(), *vars(found.disturbance).values()):
        assert 0 <= estimate.low <= estimate.value <= estimate.high < 0.01
    if smooth:  # robots that are late by a moment, and slow by one, look the same
        assert [str(entry) for entry in found.left_out] == [
            "the lag: the log cannot tell it from the dead time (99 % alike)"
        ]
        assert found.jitter.heading.value == found.jitter.heading.low == 0.0
    assert profile_from_toml(profile_to_toml(found.profile())) == found.profile()


def test_robots_that_did_not_obey_are_refused():
    log = plain_log(400)
    log.poses[:] = log.poses[0]
    with pytest.raises(LogError, match=r"nothing of how its robots follow.*did not follow"):
        calibrate(log)


def test_a_log_of_two_seconds_is_refused():
    with pytest.raises(LogError, match="needs 60"):
        calibrate(plain_log(30))


def test_robots_that_nobody_saw_are_refused():
    log = plain_log()
    poses = log.poses.copy()
    poses[::2, 0, 1] = poses[1::2, 0, 0] = np.nan
    with pytest.raises(LogError, match="nothing of how its robots follow"):
        calibrate(dataclasses.replace(log, poses=poses))
    with pytest.raises(LogError, match="no commands in it"):
        calibrate(dataclasses.replace(log, commands=None))


@pytest.mark.slow
def test_intervals_cover_the_truth_in_fifty_fits():
    from benchmarks import calibration

    assert calibration.main([]) == 0
