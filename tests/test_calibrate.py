"""Known imperfections are found again, with intervals that hold them."""

import dataclasses

import numpy as np
import pytest

from benchmarks.calibration import simulated_testbed
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
    assert found.dead_time.value == pytest.approx(truth["dead time"][0], abs=0.033)
    assert found.lag.value == pytest.approx(truth["lag"][0], rel=0.20)
    for name, estimates in (("speed gain", found.speed_gain), ("turn gain", found.turn_gain)):
        assert [e.value for e in estimates] == pytest.approx(list(truth[name]), rel=0.02)
    assert [e.value for e in found.turn_bias] == pytest.approx(list(truth["turn bias"]), abs=0.005)
    assert [e.value for e in found.heading_offset] == pytest.approx(
        list(truth["heading offset"]), abs=0.01
    )
    assert found.jitter.along.value == pytest.approx(0.0005, rel=0.1)
    assert found.jitter.lateral.value == pytest.approx(0.0003, rel=0.1)
    assert found.jitter.heading.value == pytest.approx(0.0013, rel=0.1)
    assert found.disturbance.speed.value == pytest.approx(0.0017, rel=0.4)
    assert found.disturbance.turn.value == pytest.approx(0.0175, rel=0.25)


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
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (80, 2, 3))
    run = Imperfections(Profile(dead_time=DeadTime(constant(0.21)), lag=Lag(constant(0.13))))
    run.reset(np.zeros((3, 3)), 0.033, np.random.default_rng(0))
    driven = np.array([run.actuate(u, np.zeros((3, 3)), 0.0) for u in commands])
    np.testing.assert_allclose(driven, delayed(commands, 0.21, 0.13, 0.033), atol=1e-12)


def plain_log(rows=100, t=None, speed=True, turn=True, smooth=False):
    rng = np.random.default_rng(0)
    commands = np.zeros((rows, 2, 2))
    commands[:, 0] = rng.uniform(0.0, 0.1, (rows, 2)) if speed else 0.1
    commands[:, 1] = rng.uniform(-0.5, 0.5, (rows, 2)) if turn else 0.0
    if smooth:
        waves = np.sin(np.arange(rows)[:, None] * 0.033 * np.array([0.7, 1.1]))
        commands[:, 0], commands[:, 1] = 0.05 + 0.03 * waves, 0.5 * waves[:, ::-1]
    arena = Arena(np.zeros((3, 2)))
    poses = np.empty((rows, 3, 2))
    for k in range(rows):
        poses[k] = arena.observe()
        arena.commands = commands[k].copy()
        arena.step()
    return Run("log", np.arange(rows) * 0.033 if t is None else t, poses, commands)


@pytest.mark.parametrize("smooth", [False, True])
def test_ideal_robots_have_no_imperfections(smooth):
    """Smooth commands leave residuals so regular that no jitter at all is likeliest."""
    found = calibrate(plain_log(400, smooth=smooth))
    assert found.dead_time.value + found.lag.value < 0.003
    assert [e.value for e in found.speed_gain] == pytest.approx([1.0, 1.0], abs=1e-3)
    for estimate in (*vars(found.jitter).values(), *vars(found.disturbance).values()):
        assert 0 <= estimate.low <= estimate.value <= estimate.high < 0.01
    if smooth:
        assert found.jitter.heading.value == found.jitter.heading.low == 0.0
    assert profile_from_toml(profile_to_toml(found.profile())) == found.profile()


def test_robots_that_did_not_obey_are_refused():
    log = plain_log(400)
    log.poses[:] = log.poses[0]
    with pytest.raises(LogError, match="does not determine the dead time, the lag"):
        calibrate(log)


@pytest.mark.parametrize(
    ("log", "reason"),
    [
        (plain_log(30), "needs 60"),
        (plain_log(100, t=np.arange(100.0) ** 2), "every time step"),
        (plain_log(100, speed=False), "forward speed"),
        (plain_log(100, turn=False), "turn rate"),
    ],
)
def test_logs_that_say_nothing_are_refused(log, reason):
    with pytest.raises(LogError, match=reason):
        calibrate(log)


def test_values_that_are_not_finite_are_refused():
    log = plain_log()
    poses = log.poses.copy()
    poses[5, 0, 1] = np.nan
    with pytest.raises(LogError, match="row 5: x of robot 1 is nan, not a finite number"):
        dataclasses.replace(log, poses=poses)
    with pytest.raises(LogError, match="no commands in it"):
        calibrate(dataclasses.replace(log, commands=None))


@pytest.mark.slow
def test_intervals_cover_the_truth_in_fifty_fits():
    from benchmarks import calibration

    assert calibration.main([]) == 0
