"""The submitted script, run as its users run it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from experiment_here import EXPERIMENT, fly_here

from posflock_robotarium.logs.readers import read_pose_log

ROOT = Path(__file__).resolve().parents[1]


def run(*options, cwd, **kwargs):
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | kwargs.pop("env", {})
    environment.pop("DISPLAY", None)
    environment.pop("MPLBACKEND", None)
    return subprocess.run(
        [sys.executable, str(EXPERIMENT), *options],
        cwd=cwd, env=environment, capture_output=True, text=True, timeout=120, **kwargs,
    )  # fmt: skip


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("short")
    done = run("--duration", "6", "--out", "results", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder, done


def test_a_run_leaves_log_summary_and_figures(short_run):
    folder, done = short_run
    left = sorted(path.name for path in (folder / "results").iterdir())
    figures = [f"{name}.{kind}" for name in ("alignment", "distances", "snapshots")
               for kind in ("pdf", "png")]  # fmt: skip
    assert left == sorted([*figures, "nine_robots.json", "nine_robots.npy", "summary.json"])
    assert [path.name for path in folder.iterdir()] == ["results"]
    summary = json.loads((folder / "results" / "summary.json").read_text())
    assert summary["collisions"] == 0
    assert "alignment γ" in done.stdout
    log = read_pose_log(folder / "results" / "nine_robots")
    assert len(log.t) == 182
    assert log.parameters["seed"] == 0
    assert log.parameters["neighbour_radius"] == 0.75
    assert log.parameters["api_generation"] == 2


def test_without_a_terminal_progress_is_plain_lines(short_run):
    lines = short_run[1].stderr.splitlines()
    assert lines[-1] == "flocking: 6 of 6 s"
    assert len(lines) == 10


def test_another_process_writes_the_same_bytes(short_run, tmp_path):
    assert run("--duration", "6", "--out", "again", cwd=tmp_path).returncode == 0
    for name in ("nine_robots.npy", "nine_robots.json", "summary.json", "snapshots.png"):
        assert (tmp_path / "again" / name).read_bytes() == (
            short_run[0] / "results" / name
        ).read_bytes(), name


@pytest.mark.parametrize("generation", [1, 2])
def test_it_runs_on_either_generation_of_the_api(generation, tmp_path, short_run):
    """`rps` is there, as on the testbed: our stand-in is not asked for."""
    paths = subprocess.run(
        [sys.executable, "-m", "rps_compat", "path", "--generation", str(generation)],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.strip()  # fmt: skip
    env = {"PYTHONPATH": os.pathsep.join([paths, str(ROOT)])}
    done = run("--duration", "6", cwd=tmp_path, env=env)
    assert done.returncode == 0, done.stderr
    log = read_pose_log(tmp_path / "nine_robots")
    assert log.parameters["api_generation"] == generation
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "nine_robots.json",
        "nine_robots.npy",
    ]


def test_a_control_run_is_for_the_simulator_alone(tmp_path):
    fly_here(tmp_path, "--duration", "3", "--certificate", "off")
    assert read_pose_log(tmp_path / "nine_robots").parameters["wheels"]["pair_rows"] is False
    package = tmp_path / "installed" / "rps"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "robotarium.py").write_text("class Robotarium:\n    pass\n")
    path = f"{ROOT}{os.pathsep}{package.parent}"
    refused = run("--certificate", "off", cwd=tmp_path, env={"PYTHONPATH": path})
    assert refused.returncode != 0
    assert "--certificate off lets robots collide" in refused.stderr


def test_an_interrupt_inside_step_ends_cleanly(tmp_path):
    interrupting = f"""
import runpy, sys
import rps_compat
rps_compat.install(generation=2)
import rps.robotarium
step = rps.robotarium.Robotarium.step
def interrupted(self, calls=[0]):
    calls[0] += 1
    if calls[0] == 50:
        raise KeyboardInterrupt
    step(self)
rps.robotarium.Robotarium.step = interrupted
sys.argv = ["main.py"]
runpy.run_path({str(EXPERIMENT)!r}, run_name="__main__")
"""
    done = subprocess.run(
        [sys.executable, "-c", interrupting],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "interrupted: the 50 steps until then are in" in done.stdout
    ended = read_pose_log(tmp_path / "nine_robots").parameters["ended"]
    assert ended["how"] == "interrupted"
    assert "KeyboardInterrupt" in ended["reason"]
    assert ended["rows"] == 50


def test_a_killed_run_keeps_every_step_before(tmp_path, short_run):
    child = subprocess.Popen(
        [sys.executable, str(EXPERIMENT), "--duration", "600"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        time.sleep(0.05)
        # The description is written once the rows have their room.
        begun = (tmp_path / "nine_robots.json").exists()
        if begun and np.isfinite(np.load(tmp_path / "nine_robots.npy")["t"]).sum() > 300:
            break
    os.kill(child.pid, signal.SIGKILL)
    child.communicate()
    log = read_pose_log(tmp_path / "nine_robots")
    assert len(log.t) > 300
    assert np.allclose(np.diff(log.t), 0.033)
    assert np.isfinite(log.poses).all()
    expected = read_pose_log(short_run[0] / "results" / "nine_robots")
    assert np.array_equal(log.poses[:182], expected.poses)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--duration", "nan"], "duration: expected at least one step"),
        (["--out", "file/results"], "cannot write the pose log"),
        (["--walls", "bounce"], "invalid choice: 'bounce'"),
        (["--sed", "3"], "unrecognized arguments: --sed"),
    ],
)
def test_bad_options_are_refused_before_anything_moves(options, words, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    with pytest.raises(SystemExit) as refused:
        fly_here(tmp_path, *options)
    assert refused.value.code
    assert words in f"{refused.value.code} {capsys.readouterr().err}"
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
