"""Runs that fail, die or never end well: a row each, and the study goes on."""

import csv
import json

import numpy as np
import pytest
from pyarrow import parquet
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.sweep.execution import execute, in_processes, locally
from posflock_robotarium.sweep.experiments import Experiment, register
from posflock_robotarium.sweep.results import finished
from posflock_robotarium.sweep.store import ERROR, Store
from posflock_robotarium.sweep.study import StudyError, parse_study
from posflock_robotarium.sweep.study_figures import draw_study
from rps_compat.distributions import ProfileError
from rps_compat.profiles import profile_from_toml

MENDED = False


def picky(parameters, seeds):
    """Fail in every way that a run has, by its value, and square the others."""
    value = parameters["value"]
    if value == 2 and not MENDED:
        raise ValueError("no\n  twos")
    if value == 3 and not MENDED:
        raise SystemExit(3)
    if value == 4 and not MENDED:
        return []
    if value == 5 and not MENDED:
        return [{"square": object()} for _ in seeds]
    return [{"square": np.int64(value**2)} for _ in seeds]


register(Experiment("picky-for-test", "", {"value": 0}, picky, ("square",), together=3))
PICKY = {"experiment": "picky-for-test", "replications": 1, "grid": {"value": [1, 2, 3, 4, 5, 6]}}

SMALL = {
    "experiment": "freespace",
    "replications": 3,
    "parameters": {"agents": 4, "side": 4.0, "duration": 1.0},
    "grid": {"persistence": [0.1, 0.2]},
}

DEADLY = """
import os, signal
from posflock_robotarium.sweep.experiments import Experiment, register

def run(parameters, seeds):
    if parameters["value"] == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    if parameters["value"] == 4:
        raise ValueError("no fours")
    return [{"square": float(parameters["value"] ** 2)} for _ in seeds]

register(Experiment("deadly", "", {"value": 0}, run, ("square",), together=2))
"""
SMALL_STUDY = """
experiment = "freespace"
replications = 1
[parameters]
agents = 4
side = 4.0
duration = 0.5
record_interval = 0.1
[grid]
persistence = [0.1, 0.2]
[[figures]]
x = "persistence"
y = "{figure}"
"""
STUDY = """
experiment = "deadly"
module = "deadly.py"
replications = 2
[grid]
value = [1, 2, 3, 4]
"""


def test_a_run_that_raises_is_a_row_and_the_rest_goes_on(tmp_path):
    study = parse_study(PICKY)
    with Store(tmp_path) as store:
        assert execute(study, store, locally(1)) == 6
        rows = finished(study, store)
        assert execute(study, store, locally(1)) == 0
    assert [row.get("square") for row in rows] == [1, None, None, None, None, 36]
    assert [row.get(ERROR) for row in rows] == [
        None,
        "ValueError: no twos",
        "SystemExit: 3",
        "ValueError: expected 1 outcomes, one a seed, got 0",
        "TypeError: float() argument must be a string or a real number, not 'object'",
        None,
    ]


def test_failed_runs_are_computed_once_more_when_asked(tmp_path, monkeypatch):
    study = parse_study(PICKY)
    with Store(tmp_path) as store:
        execute(study, store, locally(1))
    monkeypatch.setitem(picky.__globals__, "MENDED", True)
    with Store(tmp_path) as store:
        assert execute(study, store, locally(1), retry_failed=True) == 4
    with Store(tmp_path) as store:
        assert [row["square"] for row in finished(study, store)] == [1, 4, 9, 16, 25, 36]
        assert execute(study, store, locally(1), retry_failed=True) == 0


def test_the_command_goes_on_after_a_worker_died(tmp_path):
    (tmp_path / "deadly.py").write_text(DEADLY)
    (tmp_path / "deadly.toml").write_text(STUDY)
    command = [
        "sweep",
        str(tmp_path / "deadly.toml"),
        "-o",
        str(tmp_path / "out"),
        "--jobs",
        "1",
    ]
    done = CliRunner().invoke(app, [*command, "--json"], catch_exceptions=False)
    assert done.exit_code == 1
    said = json.loads(done.stdout)
    assert (said["computed"], said["failed"]) == (8, 4)
    with (tmp_path / "out" / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["square"] for row in rows] == ["1.0", "1.0", "", "", "9.0", "9.0", "", ""]
    assert ["WorkerDied" in row[ERROR] for row in rows] == [False] * 2 + [True] * 2 + [False] * 4
    assert rows[-1][ERROR] == "ValueError: no fours"
    table = parquet.read_table(tmp_path / "out" / "results.parquet").to_pylist()
    assert [row["square"] for row in table] == [1.0, 1.0, None, None, 9.0, 9.0, None, None]
    assert (tmp_path / "out" / "figures" / "square_over_value.png").exists()


def test_processes_give_the_rows_of_this_process(tmp_path):
    study = parse_study(SMALL)
    found = []
    for number, executor in enumerate((locally(1), in_processes(2))):
        with Store(tmp_path / str(number)) as store:
            execute(study, store, executor)
            found.append(finished(study, store))
    assert found[0] == found[1]


def test_tables_and_figures_are_written_when_a_sweep_is_stopped(tmp_path, monkeypatch):
    (tmp_path / "study.toml").write_text(
        'experiment = "freespace"\nreplications = 2\n'
        "[parameters]\nagents = 4\nside = 4.0\nduration = 1.0\n[grid]\npersistence = [0.1, 0.2]\n"
    )

    def two_runs_and_then(workers):
        def run(job, work):
            yield job(work[0])
            raise KeyboardInterrupt

        return run

    monkeypatch.setattr("posflock_robotarium.sweep.execution.in_processes", two_runs_and_then)
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["sweep", str(tmp_path / "study.toml"), "-o", str(out)])
    assert done.exit_code != 0
    with (out / "results.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 2
    assert list((out / "figures").glob("*.png"))


def test_nothing_finished_is_no_figure(tmp_path):
    assert draw_study(parse_study(PICKY), [], tmp_path) == []


def test_a_deleted_segment_frees_no_number(tmp_path):
    for key in "abc":
        with Store(tmp_path) as store:
            store.append([{"key": key}])
    (tmp_path / "rows-000000.jsonl").unlink()
    with Store(tmp_path) as store:
        store.append([{"key": "d"}])
        assert set(store.rows) == set("bcd")
    names = sorted(path.name for path in tmp_path.glob("rows-*"))
    assert names == [f"rows-{number:06d}.jsonl" for number in (1, 2, 3)]


# --- Absurd numbers -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"parameters": {"side": 1e308}}, "side"),
        ({"parameters": {"side": float("inf")}}, "side"),
        ({"parameters": {"radius": float("nan")}}, "radius"),
        ({"parameters": {"side": 10**400}}, "side"),
        ({"parameters": {"agents": 10**9}}, "agents"),
        ({"parameters": {"duration": 1e9, "time_step": 1e-9}}, "duration"),
        ({"parameters": {"duration": 1e6, "record_interval": 1e-3}}, "record_interval"),
        ({"parameters": {"agents": 10**30}}, "agents"),
        ({"replications": 10**9}, "replications"),
        ({"grid": {"persistence": [0.1, 1e308]}}, "persistence"),
        ({"distributions": {"side": {"uniform": [1.0, float("inf")]}}}, "side"),
        ({"distributions": {"side": {"normal": [1e308, 1.0]}}}, "side"),
        ({"experiment": "robots", "parameters": {"robots": 10**6}}, "robots"),
        ({"experiment": "robots", "parameters": {"duration": 1e8}}, "duration"),
    ],
)
def test_absurd_numbers_in_a_study_are_refused_by_name(wrong, named):
    with pytest.raises((StudyError, ParameterError), match=named):
        parse_study({"experiment": "freespace"} | wrong)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[dead_time]\nseconds = 1e308", "seconds"),
        ("[dead_time]\nseconds = 1e5", "dead_time.seconds"),
        ("[dead_time]\nseconds = inf", "seconds"),
        ("[dead_time]\nseconds = 1" + "0" * 400, "seconds"),
        ("[gains]\nspeed = { uniform = [0.9, 1e300] }", "speed"),
        ("[gains]\nby_speed = [[0.1, 1e300]]", "by_speed"),
        ("[turn_bias]\nrate = { normal = [0.0, 1.0], limit = 1e-9 }", "limit"),
        ("[turn_bias]\nrate = { normal = [0.0, nan] }", "rate"),
    ],
)
def test_absurd_numbers_in_a_profile_are_refused_by_name(text, named):
    with pytest.raises(ProfileError, match=named):
        profile_from_toml(text)


def test_nothing_of_another_study_stays(tmp_path, monkeypatch):
    """Not even where the second one is ended before it has computed anything."""
    path, out = tmp_path / "study.toml", tmp_path / "out"
    command = ["sweep", str(path), "-o", str(out), "--jobs", "1"]

    def names():
        return {p.relative_to(out).as_posix() for p in out.rglob("*") if "store" not in p.parts}

    tables = {"figures", "results.csv", "results.parquet", "study.json", "summary.csv"}
    path.write_text(SMALL_STUDY.format(figure="gamma_end"))
    assert CliRunner().invoke(app, command).exit_code == 0
    figures = {f"figures/gamma_end_over_persistence.{kind}" for kind in ("pdf", "png")}
    assert names() == tables | figures
    path.write_text(SMALL_STUDY.format(figure="speed_end"))
    assert CliRunner().invoke(app, command).exit_code == 0
    assert not figures & names()
    path.write_text(SMALL_STUDY.format(figure="speed_end").replace("agents = 4", "agents = 5"))

    def stopped(*_, **__):
        raise KeyboardInterrupt

    (out / "figures" / "mine.png").touch()
    with monkeypatch.context() as patch:
        patch.setattr("posflock_robotarium.sweep.execution.execute", stopped)
        assert CliRunner().invoke(app, command).exit_code != 0
    assert names() == {"figures", "figures/mine.png", "study.json"}
    assert json.loads((out / "study.json").read_text())["files"] == []
