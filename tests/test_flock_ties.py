"""Laws, logs and verdicts, too, give inputs that differ by their last bits one answer."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from last_bits import TOUCHING, neighbours_of

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.estimators import window_points
from posflock_robotarium.alignment.point_agents import Measures, summarise
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.freespace.neighbour_search import neighbour_pairs
from posflock_robotarium.freespace.sensing import Sensing, Sensors
from posflock_robotarium.freespace.simulation import FreeSpace
from posflock_robotarium.report import Run, analyse
from posflock_robotarium.verify.data_files import Readable
from posflock_robotarium.verify.findings import Verdict
from posflock_robotarium.verify.initial_drive_time import predicted_drive
from posflock_robotarium.verify.judge import Runs, judge
from posflock_robotarium.verify.timing import judge_duration, recommended_duration
from posflock_robotarium.verify.trials import Ran
from rps_compat import testbed
from rps_compat.arena import Arena
from rps_compat.clock import SimulatedClock
from rps_compat.report import report_of
from rps_compat.running.measures import RunMeasures
from rps_compat.running.outcome import Ended, Failure, Gap, Outcome, Silence
from rps_compat.testbed import GTERNAL
from rps_compat.violations import Violations

#: A lattice of 0.3 m, away from the origin, so that distances round.
LATTICE = np.stack(np.meshgrid(0.1 + 0.3 * np.arange(4), 0.7 + 0.3 * np.arange(3))).reshape(2, -1)


def test_agents_at_the_radius_are_no_neighbours_in_the_law_and_in_its_tree():
    for positions in neighbours_of(LATTICE):
        assert not neighbours(positions, 0.3).any()
        assert neighbour_pairs(positions, 0.3).agent.size == 0
        assert metrics.connected_components(positions, 0.3) == LATTICE.shape[1]
        assert metrics.connected_components(positions, 0.3 + 1e-6) == 1


def test_a_log_counts_the_collisions_that_the_arena_counts():
    for poses in neighbours_of([[0.1, 0.1 + TOUCHING], [0.2, 0.2], [0.0, np.pi]]):
        arena = Arena(poses, GTERNAL)
        arena.step()
        poses = np.repeat(poses[None], 2, axis=0)
        numbers = analyse(Run("touching", np.array([0.0, 0.033]), poses), radius=0.75).numbers
        assert arena.violations.close_pairs == 1
        assert numbers["collision_steps"].value == 2


def test_an_agent_at_the_slowest_speed_stands():
    angles = np.linspace(0.0, 6.0, 5)
    for velocities in neighbours_of([0.01 * np.cos(angles), 0.01 * np.sin(angles)]):
        found = metrics.alignment(velocities, LATTICE[:, :5], 9.0, slowest=0.01)
        assert found.counted == 0


def test_half_a_step_more_is_one_step_more():
    for (duration,) in neighbours_of([0.125]):
        scenario = FreeSpace(agents=4, duration=float(duration), record_interval=0.05)
        assert scenario.steps == 3
        assert Flock(time_step=0.05).steps_in(float(duration)) == 3


def test_a_share_of_the_agents_is_a_whole_number_where_it_is_meant_to_be():
    for (share,) in neighbours_of([0.29]):
        sensors = Sensors(Sensing(failing=float(share)), [np.random.default_rng(0)], 100, 0.05)
        assert sensors.failing.sum() == 29


def test_agents_fail_when_it_is_time():
    sensors = Sensors(Sensing(failing=0.5, failure_time=0.3), [np.random.default_rng(0)], 4, 0.1)
    for time in neighbours_of(0.3):
        assert sensors.failed(float(time)) is not None
    assert sensors.failed(0.299) is None


def test_a_flock_that_drives_straight_at_a_wall_turns_one_way():
    points = np.array([[1.4, 1.4], [0.3, -0.3]])
    for velocity in neighbours_of([[0.1, 0.1], [0.05, -0.05]]):
        assert Flock()._steering._turning(points, velocity.mean(axis=1)) > 0.0


def test_of_two_samples_as_near_the_first_is_taken():
    gamma = np.linspace(0.0, 0.9, 10)
    for step in neighbours_of(10.0 / 3.0):
        times = float(step) * np.arange(10)  # 30 s is the last; 5 s lies between two samples
        curve = np.zeros(10)
        measured = Measures(times, gamma, *([curve + 1.0] * 8), np.ones((10, 2)))
        assert summarise(measured)["gamma_5s"] == pytest.approx(0.1)


# Logs.


def test_a_gap_is_more_than_three_steps():
    regular = 0.033 * np.arange(40)
    held = np.concatenate([regular[:20], regular[22:]])  # one step of exactly three
    for t in neighbours_of(held):
        assert Run("held", t, np.zeros((38, 3, 1))).gaps.size == 0
    assert Run("gap", np.delete(regular, [20, 21, 22]), np.zeros((37, 3, 1))).gaps.size == 1


def test_a_window_of_an_even_number_of_steps_is_one_less():
    for step in neighbours_of(0.1):
        assert window_points(float(step), 0.6) == 5


def test_robots_at_the_slowest_speed_stand():
    t = 0.033 * np.arange(200)
    along = np.stack([metrics.SLOWEST * t - 0.5, metrics.SLOWEST * t - 0.4])
    for x in neighbours_of(along):
        poses = np.stack([x, np.full_like(x, 0.1), np.zeros_like(x)]).transpose(2, 0, 1)
        assert analyse(Run("slow", t, poses), radius=0.75).numbers["standing"].value == 1.0


def test_robots_on_the_wall_and_wheels_at_their_limit_are_within_the_rules():
    t = 0.033 * np.arange(60)
    poses = np.zeros((60, 3, 2))
    poses[:, 0] = [-1.6, 1.6]
    commands = np.zeros((60, 2, 2))
    commands[:, 0] = 0.2
    for read, told in zip(neighbours_of(poses), neighbours_of(commands), strict=True):
        analysis = analyse(Run("edge", t, read, commands=told), radius=0.75)
        assert analysis.numbers["boundary_events"].value == 0
        assert analysis.numbers["wheel_excess_steps"].value == 0
        assert not any("-0.000" in verdict.because for verdict in analysis.verdicts)


# Verdicts before the submission.


def outcome(**values):
    known = {"reports": (report_of(2, 10, 0.033, Violations()),), "steps": 10, "clock": 0.33}
    known |= {"finishing_call": True, "time": 0.33}
    return Outcome(Path("main.py"), 2, Ended.FINISHED, **(known | values))


def codes(ideal, drive=None, declared=None):
    ran = Ran(ideal, Path(), {"log.npy": Readable(100, True, 10, "digest")})
    return [f.code for f in judge(Runs(ran, drive=drive), [], declared)]


def test_robots_that_start_at_the_advised_distance_are_not_too_close():
    for gap in neighbours_of(testbed.SPACING):
        initial = Gap(float(gap), 0.0, (0, 1))
        assert codes(outcome(initial_gap=initial)) == []
    closer = Gap(testbed.SPACING - 1e-6, 0.0, (0, 1))
    assert codes(outcome(initial_gap=closer)) == ["close-start"]


def test_whether_a_drive_reaches_a_start_too_close_is_not_judged():
    failed = Outcome(
        Path("main.py"), 2, Ended.FAILED, error=Failure("Error", message="robots were not there")
    )
    close = Gap(0.1, 0.0, (0, 1))
    apart = Gap(0.3, 0.0, (0, 1))
    assert codes(outcome(initial_gap=close), failed) == ["close-start"]
    assert codes(outcome(initial_gap=apart), failed) == ["unreachable-start"]


def test_a_run_that_just_fits_fits():
    drive = predicted_drive(2)
    for clock in neighbours_of(300.0 - drive.most):
        assert codes(outcome(clock=float(clock)), declared=300.0) == []
        assert recommended_duration(float(clock), drive) == 300.0
    for clock in neighbours_of(300.0 + testbed.TIME_STEP):
        (found,) = judge_duration(outcome(clock=float(clock)), drive, 300.0, False)
        assert found.verdict is Verdict.RISK


def test_robots_may_be_silent_for_less_than_half_a_second():
    for seconds in neighbours_of(testbed.WATCHDOG):
        assert codes(outcome(silence=Silence(float(seconds), 1.0))) == ["watchdog"]


def test_the_smallest_gap_is_that_of_the_first_pair_at_the_first_time():
    measures = RunMeasures(SimulatedClock())
    square = [[0.1, 0.4, 0.4, 0.1], [0.2, 0.2, 0.5, 0.5], [0.0] * 4]
    for step, poses in enumerate(neighbours_of(square)):
        measures.measure(0.033 * step, SimpleNamespace(poses=poses, robot=GTERNAL))
    assert (measures.smallest_gap.time, measures.smallest_gap.robots) == (0.0, (0, 1))
    assert (measures.wall_gap.time, measures.wall_gap.robots) == (0.0, (2,))
