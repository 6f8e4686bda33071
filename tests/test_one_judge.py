"""Whatever tells of a run tells the same of it, by the run's own robot and arena."""

import dataclasses
import json
import os
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from barrier_certificates.differential_drive import DifferentialDrive
from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.summary import summarise
from posflock_robotarium.flocking.constants_on_board import constants_of
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, Flock
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.convert import convert
from posflock_robotarium.logs.readers import read
from posflock_robotarium.logs.run import How, Run
from posflock_robotarium.report import analyse, write_report
from posflock_robotarium.verify import verify
from rps_compat.logged_violations import violations_of
from rps_compat.testbed import GRITSBOT_X, GTERNAL

ROOT = Path(__file__).parents[1]
#: Of no mirror image, and so narrow that two robots start outside.
ARENA = (-0.9, 0.8, -0.42, 0.75)
ROBOT = dataclasses.replace(
    GTERNAL, base_length=0.15, wheel_radius=0.02, collision_diameter=0.32, boundaries=ARENA
)

#: The experiment on another robot in another arena, as a script that verify and run take.
ELSEWHERE = f"""
import runpy, sys
import numpy as np
from rps.robotarium import Robotarium
Robotarium.BOUNDARIES = np.array({ARENA})
Robotarium.BASE_LENGTH, Robotarium.WHEEL_RADIUS = 0.15, 0.02
Robotarium.COLLISION_DIAMETER = 0.32
sys.argv = ["main.py", "--duration", "2"]
runpy.run_path({str(ROOT / "experiments/robotarium_9bot.py")!r}, run_name="__main__")
"""


@pytest.mark.usefixtures("shared_trials")
def test_all_that_tells_of_a_run_in_another_arena_tells_the_same(tmp_path):
    script, out = tmp_path / "main.py", tmp_path / "out"
    script.write_text(ELSEWHERE)
    command = [sys.executable, "-m", "posflock_robotarium", "run", "--initial", "exact", "-o", out]
    done = subprocess.run(
        [*command, script],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=False, capture_output=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode()
    run = read(tmp_path / "nine_robots.npy")
    # First what is true, by plain geometry.
    x, y, theta = run.poses[:, 0], run.poses[:, 1], run.poses[:, 2]
    left, right, bottom, top = ARENA
    inside = np.minimum.reduce([x - left, right - x, y - bottom, top - y])
    first, second = np.triu_indices(9, 1)

    def gaps(ahead):
        points = x + ahead * np.cos(theta) + 1j * (y + ahead * np.sin(theta))
        return np.abs(points[:, first] - points[:, second])

    wall, outside, gap = inside.min(), int((inside.min(axis=1) < 0).sum()), gaps(0.0).min()
    close = int((gaps(ROBOT.collision_offset) <= 0.32).sum())
    assert wall < -0.02
    assert 10 < outside < len(run.t)
    assert close > 10
    # The log, and the one that the simulator wrote.
    recorded = read(out / "poses.npy")
    assert run.robot == recorded.robot == ROBOT
    assert run.parameters["wheels"]["boundary"] == list(ARENA)  # the flock kept to it, too
    np.testing.assert_array_equal(recorded.poses, run.poses)
    # What run says, and verify.
    (said,) = json.loads((out / "report.json").read_text())["reports"]
    assert (said["steps_outside"], said["pairs_too_close"]) == (outside, close)
    ideal = verify(script, trials=0).ideal.outcome
    assert (ideal.report.steps_outside, ideal.report.pairs_too_close) == (outside, close)
    assert ideal.wall_gap.metres == pytest.approx(wall, abs=1e-12)
    assert ideal.smallest_gap.metres == pytest.approx(gap, abs=1e-12)
    # The arena's test of the log, the summary, and the report.
    judged = violations_of(run.poses, ROBOT, range(len(run.t)))
    assert (judged.outside_steps, judged.close_pairs) == (outside, close)
    for log in (run, recorded):
        summary = summarise(log, radius=0.75)
        assert (summary.steps_outside, summary.collisions) == (outside, close)
        assert summary.smallest_wall_distance == pytest.approx(wall, abs=1e-12)
        assert summary.smallest_distance == pytest.approx(gap, abs=1e-12)
    wheel = metrics.fastest_wheel(run.commands, 0.02, 0.15).max()
    write_report([analyse(run)], tmp_path / "report", figures=False)
    told = json.loads((tmp_path / "report" / "summary.json").read_text())
    assert told["robot"]["boundaries"] == list(ARENA)
    for key, value in {
        "smallest_wall_distance": wall,
        "smallest_distance": gap,
        "boundary_steps": outside,
        "collision_steps": close,
        "fastest_wheel": wheel,
    }.items():
        assert told["numbers"][key]["value"] == pytest.approx(value, abs=1e-12), key


LEAVES = """
import numpy as np
from rps.robotarium import Robotarium
r = Robotarium(number_of_robots=1, show_figure=False, initial_conditions=np.zeros((3, 1)))
r.boundaries = [-0.1, -0.5, 0.2, 1.0]
for _ in range(40):
    r.get_poses()
    r.set_velocities(np.arange(1), np.array([[0.1], [0.0]]))
    r.step()
r.call_at_scripts_end()
"""


@pytest.mark.usefixtures("shared_trials")
@pytest.mark.parametrize("outside", [True, False])
def test_verify_and_report_agree_about_who_left_the_scripts_own_arena(tmp_path, outside):
    script = tmp_path / "main.py"
    script.write_text(LEAVES if outside else LEAVES.replace("r.boundaries = ", "kept = "))
    found = {f.code: f for f in verify(script, trials=0, generation=1).findings}
    subprocess.run(
        [sys.executable, "-m", "posflock_robotarium", "run", "-o", tmp_path / "out", script],
        cwd=ROOT, check=False, capture_output=True,
    )  # fmt: skip
    run = read(tmp_path / "out" / "poses.npy")
    analysis = analyse(run, radius=1.0)
    assert ("boundary" in found) == outside == (analysis.numbers["boundary_steps"].value > 0)
    if outside:
        assert run.robot.boundaries == pytest.approx((-0.1, 0.1, -0.5, 0.5))
        assert found["boundary"].time == pytest.approx(run.t[analysis.events[0].first])


def unknown_run():
    t = 0.033 * np.arange(60)
    poses = np.zeros((60, 3, 2))
    poses[:, 0] = 0.1 * t[:, np.newaxis]
    poses[:, 1, 1] = 0.4
    return Run("unknown", t, poses, parameters={"neighbour_radius": 0.75})


def test_what_nobody_knows_is_in_no_table_as_a_zero(tmp_path):
    analysis = analyse(unknown_run())
    write_report([analysis], tmp_path, latex=True, figures=False)
    told = json.loads((tmp_path / "summary.json").read_text())["numbers"]
    for key in ("interventions", "intervention_largest", "clearance", "unsolved", "fastest_wheel"):
        assert key not in told
    assert "intervened" not in (tmp_path / "table.tex").read_text()
    assert "intervention" not in (tmp_path / "metrics.csv").read_text()
    assert "intervened" not in (tmp_path / "report.html").read_text()
    numbers = summarise(analysis.recording).as_dict()
    for key in ("fastest_wheel", "steps_infeasible", "share_intervened", "ended"):
        assert numbers[key] is None, key


def test_a_share_is_of_the_steps_that_are_known():
    run = dataclasses.replace(
        unknown_run(), intervention=np.r_[np.full(30, np.nan), np.zeros(15), np.full(15, 0.1)]
    )
    assert analyse(run).numbers["interventions"].value == 0.5


@pytest.mark.parametrize("ending", ["npy", "npz", "mat"])
def test_unknown_survives_writing_and_reading(tmp_path, ending):
    partly = np.r_[np.full(30, np.nan), np.full(30, 0.1)]
    words = np.array([""] * 30 + ["optimal"] * 30)
    for run in (
        unknown_run(),
        dataclasses.replace(unknown_run(), intervention=partly, clearance=partly, status=words),
    ):
        back = read(convert(run, tmp_path / f"run.{ending}"))
        np.testing.assert_array_equal(back.poses, run.poses)
        for column in ("commands", "intervention", "clearance", "status"):
            known, read_back = getattr(run, column), getattr(back, column)
            assert (known is None) == (read_back is None), column
            if known is not None:
                np.testing.assert_array_equal(read_back, known)
        assert back.neighbour_radius() == 0.75


def test_an_end_that_is_no_end_is_unknown():
    assert unknown_run().ending is None
    for said, expected in ((None, None), ("stolen", None), ("failed", How.FAILED)):
        run = dataclasses.replace(unknown_run(), parameters={"ended": {"how": said}})
        assert (run.ending and run.ending.how) == expected


def test_a_log_begins_to_tell_its_robot_before_it_is_closed(tmp_path):
    log = PoseLog(tmp_path / "run", 2, 5)
    log.annotate(robot=dataclasses.asdict(ROBOT))
    for t in (0.0, 0.033):
        log.append(t, np.zeros((3, 2)), np.zeros((2, 2)))
    run = read(tmp_path / "run")
    assert run.robot == ROBOT
    assert run.ending.how is How.RUNNING


def test_constants_on_board_are_those_of_either_generation():
    class First:
        wheel_radius, base_length, boundaries = 0.016, 0.105, [-1.6, -1, 3.2, 2]

    class Second:
        WHEEL_RADIUS, BASE_LENGTH, BOUNDARIES = 0.016, 0.11, np.array([-1.6, 1.6, -1.0, 1.0])

    edges = [-1.6, 1.6, -1.0, 1.0]
    assert constants_of(First())["boundaries"] == pytest.approx(edges)
    told = constants_of(Second())
    assert told == {"wheel_radius": 0.016, "base_length": 0.11, "boundaries": edges}
    assert constants_of(object()) == {}


def test_the_certificates_robot_is_generation_ones():
    fields = {f.name: f.default for f in dataclasses.fields(DifferentialDrive)}
    assert fields["wheel_limit"] == GRITSBOT_X.max_wheel_velocity
    assert fields["wheel_radius"] == GRITSBOT_X.wheel_radius
    assert fields["base_length"] == GRITSBOT_X.base_length


def test_what_travels_repeats_the_testbeds_constants_rightly():
    """It travels without `rps_compat`, so it cannot ask there; robots tell it when it flies."""
    experiment = runpy.run_path(str(ROOT / "experiments/robotarium_9bot.py"), run_name="read")
    assert experiment["TIME_STEP"] == Flock().time_step == GRITSBOT_X.time_step
    assert EXPERIMENT_CERTIFICATE.boundary == GRITSBOT_X.boundaries == GTERNAL.boundaries
