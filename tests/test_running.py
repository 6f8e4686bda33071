"""One driver: the same script meets the same end, in the same words, by whichever command."""

import json
import os
import sys
from dataclasses import asdict
from pathlib import Path

import pytest

import rps_compat
from posflock_robotarium.logs.readers import read_pose_log
from posflock_robotarium.logs.recorder import open_pose_log
from posflock_robotarium.submission.bundle import bundle
from posflock_robotarium.submission.environment import Environment
from posflock_robotarium.submission.rehearse import rehearse
from posflock_robotarium.verify.static import check_source
from posflock_robotarium.verify.trials import Limits, TrialRoom
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.running.driver import drive
from rps_compat.running.outcome import Ended, Outcome
from rps_compat.running.plan import ClockPolicy, RunPlan
from rps_compat.v2.robotarium import Robotarium

HERE = Environment(Path(sys.executable), "this one", {})
START = """\
import sys
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, show_figure=False, sim_in_real_time=False,
               initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for k in range(30):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
"""


@pytest.fixture
def script(tmp_path):
    def script(ending):
        path = tmp_path / "s.py"
        path.write_text(START + ending)
        return path

    return script


def by_run(script):
    return run_script(script, (), RunSettings(headless=True, initial="exact"))


def by_verify(script, fork_server):
    _, source = check_source(script)
    with TrialRoom(source, 2, Limits(), fork_server) as room:
        (trial,) = room.run([room.plan("ideal")])
        return trial.outcome


def by_rehearse(script, folder):
    bundle(script, folder / "up")
    return rehearse(folder / "up", folder / "back", environment=HERE).outcome


@pytest.mark.parametrize(
    ("ending", "ended", "error", "line"),
    [
        ("r.debug()\n", Ended.FINISHED, None, None),
        ("1 / 0\n", Ended.FAILED, "ZeroDivisionError", 11),
        ("sys.exit(3)\n", Ended.FAILED, "SystemExit", 11),
        ("raise MemoryError\n", Ended.OUT_OF_MEMORY, "MemoryError", 11),
        ("raise KeyboardInterrupt\n", Ended.INTERRUPTED, "KeyboardInterrupt", 11),
    ],
)
def test_run_verify_and_rehearse_tell_one_end(
    script, tmp_path, fork_server, ending, ended, error, line
):
    path = script(ending)
    for outcome in (by_run(path), by_verify(path, fork_server), by_rehearse(path, tmp_path)):
        assert outcome.ended is ended, outcome.reason
        assert outcome.steps == outcome.report.steps == 30
        assert (outcome.error and outcome.error.type) == error
        assert (outcome.error and outcome.error.line) == line
        assert outcome.exit_code == (3 if error == "SystemExit" else outcome.exit_code)


def test_what_is_not_measured_is_unknown_and_what_is_reads_back(script, fork_server):
    path = script("1 / 0\n")
    plain, trial = by_run(path), by_verify(path, fork_server)
    assert plain.loop is plain.smallest_gap is plain.silence is plain.finishing_call is None
    assert trial.smallest_gap.metres == pytest.approx(1.0)
    assert trial.loop.p50 <= trial.loop.longest
    for outcome in (plain, trial):
        assert Outcome.from_dict(json.loads(json.dumps(outcome.as_dict()))) == outcome


def test_a_plan_is_plain_data(tmp_path):
    plan = RunPlan("s.py", str(tmp_path), 2, answers=("a",), profile={"name": "x"}, longest=1.0)
    assert RunPlan.from_dict(json.loads(json.dumps(asdict(plan)))) == plan


@pytest.mark.parametrize("only_start", [False, True])
def test_a_watched_run_leaves_the_process_as_it_was(script, capsys, only_start):
    before = dict(vars(Robotarium)), sys.argv, list(sys.path)
    path = script("r.debug()\n")
    plan = RunPlan(
        str(path),
        str(path.parent),
        2,
        clock=ClockPolicy.CHARGED,
        measures=True,
        only_start=only_start,
    )
    outcome = drive(plan)
    assert outcome.ended is (Ended.STOPPED if only_start else Ended.FINISHED)
    assert outcome.finishing_call is not only_start
    assert (dict(vars(Robotarium)), sys.argv, list(sys.path)) == before
    assert rps_compat.installed() is None


def test_the_experiments_time_and_a_planned_interruption_are_told_apart(script):
    path = script("r.debug()\n")
    plan = {"script": str(path), "folder": str(path.parent), "generation": 2, "clock": "simulated"}
    assert drive(RunPlan(**plan, longest=0.5)).ended is Ended.OVER_TIME
    assert drive(RunPlan(**plan, interrupt_at=0.5)).ended is Ended.INTERRUPTED


def test_a_rehearsed_script_that_hears_no_interruption_does_not_pass(script, tmp_path):
    deaf = START.replace(
        "    r.step()\n", "    try: r.step()\n    except KeyboardInterrupt: pass\n"
    )
    path = script("")
    path.write_text(deaf.replace("range(30)", "range(3000)"))
    bundle(path, tmp_path / "up")
    done = rehearse(tmp_path / "up", tmp_path / "back", duration=0.5, environment=HERE)
    assert (done.outcome.ended, done.passed) == (Ended.HUNG, False)
    assert "went on after it had been interrupted" in done.reason


def test_a_rehearsal_puts_policy_violations_on_record(script, tmp_path):
    call = "socket.socket().connect(('127.0.0.1', 9))"
    path = script(f"import socket\ntry:\n    {call}\nexcept OSError:\n    pass\n")
    bundle(path, tmp_path / "up")
    done = rehearse(tmp_path / "up", tmp_path / "back", environment=HERE)
    (violation,) = done.outcome.policy_violations
    assert (violation.kind, violation.line, violation.file) == ("network", 13, "main.py")


def test_a_thousand_instances_need_no_thousand_open_files(tmp_path):
    path = tmp_path / "many.py"
    path.write_text(
        "import os, numpy as np\nfrom rps.robotarium import Robotarium\n"
        "for k in range(60):\n"
        "    r = Robotarium(number_of_robots=1, show_figure=False)\n"
        "    for _ in range(3):\n"
        "        r.get_poses()\n        r.step()\n"
        "with open('open.txt', 'w') as file:\n"
        "    file.write(str(len(os.listdir('/proc/self/fd'))))\n"
    )
    before = len(os.listdir("/proc/self/fd"))
    settings = RunSettings(
        headless=True, initial="exact", out=tmp_path / "out", recorder=open_pose_log
    )
    outcome = run_script(path, (), settings)
    assert len(outcome.reports) == 60
    assert read_pose_log(tmp_path / "out" / "poses-7.npy").ending.how.value == "finished"
    assert int((tmp_path / "open.txt").read_text()) < before + 20
