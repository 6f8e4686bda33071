"""What is read of a published run's log: events, counts, its end, its drive to the start."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.real_runs import End, RealRun, counts_of, events_of, real_runs

ROOT = Path(__file__).parents[1]
LOG = """\
[INFO] [1700000000.250000000] [robotarium]: Initializing 7 robots to initial conditions...
[INFO] [1700000041.750000000] [robotarium]: At initial conditions... Starting Experiment
[t=  9.9s] robot 3 took cell 2 (1/6)
[t= 20.0s] laps=[2, 1] taken=1/6 cost=0.4
[t= 21.4s] robot 0 took cell 5 (2/6)
[t= 30.0s] bell rings
[t= 40.0s] laps=[3, 3] taken=2/6 cost=0.2
"""


def run_of(text):
    return RealRun(Path("Run3_Example.py"), text)


def test_events_are_counted_whoever_has_them():
    took = "robot # took cell #"
    assert events_of(LOG)[took, 1] == 9.9
    assert events_of(LOG)[took, 2] == 21.4
    assert events_of("no event at all\n[t=x] neither") == {}


def test_what_comes_at_whole_seconds_only_is_the_timetable():
    assert {what for what, _ in run_of(LOG).events} == {"robot # took cell #"}
    assert run_of(LOG).last == 40.0
    assert run_of("").last == 0.0


def test_counts_are_whole_numbers_and_lists_of_them():
    assert counts_of(LOG) == {
        (20.0, "laps"): "[2, 1]",
        (20.0, "taken"): "1",
        (40.0, "laps"): "[3, 3]",
        (40.0, "taken"): "2",
    }


@pytest.mark.parametrize(
    ("line", "end"),
    [
        ("", End.COMPLETED),
        ("Collision Detected! \n Stopping experiment!", End.COLLISION),
        ("KeyboardInterrupt", End.INTERRUPTED),
    ],
)
def test_a_log_says_how_its_run_ended(line, end):
    run = run_of(LOG + line)
    assert (run.end, run.name, run.robots, run.initial_drive) == (end, "Run3", 7, 41.5)


def test_a_log_without_stamps_tells_no_drive():
    run = run_of("[t= 1.5s] done")
    assert (run.robots, run.initial_drive) == (0, None)


def test_only_logs_that_have_their_script_are_runs(tmp_path):
    (tmp_path / "study/logs").mkdir(parents=True)
    for name in ("a", "b"):
        (tmp_path / f"study/logs/{name}.txt").write_text(LOG)
    (tmp_path / "study/b.py").write_text("")
    assert [run.script.name for run in real_runs(tmp_path)] == ["b.py"]


def test_without_real_runs_the_scoreboard_is_skipped_with_a_sentence(tmp_path):
    named = {k: v for k, v in os.environ.items() if k != "POSFLOCK_REAL_RUNS"}
    for where in ([], [tmp_path]):
        done = subprocess.run(
            [sys.executable, ROOT / "benchmarks/reality.py", *where],
            env=named, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0
        assert done.stdout.startswith("skipped: no real runs at hand.")
