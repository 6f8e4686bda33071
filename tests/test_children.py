"""Robots in the processes that a script starts belong to its run, whatever becomes of these."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rps_compat
from posflock_robotarium.logs.readers import read_pose_log
from posflock_robotarium.logs.recorder import open_pose_log
from rps_compat.children import VARIABLE, names
from rps_compat.children.plan import ChildError
from rps_compat.children.records import Instance, InstanceRecord, Record
from rps_compat.recording import Recording
from rps_compat.report import report_of, report_on
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.session import Session

COMMON = """
import numpy as np
from rps.robotarium import Robotarium

def drive(steps, apart=0.5, speed=0.1, crash=None):
    start = np.array([[-apart, apart], [0, 0], [0, 0]])
    r = Robotarium(number_of_robots=2, show_figure=False, sim_in_real_time=False,
                   skip_initialization=True, initial_conditions=start)
    for k in range(steps):
        r.get_poses()
        r.set_velocities(np.arange(2), np.array([[speed, speed], [0, 0]]))
        r.step()
        if k == crash:
            1 / 0
    return r
"""


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a script beside `common.py`, by `posflock run`."""

    def run(text, *options, arguments=(), **files):
        home = tmp_path / "home"
        home.mkdir(exist_ok=True)
        for name, content in {"common": COMMON, "script": text, **files}.items():
            (home / f"{name}.py").write_text(content)
        command = [
            Path(sys.executable).with_name("posflock"),
            "run",
            "--headless",
            "--generation",
            "2",
        ]
        command += ["-o", tmp_path / "out", *options, home / "script.py", *arguments]
        done = subprocess.run(command, cwd=home, capture_output=True, text=True, check=False)
        data = json.loads((tmp_path / "out" / "report.json").read_text())
        return done, data, {r["process"]: r for r in data["reports"]}

    return run


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


def notes_on_children(data):
    """The notes of a run without those on its time."""
    return [n for n in data["notes"] if "in real time" not in n and "ends every run" not in n]


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_robots_in_pools(run, tmp_path, method):
    done, data, _ = run(POOLS, "--seed", "1", arguments=[method])
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
    again, _, _ = run(POOLS, "--seed", "1", arguments=[method])
    # Which of two processes a pool gives its task to is its own affair; an executor has one here.
    assert again.stdout.splitlines()[1:3] == lines[1:3]
    assert "Robotarium 2 (process-" in done.stdout


ENDS = """
import multiprocessing as mp, os, signal, subprocess, sys
from common import *

def crash():
    drive(20, crash=10)

def for_ever(started):
    r = drive(1, apart=0.06, speed=0.3)
    while True:
        r.get_poses()
        r.set_velocities(np.arange(2), np.array([[0.3, 0.3], [0, 0]]))
        r.step()
        if r._arena.steps == 500:
            started.set()

def nested():
    inner = mp.get_context("fork").Process(target=drive, args=(4,))
    inner.start()
    inner.join()

if __name__ == "__main__":
    context = mp.get_context("fork")
    def start(target, *arguments):
        process = context.Process(target=target, args=arguments)
        process.start()
        return process
    process = start(crash)
    process.join()
    print("crashed", process.exitcode)
    for end in ("terminate", "kill"):
        started = context.Event()
        process = start(for_ever, started)
        started.wait()
        getattr(process, end)()
        process.join()
        print(end, process.exitcode)
    start(nested).join()
    for words in ([], [], ["crash"]):
        subprocess.run([sys.executable, "worker.py", *words])
    r = drive(7)
    pid = os.fork()
    if pid:
        os.waitpid(pid, 0)
        drive(9)
    r.get_poses()
    r.step()
    if not pid:
        drive(2)
        print("the child comes to the end")
    else:
        start(drive, 11)  # and wait for it not
"""
WORKER = """
import sys
from common import *
if __name__ == "__main__":
    drive(12, crash=10 if sys.argv[1:] else None)
"""


def test_every_end_of_a_child_leaves_all_that_it_did(run, tmp_path):
    done, data, by_process = run(ENDS, worker=WORKER)
    assert done.returncode == 0, done.stderr
    for line in ("crashed 1", "terminate -15", "kill -9", "the child comes to the end"):
        assert done.stdout.splitlines().count(line) == 1
    assert done.stdout.count("generation 2, finished") == 1, "the run is reported once"
    steps = [(r["process"], r["steps"]) for r in data["reports"] if r["steps"] < 100]
    assert steps == [
        ("", 8), ("", 9), ("fork-1", 8), ("fork-1", 2), ("process-1", 11), ("process-4.1", 4),
        ("process-5", 11), ("worker-1", 12), ("worker-2", 12), ("worker-3", 11),
    ]  # fmt: skip
    for process in ("process-2", "process-3"):
        report, log = by_process[process], read_pose_log(tmp_path / "out" / f"poses-{process}.npy")
        assert log.parameters["ended"]["how"] == "running"
        assert report["steps"] >= 500
        assert len(log.t) - report["steps"] in (0, 1), "it may be killed between log and record"
        # Nothing is lost: too close from the first step to the last, and all of them too fast.
        assert report["steps_too_close"] == report["steps_over_actuator_limits"] == report["steps"]
        collision = next(f for f in report["faults"] if f["kind"] == "collision")
        assert collision["end"] == pytest.approx(0.033 * (report["steps"] - 1))
    assert not data["clean"]
    assert notes_on_children(data) == [
        "fork-1 drove on a copy of a Robotarium that its parent had made: what that had done "
        "before is told of both",
        "process-1 failed: ZeroDivisionError: division by zero",
        *(
            f"process-{k} was ended while its robots drove: what is told of it ends with a step "
            "that it may not have finished"
            for k in (2, 3)
        ),
        "worker-3 failed: ZeroDivisionError: division by zero",
    ]
    # The parent's own log is not written into by its children, and theirs goes on with the row
    # after the fork.
    logs = {
        p: np.load(tmp_path / "out" / f"poses{p}.npy")["t"] for p in ("", "-fork-1", "-fork-1-2")
    }
    assert [np.isfinite(times).sum() for times in logs.values()] == [8, 1, 2]
    assert logs["-fork-1"][0] == pytest.approx(7 * 0.033)
    assert "rps_compat" not in done.stderr, "tracebacks are the script's own"
    assert not list(Path("/tmp").glob("posflock-run-*/fork-1.process"))


LEFT = """
import multiprocessing as mp, subprocess, sys
from concurrent.futures import ProcessPoolExecutor
from common import *

def for_ever(steps):
    r = drive(steps)
    while True:
        r.get_poses()
        r.step()

if __name__ == "__main__":
    context = mp.get_context("fork")
    if sys.argv[1:]:
        subprocess.Popen([sys.executable, "worker.py"])
        with context.Pool(1) as pool:
            pool.map(for_ever, [3])
    executor = ProcessPoolExecutor(1, mp_context=context)
    executor.submit(drive, 5)
    pool = context.Pool(1)
    pool.apply(len, ["abc"])
    manager = context.Manager()
    context.Process(target=for_ever, args=[4], daemon=True).start()
"""


def test_what_a_script_leaves_running_is_ended_or_waited_for_as_python_does(run):
    done, _, by_process = run(LEFT)
    assert done.returncode == 0, done.stderr
    assert by_process["process-1"]["steps"] == 5


def test_the_time_limit_ends_children(run):
    worker = "from common import *\nr = drive(1)\nwhile True:\n    r.get_poses()\n    r.step()\n"
    done, data, by_process = run(LEFT, "--timeout", "8", arguments=["all"], worker=worker)
    assert done.returncode == 124
    assert {*by_process} == {"process-1", "worker-1"}
    assert [note.partition(":")[0] for note in notes_on_children(data)] == [
        "process-1 was ended while its robots drove", "worker-1 was ended while its robots drove",
    ]  # fmt: skip
    assert by_process["process-1"]["steps"] > 3


def test_a_simulator_beside_the_script_and_files_that_hide_modules(run, tmp_path):
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


# --- In this process ---------------------------------------------------------------------------


def script_in(folder, text):
    (folder / "common.py").write_text(COMMON)
    script = folder / "script.py"
    script.write_text(text)
    return script


def test_what_cannot_be_handed_on_is_refused_where_it_is_needed(tmp_path):
    script = script_in(
        tmp_path,
        "import subprocess, sys\nfrom common import *\nif __name__ == '__main__' and "
        "not sys.argv[1:]:\n    drive(2)\n    code = 'from common import *; drive(1)'\n"
        "    print(subprocess.run([sys.executable, '-c', code], capture_output=True).stderr)\n",
    )
    told = []

    def open_log(path, robots, about):
        told.append(robots)
        return open_pose_log(path, robots, about)

    settings = RunSettings(
        headless=True, generation=2, recorder=open_log, out=tmp_path / "out", seed=1
    )
    import contextlib
    import io

    with contextlib.redirect_stdout(io.StringIO()) as said:
        result = run_script(script, (), settings)
    assert result.ended == "finished"
    assert told == [2], "the script's own process has its log"
    assert ChildError.__name__ in said.getvalue()
    assert "give RunSettings a recorder that stands in a module" in said.getvalue()
    assert [report.process for report in result.reports] == [""]


def test_the_environment_is_left_as_it_was(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "somewhere")
    script = script_in(
        tmp_path,
        f"import os\nprint(os.environ['PYTHONPATH'])\nassert os.environ['{VARIABLE}']\n",
    )
    result = run_script(script, (), RunSettings(headless=True, generation=1))
    assert result.ended == "finished", result.reason
    assert os.environ["PYTHONPATH"] == "somewhere"
    assert VARIABLE not in os.environ


def test_a_record_is_true_after_every_step(tmp_path):
    from rps_compat.arena import Arena

    arena = Arena(np.array([[0, 0.1, 1.0], [0, 0, 0.99], [0, 0, np.pi / 2]]))
    instance = Instance("process-1", 1, 3, "")
    record = InstanceRecord(tmp_path, instance)

    class Recorder:
        def append(self, time, poses, commands):
            record.update(arena)
            now = Record.read(tmp_path, instance)
            expected = report_of(3, arena.steps + 1, now.time_step, arena.violations)
            assert report_of(3, now.steps, now.time_step, now.found) == expected
            assert not now.over

    arena.recorder = Recorder()
    for k in range(60):
        arena.commands = np.array([[0.1, 0.4 if k % 7 < 3 else 0.2, 0.1], [0, 0.5 * (k % 3), 0]])
        arena.step()
        if k == 40:
            arena.forget_violations()
    assert len(arena.violations.events) > 4
    arena.check()
    record.close(arena)
    last = Record.read(tmp_path, instance)
    assert report_of(3, last.steps, last.time_step, last.found) == report_on(arena)
    assert last.over


def test_names_and_random_numbers_differ_between_all_processes():
    script = names.Name()
    pool = [script.of_multiprocessing((k,)) for k in (1, 2)]
    below = [pool[0].of_multiprocessing((1, 1)), pool[0].of_fork(1, (1,)), script.of_fork(1, ())]
    started = [next(script.of_script("dir/my worker.py")), next(pool[0].or_similar())]
    found = [script, *pool, *below, started[0]]
    assert [name.text for name in found] == [
        "", "process-1", "process-2", "process-1.1", "process-1.fork-1", "fork-1", "my_worker-1",
    ]  # fmt: skip
    assert len({name.entropy for name in found}) == len(found)
    drawn = set()
    for name in found:
        session = Session(seed=5, process=name.entropy)
        drawn |= {session.generator().random(), session.generator().random()}
        names.seed_generators(5, name.entropy)
        drawn.add(np.random.rand())  # noqa: NPY002
    assert len(drawn) == 3 * len(found)


def test_a_name_is_given_once(tmp_path):
    wanted = names.Name("process-1", (1,))
    given = [names.claim(tmp_path, wanted.or_similar()).text for _ in range(3)]
    assert given == ["process-1", "process-1+2", "process-1+3"]
    workers = [names.claim(tmp_path, names.Name().of_script("w.py")).text for _ in range(2)]
    assert workers == ["w-1", "w-2"]


def test_logs_of_one_process_do_not_take_each_others_files(tmp_path):
    recording = Recording(
        tmp_path, open_pose_log, {}, lambda seconds: None, name=lambda: "process-1"
    )
    other = Recording(tmp_path, open_pose_log, {}, lambda seconds: None, name=lambda: "process-1.1")
    for one in (recording, recording, other):
        one.watch(1)
    assert len(recording.close("finished", "")) == 4
    assert len(other.close("finished", "")) == 2
