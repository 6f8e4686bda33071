"""Windows and macOS, simulated: neither is here to run on. docs/reference/systems.md says what is.

Beside these: streams of cp1252 and ASCII (`test_shell`), processes that are spawned
(`test_workers`, `test_children`), systems and disks without locks (`test_file_lock`), names of an
upload that differ in case alone (`test_bundle`).
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from posflock_robotarium.flocking import row_file
from posflock_robotarium.flocking.pose_log import PoseLog

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = """
import numpy as np
from rps.robotarium import Robotarium
r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for k in range(40):
    r.get_poses()
    r.set_velocities([0], np.array([[0.1], [0.1]]))
    r.step()
print("γ = 1")
r.debug()
"""


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="looks there for open files")
def test_commands_need_nothing_that_windows_lacks(tmp_path):
    home = tmp_path / "Müller γ"  # cp1252 has no γ
    home.mkdir()
    (home / "turning.py").write_text(SCRIPT, encoding="utf-8")
    commands = [
        "run --initial exact -o run turning.py",
        "report run/poses.npy -o page --no-figures",
        "new mine",
        "convert run/poses.npy --to csv -o poses.csv",
        "bundle turning.py -o upload",
        "verify turning.py -n 1",
    ]
    done = subprocess.run(
        [sys.executable, str(ROOT / "tests/as_on_windows.py"), *" --then ".join(commands).split()],
        cwd=home, env=os.environ | {"PYTHONIOENCODING": "cp1252"},
        capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode("cp1252")
    told = re.findall(rb"^(\w+) .*: ended with (\d+)$", done.stdout.replace(b"\r", b""), re.M)
    assert dict(told) == {
        b"run": b"0", b"report": b"0", b"new": b"0", b"convert": b"0", b"bundle": b"0",
        b"verify": b"2",
    }, done.stderr.decode("cp1252")  # fmt: skip
    assert b"use Linux, macOS or, on Windows, WSL" in done.stderr
    assert b"Traceback" not in done.stderr
    assert len(np.load(home / "run/poses.npy")) == 40
    assert "γ" in (home / "page/report.html").read_text(encoding="utf-8")


def test_a_log_is_whole_where_no_open_file_can_be_moved(tmp_path, monkeypatch):
    monkeypatch.setattr(row_file, "KNOWN", False)
    with PoseLog(tmp_path / "log", 2, 3) as log:  # grows, too
        for k in range(20):
            log.append(0.033 * k, np.full((3, 2), float(k)), command=np.zeros((2, 2)))
    assert np.load(tmp_path / "log.npy")["pose"][:, 0, 0].tolist() == list(range(20))
    assert sorted(path.name for path in tmp_path.glob("*.part")) == []


def test_files_of_the_project_can_lie_on_any_disk():
    told = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    paths = told.stdout.splitlines() or [
        str(path.relative_to(ROOT)) for path in (ROOT / "posflock_robotarium").rglob("*.*")
    ]
    folded: dict[str, str] = {}
    for path in paths:
        assert folded.setdefault(path.casefold(), path) == path  # macOS, Windows
        assert not re.search(r'[<>:"|?*\\]|[ .](?=/|$)', path)
        for part in path.split("/"):
            assert not re.fullmatch(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?", part)
        assert len(path) < 150
