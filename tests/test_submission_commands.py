"""The commands around a submission: exit codes, files, JSON, and errors in one line."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.simulated_testbed import simulated_testbed
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, PosflockError
from posflock_robotarium.logs.convert import write_pose_log
from posflock_robotarium.verify import EFFECT_TRIALS, TRIALS
from rps_compat.profiles import load_profile

ZOO = Path(__file__).parent / "zoo"
pytestmark = pytest.mark.usefixtures("shared_trials")


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.parametrize(
    ("script", "code", "verdict"),
    [
        ("sound/two_robots_forward.py", 0, "PASS"),
        ("faulty/saves_at_end.py", 1, "RISK"),
        ("faulty/missing_module.py", 2, "FAIL"),
    ],
)
def test_exit_codes_say_the_verdict(script, code, verdict, tmp_path):
    done = run("verify", ZOO / script, "-n", 1, "-o", tmp_path / "out")
    assert done.exit_code == code
    assert done.output.startswith(verdict)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"verify.json", "verify.html"}


@pytest.mark.parametrize(
    ("declared", "words"),
    [
        ((), "declare 80 s"),
        (("-d", 300), "declare 80 s; you will declare 300 s, which is enough"),
        (("-d", 50), "declare 80 s; you will declare 50 s, which may be too short"),
    ],
)
def test_the_duration_to_declare_is_said_in_whole_sentences(declared, words):
    script = ZOO / "sound/two_robots_forward.py"
    said = run("verify", script, "-n", 1, *declared).stdout
    assert " ".join(said.split()).count("1 trial under") == 1
    (line,) = [line for line in said.splitlines() if line.strip().startswith("duration ")]
    assert line.endswith(f"(median 26): {words}")


def test_a_script_that_cannot_be_read_is_an_error_and_no_verdict():
    done = run("verify", "none.py", "--json")
    assert (done.exit_code != 0, done.stdout) == (True, "")


def test_json_is_all_that_is_printed():
    done = run("verify", ZOO / "faulty/missing_module.py", "--json")
    assert json.loads(done.stdout)["verdict"] == "FAIL"


def test_one_imperfection_at_a_time():
    done = run("verify", ZOO / "sound/two_robots_forward.py", "--effect", "lag", "-n", 1, "--json")
    assert [row["effect"] for row in json.loads(done.stdout)] == ["lag", "all"]
    assert done.exit_code == 0


@pytest.mark.parametrize(("asked", "runs"), [((), EFFECT_TRIALS), (("--trials", TRIALS), TRIALS)])
def test_an_imperfection_gets_as_many_trials_as_are_asked_for(asked, runs):
    script = ZOO / "sound/two_robots_forward.py"
    done = run("verify", script, "--effect", "lag", "--json", *asked)
    assert [row["trials"] for row in json.loads(done.stdout)] == [runs, runs]


def test_help_says_how_many_trials_there_are_by_default():
    words = " ".join(run("verify", "--help").stdout.replace("│", " ").split())
    assert f"Default: {TRIALS}, with --effect {EFFECT_TRIALS} each." in words


@pytest.mark.parametrize(
    "words",
    [
        ("run", "--api", "2", ZOO / "sound/own_clock.py"),
        ("run", "--realism", "ideal", ZOO / "sound/own_clock.py"),
        ("lint", ZOO / "sound/own_clock.py", "--to", "2"),
        ("run", "--generation", "0", ZOO / "sound/own_clock.py"),
    ],
)
def test_one_thing_has_one_spelling(words):
    done = run(*words)
    assert done.exit_code == 2
    assert "No such option" in done.stderr or "greater than or equal to 1" in done.stderr


def test_a_profile_is_printed_as_a_file_to_edit(tmp_path):
    done = run("profile", "harsh")
    (tmp_path / "lab.toml").write_text(done.stdout)
    assert load_profile(tmp_path / "lab.toml") == load_profile("harsh")


def test_a_bundle_says_what_to_enter(tmp_path):
    script = ZOO / "sound/local_helper.py"
    done = run("bundle", script, "-o", tmp_path / "up", "--json")
    said = json.loads(done.stdout)
    assert set(said["files"]) == {"local_helper.py", "zoo_helper.py"}
    assert (said["robots"], said["duration"]) == (2, 80.0)
    assert said["warnings"] == []


def test_one_file_is_one_file_and_warnings_are_told(tmp_path):
    (tmp_path / "empty.py").write_text("")
    done = run("bundle", tmp_path / "empty.py", "-o", tmp_path / "up")
    assert done.stdout.startswith("1 file, ")
    assert done.stderr == "warning: empty.py never imports rps: no robot would move\n"
    assert done.exit_code == 0
    assert "1 file, " in (tmp_path / "up" / "SUBMIT.md").read_text()


def test_a_log_becomes_a_profile_and_is_overlaid_with_it(tmp_path):
    log, truth = simulated_testbed(1, robots=3, rows=900)
    log = replace(log, parameters={**log.parameters, "neighbour_radius": 0.75})
    path = write_pose_log(log, tmp_path / "returned")
    done = run("calibrate", path, "-o", tmp_path / "lab.toml", "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)["dead_time"]["value"]
    assert found == pytest.approx(truth.dead_time, abs=0.033)
    assert load_profile(tmp_path / "lab.toml").dead_time.seconds.values == (found,)
    compared = run("compare", path, "--resimulate", tmp_path / "lab.toml", "--json")
    assert compared.exit_code == 0
    assert "returned_resimulated" in compared.stdout


@pytest.mark.parametrize(
    ("name", "content", "answer"),
    [
        ("none.npz", None, "none.npz: no such file"),
        ("poses", "folder", "poses: a folder with no log in it"),
        ("noise.npy", b"\x00\x07noise" * 50, "not a .npy file, or its beginning is damaged"),
        ("empty.npy", b"", "empty file"),
        ("poses.csv", b"t,x1,y1,theta1\n0,0,0,0\n0.033,0,0,0\n", "no commands in it"),
        ("text.csv", b"1,2,3\n1,2,3\n", "for example --dt 0.033"),
    ],
)
def test_what_is_no_log_is_answered_as_the_report_does(tmp_path, name, content, answer):
    path = tmp_path / name
    if content == "folder":
        path.mkdir()
    elif content is not None:
        path.write_bytes(content)
    done = run("calibrate", path, "-o", tmp_path / "lab.toml")
    assert isinstance(done.exception, LogError)
    assert answer in str(done.exception)
    assert "pickle" not in str(done.exception)
    assert not (tmp_path / "lab.toml").exists()


def test_an_archive_with_commands_can_be_calibrated(tmp_path):
    log, truth = simulated_testbed(1, robots=2, rows=400)
    np.savez(tmp_path / "run.npz", t=log.t, poses=log.poses, commands=log.commands)
    done = run("calibrate", tmp_path / "run.npz", "-o", tmp_path / "lab.toml", "--json")
    found = json.loads(done.stdout)["dead_time"]["value"]
    assert found == pytest.approx(truth.dead_time, abs=0.033)


@pytest.mark.parametrize(
    "arguments",
    [
        ("verify", "none.py"),
        ("verify", ZOO / "sound/own_clock.py", "--profile", "mild"),
        ("verify", ZOO / "sound/own_clock.py", "--duration", 1000),
        ("verify", ZOO / "sound/own_clock.py", "--stall", 0),
        ("verify", ZOO / "sound/own_clock.py", "--effect", "dead_tim"),
        ("profile", "mild"),
        ("bundle", ZOO / "faulty/pandas_import.py", "-o", "up", "--no-run"),
        ("rehearse", "none"),
        ("calibrate", "none.npy"),
    ],
    ids=lambda arguments: " ".join(str(a).rpartition("/")[2] for a in arguments),
)
def test_errors_have_a_name_and_leave_nothing(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run(*arguments)
    assert isinstance(done.exception, PosflockError), done.output
    assert list(tmp_path.iterdir()) == []
