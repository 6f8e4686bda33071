"""Robots in the processes that a script starts belong to its run, however they were started."""

import os
import subprocess
import sys

import pytest
from scripts_with_children import COMMON, notes_on_children, run

import rps_compat
from posflock_robotarium.logs.readers import read_pose_log

POOLS = """
import multiprocessing as mp, sys, threading
from concurrent.futures import ProcessPoolExecutor
from common import *

class Item:
    def __init__(self, value):
        self.value = value

def work(item):
    r = drive(item.value)
    return Item(item.value + np.random.rand()), __name__, Robotarium.__module__

if __name__ == "__main__":
    context = mp.get_context(sys.argv[1])
    with context.Pool(2) as pool:
        found = [pool.apply(work, [Item(5)])]
    with ProcessPoolExecutor(1, mp_context=context) as executor:
        found += executor.map(work, [Item(6), Item(7)])
    for item, name, module in found:
        print(round(item.value, 9), name, module)
    drive(3)
"""


@pytest.mark.parametrize(
    "method", ["fork", "spawn", pytest.param("forkserver", marks=pytest.mark.slow)]
)
def test_robots_in_pools(tmp_path, method):
    done, data, _ = run(tmp_path, POOLS, "--seed", "1", arguments=[method])
    assert done.returncode == 0, done.stderr
    steps = [(r["process"][:8], r["steps"]) for r in data["reports"]]
    assert steps == [("", 3), ("process-", 5), ("process-", 6), ("process-", 7)]
    assert notes_on_children(data) == []
    logs = [name for name in data["files"] if name.endswith(".npy")]
    assert len(logs) == len(set(logs)) == 4
    assert sorted(len(read_pose_log(tmp_path / "out" / name).t) for name in logs) == [3, 5, 6, 7]
    for name in logs[1:]:
        about = read_pose_log(tmp_path / "out" / name).parameters
        assert name.startswith(f"poses-{about['process']}")
        assert about["ended"]["how"] == "finished", "although pools end their processes"
        assert about["seed"] == 1
    lines = done.stdout.splitlines()[:3]
    main = "__main__" if method == "fork" else "__mp_main__"
    assert all(line.endswith(f" {main} rps_compat.v2.robotarium") for line in lines)
    drawn = [float(line.split()[0]) % 1 for line in lines]
    assert len(set(drawn)) == 3, "every process and every task has numbers of its own"
    again, _, _ = run(tmp_path, POOLS, "--seed", "1", arguments=[method])
    # Which of two processes a pool gives its task to is its own affair; an executor has one here.
    assert again.stdout.splitlines()[1:3] == lines[1:3]
    assert "Robotarium 2 (process-" in done.stdout


def test_children_send_the_scripts_own_classes_whoever_imported_multiprocessing_first(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import multiprocessing, sys\n"
        "class Item: pass\n"
        "print(sys.modules['__mp_main__'].Item is Item)\n"
    )
    early = "import multiprocessing; from posflock_robotarium.cli import main; main()"
    command = [sys.executable, "-c", early, "run", "--headless", "-o", "out", script.name]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[0] == "True", done.stderr


def test_a_simulator_beside_the_script_and_files_that_hide_modules(tmp_path):
    (tmp_path / "home" / "rps").mkdir(parents=True)
    (tmp_path / "home" / "rps" / "__init__.py").write_text("raise RuntimeError('not ours')")
    text = """
import multiprocessing as mp
from common import *
if __name__ == "__main__":
    import barrier_certificates
    for method in ("spawn", "forkserver"):
        with mp.get_context(method).Pool(1) as pool:
            print(pool.map(barrier_certificates.work, [barrier_certificates.Item(3)])[0].steps)
"""
    done, _, _ = run(
        tmp_path,
        text,
        queue="NAME = 'script'",
        types="",
        selectors="",
        barrier_certificates="""
from common import *
class Item:
    def __init__(self, steps):
        self.steps = steps
def work(item):
    import queue
    return Item(f"{queue.NAME} {drive(item.steps)._arena.steps}")
""",
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[:2] == ["script 3", "script 3"]


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_children_under_plain_python(tmp_path, method):
    for name, text in (("common", COMMON), ("script", POOLS)):
        (tmp_path / f"{name}.py").write_text(text)
    environment = {**os.environ, "PYTHONPATH": str(rps_compat.import_path(2))}
    command = [sys.executable, "script.py", method]
    out = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    ).stdout
    assert out.count("rps_compat.v2.robotarium") == 3
