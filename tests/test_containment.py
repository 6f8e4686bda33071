"""What a contained process can reach; and that only its watcher's word counts."""

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from posflock_robotarium.submission.bundle import bundle
from posflock_robotarium.submission.environment import Environment
from posflock_robotarium.submission.rehearse import rehearse
from posflock_robotarium.verify.data_files import read_back
from rps_compat.containment.namespaces import (
    VARIABLE,
    Containment,
    ContainmentError,
    contained,
    containment_here,
    own_folders,
    python_folders,
    works,
)
from rps_compat.containment.room import Room
from rps_compat.containment.usage import Allowance
from rps_compat.running.outcome import Ended, Outcome
from rps_compat.running.policy_violations import PolicyKind, PolicyViolation
from rps_compat.running.watching import Listener, Teller

HERE = Environment(Path(sys.executable), "this one", {})
LOOK = """
import json, os, socket, sys
def tried(call, *words):
    try:
        call(*words)
    except OSError as error:
        return type(error).__name__
    return "done"
status = open("/proc/self/status").read()
print(json.dumps({
    "outside": tried(open, sys.argv[1], "w"),
    "inside": tried(open, "inside.txt", "w"),
    "null": tried(open, "/dev/null", "w"),
    "call": tried(socket.create_connection, ("127.0.0.1", int(sys.argv[2]))),
    "kill": tried(os.kill, int(sys.argv[3]), 0),
    "processes": len([name for name in os.listdir("/proc") if name.isdigit()]),
    "tmp": os.listdir("/tmp"),
    "capabilities": int(status.partition("CapEff:")[2].split()[0], 16),
    "folder": os.getcwd(),
    "number": os.getpid(),
}))
"""


@pytest.mark.parametrize("how", [Containment.BUBBLEWRAP, Containment.UNSHARE])
@pytest.mark.parametrize("as_init", [False, True])
def test_a_process_in_namespaces_reaches_its_folder_and_nothing_else(tmp_path, how, as_init):
    if not works(how):
        pytest.skip(f"{how.value} does not work here")
    outside = Path(__file__).with_name("made_outside.txt")
    server = socket.create_server(("127.0.0.1", 0))
    # Python's path may name folders that do not exist: so does that of an editable installation.
    readable = (*python_folders(sys.executable), str(tmp_path / "there is none"))
    room = Room((str(tmp_path),), readable, str(tmp_path), as_init)
    words = [str(outside), str(server.getsockname()[1]), str(os.getpid())]
    command = contained(how, room, [sys.executable, "-I", "-S", "-c", LOOK, *words])
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    server.close()
    seen = json.loads(done.stdout)
    assert not outside.exists()
    assert (tmp_path / "inside.txt").exists()
    # Beside the tests there is nothing to be seen at all, where they lie in a temporary folder.
    assert seen["outside"] in ("OSError", "FileNotFoundError")
    assert (seen["inside"], seen["null"]) == ("done", "done")
    assert seen["call"] in ("ConnectionRefusedError", "OSError")
    assert seen["kill"] == "ProcessLookupError"
    assert seen["processes"] <= 2
    # Of the temporary folder no more than the way to what it was given.
    given = [Path(folder) for folder in (tmp_path, *python_folders(sys.executable))]
    ways = {folder.parts[2] for folder in given if folder.is_relative_to("/tmp")}
    assert set(seen["tmp"]) <= ways
    assert seen["capabilities"] == 0
    assert seen["folder"] == str(tmp_path)
    assert (seen["number"] == 1) == as_init


def test_a_containment_can_be_asked_for_and_is_never_another(monkeypatch):
    monkeypatch.setenv(VARIABLE, "hook")
    assert containment_here() is Containment.HOOK
    monkeypatch.setenv(VARIABLE, "none")
    with pytest.raises(ContainmentError, match=r"expected bubblewrap, unshare, hook, got 'none'"):
        containment_here()
    monkeypatch.setenv(VARIABLE, "bubblewrap")
    monkeypatch.setattr("rps_compat.containment.namespaces.works", lambda how: False)
    with pytest.raises(ContainmentError, match="does not work here"):
        containment_here()


def test_only_lines_that_begin_with_the_word_count(tmp_path):
    ear, mouth = os.pipe()
    listener = Listener(ear, "secret")
    honest = Outcome(tmp_path / "s.py", 2, Ended.FAILED, "it failed", 1)
    forged = json.dumps(Outcome(tmp_path / "s.py", 2, Ended.FINISHED, "", 0).as_dict())
    os.write(mouth, f"outcome {forged}\nwrong outcome {forged}\n\n {{}}\n".encode())
    teller = Teller(mouth, "secret")
    teller.violation(PolicyViolation(PolicyKind.NETWORK, "x"))
    teller.outcome(honest)
    os.write(mouth, f"outcome {forged}".encode())
    os.close(mouth)
    listener.close()
    assert listener.said.ended is Ended.FAILED
    assert [violation.what for violation in listener.violations] == ["x"]


SCRIPT = """\
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, show_figure=False, initial_conditions=np.zeros((3, 1)))
for k in range(9):
    r.get_poses()
    r.step()
r.debug()
"""


def rehearsed(tmp_path, deed):
    script = tmp_path / "one.py"
    script.write_text(SCRIPT.replace("r.debug()", f"r.debug()\n{deed}"))
    bundle(script, tmp_path / "up")
    return rehearse(tmp_path / "up", tmp_path / "back", environment=HERE)


@pytest.mark.parametrize("how", list(Containment))
def test_a_rehearsal_cannot_be_forged_by_a_file_and_writes_nowhere_else(tmp_path, monkeypatch, how):
    if not works(how):
        pytest.skip(f"{how.value} does not work here")
    monkeypatch.setenv(VARIABLE, how.value)
    deed = (
        "import contextlib, os\n"
        "with contextlib.suppress(OSError):\n"
        "    open('../outcome.json', 'w').write('{}')\n"
        "os._exit(0)\n"
    )
    done = rehearsed(tmp_path, deed)
    assert done.containment is how
    assert done.as_dict()["containment"] == how.value
    assert (done.outcome.ended, done.passed) == ("died", False)
    (violation,) = done.outcome.policy_violations
    assert (violation.kind, violation.line) == (PolicyKind.OUTSIDE_WRITE, 11)


def test_a_rehearsal_that_fills_the_disk_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "posflock_robotarium.submission.rehearse._ALLOWANCE",
        Allowance(disk=1 << 20),
    )
    done = rehearsed(
        tmp_path, "for k in range(10 ** 9):\n    open(f'{k}.txt', 'w').write('x' * 9999)"
    )
    assert not done.passed
    assert "files of more than 1 MiB" in done.reason


@pytest.mark.parametrize("ending", [".txt", ".json", ".npz", ".mat"])
def test_a_large_file_costs_its_reader_little_memory(tmp_path, ending):
    path = tmp_path / f"large{ending}"
    size = 80 << 20
    if ending == ".npz":
        np.savez_compressed(path, a=np.zeros(size // 8))
    elif ending == ".mat":
        from scipy.io import savemat

        savemat(path, {"a": np.zeros(size // 8)}, do_compression=True)
    else:
        path.write_text("1" * size)
    program = (
        "import resource, sys\n"
        "from pathlib import Path\n"
        "import numpy, scipy.io\n"
        "from posflock_robotarium.verify.data_files import read_back\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "found = read_back(Path(sys.argv[1]))\n"
        "print(found.readable, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, path], capture_output=True, text=True, check=True
    )
    readable, kibibytes = done.stdout.split()
    assert readable == "True"
    assert int(kibibytes) < 24 << 10


def test_a_torn_archive_is_told_without_being_loaded(tmp_path):
    path = tmp_path / "whole.npz"
    np.savez(path, a=np.arange(1000.0), b=np.ones((3, 2), dtype="i4"))
    assert (read_back(path).readable, read_back(path).values) == (True, 1006)
    content = bytearray(path.read_bytes())
    content[500] ^= 1
    path.write_bytes(content)
    assert not read_back(path).readable


def test_our_packages_can_be_read_where_only_a_hook_knows_of_them():
    import rps_compat

    ours = Path(rps_compat.__file__).resolve().parents[1]
    assert str(ours) in own_folders()
