"""The flock on wheels keeps its promises in the arena, and refuses what means nothing."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from posflock_robotarium.alignment.metrics import heading_vectors, smallest_distance, wall_distance
from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.flocking.steering import SteeringParameters
from posflock_robotarium.logs.run import Run
from posflock_robotarium.simulation.flock_trial import simulate
from rps_compat.arena import Arena
from rps_compat.testbed import GTERNAL


def start_of(seed):
    return random_poses(9, np.random.default_rng(seed))


def clearance_of(poses, certificate=EXPERIMENT_CERTIFICATE):
    """Return what look-ahead points have beyond radius and margin, by plain geometry."""
    points = poses[:, :2] + certificate.projection_distance * heading_vectors(poses)
    pairs = smallest_distance(points) - certificate.safety_radius
    walls = wall_distance(points, certificate.boundary) - certificate.wall_margin
    return np.minimum(pairs, walls)


@pytest.mark.parametrize("seed", [0, 7, 13])
def test_the_acceptance_table_holds(seed):
    log = simulate(Flock(), start_of(seed), 120.0).log
    summary = summarise(log)
    assert summary.gamma_headings >= 0.95
    assert summary.gamma_motion >= 0.95
    assert_allclose(log.clearance, clearance_of(log.poses), atol=1e-12)
    assert summary.smallest_clearance >= 0.0
    assert summary.mean_speed >= 0.030
    assert summary.smallest_distance >= 0.20
    assert summary.smallest_wall_distance >= 0.12
    assert summary.fastest_wheel <= 12.5
    assert summary.collisions == summary.steps_outside == summary.steps_infeasible == 0


def test_without_steering_the_flock_parks_and_headings_do_not_show_it():
    summary = summarise(simulate(Flock(walls="certificate"), start_of(0), 120.0).log)
    assert summary.gamma_headings > 0.95
    assert summary.mean_speed < 0.02
    assert summary.collisions == summary.steps_outside == 0


def test_commands_keep_the_papers_limits():
    log = simulate(Flock(), start_of(1), 20.0).log
    assert np.abs(log.commands[:, 0]).max() <= 0.15 + 1e-9
    assert np.abs(log.commands[:, 1]).max() <= 0.55 + 1e-7


def test_the_same_seed_gives_the_same_bytes():
    one, other = (simulate(Flock(), start_of(2), 10.0).log for _ in range(2))
    assert one.poses.tobytes() == other.poses.tobytes()
    assert one.commands.tobytes() == other.commands.tobytes()


def test_a_reset_flock_begins_again():
    flock, poses = Flock(), start_of(4)
    first = flock.step(poses).command
    flock.step(poses + 0.01)
    flock.reset()
    assert np.array_equal(flock.step(poses).command, first)


def test_the_imprint_is_what_was_read_first():
    """Robots that stand where they first stood feel cohesion-separation only."""
    poses = np.array([[0.0, 0.4], [0.0, 0.0], [0.0, 0.0]])
    command = Flock().step(poses).command
    # δ·|N| = 0.12 m is less than 0.4 m: they are drawn together along x.
    assert command[0, 0] > 0 > command[0, 1]
    assert_allclose(command[1], 0.0, atol=1e-12)


def test_steering_turns_the_common_velocity_only():
    """Three metres of drift towards a wall end in a turn; relative motion stays the law's."""
    steered = simulate(Flock(), start_of(3), 60.0).log
    plain = simulate(Flock(walls="certificate"), start_of(3), 60.0).log
    assert np.array_equal(steered.poses[:90], plain.poses[:90])  # before 3 s there is none
    assert not np.array_equal(steered.poses[-1], plain.poses[-1])


#: Narrower than the testbed's, and nowhere symmetric.
OTHER_ARENA = (-0.9, 1.1, -0.7, 0.8)


@pytest.mark.parametrize("walls", ["steer", "certificate"])
def test_certificate_and_steering_keep_to_the_arena_that_they_are_given(walls):
    certificate = replace(EXPERIMENT_CERTIFICATE, boundary=OTHER_ARENA)
    flock = Flock(walls=walls, certificate=certificate)
    arena, seen, turned = Arena(start_of(0)), [], []
    for _ in range(flock.steps_in(25.0)):
        seen.append(arena.poses.copy())
        decision = flock.step(arena.poses)
        turned.append(decision.turning)
        assert decision.clearance == pytest.approx(clearance_of(seen[-1][None], certificate)[0])
        arena.commands = decision.command
        arena.step()
    points = np.array(seen)[:, :2] + 0.05 * heading_vectors(np.array(seen))
    nearest = wall_distance(points, OTHER_ARENA).min()
    assert nearest >= certificate.wall_margin
    if walls == "certificate":
        assert nearest < certificate.wall_margin + 0.03  # they were held at this wall
        assert not any(turned)
    else:  # they turned at it, far from where the testbed has one
        first = np.flatnonzero(turned)[0]
        assert abs(turned[first]) == pytest.approx(flock.steering.turn_rate * flock.time_step)
        gap = wall_distance(points[first : first + 1], OTHER_ARENA).min()
        assert gap <= certificate.wall_margin + flock.steering.reach
        assert wall_distance(points[first : first + 1], EXPERIMENT_CERTIFICATE.boundary).min() > 0.4


def test_parameters_tell_all_that_a_run_needs():
    told = Flock(walls="steer").parameters()
    assert told["law"]["distance_scale"] == 0.12
    assert told["wheels"]["turn_rate_limit"] == 0.55
    assert told["steering"]["turn_rate"] == 0.45
    assert Flock(walls="certificate").parameters()["steering"] is None


def flock_of(**changes):
    return Flock(certificate=replace(EXPERIMENT_CERTIFICATE, **changes))


def test_flocks_of_one_certificate_share_no_memory():
    knowing_the_step = replace(EXPERIMENT_CERTIFICATE, time_step=0.033)
    assert Flock().certificate == Flock().certificate == knowing_the_step
    assert Flock().certificate._memory is not Flock().certificate._memory


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Flock(walls="bounce"), "walls: expected one of steer, certificate"),
        (lambda: Flock(time_step=0.0), "time_step: expected more than 0 s"),
        (
            lambda: flock_of(speed_limit=None, wheel_limit=None),
            "certificate: expected a speed_limit or a wheel_limit; got none",
        ),
        (lambda: flock_of(barrier_gain=1e7), "barrier_gain is 1e.07; steps .* admit [0-9.e+]+ at"),
        (lambda: flock_of(wall_gain=1e8), "wall_gain is 1e.08; steps .* admit [0-9.e+]+ at most"),
        (lambda: Flock(neighbour_hysteresis=-0.1), "neighbour_hysteresis: expected from 0"),
        (lambda: Flock(neighbour_hysteresis=0.75), "less than the radius, 0.75 m; got 0.75"),
        (lambda: flock_of(boundary=None), "certificate: expected a boundary .* got None and 0.11"),
        (lambda: flock_of(wall_margin=None), "certificate: expected .* a wall_margin"),
        (lambda: SteeringParameters(clear=1.0), "clear: expected a cosine"),
        (lambda: SteeringParameters(reach=math.nan), "reach: expected finite"),
        (lambda: Flock().steps_in(math.nan), "duration: expected at least one step"),
        (lambda: Flock().steps_in(0.0), "duration: expected at least one step"),
    ],
)
def test_parameters_that_mean_nothing_are_refused(make, words):
    with pytest.raises(ParameterError, match=words):
        make()


@pytest.mark.parametrize(
    ("poses", "words"),
    [
        (np.zeros((3, 1)), r"at least two robots .* got \(3, 1\)"),
        (np.zeros((3, 0)), r"got \(3, 0\)"),
        (np.zeros((2, 9)), r"got \(2, 9\)"),
        ("poses", "expected a \\(3, N\\) array, got 'poses'"),
        ([[0.0, 1.0], [0.0, math.nan], [0.0, 0.0]], "got y = nan of robot 1"),
    ],
)
def test_poses_that_mean_nothing_are_refused_before_anything_moves(poses, words):
    with pytest.raises(ParameterError, match=words):
        Flock().step(poses)


def test_the_number_of_robots_stays():
    flock = Flock()
    flock.step(start_of(0))
    with pytest.raises(ParameterError, match="expected 9 robots as at the first step, got 4"):
        flock.step(start_of(0)[:, :4])


def test_robots_that_start_too_close_are_named_once():
    poses = np.array([[0.0, 0.25], [0.0, 0.0], [0.0, np.pi]])  # points 0.15 m apart
    flock = Flock()
    with pytest.warns(UserWarning, match="robots 0 and 1 start 50 mm closer than the certificate"):
        decision = flock.step(poses)
    assert decision.clearance == pytest.approx(-0.05)
    flock.step(poses)  # a second warning would be an error


def test_a_control_run_keeps_nobody_apart_and_says_how_close_they_came():
    log = simulate(flock_of(pair_rows=False), start_of(0), 60.0).log
    assert log.parameters["wheels"]["pair_rows"] is False
    assert_allclose(log.clearance, clearance_of(log.poses), atol=1e-12)
    meeting = np.array([[0.0, 0.3], [0.0, 0.0], [0.0, np.pi]])  # the law draws both together
    law_alone, certified = (
        simulate(flock, meeting, 20.0).log for flock in (flock_of(pair_rows=False), Flock())
    )
    assert law_alone.clearance.min() < -0.05
    assert certified.clearance.min() >= 0.0


def test_interventions_count_from_a_millimetre_a_second():
    run = simulate(Flock(), start_of(0), 3.0).log
    moved = np.zeros(len(run.t))
    moved[:10], moved[10:20] = 1.1e-3, 0.9e-3
    summary = summarise(replace(run, intervention=moved))
    assert summary.share_intervened == pytest.approx(10 / len(moved))
    assert summary.largest_intervention == 1.1e-3


def test_what_a_log_does_not_say_stays_unknown():
    run = simulate(Flock(), start_of(0), 3.0).log
    unknown = np.full(len(run.t), math.nan)
    summary = summarise(replace(run, intervention=unknown, clearance=unknown))
    numbers = summary.as_dict()
    for name in ("smallest_clearance", "share_intervened", "largest_intervention"):
        assert numbers[name] is None
    assert "smallest clearance       unknown" in str(summary)


def test_a_summary_in_which_nothing_moved_is_valid_json():
    rows = 100
    log = Run(
        name="still",
        t=0.033 * np.arange(rows),
        poses=np.repeat(start_of(0)[None], rows, axis=0),
        commands=np.zeros((rows, 2, 9)),
        status=np.full(rows, "trivial"),
        intervention=np.zeros(rows),
        clearance=np.zeros(rows),
        parameters={"neighbour_radius": 0.75, "time_step": 0.033},
    )
    numbers = summarise(log).as_dict()
    assert numbers["gamma_motion"] is None
    json.dumps(numbers, allow_nan=False)


def test_a_trial_drives_and_is_judged_by_its_own_robot_and_arena():
    arena = (-0.9, 0.8, -0.42, 0.75)
    kept = replace(EXPERIMENT_CERTIFICATE, boundary=arena)
    flock, start = Flock(certificate=kept), start_of(0)
    start[0, 0] = -0.95  # outside of this arena, within the testbed's
    with pytest.warns(UserWarning, match="wall -x start .* closer"):
        own = simulate(flock, start, 1.0).log
    assert own.robot.boundaries == flock.arena == arena
    assert summarise(own).steps_outside > 0
    wide = replace(GTERNAL, collision_diameter=0.4)
    with pytest.warns(UserWarning, match="wall -x start .* closer"):
        other = simulate(flock, start, 1.0, robot=wide).log
    assert other.robot == wide
    assert summarise(other).steps_outside == 0
    assert summarise(other).collisions > summarise(own).collisions == 0


def test_a_trial_lasts_as_long_as_its_log_says():
    slow = Flock(time_step=0.1)
    run = simulate(slow, start_of(0), 2.0).log
    assert run.robot.time_step == 0.1
    straight = np.abs(run.commands[5:15, 1]) < 0.2
    ways = np.hypot(*np.moveaxis(np.diff(run.poses[5:16, :2], axis=0), 1, 0))
    driven = np.abs(run.commands[5:15, 0]) * 0.1
    assert_allclose(ways[straight], driven[straight], rtol=2e-3, atol=1e-6)
    with pytest.raises(ParameterError, match=r"0.033 s, and the flock's 0.1 s"):
        simulate(slow, start_of(0), 2.0, robot=GTERNAL)
