"""What children of a script are called, what they record, and what cannot be handed on to them."""

import contextlib
import io
import os

import numpy as np
from scripts_with_children import COMMON

from posflock_robotarium.logs.recorder import open_pose_log
from rps_compat.arena import Arena
from rps_compat.children import VARIABLE, names
from rps_compat.children.plan import ChildError
from rps_compat.children.records import InstanceRecord, Record, RobotariumInstance
from rps_compat.recording import Recording
from rps_compat.report import report_of, report_on
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.session import Session


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
    arena = Arena(np.array([[0, 0.1, 1.0], [0, 0, 0.99], [0, 0, np.pi / 2]]))
    instance = RobotariumInstance("process-1", 1, 3, "")
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
