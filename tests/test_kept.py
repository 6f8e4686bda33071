"""Nothing that a command started or made outlives it, however it ends."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path

import pytest

from rps_compat.containment import stale_folders
from rps_compat.containment.keeper import ProcessOrder
from rps_compat.containment.kept import KeptFolder, KeptProcess
from rps_compat.containment.usage import Allowance, bytes_in

pytestmark = pytest.mark.skipif(not Path("/proc").exists(), reason="looks at processes in /proc")

#: Makes a folder, and starts processes of all kinds: held, told of the folder, forked.
OWNER = """
import os, signal, subprocess, sys, time
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # ignored where the tests run under nohup
from rps_compat.containment.keeper import ProcessOrder
from rps_compat.containment.kept import KeptFolder, KeptProcess
kept = KeptFolder("test")
(kept.path / "file").write_text("x")
shell = f"setsid sleep 1000 & echo > {kept.path}/held; sleep 1000"
process = KeptProcess(ProcessOrder(["sh", "-c", shell]), cwd="/", env={"A": "held"})
told = os.environ | {"ROOM": str(kept.path)}
subprocess.Popen(["sleep", "1000"], env=told, start_new_session=True)
if os.fork() == 0:
    os.setsid()
    time.sleep(1000)
while not (kept.path / "held").exists():
    time.sleep(0.01)
print("ready", flush=True)
try:
    time.sleep(1000)
finally:
    process.end()
    kept.close()
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Let temporary folders be made here, and processes be known by it."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


def processes_of(pattern):
    """Return running processes whose environment holds a text."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if pattern.encode() in (folder / "environ").read_bytes():
                found.append(int(folder.name))
        except OSError:
            continue
    return set(found) - {os.getpid()}


def soon(is_so):
    deadline = time.monotonic() + 10.0
    while not is_so() and time.monotonic() < deadline:
        time.sleep(0.02)
    return is_so()


@pytest.mark.parametrize("sent", ["SIGTERM", "SIGHUP", "SIGKILL"])
def test_what_a_killed_command_leaves_is_ended_and_removed(place, sent):
    owner = subprocess.Popen(
        [sys.executable, "-c", OWNER], stdout=subprocess.PIPE, start_new_session=True
    )
    assert owner.stdout.readline() == b"ready\n"
    (folder,) = place.iterdir()
    before = processes_of(str(place))
    owner.send_signal(getattr(signal, sent))
    owner.wait(10)
    owner.stdout.close()
    assert len(before) >= 4
    assert soon(lambda: not folder.exists())
    assert soon(lambda: not processes_of(str(place)))


def test_a_folder_is_there_for_its_block_and_no_longer(place):
    with KeptFolder("test") as folder:
        (folder / "deep").mkdir()
        assert folder.parent == place
    assert list(place.iterdir()) == []
    assert soon(lambda: not processes_of(str(place)))


CHILDREN = """
import os
from rps_compat.containment.kept import KeptFolder

with KeptFolder("test"):
    try:
        os.waitpid(-1, os.WNOHANG)
    except ChildProcessError:
        print("none")
"""


def test_the_command_has_no_child_that_it_does_not_know_of(place):
    told = subprocess.run([sys.executable, "-c", CHILDREN], capture_output=True, text=True)
    assert told.stdout == "none\n"


def started(place, shell, **held):
    (place / "work").mkdir(exist_ok=True)
    order = ProcessOrder(
        ["sh", "-c", shell], folder=str(place / "work"), printed=str(place / "said"), **held
    )
    with open(place / "said", "wb") as said:
        return KeptProcess(order, cwd=place / "work", env=os.environ, stdout=said)


def test_the_end_of_a_process_is_told_and_what_it_left_is_ended(place):
    assert started(place, "exit 3").wait().code == 3
    assert started(place, "kill -9 $$").wait().code == -9
    end = started(place, "setsid sleep 1000 & exit 0").wait()
    assert (end.code, end.left, end.timed_out, end.surplus) == (0, True, False, "")
    assert soon(lambda: not processes_of(str(place)))


def test_a_time_limit_holds(place):
    end = started(place, "trap '' INT TERM; while :; do :; done", seconds=0.3).wait()
    assert (end.timed_out, end.code, end.left) == (True, -9, False)


@pytest.mark.parametrize(
    ("shell", "words"),
    [
        ("while :; do echo x; done", "prints more than 1 MiB"),
        ("while :; do head -c 100000 /dev/zero > f$((++k)); done", "files of more than 2 MiB"),
        ("while :; do : > f$((++k)); done", "files of more than 2 MiB"),
        ("while :; do sleep 100 & sleep 0.01; done", "processes at once, at most 5"),
    ],
)
def test_limits_hold_for_all_that_a_process_does_together(place, shell, words):
    allowance = Allowance(output=1 << 20, disk=2 << 20, processes=5)
    shell = "k=0; " + shell.replace("$((++k))", "$((k=k+1))")
    end = started(place, shell, allowance=asdict(allowance)).wait()
    assert words in end.surplus
    assert soon(lambda: not processes_of(str(place)))


def test_a_folder_is_measured_by_what_it_takes_on_disk(tmp_path):
    with open(tmp_path / "holes", "wb") as file:
        file.truncate(1 << 40)
    (tmp_path / "link").symlink_to("/")
    assert bytes_in(tmp_path, 1 << 30) <= 3 * 4096


def test_the_next_start_removes_what_nobody_uses_and_nothing_else(place):
    stale, used, young = (place / stale_folders.new_name("test") for _ in range(3))
    others = place / "posflock-results", place / "posflock-verify-of-mine"
    for folder in (stale, used, young, *others):
        folder.mkdir()
        os.utime(folder, (0, 0))
    os.utime(young)
    held = stale_folders.hold(used)
    stale_folders.sweep(place)
    assert set(place.iterdir()) == {used, young, *others}
    os.close(held)
    stale_folders.sweep(place)
    assert set(place.iterdir()) == {young, *others}
