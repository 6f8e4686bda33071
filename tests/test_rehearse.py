"""A rehearsal isolates the bundle, ends it in time, and brings back what it wrote."""

import os
import re
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.logs.readers import read_pose_log
from posflock_robotarium.submission import environment
from posflock_robotarium.submission.bundle import bundle
from posflock_robotarium.submission.environment import Environment, RehearsalError
from posflock_robotarium.submission.manifest import BundleError
from posflock_robotarium.submission.private_simulator import PRIVATE, lay_simulator
from posflock_robotarium.submission.rehearse import rehearse, report_on
from posflock_robotarium.submission.returned_files import FileState
from posflock_robotarium.verify.static import check_source
from posflock_robotarium.verify.trials import Limits, TrialRoom
from rps_compat.scripts import libraries

EXPERIMENT = Path(__file__).parents[1] / "experiments" / "robotarium_9bot.py"
HERE = Environment(Path(sys.executable), "this one", {})
SCRIPT = """\
import sys
import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, show_figure=False, initial_conditions=np.array(
    [[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
seen = []
try:
    for k in range(90):
        seen.append(r.get_poses())
        r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
        r.step()
finally:
    np.save("poses.npy", np.array(seen))
print("main is", sys.argv, __name__)
r.debug()
"""


def laid(tmp_path, text=SCRIPT):
    script = tmp_path / "two_robots.py"
    script.write_text(text)
    bundle(script, tmp_path / "up")
    return tmp_path / "up"


def test_a_bundle_runs_as_main_and_its_files_come_back(tmp_path):
    done = rehearse(laid(tmp_path), tmp_path / "back", environment=HERE)
    assert (done.outcome.ended, done.outcome.steps) == ("finished", 90)
    assert done.outcome.report.number_of_robots == 2
    assert done.passed
    assert np.load(tmp_path / "back" / "poses.npy").shape == (90, 3, 2)
    assert "main is ['main.py'] __main__" in (tmp_path / "back" / "log.txt").read_text()
    assert {path.name for path in (tmp_path / "back").iterdir()} == {"poses.npy", "log.txt"}
    assert done.files["poses.npy"].state is FileState.READABLE


def test_files_that_cannot_be_opened_do_not_pass(tmp_path):
    up = laid(tmp_path, SCRIPT + "open('torn.npz', 'w').write('not an archive')\n")
    done = rehearse(up, tmp_path / "back", environment=HERE)
    assert done.outcome.ended == "finished"
    assert done.files["torn.npz"].state is FileState.UNREADABLE
    assert not done.passed


def test_the_declared_duration_interrupts_the_run(tmp_path):
    done = rehearse(laid(tmp_path), tmp_path / "back", duration=1.0, environment=HERE)
    assert done.outcome.ended == "over time"
    assert done.passed
    assert done.reason == ""
    assert done.outcome.time == pytest.approx(1.0, abs=0.05)
    assert len(np.load(tmp_path / "back" / "poses.npy")) == 32


def test_the_same_seed_gives_the_same_files(tmp_path):
    up = laid(tmp_path)
    for name in ("one", "two"):
        rehearse(up, tmp_path / name, seed=4, environment=HERE)
    one, two = ((tmp_path / name / "poses.npy").read_bytes() for name in ("one", "two"))
    assert one == two


def test_a_crash_comes_back_with_its_traceback(tmp_path):
    up = laid(tmp_path, SCRIPT.replace("r.debug()", "1 / 0"))
    done = rehearse(up, tmp_path / "back", environment=HERE)
    assert done.outcome.ended == "failed"
    assert not done.passed
    assert done.reason == "main.py, line 16: ZeroDivisionError: division by zero"
    assert "ZeroDivisionError" in (tmp_path / "back" / "log.txt").read_text()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (SCRIPT + "sys.exit('no goals left')\n", r"exit code 'no goals left'"),
        (SCRIPT + "raise ValueError\n", r"main\.py, line 17: ValueError$"),
        (
            SCRIPT + "import json\njson.loads('')\n",
            r"main\.py, line 18: json\.decoder\.JSONDecodeError: Exp",
        ),
        (SCRIPT, "$"),
    ],
)
def test_the_reason_of_the_end_is_told_in_a_line(tmp_path, text, reason):
    done = rehearse(laid(tmp_path, text), tmp_path / "back", environment=HERE)
    assert re.match(reason, done.reason), done.reason


def test_a_module_that_crashes_is_named_with_the_main_files_line(tmp_path):
    (tmp_path / "helper.py").write_text("def halve(x):\n    return x / 0\n")
    up = laid(tmp_path, SCRIPT + "import helper\nhelper.halve(1)\n")
    done = rehearse(up, tmp_path / "back", environment=HERE)
    assert (
        done.reason == "main.py, line 18 (helper.py, line 2): ZeroDivisionError: division by zero"
    )


def test_a_module_that_the_testbeds_python_cannot_read_is_named(tmp_path):
    text = SCRIPT + "open('bad.py', 'w').write('\\nx = (')\n__import__('ba' + 'd')\n"
    done = rehearse(laid(tmp_path, text), tmp_path / "back", environment=HERE)
    assert done.reason.startswith("main.py, line 18 (bad.py, line 2): SyntaxError: ")


def test_there_is_no_network(tmp_path):
    text = SCRIPT + "import socket\nsocket.create_connection(('127.0.0.1', 9), timeout=1)\n"
    done = rehearse(laid(tmp_path, text), tmp_path / "back", environment=HERE)
    assert done.outcome.ended == "failed"
    assert "there is no network" in (tmp_path / "back" / "log.txt").read_text()


def test_a_script_that_hangs_is_ended(tmp_path):
    text = SCRIPT.replace("finally:", "except KeyboardInterrupt:\n    pass\nfinally:").replace(
        "print(", "while True:\n    pass\nprint("
    )
    done = rehearse(laid(tmp_path, text), tmp_path / "back", timeout=6.0, environment=HERE)
    assert done.outcome.ended in ("hung", "timed out")
    assert not done.passed
    assert (tmp_path / "back" / "poses.npy").exists()


def test_bad_requests_are_refused(tmp_path):
    up = laid(tmp_path)
    with pytest.raises(ParameterError, match="duration"):
        rehearse(up, tmp_path / "back", duration=1000.0, environment=HERE)
    with pytest.raises(BundleError, match="holds no MANIFEST"):
        rehearse(tmp_path, tmp_path / "back", environment=HERE)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "x").write_text("mine")
    with pytest.raises(OutputError, match="not empty"):
        rehearse(up, tmp_path / "full", environment=HERE)


def test_without_the_testbeds_python_the_nearest_is_taken_and_said(monkeypatch):
    elsewhere = {(3, 9): Path("nine"), (3, 12): Path("twelve"), (3, 13): Path("thirteen")}
    monkeypatch.setattr(environment, "find_python", elsewhere.get)
    monkeypatch.setattr(environment, "installed_pythons", lambda: elsewhere)
    python, note = environment._nearest_python()
    assert python == Path("twelve")
    assert "3.10, which is not installed" in note
    monkeypatch.setattr(environment, "find_python", {(3, 10): Path("ten")}.get)
    assert environment._nearest_python() == (Path("ten"), "")


def test_an_environment_that_cannot_be_built_says_why_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(environment, "_nearest_python", lambda: (Path("/bin/false"), ""))
    with pytest.raises(RehearsalError, match="cannot build"):
        environment.build_environment(["numpy"])
    assert not list(tmp_path.rglob("ready"))


def test_an_environment_that_is_ready_needs_no_search_and_one_that_is_broken_is_built_anew(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    built = []

    def build(base, folder, python, pins):
        built.append(base)
        python.parent.mkdir(parents=True, exist_ok=True)
        python.unlink(missing_ok=True)
        python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
        python.chmod(0o755)
        (folder / "ready").write_text("")

    monkeypatch.setattr(environment, "_build", build)
    monkeypatch.setattr(environment, "_BASE", ("numpy",))
    monkeypatch.setattr(environment, "_nearest_python", lambda: (Path("ten"), ""))
    first = environment.build_environment(["numpy"])
    monkeypatch.setattr(environment, "_nearest_python", lambda: pytest.fail("searched"))
    assert environment.build_environment(["numpy"]) == first
    first.python.write_text("#!/bin/sh\nexit 1\n")
    monkeypatch.setattr(environment, "_nearest_python", lambda: (Path("ten"), ""))
    assert environment.build_environment(["numpy"]) == first
    assert built == [Path("ten"), Path("ten")]


def test_the_simulator_goes_by_a_private_name(tmp_path):
    lay_simulator(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(PRIVATE.values())
    text = "\n".join(path.read_text() for path in tmp_path.rglob("*.py"))
    assert not re.findall(r"^\s*(?:from|import) (?:rps_compat|barrier_certificates)\b", text, re.M)


def unbundled(generation=2):
    """Return the log of the experiment as it lies in the repository."""
    _, source = check_source(EXPERIMENT)
    with TrialRoom(source, generation, Limits()) as room:
        (ran,) = room.run([room.plan("here")])
        return read_pose_log(ran.scratch / "nine_robots.npy")


@pytest.mark.slow
@pytest.mark.parametrize("generation", [2, 1])
def test_the_experiments_bundle_repeats_the_unbundled_run(tmp_path, generation):
    bundle(EXPERIMENT, tmp_path / "up")
    done = rehearse(
        tmp_path / "up",
        tmp_path / "back",
        profile="ideal",
        initial="exact",
        generation=generation,
    )
    assert done.passed
    versions = done.environment.libraries
    if not done.environment.note:
        assert done.environment.version.startswith("3.10.")
    assert {n: versions[n] for n in ("numpy", "scipy", "matplotlib", "cvxopt")} == {
        n: libraries.LIBRARIES[n] for n in ("numpy", "scipy", "matplotlib", "cvxopt")
    }
    site = next(done.environment.python.parents[1].glob("lib/python*/site-packages"))
    there = {name.lower() for name in os.listdir(site)}
    assert not there & {"osqp", "cvxpy", "clarabel", "typer", "rich", "posflock_robotarium"}
    back = read_pose_log(tmp_path / "back" / "nine_robots.npy")
    here = unbundled(generation)
    assert np.abs(back.poses - here.poses).max() <= 1e-9
    assert np.abs(back.commands - here.commands).max() <= 1e-9
    assert report_on(done).exists()


def test_ends_although_the_script_left_processes_running_that_hold_its_output(tmp_path):
    text = SCRIPT + (
        "import subprocess, sys\n"
        "sleep = [sys.executable, '-c', 'import time; time.sleep(20)']\n"
        "open('left.txt', 'w').write(str(subprocess.Popen(sleep).pid))\n"
        "subprocess.Popen(sleep, start_new_session=True)\n"
    )
    begun = time.monotonic()
    done = rehearse(laid(tmp_path, text), tmp_path / "back", environment=HERE)
    assert done.outcome.ended == "finished"
    assert time.monotonic() - begun < 15
    left = Path("/proc") / (tmp_path / "back/left.txt").read_text() / "cmdline"
    deadline = time.monotonic() + 5  # it is killed, but a busy machine takes a moment
    while left.exists() and left.read_bytes():  # then gone, or nothing but a table entry
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.parametrize("wrong", [{"initial": "later"}, {"timeout": 0.0}, {"duration": -5.0}])
def test_refuses_options_outside_their_range(tmp_path, wrong):
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        rehearse(laid(tmp_path, SCRIPT), tmp_path / "back", environment=HERE, **wrong)


def test_a_script_that_ends_its_process_is_not_said_to_hang(tmp_path):
    text = SCRIPT + "import os\nos._exit(0)\n"
    done = rehearse(laid(tmp_path, text), tmp_path / "back", environment=HERE)
    assert (done.outcome.ended, done.passed) == ("died", False)
    assert "ended itself, exit code 0" in done.reason
