"""However a script ends, the run ends: at the limit, when all wait for ever, with its threads."""

import json
import subprocess
import sys
import threading
import time

import pytest

from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script

START = """
import threading, time, queue, os, sys
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=1, show_figure=False, skip_initialization=True,
               initial_conditions=np.zeros((3, 1)))
def drive():
    r.get_poses()
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
drive()
"""


@pytest.fixture
def script(tmp_path):
    def script(body):
        path = tmp_path / "s.py"
        path.write_text(START + body)
        return path

    return script


@pytest.fixture
def command(script, tmp_path):
    """Run a script by the command line, in a process of its own; a hang fails."""

    def command(body, limit=None, module="posflock_robotarium"):
        options = [] if limit is None else ["--timeout", str(limit)]
        words = ["run", "--headless", "--json", *options, "-o", tmp_path / "out", script(body)]
        begun = time.monotonic()
        done = subprocess.run(
            [sys.executable, "-m", module, *words],
            capture_output=True,
            stdin=subprocess.DEVNULL,
            text=True,
            timeout=90,
            check=False,
        )
        return done, json.loads(done.stdout), time.monotonic() - begun

    return command


def run(path, **settings):
    return run_script(path, (), RunSettings(headless=True, generation=2, **settings))


def test_threads_are_waited_for_in_simulated_time(script, capsys):
    body = (
        "def late():\n    time.sleep(20)\n    drive()\n    print('late', round(time.time() - t))\n"
        "t = time.time()\nthreading.Thread(target=late).start()\n"
        "threading.Thread(target=lambda: time.sleep(800), daemon=True).start()\n"
    )
    before = threading.active_count()
    result = run(script(body))
    assert (result.ended, result.reports[0].steps) == ("finished", 2)
    assert "late 20" in capsys.readouterr().out
    result = run(script(body + "raise KeyError"))
    assert (result.ended, result.reports[0].steps) == ("failed", 2)
    assert threading.active_count() <= before + 2  # the daemons sleep on in real time


def test_idle_pools_are_dismissed_and_others_are_not(script):
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as ours:
        assert ours.submit(int).result() == 0
        body = (
            "from concurrent.futures import ThreadPoolExecutor, ProcessPoolExecutor\n"
            "pool = ThreadPoolExecutor(2)\n"
            "done = [pool.submit(time.sleep, 5), pool.submit(drive)]\n"
            "other = ProcessPoolExecutor(1)\nassert other.submit(abs, -1).result() == 1\n"
        )
        result = run(script(body))
        assert (result.ended, result.reports[0].steps) == ("finished", 2), result.reason
        assert ours.submit(int, 1).result() == 1


# What waits for ever, and who is named.
FOR_EVER = {
    "main": ("threading.Event().wait()", "the main thread waits at s.py, line 13"),
    "a thread": (
        "threading.Thread(target=threading.Event().wait, name='T').start()",
        "T, started at s.py, line 13, waits in wait()",
    ),
    "a line of the script": (
        "def f():\n    queue.Queue().get()\nthreading.Thread(target=f, name='T').start()",
        "T waits at s.py, line 14",
    ),
    "a loop": ("while True:\n    time.sleep(1)", "no step for 900 s of the run, the main thread"),
    "a loop in a thread": (
        "def f():\n    while True:\n        time.sleep(1)\n"
        "threading.Thread(target=f, name='T').start()",
        "no step for 900 s of the run, T waits at s.py, line 15",
    ),
}


@pytest.mark.parametrize("name", FOR_EVER)
def test_who_waits_for_ever_is_told_where(command, name):
    body, told = FOR_EVER[name]
    done, result, _ = command(body)
    assert (done.returncode, result["ended"]) == (3, "hung")
    assert result["reason"].startswith("waits for ever: ")
    assert told in result["reason"]
    assert result["reports"][0]["steps"] == 1


# Scripts that go on for ever, each in a way that an exception in the main thread does not end.
ENDLESS = {
    "a thread that drives": (
        "def f():\n    while True:\n        drive()\nthreading.Thread(target=f).start()\n"
    ),
    "threads while main hangs in a lock": (
        "def f():\n    while True:\n        time.sleep(0.1); drive()\n"
        "threading.Thread(target=f).start()\n"
        "import _thread\nlock = _thread.allocate_lock()\nlock.acquire(); lock.acquire()\n"
    ),
    "a thread that swallows exceptions": (
        "def f():\n    while True:\n        try:\n            drive()\n"
        "        except BaseException:\n            pass\n"
        "threading.Thread(target=f).start()\ntime.sleep(10**5)\n"
    ),
    "main that swallows exceptions": (
        "while True:\n    try:\n        while True:\n            drive()\n"
        "    except BaseException:\n        pass\n"
    ),
    "main that is lost in C": (
        "import ctypes\nwhile True:\n    ctypes.CDLL(None).sleep(1000)\n"
    ),
    "a process": (
        "import multiprocessing\n"
        "p = multiprocessing.get_context('fork').Process(target=time.sleep, args=(1e9,))\n"
        "def f():\n    while True:\n        pass\n"
        "p = multiprocessing.get_context('fork').Process(target=f)\np.start()\np.join()\n"
    ),
    "an alarm of its own": (
        "import signal\nsignal.signal(signal.SIGALRM, lambda *_: None)\n"
        "signal.setitimer(signal.ITIMER_REAL, 0.1, 0.1)\nwhile True:\n    drive()\n"
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ENDLESS)
def test_the_limit_holds(command, tmp_path, name):
    done, result, seconds = command(ENDLESS[name], limit=1)
    assert done.returncode == 124, done.stderr
    assert (result["ended"], result["exit_code"]) == ("timed out", 124)
    assert "time limit of 1 s" in result["reason"]
    assert seconds < 60
    assert json.loads((tmp_path / "out" / "report.json").read_text())["ended"] == "timed out"
    log = json.loads((tmp_path / "out" / "poses.json").read_text())["ended"]
    assert log["how"] == "interrupted"
    assert log["rows"] >= 1


def test_the_limit_holds_where_python_itself_is_held(script, monkeypatch):
    """Only the kernel ends this; a second run shows that the timer is taken back."""
    program = (
        "import sys\nfrom rps_compat.last_resort import last_resort\n"
        "with last_resort(1, 124): pass\n"
        "import time; time.sleep(1.5); print('taken back', flush=True)\n"
        "with last_resort(1, 124): sum(range(10**12))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False
    )
    if sys.platform == "linux":
        assert (done.stdout, done.returncode) == ("taken back\n", 124)


def test_the_simulator_alone_has_the_same_command(command):
    done, result, _ = command(ENDLESS["a thread that drives"], limit=1, module="rps_compat")
    assert (done.returncode, result["ended"]) == (124, "timed out")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_threads_left_behind_end_with_their_next_step(script):
    body = ENDLESS["a thread that drives"].replace("target=f", "target=f, name='left'")
    result = run(script(body), timeout=0.5)
    assert result.ended == "timed out"
    end = time.monotonic() + 20
    while any(thread.name == "left" for thread in threading.enumerate()):
        assert time.monotonic() < end
        time.sleep(0.01)


def test_what_took_real_time_is_noted_once(script):
    result = run(
        script("import subprocess\nfor k in range(3):\n    subprocess.run(['sleep', '.1'])")
    )
    assert result.notes == ("in real time, since it cannot be simulated: other processes",)
    assert run(script("time.sleep(5)")).notes == ()


def test_the_script_leaves_with_its_own_code(script):
    result = run(script("threading.Thread(target=time.sleep, args=(5,)).start(); sys.exit(7)"))
    assert (result.ended, result.exit_code) == ("failed", 7)
    result = run(script("import signal; signal.alarm(3); time.sleep(10)"))
    assert (result.ended, result.exit_code) == ("failed", 142)
