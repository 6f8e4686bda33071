"""Scripts as people write them run as they are, and leave what they should."""

import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.logs.readers import read_pose_log
from posflock_robotarium.logs.recorder import open_pose_log
from rps_compat.errors import ScriptError
from rps_compat.run_settings import RunSettings, SettingsError
from rps_compat.runner import run_script
from rps_compat.running.outcome import summary

SCRIPTS = Path(__file__).parent / "scripts"


@pytest.fixture
def run(tmp_path, capsys):
    """Run one of the scripts in a folder of its own."""

    def run(name, *arguments, **settings):
        home = tmp_path / "home"
        home.mkdir(exist_ok=True)
        script = Path(shutil.copy(SCRIPTS / name, home))
        settings = {"headless": True, "seed": 0, "timeout": 60, **settings}
        result = run_script(
            script,
            arguments,
            RunSettings(out=tmp_path / "out", recorder=open_pose_log, **settings),
        )
        printed = capsys.readouterr()
        result_log = tmp_path / "out" / "poses.npy"
        log = read_pose_log(result_log) if result_log.exists() else None
        return result, printed.out, printed.err, log

    return run


# What each script is, how it ends, and something that it prints when all went well.
FINISHING = {
    "goals_with_barriers.py": (1, "all there 5"),
    "plot_on_axes.py": (1, "201 lines 4 texts"),
    "bare_pyplot.py": (1, "121 120"),
    "subclass_of_robotarium.py": (1, "speed 0.080 steps 100 x -1.00"),
    "ids_of_all_kinds.py": (1, "0.0198"),
    "poses_in_while.py": (1, "arrived after 203"),
    "many_instances.py": (1, "[0, 0, 0"),
    "saves_its_data.py": (1, "saved to ."),
    "consensus.py": (1, "errors"),
    "generation2_goals.py": (2, "done: True"),
    "generation2_sensors.py": (2, "(2, 3) (3, 3) (3, 3) (3, 3) (3,) (2, 7, 3)\nTrue"),
    "generation2_subsets.py": (2, "[0.08 0.08 0.08 0.08] 31"),
    "either_generation.py": (2, "time step 0.033"),
    "tells_no_generation.py": (2, "there (3, 2)"),
}


@pytest.mark.parametrize("name", FINISHING)
def test_script_finishes(run, name):
    generation, said = FINISHING[name]
    result, out, err, log = run(name)
    assert (result.ended, result.exit_code, result.generation) == ("finished", 0, generation), err
    assert said in out
    assert len(log.t) == result.reports[0].steps
    assert np.isfinite(log.poses).all()


def test_every_script_is_tested():
    others = {"real_time_and_input.py", "runs_forever.py", "wrong_name.py", "divides_by_zero.py"}
    assert {path.name for path in SCRIPTS.glob("*.py")} == FINISHING.keys() | others


def test_clock_and_input_do_not_wait(run):
    result, out, _, _ = run("real_time_and_input.py", answers=["0.1"])
    # A step and its two sleeps are 0.2 s of the script's time.
    assert "steps 25 speed 0.1 ''" in out
    assert "How fast? 0.1" in out
    assert result.exit_code == 0


def test_endless_script_is_stopped_and_its_log_kept(run):
    result, _, _, log = run("runs_forever.py", timeout=3.0)
    assert (result.ended, result.exit_code) == ("timed out", 124)
    assert "time limit of 3 s" in summary(result)
    # The step in which it was stopped may have been begun and not ended.
    assert len(log.t) - result.reports[0].steps in (0, 1)
    assert len(log.t) > 100
    assert log.parameters["ended"]["how"] == "interrupted"
    assert "time limit" in log.parameters["ended"]["reason"]


def test_wrong_name_gets_the_right_one(run):
    result, _, err, log = run("wrong_name.py", generation=1)
    assert (result.ended, result.exit_code) == ("failed", 1)
    assert "generation 1 calls this call_at_scripts_end()" in result.reason
    assert "runner.py" not in err, "the traceback begins in the script"
    assert len(log.t) == 20


def test_names_of_the_other_generation_are_told_before_the_run(tmp_path):
    script = tmp_path / "s.py"
    script.write_text(
        "from rps.robotarium import Robotarium\n"
        "r = Robotarium(number_of_robots=1, skip_initialization=True)\n"
        "t = r.TIME_STEP\n"
        "print('first step')\n"
        "r.get_poses(); r.step()\n"
        "r.call_at_scripts_end()\n"
    )
    note = "line 6: call_at_scripts_end() is generation 1's; generation 2 calls it"
    done = subprocess.run(
        [sys.executable, "-u", "-m", "posflock_robotarium", "run", "-o", tmp_path / "out", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert 0 <= done.stdout.find(f"{note} debug()") < done.stdout.find("first step")
    data = json.loads((tmp_path / "out" / "report.json").read_text())
    assert data["notes"] == [f"{note} debug()"]
    told = []
    run_script(script, (), RunSettings(headless=True, generation=1, tell=told.append))
    assert [note.split(":")[0] for note in told] == ["line 2", "line 3"]


def test_a_generation_that_nothing_tells_is_said_to_be_assumed(run):
    result, _, _, _ = run("either_generation.py")
    assert result.notes == ()
    result, _, _, _ = run("subclass_of_robotarium.py")
    assert result.notes == ()
    told = []
    result, _, _, _ = run("tells_no_generation.py", tell=told.append)
    assert "nothing in the script tells its generation: running as generation 2" in told[0]
    assert told == list(result.notes)
    result, _, _, _ = run("tells_no_generation.py", generation=1)
    assert result.notes == ()


def test_command_that_is_no_number_stops_the_run(run):
    result, _, _, log = run("divides_by_zero.py")
    assert result.ended == "failed"
    assert "the turn rate of robot 2 is nan" in result.reason
    assert len(log.t) == 7
    assert log.parameters["ended"]["how"] == "failed"


def test_same_seed_same_bytes(run, tmp_path):
    run("saves_its_data.py")
    first = (tmp_path / "out" / "poses.npy").read_bytes()
    run("saves_its_data.py", seed=1)
    other = (tmp_path / "out" / "poses.npy").read_bytes()
    run("saves_its_data.py")
    assert (tmp_path / "out" / "poses.npy").read_bytes() == first != other


def test_script_writes_where_it_says(run, tmp_path):
    (tmp_path / "data").mkdir()
    run("saves_its_data.py", str(tmp_path / "data"))
    assert sorted(p.name for p in (tmp_path / "data").iterdir()) == [
        "end.png", "poses.npy", "x.csv", "y.csv",
    ]  # fmt: skip
    assert [p.name for p in (tmp_path / "home").iterdir()] == ["saves_its_data.py"]


def test_report_is_left_as_text_and_data(run, tmp_path):
    result, _, _, _ = run("many_instances.py")
    data = json.loads((tmp_path / "out" / "report.json").read_text())
    assert len(data["reports"]) == 12
    assert not data["clean"]
    fault = next(f for r in data["reports"] for f in r["faults"] if f["kind"] == "collision")
    assert fault["robots"] == [0, 1]
    assert 0 < fault["worst"] < 0.135
    text = (tmp_path / "out" / "report.txt").read_text()
    assert "iteration(s) where robots collided." in text
    assert (tmp_path / "out" / "poses-12.npy") in result.files


def test_reports_of_equal_runs_are_equal(run, tmp_path):
    run("plot_on_axes.py", snapshots=(0.0,))
    first = (tmp_path / "out" / "report.json").read_bytes()
    assert str(tmp_path / "out").encode() not in first
    names = json.loads(first)["files"]
    assert {"poses.npy", "report.json", "snapshot-0s.png"} <= set(names)
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    script = tmp_path / "home" / "plot_on_axes.py"
    settings = {"headless": True, "seed": 0, "snapshots": (0.0,), "recorder": open_pose_log}
    run_script(script, (), RunSettings(out=tmp_path / "other", **settings))
    assert (tmp_path / "other" / "report.json").read_bytes() == first


LONG_TEAM = """
import numpy as np
from rps.robotarium import Robotarium

x, y = np.meshgrid(np.linspace(-1.4, 1.4, 7), [-0.6, 0.0, 0.6])
r = Robotarium(21, False, False, np.stack([x.ravel(), y.ravel(), 0 * x.ravel()]))
r.time_step = 10.0
for k in range({steps}):
    r.get_poses()
    r.step()
"""


def test_what_the_testbed_does_not_take_is_noted(tmp_path):
    script = tmp_path / "s.py"
    script.write_text(LONG_TEAM.format(steps=91))
    result = run_script(script, (), RunSettings(headless=True, out=tmp_path / "out"))
    assert result.exit_code == 0
    assert result.clean, "a note is no failure"
    assert result.notes == (
        "21 robots: the testbed has 20",
        "910.0 s: the testbed ends every run after 900 s",
    )
    assert "note: 21 robots: the testbed has 20" in summary(result)
    data = json.loads((tmp_path / "out" / "report.json").read_text())
    assert data["notes"] == list(result.notes)
    script.write_text(LONG_TEAM.format(steps=90))
    assert run_script(script, (), RunSettings(headless=True)).notes == result.notes[:1]


def test_a_script_without_a_robotarium_is_noted(tmp_path):
    script = tmp_path / "s.py"
    script.write_text("print('hello')")
    result = run_script(script, (), RunSettings(headless=True, generation=2, out=tmp_path / "out"))
    assert result.exit_code == 0
    assert "no Robotarium was made" in result.notes[0]
    assert summary(result).count("no Robotarium was made") == 1
    data = json.loads((tmp_path / "out" / "report.json").read_text())
    assert data["notes"] == list(result.notes)


def test_pictures_show_what_the_script_drew(run, tmp_path):
    from matplotlib.image import imread

    run("plot_on_axes.py", snapshots=(0.0, 3.0, float("inf")))
    names = {path.name for path in (tmp_path / "out").iterdir()}
    taken = {f"snapshot-{when}.{kind}" for when in ("0s", "3s", "end") for kind in ("png", "pdf")}
    assert taken <= names
    assert (tmp_path / "out" / "snapshot-0s.pdf").read_bytes().startswith(b"%PDF")
    first, last = (imread(tmp_path / "out" / f"snapshot-{when}.png") for when in ("0s", "end"))
    assert (np.abs(first - last).max(axis=2) > 0.2).sum() > 500, "robots and trails have moved"


@pytest.mark.parametrize("ending", ["gif", "mp4"])
def test_film_has_a_frame_for_every_moment(run, tmp_path, ending):
    if ending == "mp4":
        pytest.importorskip("imageio_ffmpeg")
    result, _, _, _ = run("ids_of_all_kinds.py", video=Path(f"run.{ending}"))
    film = tmp_path / "out" / f"run.{ending}"
    assert film in result.files
    if ending == "gif":
        from PIL import Image

        with Image.open(film) as frames:
            assert frames.n_frames == 2, "0.2 s at ten frames a second"
    else:
        assert film.stat().st_size > 1000


@pytest.mark.parametrize("initial", ["exact", "arrive", "drive"])
@pytest.mark.parametrize("generation", [1, 2])
def test_initial_conditions_can_be_chosen(run, generation, initial):
    result, _, _, log = run("either_generation.py", initial=initial, generation=generation)
    target = np.array([[-0.5, 0.5], [0, 0], [0, 0.0]])
    start = log.poses[-20]
    error = np.hypot(*(start - target)[:2]).max()
    assert (error == 0) == (initial == "exact")
    assert error <= {"exact": 0, "arrive": 0.05, "drive": 0.02}[initial]
    assert (result.reports[0].steps > 20) == (initial == "drive")
    assert result.clean


def test_process_is_left_as_it_was(run):
    import time

    before = (Path.cwd(), list(sys.path), sys.argv, time.sleep, time.time, set(sys.meta_path))
    random_state = np.random.get_state()[1].copy()  # noqa: NPY002
    run("generation2_sensors.py")
    assert before == (
        Path.cwd(), list(sys.path), sys.argv, time.sleep, time.time, set(sys.meta_path),
    )  # fmt: skip
    assert (np.random.get_state()[1] == random_state).all()  # noqa: NPY002
    assert not hasattr(np, "mat")
    assert "rps" not in sys.modules


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"timeout": -1.0}, "timeout is -1 s, expected more than 0"),
        ({"timeout": 0.0}, "timeout is 0 s, expected more than 0; leave it out for none"),
        ({"timeout": float("nan")}, "timeout is nan s"),
        ({"snapshots": (0.0, -5.0)}, "snapshot at -5 s, expected 0 or more seconds"),
        ({"snapshots": (float("nan"),)}, "snapshot at nan s"),
        ({"seed": -1}, "seed is -1, expected a whole number from 0"),
    ],
)
def test_impossible_settings_are_refused(settings, message):
    with pytest.raises(SettingsError, match=message):
        RunSettings(**settings)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--timeout", "-1"], "timeout is -1 s"),
        (["--timeout", "0"], "timeout is 0 s"),
        (["--snapshot", "-5"], "snapshot at -5 s"),
        (["--snapshot", "soon"], "expected seconds, e.g. 0,10,end"),
        (["--seed", "-1"], "seed is -1"),
    ],
)
def test_impossible_options_are_no_fault_of_the_script(tmp_path, options, message):
    script, out = tmp_path / "s.py", tmp_path / "out"
    script.write_text("print('never')")
    result = CliRunner().invoke(app, ["run", *options, "-o", str(out), str(script)])
    assert isinstance(result.exception, PosflockError)
    assert message in str(result.exception)
    assert not out.exists()


def test_script_that_is_none(tmp_path):
    with pytest.raises(ScriptError, match="No such file"):
        run_script(tmp_path / "nothing.py")
    (tmp_path / "text.py").write_text("once upon a time")
    with pytest.raises(ScriptError, match="line 1: not valid Python"):
        run_script(tmp_path / "text.py")


@pytest.mark.skipif(sys.platform == "win32", reason="folders have no locks there")
def test_two_runs_at_once_do_not_write_into_one_folder(tmp_path):
    shutil.copy(SCRIPTS / "runs_forever.py", tmp_path)
    command = [sys.executable, "-m", "posflock_robotarium", "run", "--headless"]

    def begin(*options):
        return subprocess.Popen(
            [*command, *options, "runs_forever.py"],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    first = begin("--timeout", "600")  # it is killed long before, however busy the machine
    try:
        while not (tmp_path / "runs/runs_forever/poses.npy").exists():
            assert first.poll() is None
            time.sleep(0.05)
        second = begin("--timeout", "0.5")
        printed, _ = second.communicate(timeout=60)
        assert "runs/runs_forever-2: " in printed
        assert (tmp_path / "runs/runs_forever-2/report.txt").exists()
        third = begin("--timeout", "0.5", "-o", "runs/runs_forever")
        _, said = third.communicate(timeout=60)
        assert third.returncode == 2
        assert "another run is writing into this folder; choose another (-o)" in said
        assert not (tmp_path / "runs/runs_forever/report.txt").exists()
    finally:
        first.kill()
        first.communicate()
    assert begin("--timeout", "0.5").communicate(timeout=60)[0].count("runs/runs_forever: ")
