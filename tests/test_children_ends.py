"""However a child of a script ends, all that its robots did belongs to the run."""

import numpy as np
import pytest
from scripts_with_children import notes_on_children, run

from posflock_robotarium.logs.readers import read_pose_log

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


def test_every_end_of_a_child_leaves_all_that_it_did(tmp_path):
    done, data, by_process = run(tmp_path, ENDS, worker=WORKER)
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
        # The last step may have begun to be told, too: "a step that it may not have finished".
        assert round(collision["end"] / 0.033) - report["steps"] in (-1, 0)
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
    assert "fork-1.process" not in data["left"]


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


def test_what_a_script_leaves_running_is_ended_or_waited_for_as_python_does(tmp_path):
    done, _, by_process = run(tmp_path, LEFT)
    assert done.returncode == 0, done.stderr
    assert by_process["process-1"]["steps"] == 5


def test_the_time_limit_ends_children(tmp_path):
    worker = """
import signal
signal.signal(signal.SIGTERM, signal.SIG_IGN)  # as a library may that ends in its own time
from common import *
r = drive(1)
while True:
    r.get_poses()
    r.step()
"""
    done, data, by_process = run(tmp_path, LEFT, "--timeout", "8", arguments=["all"], worker=worker)
    assert done.returncode == 124
    assert {*by_process} == {"process-1", "worker-1"}
    assert [note.partition(":")[0] for note in notes_on_children(data)] == [
        "process-1 was ended while its robots drove", "worker-1 was ended while its robots drove",
    ]  # fmt: skip
    assert by_process["process-1"]["steps"] > 3


DEAF = """
import multiprocessing as mp, signal, subprocess, sys
from common import *

def for_ever():
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    r = drive(1)
    while True:
        r.get_poses()
        r.step()

if __name__ == "__main__":
    subprocess.Popen([sys.executable, "worker.py"])
    mp.get_context("fork").Process(target=for_ever).start()
    r = drive(1)
    while True:
        r.get_poses()
        r.step()
"""


@pytest.mark.slow  # waits for two limits
def test_a_limit_that_strikes_again_while_children_will_not_end_leaves_none(tmp_path):
    worker = DEAF.replace('    subprocess.Popen([sys.executable, "worker.py"])\n', "").replace(
        'mp.get_context("fork").Process(target=for_ever).start()', "for_ever()"
    )
    done, data, by_process = run(tmp_path, DEAF, "--timeout", "6", worker=worker)
    assert done.returncode == 124
    assert {*by_process} == {"", "process-1", "worker-1"}
    assert all("was ended while its robots drove" in note for note in notes_on_children(data))
