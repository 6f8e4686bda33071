"""What an analysis says is what the metrics say, saved, reloaded and in stretches."""

import dataclasses
import inspect

import numpy as np
import pytest
from experiment_here import fly_here
from judged_runs import pair, verdict

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.questions import Questions
from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.alignment.verdicts import headline
from posflock_robotarium.commands.report import report as report_command
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.readers import read_pose_log
from posflock_robotarium.report import AnalysisOptions, analyse, load
from rps_compat.logged_violations import violations_of


@pytest.fixture(scope="module")
def nine_robots(tmp_path_factory):
    """A real run of the experiment, short."""
    folder = tmp_path_factory.mktemp("nine")
    fly_here(folder, "--seed", "3", "--duration", "22")
    return analyse(folder / "nine_robots.npy")


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


def test_the_neighbour_radius_is_asked_for_and_checked():
    recording = pair(np.full(120, 0.3))
    with pytest.raises(LogError, match="--radius"):
        analyse(recording, AnalysisOptions(questions=Questions.FLOCKING))
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
