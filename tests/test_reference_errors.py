"""How far robots are from a reference, against errors that are known by construction."""

import csv
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from posflock_robotarium.alignment.reference_errors import errors_against
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.report import Run

T = 0.05 * np.arange(200)


def circling(robots=2):
    """Robots on circles, at 0.2 m/s and 0.5 rad/s."""
    poses = np.empty((len(T), 3, robots))
    poses[:, 2] = 0.5 * T[:, np.newaxis] + np.arange(robots)
    poses[:, 0] = 0.4 * np.sin(poses[:, 2])
    poses[:, 1] = -0.4 * np.cos(poses[:, 2])
    return poses


def run(poses, t=T, name="run"):
    return Run(name, t, poses)


def moved(poses, x, y, angle):
    """Turn the whole run about the origin and shift it: a run that was only placed elsewhere."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack(
        [
            cos * poses[:, 0] - sin * poses[:, 1] + x,
            sin * poses[:, 0] + cos * poses[:, 1] + y,
            poses[:, 2] + angle,
        ],
        axis=1,
    )


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3))
def test_a_run_that_is_placed_elsewhere_moves_as_the_reference(x, y, angle):
    errors = errors_against(run(moved(circling(), x, y, angle)), run(circling()))
    for robot in errors.robots:
        assert robot.motion.largest < 1e-9
        assert robot.turning.largest < 1e-9
        assert robot.heading.mean == pytest.approx(abs(angle), abs=1e-9)


def test_a_shift_is_the_absolute_error():
    errors = errors_against(run(moved(circling(), 0.03, 0.04, 0.0)), run(circling()))
    for robot in errors.robots:
        for value in vars(robot.position).values():
            assert value == pytest.approx(0.0 if value is robot.position.sd else 0.05, abs=1e-9)
    assert (errors.frames, errors.robots[1].samples, errors.robots[1].pairs) == (20, 200, 9)


def test_a_slow_robot_has_a_relative_error_of_what_it_lost_in_a_second():
    straight = np.zeros((len(T), 3, 1))
    straight[:, 0, 0] = 0.2 * T
    slow = straight * [[0.7], [1.0], [1.0]]
    [robot] = errors_against(run(slow), run(straight)).robots
    assert robot.motion.rmse == pytest.approx(0.06, abs=1e-9)
    assert robot.position.largest == pytest.approx(0.06 * T[-1], abs=1e-9)
    assert robot.turning.rmse == pytest.approx(0.0, abs=1e-9)
    [robot] = errors_against(run(slow), run(straight), delta=2.0).robots
    assert robot.motion.rmse == pytest.approx(0.12, abs=1e-9)


def test_samples_belong_together_by_time_since_the_first_pose():
    later = run(circling()[::2], 1000.0 + T[::2], "later")
    for a, b in ((later, run(circling())), (run(circling()), later)):
        errors = errors_against(a, b)
        assert errors.robots[0].samples == 100
        assert errors.robots[0].position.largest < 1e-9
    shifted = errors_against(run(circling()[40:], T[40:]), run(circling()), offset=-2.0)
    assert shifted.robots[0].samples == 160
    assert shifted.robots[0].position.largest < 1e-9


def test_no_motion_is_taken_across_a_gap():
    keep = np.r_[0:70, 150:200]
    poses = circling()
    errors = errors_against(run(poses[keep], T[keep]), run(poses))
    assert errors.robots[0].samples == 120
    assert errors.robots[0].pairs == 4
    assert errors.robots[0].motion.largest < 1e-9


def test_without_headings_there_is_the_distance_alone():
    poses = circling()
    poses[:, 2] = np.nan
    [robot, _] = errors_against(run(poses), run(circling())).robots
    assert robot.position.rmse == 0.0
    assert (robot.heading, robot.motion, robot.turning) == (None, None, None)


def test_what_cannot_be_compared_is_told():
    with pytest.raises(LogError, match="run has 2 robots, the reference run has 3"):
        errors_against(run(circling()), run(circling(3)))
    with pytest.raises(LogError, match="--reference-offset"):
        errors_against(run(circling()), run(circling()), offset=100.0)
    for wrong in ({"delta": 0.0}, {"delta": np.nan}, {"offset": np.inf}):
        with pytest.raises(ParameterError, match="expected a time"):
            errors_against(run(circling()), run(circling()), **wrong)


def test_the_command_tells_each_robot_in_table_page_csv_and_json(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("posflock_robotarium.report.curve_figures.draw", lambda *_: [])
    np.savez("there.npz", t=T, poses=circling())
    np.savez("here.npz", t=T, poses=moved(circling(), 0.03, 0.04, 0.0))
    arguments = ["compare", "here.npz", "--reference", "there.npz", "-o", "out"]
    told = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert "here against there, root mean square (largest); RPE over 1 s, 20 samples" in told.output
    assert told.output.count("0.0500 m (0.0500 m)") == 2
    with open("out/reference_errors.csv") as file:
        rows = list(csv.DictReader(file))
    assert [(row["run"], row["robot"]) for row in rows] == [("here", "0"), ("here", "1")]
    assert float(rows[0]["ape_position_m_rmse"]) == pytest.approx(0.05)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Errors against there" in page
    told = CliRunner().invoke(app, [*arguments[:4], "--json"], catch_exceptions=False)
    summary = json.loads(told.stdout)
    assert summary["labels"] == ["reference", "runs"]
    [errors] = summary["errors_against_reference"]
    assert errors["robots"][1]["position"]["mean"] == pytest.approx(0.05)
    again = CliRunner().invoke(app, ["compare", "here.npz", "there.npz", "-o", "out"])
    assert again.exit_code == 0
    assert not (tmp_path / "out" / "reference_errors.csv").exists()
