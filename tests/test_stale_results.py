"""What an earlier run left never passes for a later one's, nor half a file for a whole one."""

import hashlib
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.convert import convert, write_pose_log
from posflock_robotarium.logs.readers import read
from posflock_robotarium.report import analyse
from rps_compat.errors import ScriptError
from rps_compat.run_folder import forget_run
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script

FINISHED = {"ended": {"how": "finished", "reason": "", "rows": 61}, "neighbour_radius": 0.75}


@pytest.fixture
def log(tmp_path):
    """Return the path of the log of a run that finished, 61 rows of 4 robots."""
    run = known_flock("parallel", 0.1, robots=4, duration=2.0).recording
    return write_pose_log(replace(run, parameters=FINISHED), tmp_path / "run")


def whole(path):
    """Return what the report answers to the question whether it is the whole run."""
    (verdict,) = [
        v for v in analyse(path, radius=0.75).verdicts if v.question == "Is it the whole run?"
    ]
    return verdict.mark, verdict.answer


def test_a_whole_log_is_one_and_stays_one_in_every_format(log):
    assert whole(log) == ("good", "Yes, the run finished.")
    for ending in ("csv", "npz", "mat", "npy"):
        again = convert(read(log), log.with_name(f"again.{ending}"))
        assert whole(again) == ("good", "Yes, the run finished.")


def test_rows_that_are_missing_are_told_whatever_the_description_says(log):
    rows = np.load(log)
    np.save(log, rows[:40])
    assert whole(log) == ("bad", f"No: {len(rows) - 40} of {len(rows)} rows are missing.")


def test_a_description_of_another_run_is_told(log):
    rows = np.load(log)
    rows["pose"][7, 0, 1] += 1e-9
    np.save(log, rows)
    assert whole(log) == ("bad", "No: the rows are not those that run.json was written for.")


def test_the_description_names_the_rows_it_is_of(log):
    said = json.loads(log.with_suffix(".json").read_text())
    other = write_pose_log(read(log), log.with_name("other"))
    assert json.loads(other.with_suffix(".json").read_text())["rows_digest"] == said["rows_digest"]


@pytest.mark.parametrize("cut", [1, 4, 30, 300])
def test_a_converted_table_cut_in_mid_number_is_told(log, cut):
    table = convert(read(log), log.with_name("table.csv"))
    table.write_bytes(table.read_bytes()[:-cut])
    mark, answer = whole(table)
    assert mark == "bad"
    assert "rows are missing" in answer
    assert "cut off" in " ".join(read(table).notes)


def test_a_table_cut_within_its_header_is_refused(log):
    table = convert(read(log), log.with_name("table.csv"))
    head = table.read_bytes().index(b"theta2")
    table.write_bytes(table.read_bytes()[:head])
    with pytest.raises(LogError, match=r"table\.csv: cut off before its first row"):
        read(table)


def test_a_foreign_table_without_a_last_line_end_is_read_and_told(tmp_path):
    table = tmp_path / "foreign.csv"
    table.write_text("t,x,y,theta\n0,0,0,0\n0.1,0.01,0,0\n0.2,0.0")
    assert len(read(table).t) == 2
    assert any("the last row is cut off, and left out" in note for note in read(table).notes)
    table.write_text("t,x,y,theta\n0,0,0,0\n0.1,0.01,0,0\n0.2,0.02,0,0")
    assert len(read(table).t) == 3
    assert any("its last number is wrong" in note for note in read(table).notes)


# --- Earlier results ---------------------------------------------------------------------------


def test_a_verify_that_fails_leaves_no_earlier_verdict(tmp_path):
    for name in ("verify.json", "verify.html", "notes.txt"):
        (tmp_path / name).write_text('{"verdict": "PASS"}')
    done = CliRunner().invoke(app, ["verify", str(tmp_path / "none.py"), "-o", str(tmp_path)])
    assert done.exit_code != 0
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


RUN = """
from rps.robotarium import Robotarium
for _ in range({instances}):
    r = Robotarium(number_of_robots=1)
    r.get_poses()
    r.step()
"""


def run(script, out, **more):
    from posflock_robotarium.logs.recorder import open_pose_log

    settings = RunSettings(
        generation=2, headless=True, out=out, recorder=open_pose_log, claims_folder=True, **more
    )
    return run_script(script, (), settings)


def test_a_second_run_leaves_nothing_of_the_first(tmp_path):
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(RUN.format(instances=2))
    run(script, out)
    (out / "mine.txt").touch()
    assert (out / "poses-2.npy").exists()
    script.write_text(RUN.format(instances=1))
    run(script, out)
    names = {path.name for path in out.iterdir()}
    assert names == {"mine.txt", "poses.npy", "poses.json", "report.json", "report.txt"}


def test_a_second_run_that_cannot_begin_leaves_the_data_and_no_report(tmp_path):
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(RUN.format(instances=1))
    run(script, out)
    script.write_text("this is no Python")
    with pytest.raises(ScriptError):
        run(script, out)
    assert {path.name for path in out.iterdir()} == {"poses.npy", "poses.json"}


def notes_of(log):
    """Return what the reader says of files beside a log."""
    return [note for note in read(log).notes if "beside it" in note]


def test_a_report_of_another_run_beside_a_log_is_told(tmp_path):
    script, out, other = tmp_path / "script.py", tmp_path / "out", tmp_path / "other"
    script.write_text(RUN.format(instances=1))
    run(script, out)
    assert notes_of(out / "poses.npy") == []
    script.write_text(RUN.format(instances=1) + "r.get_poses()\nr.step()\n")
    run(script, other)
    shutil.copy(other / "report.json", out)
    assert notes_of(out / "poses.npy") == ["report.json beside it is of another run"]
    (out / "report.json").write_text("[")
    assert notes_of(out / "poses.npy") == []


def test_a_summary_of_another_run_beside_a_log_is_told(log):
    said = json.loads(log.with_suffix(".json").read_text())
    for digest, told in ((said["rows_digest"], []), ("0" * 16, ["summary.json"])):
        log.with_name("summary.json").write_text(json.dumps({"rows_digest": digest}))
        assert [note.split(" beside")[0] for note in notes_of(log)] == told


def test_a_verdict_on_another_script_beside_a_log_is_told(tmp_path):
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(RUN.format(instances=1))
    run(script, out)
    for content, told in ((script.read_bytes(), 0), (b"another state of it", 1)):
        verdict = {"sha256": hashlib.sha256(content).hexdigest()}
        (out / "verify.json").write_text(json.dumps(verdict))
        assert len(notes_of(out / "poses.npy")) == told
    assert "says nothing of this run" in notes_of(out / "poses.npy")[0]


def test_a_report_that_lists_files_elsewhere_removes_none_of_them(tmp_path):
    folder, precious = tmp_path / "run", tmp_path / "precious.txt"
    folder.mkdir()
    precious.touch()
    listed = ["../precious.txt", str(precious), "kept/../../precious.txt", 3]
    (folder / "report.json").write_text(json.dumps({"files": listed[:3]}))
    forget_run(folder)
    (folder / "report.json").write_text(json.dumps({"files": listed}))
    forget_run(folder)
    assert precious.exists()
    assert list(folder.iterdir()) == []
    shutil.rmtree(folder)
    forget_run(folder)
