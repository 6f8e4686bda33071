"""What a rehearsal brings back is opened, and a file that cannot be read does not pass."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.submission.environment import Environment
from posflock_robotarium.submission.rehearse import Rehearsal
from posflock_robotarium.submission.returned_files import FileState, ReturnedFile, describe_file
from rps_compat.containment.namespaces import Containment
from rps_compat.report import RunReport
from rps_compat.running.outcome import Ended, Failure, Outcome

HERE = Environment(Path(sys.executable), "this one", {})


def write_npy(path):
    np.save(path, np.arange(12.0))


def write_npz(path):
    np.savez(path, a=np.arange(12.0))


def write_mat(path):
    savemat(path, {"a": np.arange(12.0)})


def write_text(path):
    path.write_text('{"a": [1, 2, 3, 4, 5, 6]}\n')


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("a.npy", write_npy),
        ("a.npz", write_npz),
        ("a.mat", write_mat),
        ("a.json", write_text),
        ("a.csv", write_text),
        ("a.txt", write_text),
        ("a.png", write_text),
    ],
)
def test_sound_files_are_readable_and_torn_ones_are_not(tmp_path, name, write):
    path = tmp_path / name
    write(path)
    whole = path.read_bytes()
    assert describe_file(path) == ReturnedFile(FileState.READABLE, f"{len(whole)} bytes")
    # The run was killed while it wrote: after the first half, or before the first byte.
    for kept in ([] if name.endswith(("csv", "txt", "png")) else [len(whole) // 2]) + [0]:
        path.write_bytes(whole[:kept])
        assert describe_file(path) == ReturnedFile(FileState.UNREADABLE, f"{kept} bytes")


@pytest.mark.parametrize("rows", [0, 1, 5])
def test_a_pose_log_is_told_by_its_rows_and_one_without_any_cannot_be_read(tmp_path, rows):
    with PoseLog(tmp_path / "run", 2, 10, {"neighbour_radius": 0.75}) as log:
        for k in range(rows):
            log.append(0.5 * k, np.zeros((3, 2)), np.zeros((2, 2)))
    found = describe_file(tmp_path / "run.npy")
    if rows < 2:
        assert found.state is (FileState.READABLE if rows else FileState.UNREADABLE)
    else:
        assert found == ReturnedFile(FileState.POSE_LOG, "2 robots, 5 rows until 2.0 s, finished")
        assert str(found) == "pose log, 2 robots, 5 rows until 2.0 s, finished"
        (tmp_path / "run.json").unlink()
        assert describe_file(tmp_path / "run.npy").about.endswith("until 2.0 s, unknown")


def rehearsal(states=(FileState.READABLE,), pairs=0, **changes):
    report = RunReport(2, 90, 2.97, pairs, 0, 0, pairs, 0.0, ())
    outcome = Outcome(Path("main.py"), 2, Ended.FINISHED, reports=(report,), steps=90)
    files = {f"{k}.npy": ReturnedFile(state, "12 bytes") for k, state in enumerate(states)}
    return Rehearsal(replace(outcome, **changes), Path("back"), files, HERE, Containment.HOOK)


def test_a_rehearsal_passes_by_its_end_its_robots_and_every_file():
    sound, log, torn = FileState.READABLE, FileState.POSE_LOG, FileState.UNREADABLE
    assert rehearsal(()).passed
    assert rehearsal((sound, log)).passed
    for states in ((torn,), (torn, sound), (sound, torn), (log, torn, sound)):
        assert not rehearsal(states).passed
    assert not rehearsal(pairs=1).passed
    for ended in Ended:
        good = ended in (Ended.FINISHED, Ended.IDLE, Ended.OVER_TIME)
        assert rehearsal(ended=ended).passed == good, ended
    assert not rehearsal(ended=Ended.OVER_TIME, error=Failure("ValueError")).passed
    assert rehearsal(ended=Ended.OVER_TIME, error=Failure("KeyboardInterrupt")).passed


def test_its_json_says_of_every_file_what_was_found():
    told = rehearsal((FileState.READABLE, FileState.UNREADABLE)).as_dict()
    assert told["passed"] is False
    assert told["files"] == {
        "0.npy": {"state": "readable", "about": "12 bytes"},
        "1.npy": {"state": "unreadable", "about": "12 bytes"},
    }
