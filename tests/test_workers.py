"""Worker processes: one BLAS thread each, and the caller's settings left alone."""

import os
import signal
import subprocess
import sys
import time

import pytest

from posflock_robotarium.flocking.progress import counted
from posflock_robotarium.simulation.workers import THREAD_VARIABLES, local_pool, processors


def test_workers_have_one_thread_and_the_caller_keeps_its_own(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with local_pool(1) as pool:
        seen = [pool.submit(os.getenv, name).result() for name in THREAD_VARIABLES]
    assert seen == ["1"] * len(THREAD_VARIABLES)
    assert os.environ["OPENBLAS_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ
    assert 1 <= processors() <= (os.cpu_count() or 1)


ORPHANING = """
import os, time
from posflock_robotarium.simulation.workers import local_pool
if __name__ == "__main__":
    with local_pool(2) as pool:
        tasks = [pool.submit(time.sleep, 0.2) for _ in range(2)]
        [task.result() for task in tasks]
        pool.submit(time.sleep, 60.0)  # one works on, one waits
        print(*pool._processes, flush=True)
        time.sleep(60.0)
"""


def runs(pid):
    """Tell whether a process lives; one that nobody has waited for yet does not."""
    try:
        os.kill(pid, 0)
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="looks at processes in /proc")
def test_workers_die_with_a_killed_parent(tmp_path):
    """Killed outright, a sweep can tell no one; its workers notice by themselves."""
    script = tmp_path / "orphaning.py"
    script.write_text(ORPHANING)
    parent = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True)
    workers = [int(pid) for pid in parent.stdout.readline().split()]
    assert len(workers) == 2
    assert all(map(runs, workers))
    os.kill(parent.pid, signal.SIGKILL)
    # Not communicate(): orphans hold the pipe open, and waiting for its end would hide them.
    parent.wait()
    parent.stdout.close()
    try:
        deadline = time.monotonic() + 10.0
        while any(map(runs, workers)) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert not any(map(runs, workers))
    finally:
        for pid in filter(runs, workers):
            os.kill(pid, signal.SIGKILL)


def test_progress_tells_each_tenth_once_where_there_is_no_terminal(capsys):
    with counted("working") as progress:
        for done in range(1, 51):
            progress(done, 50)
        progress(50, 50)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("working: 5 of 50")
    assert 10 <= len(lines) <= 11
