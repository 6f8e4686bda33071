"""The drive to the start in the log of a simulated run: marked, and no part of the experiment."""

import json

import numpy as np
import pytest

from posflock_robotarium.alignment.analysis import analyse
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.readers import read, read_pose_log
from posflock_robotarium.logs.recorder import open_pose_log
from posflock_robotarium.logs.start import experiment_start
from posflock_robotarium.report.page import render
from rps_compat.profiles import load_profile
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script

SCRIPT = """
import numpy as np
from rps.robotarium import Robotarium

STARTS = np.array([[-0.4, 0.4], [0.0, 0.0], [0.0, 3.0]])
robotarium = Robotarium(
    number_of_robots=2, initial_conditions=STARTS, show_figure=False, sim_in_real_time=False
)
for k in range(60):
    poses = robotarium.get_poses()
    if k == 0:
        np.save("first.npy", poses)
    robotarium.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    robotarium.step()
robotarium.debug()
"""


@pytest.fixture
def simulated(tmp_path, monkeypatch):
    """Simulate the script, and return its log as it is read, and what its description says."""
    monkeypatch.chdir(tmp_path)

    def simulate(**settings):
        script = tmp_path / "main.py"
        script.write_text(SCRIPT)
        out = tmp_path / "out"
        settings = {"headless": True, "seed": 3, "recorder": open_pose_log, **settings}
        run_script(script, (), RunSettings(out=out, **settings))
        return read(out / "poses.npy"), json.loads((out / "poses.json").read_text())

    return simulate


def test_the_log_says_when_the_drive_to_the_start_was_over(simulated, tmp_path):
    run, said = simulated()
    first = int(np.flatnonzero(run.t == experiment_start(run))[0])
    assert said["drive"] > 1.0
    assert len(run.t) - first == 60
    np.testing.assert_array_equal(run.poses[first], np.load(tmp_path / "first.npy"))
    assert analyse(run).start == said["drive"]


def test_the_report_of_a_simulated_run_says_what_it_is(simulated, tmp_path):
    """It is called after its script; and no clock of this computer is told for the robots'."""
    run, said = simulated(profile=load_profile("gternal"))
    assert (said["simulated"], said["profile"]) == (True, "gternal")
    analysis = analyse(run)
    assert (analysis.name, analysis.summary()["origin"]) == ("main", "simulation")
    assert "time" not in " ".join(verdict.question for verdict in analysis.verdicts)
    page = render([analysis])
    assert "simulation, profile gternal, " in page
    assert "hardware" not in page


def test_a_run_that_begins_where_it_should_has_no_drive(simulated):
    run, said = simulated(initial="exact")
    assert "drive" not in said
    assert experiment_start(run) == 0.0
    assert len(run.t) == 60


def test_a_log_that_the_script_keeps_itself_says_it_too(simulated, tmp_path, monkeypatch):
    """In the simulator there is no real time but this computer's; elsewhere nobody knows."""
    own = SCRIPT.replace("robotarium.debug()", OWN_LOG).replace("range(60)", "range(2)")
    monkeypatch.setitem(globals(), "SCRIPT", own)
    simulated()
    run = read(tmp_path / "own.npy")
    assert (run.simulated, run.real_time) == (True, None)
    assert analyse(run, radius=0.75).summary()["origin"] == "simulation"
    with PoseLog(tmp_path / "elsewhere", 2, 2) as log:
        for k in range(2):
            log.append(0.033 * k, np.zeros((3, 2)), np.zeros((2, 2)))
    assert read_pose_log(tmp_path / "elsewhere").simulated is None


OWN_LOG = """
from posflock_robotarium.flocking.pose_log import PoseLog

with PoseLog("own", 2, 20, {"seed": 1}) as log:
    for k in range(20):
        log.append(0.033 * k, robotarium.get_poses(), np.zeros((2, 2)))
        robotarium.step()
robotarium.debug()
"""
