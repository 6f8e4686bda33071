"""The pose log holds every step, whatever ends the process."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from posflock_robotarium.flocking.errors import LogError, OutputError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.readers import read_pose_log


def fill(log, rows, robots=3):
    for k in range(log.rows, log.rows + rows):
        log.append(0.033 * k, np.full((3, robots), k), np.full((2, robots), -k), status="optimal")


def test_what_is_written_is_read_by_plain_numpy(tmp_path):
    with PoseLog(tmp_path / "run", 3, 10, {"seed": np.int64(7)}) as log:
        fill(log, 4)
    rows = np.load(tmp_path / "run.npy", allow_pickle=False)
    assert rows["t"].tolist() == [0.0, 0.033, 0.066, 0.099]
    assert rows["pose"].shape == (4, 3, 3)
    description = json.loads((tmp_path / "run.json").read_text())
    assert description["seed"] == 7
    assert description["ended"] == {"how": "finished", "reason": "", "rows": 4}
    back = read_pose_log(tmp_path / "run")
    assert back.commands.shape == (4, 2, 3)
    assert back.status.tolist() == ["optimal"] * 4
    assert back.robots == 3


def test_a_log_grows_beyond_what_was_asked_for(tmp_path):
    with PoseLog(tmp_path / "run.npy", 2, 3) as log:
        fill(log, 25, robots=2)
    back = read_pose_log(tmp_path / "run.json")
    assert np.array_equal(back.poses[:, 0, 0], np.arange(25))


def test_without_a_certificate_nobody_knows_what_it_did(tmp_path):
    with PoseLog(tmp_path / "run", 2, 3) as log:
        for t in (0.0, 0.033):
            log.append(t, np.zeros((3, 2)), np.zeros((2, 2)))
    rows = np.load(tmp_path / "run.npy")[:2]
    assert rows["status"].tolist() == ["", ""]
    assert np.isnan(rows["intervention"]).all()
    back = read_pose_log(tmp_path / "run")
    assert back.status is back.intervention is back.clearance is None


def test_a_killed_process_has_lost_nothing(tmp_path):
    script = """
import sys, time
import numpy as np
from posflock_robotarium.flocking.pose_log import PoseLog
log = PoseLog(sys.argv[1], 4, 100000)
for k in range(100000):
    log.append(0.033 * k, np.full((3, 4), k), np.full((2, 4), k))
    if k == 500:
        print("go", flush=True)
"""
    child = subprocess.Popen(
        [sys.executable, "-c", script, str(tmp_path / "run")], stdout=subprocess.PIPE, text=True
    )
    assert child.stdout.readline() == "go\n"
    time.sleep(0.01)
    os.kill(child.pid, signal.SIGKILL)
    child.wait()
    child.stdout.close()
    log = read_pose_log(tmp_path / "run")
    assert len(log.t) > 500
    assert np.array_equal(log.poses[:, 0, 0], np.arange(len(log.t)))
    assert log.parameters["ended"]["how"] == "running"


def test_rows_that_a_killed_run_did_not_reach_hold_nothing(tmp_path):
    log = PoseLog(tmp_path / "run", 2, 3)
    fill(log, 4, robots=2)  # it has grown to six
    rows = np.load(tmp_path / "run.npy")
    assert len(rows) == 6
    for name in ("t", "pose", "command", "intervention", "clearance"):
        assert np.isnan(rows[name][4:]).all()
    assert np.isfinite(rows["pose"][:4]).all()
    log.close()
    assert len(np.load(tmp_path / "run.npy")) == 4


def test_a_second_run_does_not_get_the_file_of_one_that_goes_on(tmp_path):
    first = PoseLog(tmp_path / "run", 2, 100)
    fill(first, 3, robots=2)
    with pytest.raises(OutputError, match="another run is writing it; choose another folder"):
        PoseLog(tmp_path / "run", 2, 5)
    second = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys; from posflock_robotarium.flocking.pose_log import PoseLog\n"
            "PoseLog(sys.argv[1], 2, 5)",
            str(tmp_path / "run"),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "another run is writing it" in second.stderr
    fill(first, 3, robots=2)
    first.close()
    assert len(read_pose_log(tmp_path / "run").t) == 6
    with PoseLog(tmp_path / "run", 2, 5) as again:
        fill(again, 2, robots=2)
    assert len(np.load(tmp_path / "run.npy")) == 2


def test_an_earlier_runs_description_does_not_describe_the_next(tmp_path, monkeypatch):
    with PoseLog(tmp_path / "run", 2, 5, {"seed": 1}) as log:
        fill(log, 2, robots=2)

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(PoseLog, "_describe", interrupted)
    with pytest.raises(KeyboardInterrupt):
        PoseLog(tmp_path / "run", 3, 5)
    assert not (tmp_path / "run.json").exists()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_forked_process_does_not_write_into_it(tmp_path):
    with PoseLog(tmp_path / "run", 2, 5) as log:
        fill(log, 1, robots=2)
        child = os.fork()
        if child == 0:
            try:
                fill(log, 1, robots=2)
            except LogError:
                log.close("failed", "in the child")
                os._exit(7)
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
        fill(log, 1, robots=2)
    back = read_pose_log(tmp_path / "run")
    assert back.parameters["ended"] == {"how": "finished", "reason": "", "rows": 2}


def test_rows_outlive_their_folder(tmp_path):
    with PoseLog(tmp_path / "out/run", 2, 10) as log:
        fill(log, 3, robots=2)
        shutil.rmtree(tmp_path / "out")
        fill(log, 2, robots=2)
    assert len(read_pose_log(tmp_path / "out/run").t) == 5
    with PoseLog(tmp_path / "out/run", 2, 10) as log:
        fill(log, 3, robots=2)
        shutil.rmtree(tmp_path / "out")
        with PoseLog(tmp_path / "out/run", 2, 10) as other:
            fill(other, 2, robots=2)
    first = read_pose_log(tmp_path / "out/run")
    assert len(first.t) == 2
    assert first.parameters["ended"]["rows"] == 2  # its description is its own
    assert len(read_pose_log(tmp_path / "out/run-2").t) == 3


def test_a_full_disk_costs_no_finished_row(tmp_path):
    """A limit on the size of files fails at the same call as a full disk does."""
    script = """
import resource, signal, sys
import numpy as np
from posflock_robotarium.flocking.pose_log import PoseLog
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
with PoseLog(sys.argv[1], 2, 64) as log:
    for k in range(1000):
        log.append(0.033 * k, np.full((3, 2), k), np.full((2, 2), k))
"""
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "run")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "OutputError: cannot write the pose log" in done.stderr
    assert "the rows before are kept" in done.stderr
    back = read_pose_log(tmp_path / "run")
    assert np.array_equal(back.poses[:, 0, 0], np.arange(128))
    assert back.parameters["ended"]["how"] == "failed"
    with pytest.raises(OutputError, match="cannot write the pose log"):
        PoseLog("/dev/full/run", 2, 5)


def test_an_interrupt_is_recorded(tmp_path):
    def interrupted_run():
        with PoseLog(tmp_path / "run", 3, 5) as log:
            fill(log, 2)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted_run()
    ended = read_pose_log(tmp_path / "run").parameters["ended"]
    assert ended["how"] == "interrupted"
    assert ended["rows"] == 2


def test_an_error_is_recorded_with_its_words(tmp_path):
    def failing_run():
        with PoseLog(tmp_path / "run", 3, 5) as log:
            fill(log, 2)
            raise ZeroDivisionError("by nothing")

    with pytest.raises(ZeroDivisionError):
        failing_run()
    assert (
        read_pose_log(tmp_path / "run").parameters["ended"]["reason"]
        == "ZeroDivisionError: by nothing"
    )


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"cannot write the pose log .*run\.npy"):
        PoseLog(tmp_path / "file" / "run", 3, 5)


@pytest.mark.parametrize("arguments", [(0, 5), (3, 0), (2.5, 5), (-1, 5)])
def test_sizes_that_mean_nothing_are_refused(tmp_path, arguments):
    with pytest.raises(ParameterError, match="expected a whole number from 1"):
        PoseLog(tmp_path / "run", *arguments)


def test_files_that_are_no_pose_log_are_named(tmp_path):
    with pytest.raises(LogError, match="no such file"):
        read_pose_log(tmp_path / "none")
    np.save(tmp_path / "other.npy", np.zeros(3))
    with pytest.raises(LogError, match="expected rows with the fields t, pose, command"):
        read_pose_log(tmp_path / "other")
    (tmp_path / "cut.npy").write_bytes(b"\x93NUMPY\x01\x00")
    with pytest.raises(LogError, match="not a NumPy file"):
        read_pose_log(tmp_path / "cut")


def test_a_log_tells_its_time_step_and_neighbour_radius(tmp_path):
    with PoseLog(tmp_path / "run", 1, 3, {"neighbour_radius": 0.75}) as writer:
        for t in (0.0, 0.033, 0.066, 0.5):  # the median is blind to one slow step
            writer.append(t, np.zeros((3, 1)), np.zeros((2, 1)))
    log = read_pose_log(tmp_path / "run")
    assert log.step == pytest.approx(0.033)
    assert log.neighbour_radius() == 0.75
    assert log.neighbour_radius(0.4) == 0.4


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ({}, "give it in metres"),
        ({"neighbour_radius": -1.0}, "above 0"),
        ({"neighbour_radius": "far"}, "'far'; expected metres"),
    ],
)
def test_a_log_without_a_sound_radius_asks_for_it(tmp_path, said, reason):
    with PoseLog(tmp_path / "run", 1, 1, said) as writer:
        for t in (0.0, 0.033):
            writer.append(t, np.zeros((3, 1)), np.zeros((2, 1)))
    log = read_pose_log(tmp_path / "run")
    with pytest.raises(LogError, match=reason):
        log.neighbour_radius()
