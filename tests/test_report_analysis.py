"""What an analysis says is what the metrics say, and its verdicts are true."""

import dataclasses
import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.comparison import compare, distinctly_named, spread_of
from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.alignment.verdicts import headline
from posflock_robotarium.commands.report import report as report_command
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.readers import read_pose_log
from posflock_robotarium.report import AnalysisOptions, Run, analyse, load
from rps_compat.arena import violations_of

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def nine_robots(tmp_path_factory):
    """A real run of the experiment, short."""
    folder = tmp_path_factory.mktemp("nine")
    command = [sys.executable, ROOT / "experiments/robotarium_9bot.py", "--seed", "3"]
    subprocess.run(
        [*command, "--duration", "22", "--out", folder], check=True, capture_output=True, cwd=ROOT
    )
    return analyse(folder / "nine_robots.npy")


def verdict(analysis, question):
    return next(v for v in analysis.verdicts if question in v.question)


def test_the_nine_robots_agree_with_the_metrics(nine_robots):
    recording, curves = nine_robots.recording, nine_robots.curves
    poses, positions, step = recording.poses, recording.poses[:, :2], recording.step
    radius = recording.parameters["neighbour_radius"]
    motion = metrics.smoothed_velocities(positions, step)
    differences = metrics.velocities_by_differences(positions, step)
    headings = metrics.heading_vectors(poses)
    expected = {
        "gamma_motion": metrics.alignment(motion, positions, radius, slowest=0.01).gamma,
        "gamma_headings": metrics.alignment(headings, positions, radius).gamma,
        "gamma_differences": metrics.alignment(differences, positions, radius, slowest=0.01).gamma,
        "left_out_motion": 1
        - metrics.alignment(motion, positions, radius, slowest=0.01).counted / 9,
        "polarisation_motion": metrics.polarisation(motion, slowest=0.01),
        "speed": metrics.mean_speed(motion),
        "nearest_neighbour": metrics.nearest_neighbour_distance(positions),
        "smallest_distance": metrics.smallest_distance(positions),
        "cohesive_radius": metrics.cohesive_radius(positions),
        "spread": metrics.spread(positions),
        "wall_distance": metrics.wall_distance(positions, (-1.6, 1.6, -1.0, 1.0)),
        "components": metrics.connected_components(positions, radius),
        "algebraic_connectivity": metrics.algebraic_connectivity(positions, radius),
        "fastest_wheel": metrics.fastest_wheel(recording.commands, 0.016, 0.11),
    }
    for key, values in expected.items():
        np.testing.assert_allclose(curves[key], values, rtol=0, atol=1e-12, err_msg=key)
    late = recording.t > 20
    for key in ("gamma_motion", "gamma_headings", "speed"):
        mean = float(expected[key][late].mean())
        assert nine_robots.numbers[key].value == pytest.approx(mean, rel=0, abs=1e-12)
    assert (
        nine_robots.numbers["collision_steps"].value
        == violations_of(poses, recording.robot, range(len(poses))).close_pairs
    )


def one_parks(folder):
    """A log of which robot 1 stands still after a third, seen with tracking noise."""
    flock = known_flock("parallel", 0.1, duration=6.0).recording
    poses = flock.poses.copy()
    stop = len(poses) // 3
    noise = np.random.default_rng(1).normal(scale=5e-4, size=(len(poses) - stop, 3))
    poses[stop:, :, 0] = poses[stop, :, 0] + noise
    with PoseLog(folder / "run", flock.robots, len(flock.t), {"neighbour_radius": 0.72}) as writer:
        for t, pose in zip(flock.t, poses, strict=True):
            writer.append(t, pose, np.zeros((2, flock.robots)))
    return folder / "run.npy"


def test_summary_and_report_agree_about_robots_that_stand(tmp_path):
    path = one_parks(tmp_path)
    numbers, summary = analyse(path).numbers, summarise(read_pose_log(path))
    assert summary.gamma_motion == pytest.approx(numbers["gamma_motion"].value, rel=0, abs=1e-12)
    assert summary.gamma_headings == pytest.approx(
        numbers["gamma_headings"].value, rel=0, abs=1e-12
    )


def test_a_robot_stands_by_one_measure_everywhere():
    default = inspect.signature(report_command).parameters["slowest"].default
    assert default == AnalysisOptions().slowest == metrics.SLOWEST


def test_the_nine_robots_flock(nine_robots):
    assert headline(nine_robots.verdicts) == "aligned, together, safe"
    assert verdict(nine_robots, "whole run").mark == "good"
    assert verdict(nine_robots, "limits").mark == "good"


def test_small_stretches_give_the_same_curves(nine_robots, monkeypatch):
    monkeypatch.setattr("posflock_robotarium.alignment.measured_run.PAIRS_AT_A_TIME", 81 * 7)
    again = analyse(nine_robots.recording)
    for key, curve in nine_robots.curves.items():
        np.testing.assert_array_equal(again.curves[key], curve, err_msg=key)
    assert again.events == nine_robots.events


def test_saved_and_reloaded_it_is_the_same(nine_robots, tmp_path):
    again = load(nine_robots.save(tmp_path / "run.analysis.npz"))
    assert again.summary() == nine_robots.summary()
    assert again.numbers.keys() == nine_robots.numbers.keys()
    for key, curve in nine_robots.curves.items():
        np.testing.assert_array_equal(again.curves[key], curve)
    np.testing.assert_array_equal(again.recording.poses, nine_robots.recording.poses)
    assert again.verdicts == nine_robots.verdicts
    assert again.options == nine_robots.options


def test_a_file_that_is_no_analysis_is_refused(tmp_path, nine_robots):
    np.savez(tmp_path / "other.npz", t=[1, 2])
    with pytest.raises(LogError, match="not a saved analysis"):
        load(tmp_path / "other.npz")
    saved = nine_robots.save(tmp_path / "run.npz")
    (tmp_path / "cut.npz").write_bytes(saved.read_bytes()[:5000])
    with pytest.raises(LogError):
        load(tmp_path / "cut.npz")


def parked(noise=0.0005, **changes):
    flock = known_flock("stopped", 0.0, position_noise=noise)
    return analyse(dataclasses.replace(flock.recording, **changes), radius=flock.radius)


@pytest.mark.parametrize("noise", [0.0, 0.0005])
def test_a_parked_flock_is_said_to_stand_however_parallel_its_headings(noise):
    analysis = parked(noise)
    aligned = verdict(analysis, "align")
    assert analysis.numbers["gamma_headings"].value > 0.999
    assert aligned.mark == "bad"
    assert aligned.answer == "No: nothing moves."
    assert "Headings are parallel (γ from headings 1.000)" in aligned.because
    assert "not flocking" in aligned.because
    assert headline(analysis.verdicts).startswith("parked")
    assert verdict(analysis, "sure").mark == "caution"


def test_one_robot_of_many_that_stands_is_told():
    moving = known_flock("parallel", 0.1, robots=20, position_noise=0).recording
    poses = moving.poses.copy()
    poses[:, :, 3] = poses[0, :, 3]
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert analysis.numbers["robots_standing"].value == 1
    assert verdict(analysis, "align").answer == "Those that moved did."
    assert "1 of 20 robots stood over half the time." in verdict(analysis, "align").because


def test_a_flock_that_parks_on_the_way_came_to_a_stop():
    moving = known_flock("parallel", 0.1, duration=70.0, position_noise=0).recording
    poses = moving.poses.copy()
    poses[len(poses) * 3 // 4 :] = poses[len(poses) * 3 // 4]
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert verdict(analysis, "align").answer == "No: it came to a stop."
    assert verdict(analysis, "align").mark == "bad"


def test_a_flock_that_stops_at_the_very_end_has_flocked():
    moving = known_flock("parallel", 0.1, duration=70.0, position_noise=0).recording
    poses = moving.poses.copy()
    poses[-60:] = poses[-60]
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert verdict(analysis, "align").mark == "good"


def test_verdicts_tell_parallel_from_scattered():
    answers = {}
    for motion in ("parallel", "counter", "random"):
        flock = known_flock(motion, 0.1)
        answers[motion] = verdict(analyse(flock.recording, radius=flock.radius), "align").mark
    assert answers == {"parallel": "good", "counter": "bad", "random": "bad"}


def test_parallel_headings_with_scattered_motion_are_not_alignment():
    flock = known_flock("random", 0.1)
    poses = flock.recording.poses.copy()
    poses[:, 2] = 0.7
    analysis = analyse(dataclasses.replace(flock.recording, poses=poses), radius=100.0)
    assert verdict(analysis, "align").answer == "No: headings are parallel, motion is not."
    assert "headings and motion disagree" in verdict(analysis, "sure").answer


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def test_headings_in_degrees_are_noticed():
    flock = known_flock("random", 0.1)
    poses = flock.recording.poses.copy()
    poses[:, 2] = np.degrees(poses[:, 2])
    analysis = analyse(dataclasses.replace(flock.recording, poses=poses), radius=100.0)
    assert verdict(analysis, "sure").mark == "bad"
    assert "degrees" in verdict(analysis, "sure").answer


def test_degrees_that_happen_to_lie_along_the_motion_are_noticed():
    moving = known_flock("parallel", 0.1, robots=4).recording
    course = np.arctan2(*(moving.poses[-1, 1::-1, 0] - moving.poses[0, 1::-1, 0]))
    poses = moving.poses.copy()
    poses[:, :2] = rotation(np.radians(70.0) - course) @ poses[:, :2]
    poses[:, 2] = 70.0  # which is 51 degrees as an angle in radians
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert 0.15 < analysis.numbers["heading_offset"].value < 0.35
    assert "degrees" in verdict(analysis, "sure").answer


def test_headings_that_count_whole_turns_are_radians():
    moving = known_flock("parallel", 0.1, robots=4).recording
    poses = moving.poses + np.array([[0.0], [0.0], [6 * np.pi]])
    analysis = analyse(dataclasses.replace(moving, poses=poses), radius=100.0)
    assert verdict(analysis, "sure").mark == "good"


def pair(distance, heading=(0.0, 0.0), samples=120):
    """Two robots beside each other that drive along x, `distance` (T,) apart."""
    t = np.arange(samples) * 0.033
    poses = np.zeros((samples, 3, 2))
    poses[:, 0] = -0.5 + 0.1 * t[:, np.newaxis]
    poses[:, 1, 1] = distance
    poses[:, 2] = heading
    return Run("pair", t, poses)


def test_collisions_are_counted_by_the_testbeds_own_test():
    distance = np.full(120, 0.3)
    distance[20:30] = 0.13
    distance[60:62] = 0.134
    distance[90] = 0.136
    analysis = analyse(pair(distance), radius=0.75)
    assert analysis.numbers["collisions"].value == 2
    assert analysis.numbers["collision_steps"].value == 12
    assert [(e.first, e.last, e.robots) for e in analysis.events] == [
        (20, 29, (0, 1)),
        (60, 61, (0, 1)),
    ]
    assert verdict(analysis, "safe").answer == "No: 2 collisions."


def test_the_collision_points_lie_ahead_of_the_centres():
    # Centres .18 apart along x, nose to nose: the points .025 ahead are .13 apart.
    recording = pair(np.zeros(120), heading=(0.0, np.pi))
    poses = recording.poses.copy()
    poses[:, 0] = [[0.0, 0.18]]
    analysis = analyse(dataclasses.replace(recording, poses=poses), radius=0.75)
    assert analysis.numbers["smallest_distance"].value == pytest.approx(0.18)
    assert analysis.numbers["smallest_collision_distance"].value == pytest.approx(0.13)
    assert analysis.numbers["collisions"].value == 1


def test_leaving_the_arena_is_an_event_and_a_verdict():
    recording = pair(np.full(120, 0.3))
    poses = recording.poses.copy()
    poses[40:50, 0, 1] = 1.65
    analysis = analyse(dataclasses.replace(recording, poses=poses), radius=0.75)
    assert analysis.numbers["boundary_events"].value == 1
    assert analysis.numbers["boundary_steps"].value == 10
    assert analysis.numbers["smallest_wall_distance"].value == pytest.approx(-0.05)
    assert verdict(analysis, "safe").answer == "No: 1 boundary crossing."


def test_stalls_and_wheel_excess_come_from_the_commands():
    recording = pair(np.full(120, 0.3))
    poses = recording.poses.copy()
    poses[60:, :, 1] = poses[60, :, 1]
    command = np.zeros((120, 2, 2))
    command[:, 0] = 0.1
    command[5, 0, 0] = 0.3
    analysis = analyse(dataclasses.replace(recording, poses=poses, commands=command), radius=0.75)
    assert analysis.numbers["stalls"].value == 1
    assert analysis.numbers["wheel_excess_steps"].value == 1
    assert analysis.numbers["wheel_excess"].value == pytest.approx(0.3 / 0.016 - 12.5)
    assert verdict(analysis, "limits").mark == "bad"


def test_without_commands_limits_are_unknown():
    assert verdict(parked(), "limits").mark == "unknown"


def test_the_certificates_interventions_are_counted():
    recording = dataclasses.replace(
        pair(np.full(120, 0.3)),
        commands=np.zeros((120, 2, 2)),
        intervention=np.where(np.arange(120) < 30, 0.02, 0.0),
        clearance=np.linspace(0.1, 0.01, 120),
        status=np.array(["relaxed"] * 3 + ["optimal"] * 117),
    )
    numbers = analyse(recording, radius=0.75).numbers
    assert numbers["interventions"].value == 0.25
    assert numbers["intervention_mean"].value == pytest.approx(0.02)
    assert numbers["clearance"].value == pytest.approx(0.01)
    assert numbers["unsolved"].value == 3


def test_an_unsafe_start_is_said_with_the_safety():
    recording = dataclasses.replace(
        pair(np.full(120, 0.3)), clearance=np.linspace(-0.02, 0.01, 120)
    )
    analysis = analyse(recording, radius=0.75)
    assert analysis.numbers["clearance_first"].value == pytest.approx(-0.02)
    assert "It started 20 mm closer than the certificate keeps" in verdict(analysis, "safe").because


def test_a_log_without_a_certificate_says_nothing_of_one():
    nothing = np.full(120, np.nan)
    recording = dataclasses.replace(
        pair(np.full(120, 0.3)),
        intervention=nothing,
        clearance=nothing,
        status=np.full(120, ""),
    )
    numbers = analyse(recording, radius=0.75).numbers
    assert not {"interventions", "clearance", "clearance_first", "unsolved"} & set(numbers)


def test_a_flock_that_parts_is_not_together():
    distance = np.linspace(0.3, 1.2, 120)
    analysis = analyse(pair(distance), radius=0.75)
    assert analysis.numbers["components"].value == 2
    assert analysis.numbers["connected"].value == pytest.approx((distance < 0.75).mean())
    assert verdict(analysis, "together").mark == "bad"


def test_alignment_for_good_is_later_than_alignment_for_once():
    t = np.arange(300) * 0.033
    poses = np.zeros((300, 3, 2))
    poses[:, 0, 0] = poses[:, 0, 1] = 0.1 * t
    poses[:, 1, 1] = 0.3
    poses[100:150, 2, 1] = 2.0
    numbers = analyse(Run("wobble", t, poses), radius=0.75).numbers
    assert numbers["time_to_alignment_headings"].value == 0
    assert numbers["time_aligned_for_good_headings"].value == pytest.approx(150 * 0.033)
    assert numbers["share_aligned_headings"].value == pytest.approx(250 / 300)


def test_one_robot_is_analysed_without_alignment():
    recording = pair(np.full(120, 0.3))
    alone = dataclasses.replace(recording, poses=recording.poses[:, :, :1])
    analysis = analyse(alone, radius=0.75)
    assert np.isnan(analysis.numbers["gamma_motion"].value)
    assert verdict(analysis, "align").mark == "unknown"


def test_the_neighbour_radius_is_asked_for_and_checked():
    recording = pair(np.full(120, 0.3))
    with pytest.raises(LogError, match="--radius"):
        analyse(recording)
    known = dataclasses.replace(recording, parameters={"neighbour_radius": [0.5, 0.6]})
    assert analyse(known).options.radius == (0.5, 0.6)
    for wrong in ([0.5] * 3, "wide", -1, float("nan")):
        with pytest.raises(LogError, match="neighbour radius"):
            analyse(dataclasses.replace(recording, parameters={"neighbour_radius": wrong}))


@pytest.mark.parametrize(
    "wrong",
    [
        {"radius": 0.0},
        {"window": 0.0},
        {"slowest": -1.0},
        {"threshold": 2.0},
        {"transient": np.nan},
    ],
)
def test_options_are_checked(wrong):
    with pytest.raises(ParameterError):
        AnalysisOptions(**wrong)


def test_a_settling_time_beyond_the_end_is_refused():
    flock = known_flock("parallel", 0.1, duration=4.0)
    for transient in (4.0, 30.0):
        with pytest.raises(
            ParameterError, match=r"--transient is \d+ s, but the run ends after 3\.9"
        ):
            analyse(flock.recording, AnalysisOptions(radius=flock.radius, transient=transient))
    late = analyse(flock.recording, AnalysisOptions(radius=flock.radius, transient=2.0))
    assert late.settled.sum() == (flock.recording.t > 2.0).sum()
    assert analyse(flock.recording, radius=flock.radius).settled.all()


def test_a_killed_run_is_not_the_whole_run():
    analysis = parked(parameters={"ended": {"how": "running"}, "duration": 120.0})
    assert verdict(analysis, "whole run").mark == "caution"
    assert "60.0 s are logged of 120.0 s planned" in verdict(analysis, "whole run").because


def test_the_bootstrap_interval_covers_the_mean_about_as_often_as_it_says():
    rng = np.random.default_rng(5)
    covered = 0
    for k in range(200):
        spread = spread_of(rng.normal(3.0, 1.0, 20), seed=k)
        covered += spread.low <= 3.0 <= spread.high
    assert 178 <= covered <= 198  # 95 % in theory, a little less for twenty values


def test_fewer_than_three_runs_have_no_interval():
    assert np.isnan(spread_of(np.array([1.0, 2.0])).low)
    assert spread_of(np.array([np.nan, np.nan])).runs == 0
    assert spread_of(np.array([1.0, 2.0, 4.0]), seed=1) == spread_of(
        np.array([1.0, 2.0, 4.0]), seed=1
    )


def test_simulation_and_reality_side_by_side():
    runs = []
    for simulated, seed in ((True, 0), (True, 1), (False, 2)):
        flock = known_flock("parallel", 0.1, duration=5.0, seed=seed)
        recording = dataclasses.replace(flock.recording, parameters={"simulated": simulated})
        runs.append(analyse(recording, radius=flock.radius))
    comparison = compare(distinctly_named(runs))
    assert comparison.groups == ("simulation", "testbed")
    row = next(row for row in comparison.rows if row.key == "gamma_motion")
    assert row.by_label["simulation"].runs == 2
    assert row.by_label["simulation"].mean == pytest.approx(np.mean(row.values[:2]))
    assert len({a.name for a in comparison.analyses}) == 3
    with pytest.raises(ParameterError, match="labels"):
        compare(runs, ["a"])


def test_three_frames_do_not_tell_whether_a_flock_aligned():
    flock = known_flock("parallel", 0.1, duration=2.0)
    short = dataclasses.replace(
        flock.recording, t=flock.recording.t[:3], poses=flock.recording.poses[:3]
    )
    answer = verdict(analyse(short, radius=flock.radius), "align")
    assert (answer.mark, answer.answer) == ("unknown", "Too short to tell.")
