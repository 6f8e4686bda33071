"""Studies: what a file means, streams of their own, a store that survives, tidy results."""

import csv
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.sweep.execution import batches, compute, execute, locally
from posflock_robotarium.sweep.experiments import Experiment, find, names, register
from posflock_robotarium.sweep.parameter_distribution import (
    ParameterDistribution,
    ParameterSpread,
    StudyError,
)
from posflock_robotarium.sweep.results import finished, outcomes, summary, write_tables
from posflock_robotarium.sweep.store import Store, StoreError
from posflock_robotarium.sweep.study import parse_study, read_study

SMALL = {
    "experiment": "freespace",
    "seed": 3,
    "replications": 3,
    "parameters": {"agents": 8, "side": 8.0, "duration": 2.0},
    "grid": {"model": ["velocity", "position"], "persistence": [0.1, 0.5]},
    "distributions": {"distance_scale": {"uniform": [0.4, 0.6]}},
}


def without(said, *keys):
    return {key: value for key, value in said.items() if key not in keys}


def table(study, store):
    return finished(study, store)


def test_a_study_is_every_combination_times_replications():
    runs = parse_study(SMALL).runs()
    assert len(runs) == 2 * 2 * 3
    assert [run.point for run in runs] == [0] * 3 + [1] * 3 + [2] * 3 + [3] * 3
    assert {(r.parameters["model"], r.parameters["persistence"]) for r in runs} == {
        (model, k) for model in ("velocity", "position") for k in (0.1, 0.5)
    }
    assert all(0.4 <= run.parameters["distance_scale"] <= 0.6 for run in runs)
    assert set(runs[0].parameters) == set(find("freespace").defaults)


def test_every_run_has_a_key_and_a_stream_of_its_own():
    runs = parse_study(SMALL).runs()
    assert len({run.key for run in runs}) == len(runs)
    assert len({tuple(run.stream.generate_state(4)) for run in runs}) == len(runs)
    assert len({run.parameters["distance_scale"] for run in runs}) == len(runs)


def test_common_random_numbers_pair_combinations():
    runs = parse_study(SMALL | {"common_random_numbers": True}).runs()
    streams = np.array([run.stream.generate_state(4) for run in runs]).reshape(4, 3, 4)
    assert (streams == streams[0]).all()
    assert len({tuple(stream) for stream in streams[0]}) == 3
    assert len({run.key for run in runs}) == len(runs)


def test_runs_keep_their_streams_when_a_study_grows():
    """A longer grid, in another order, and more replications: the old runs are among the new."""
    before = {run.key: run for run in parse_study(SMALL).runs()}
    grown = SMALL | {
        "replications": 5,
        "grid": {"persistence": [0.9, 0.5, 0.1], "model": ["position", "velocity"]},
    }
    after = {run.key: run for run in parse_study(grown).runs()}
    assert before.keys() < after.keys()
    for key, run in before.items():
        assert after[key].parameters == run.parameters
        np.testing.assert_array_equal(
            after[key].stream.generate_state(4), run.stream.generate_state(4)
        )


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"replicatons": 3}, "replicatons"),
        ({"experiment": "boids"}, "freespace"),
        ({"experiment": 3}, "str"),
        ({"seed": "one"}, "seed"),
        ({"seed": -1}, "seed"),
        ({"replications": 0}, "replications"),
        ({"parameters": {"agnets": 8}}, "agnets"),
        ({"parameters": {"agents": 1}}, "from 2"),
        ({"parameters": {"agents": "many"}}, "int"),
        ({"parameters": {"model": "velocity"}}, "two of"),
        ({"grid": {"model": []}}, "at least one"),
        ({"grid": {"model": "velocity"}}, "list"),
        ({"grid": {"model": ["velocity", "velocity"]}}, "twice"),
        ({"grid": {"dropout": [0.1, 2.0]}}, "probability"),
        ({"distributions": {"side": {"gauss": [0, 1]}}}, "uniform"),
        ({"distributions": {"side": [1, 2]}}, "one distribution"),
        ({"distributions": {"side": {"uniform": [2.0, 1.0]}}}, "low"),
        ({"distributions": {"side": {"loguniform": [0.0, 1.0]}}}, "above zero"),
        ({"distributions": {"agents": {"integers": [2, 8.0]}}}, "whole numbers"),
        ({"distributions": {"failure": {"uniform": [0.0, 1.0]}}}, "failure"),
        ({"figures": [{"x": "side", "y": "gamma_end"}]}, "not varied"),
        ({"figures": [{"x": "persistence", "y": "gamma_end", "z": 1}]}, "z"),
    ],
)
def test_what_a_study_cannot_mean_is_refused(wrong, said):
    with pytest.raises((StudyError, ParameterError), match=said):
        parse_study(SMALL | wrong)


def test_a_file_that_is_no_study_is_named(tmp_path):
    path = tmp_path / "study.toml"
    with pytest.raises(StudyError, match=r"study\.toml"):
        read_study(path)
    path.write_text("experiment = ")
    with pytest.raises(StudyError, match="not TOML"):
        read_study(path)
    path.write_text('experiment = "freespace"\nspeed = 3\n')
    with pytest.raises(StudyError, match=r"study\.toml: speed"):
        read_study(path)


def test_distributions_draw_what_they_say():
    generator = np.random.default_rng(0)
    draw = {
        kind: [ParameterDistribution(kind, arguments).draw(generator) for _ in range(2000)]
        for kind, arguments in {
            ParameterSpread.UNIFORM: (2.0, 4.0),
            ParameterSpread.LOGUNIFORM: (0.01, 100.0),
            ParameterSpread.NORMAL: (5.0, 2.0),
            ParameterSpread.CHOICE: ("a", "b", "c"),
        }.items()
    }
    assert min(draw["uniform"]) >= 2.0
    assert np.mean(draw["uniform"]) == pytest.approx(3.0, abs=0.05)
    assert np.mean(np.log10(draw["loguniform"])) == pytest.approx(0.0, abs=0.1)
    assert np.std(draw["normal"]) == pytest.approx(2.0, rel=0.1)
    assert set(draw["choice"]) == {"a", "b", "c"}


def test_an_experiment_can_be_added_once():
    def count(parameters, seeds):
        return [{"twice": 2.0 * parameters["value"]} for _ in seeds]

    register(Experiment("count-for-test", "Doubles.", {"value": 1.0}, count, ("twice",)))
    study = parse_study(
        {"experiment": "count-for-test", "replications": 1, "grid": {"value": [1, 2.5]}}
    )
    made = batches(study.runs(), study.experiment)
    rows = [row for batch in made for row in compute("count-for-test", batch)]
    assert [row["twice"] for row in rows] == [2.0, 5.0]
    with pytest.raises(ParameterError, match="already"):
        register(Experiment("count-for-test", "", {}, count, ()))
    assert "count-for-test" in names()


def test_batches_hold_equal_parameters():
    study = parse_study(without(SMALL, "distributions") | {"replications": 11})
    made = batches(study.runs(), study.experiment, workers=3)
    assert [len(batch) for batch in made] == [8, 3] * 4
    assert all(len({str(run.parameters) for run in batch}) == 1 for batch in made)


def test_results_are_the_same_by_one_process_or_two_and_in_any_batches(tmp_path):
    study = parse_study(without(SMALL, "distributions"))
    with Store(tmp_path / "one") as one, Store(tmp_path / "two") as two:
        execute(study, one, locally(1))
        execute(study, two, locally(2))
        assert table(study, one) == table(study, two)
        for run in study.runs():
            (row,) = compute("freespace", [run])
            stored = one.rows[run.key]
            assert without(row, "seconds") == without(stored, "seconds")


def test_a_row_holds_every_parameter_and_its_stream(tmp_path):
    study = parse_study(SMALL)
    with Store(tmp_path) as store:
        execute(study, store, locally(1))
        rows = table(study, store)
    for row, run in zip(rows, study.runs(), strict=True):
        assert {name: row[name] for name in run.parameters} == run.parameters
        assert (row["study_seed"], row["replication"]) == (3, run.replication)
        assert "version" in row
    assert "gamma_settled" in outcomes(study, rows)


def test_a_second_sweep_computes_only_what_is_missing(tmp_path):
    study = parse_study(SMALL)
    with Store(tmp_path) as store:
        rows = compute("freespace", study.runs()[:1])
        store.append(rows)
    with Store(tmp_path) as store:
        assert execute(study, store, locally(1)) == len(study.runs()) - 1
    with Store(tmp_path) as store:
        assert execute(study, store, locally(1)) == 0
        grown = parse_study(SMALL | {"replications": 4})
        assert execute(grown, store, locally(1)) == 4


KILLED_SWEEP = """
import sys
from pathlib import Path
from posflock_robotarium.sweep.execution import execute, locally
from posflock_robotarium.sweep.store import Store
from posflock_robotarium.sweep.study import read_study
with Store(Path(sys.argv[2])) as store:
    execute(read_study(Path(sys.argv[1])), store, locally(1),
            lambda done, _: print(done, flush=True))
"""


def test_a_killed_sweep_loses_nothing_finished(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        'experiment = "freespace"\nreplications = 40\n'
        "[parameters]\nagents = 8\nside = 8.0\nduration = 5.0\n"
        "[distributions]\npersistence = { uniform = [0.1, 0.2] }\n"
    )
    sweep = subprocess.Popen(
        [sys.executable, "-c", KILLED_SWEEP, str(path), str(tmp_path / "store")],
        stdout=subprocess.PIPE,
        text=True,
    )
    told = [int(sweep.stdout.readline()) for _ in range(3)][-1]
    os.kill(sweep.pid, signal.SIGKILL)
    sweep.communicate()
    study = read_study(path)
    with Store(tmp_path / "store") as store:
        there = len(table(study, store))
        assert told <= there < 40
        assert execute(study, store, locally(1)) == 40 - there
        whole = table(study, store)
    with Store(tmp_path / "fresh") as store:
        execute(study, store, locally(1))
        assert table(study, store) == whole


@pytest.mark.parametrize("torn_at", [1, 12, -2])
def test_a_torn_line_costs_its_run_alone(tmp_path, torn_at):
    rows = [{"key": f"k{i}", "value": i / 7.0} for i in range(5)]
    with Store(tmp_path) as store:
        store.append(rows)
    (segment,) = tmp_path.glob("rows-*.jsonl")
    whole = segment.read_bytes()
    last = whole.rstrip(b"\n").rfind(b"\n") + 1
    segment.write_bytes(whole[: last + torn_at] if torn_at > 0 else whole[:torn_at])
    with Store(tmp_path) as store:
        assert store.torn == 1
        assert list(store.rows) == ["k0", "k1", "k2", "k3"]
        store.append(rows)
    with Store(tmp_path) as store:
        assert list(store.rows.values()) == rows


def test_garbled_bytes_are_noticed(tmp_path):
    with Store(tmp_path) as store:
        store.append([{"key": "a", "value": 0.5}, {"key": "b", "value": 0.25}])
    (segment,) = tmp_path.glob("rows-*.jsonl")
    segment.write_bytes(segment.read_bytes().replace(b"0.5", b"0.6") + b"\0" * 40)
    with Store(tmp_path) as store:
        assert list(store.rows) == ["b"]
        assert store.torn == 2


def test_numbers_come_back_as_they_were(tmp_path):
    row = {"key": "a", "tiny": 5e-324, "third": 1 / 3, "never": float("inf"), "word": "é"}
    with Store(tmp_path) as store:
        store.append([row])
    with Store(tmp_path) as store:
        assert store.rows["a"] == row


def test_two_sweeps_do_not_share_a_store(tmp_path):
    with Store(tmp_path), pytest.raises(StoreError, match="another sweep"):
        Store(tmp_path)
    Store(tmp_path).close()


def test_a_store_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        Store(tmp_path / "file" / "store")


def test_tables_are_tidy_and_agree(tmp_path):
    study = parse_study(SMALL)
    with Store(tmp_path / "store") as store:
        execute(study, store, locally(1))
        write_tables(study, store, tmp_path)
        rows = table(study, store)
        found = summary(study, rows)
    with (tmp_path / "results.csv").open() as file:
        from_csv = list(csv.DictReader(file))
    from_parquet = parquet.read_table(tmp_path / "results.parquet").to_pylist()
    assert from_parquet == rows
    assert [row["key"] for row in from_csv] == [run.key for run in study.runs()]
    assert float(from_csv[4]["gamma_settled"]) == rows[4]["gamma_settled"]
    assert len(found) == 4 * len(outcomes(study, rows))
    one = next(f for f in found if f["outcome"] == "gamma_settled")
    assert one["runs"] == 3
    assert one["low"] <= one["median"] <= one["high"]


def test_the_command_sweeps_draws_and_resumes(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        'experiment = "freespace"\nreplications = 3\n'
        "[parameters]\nagents = 6\nside = 6.0\nduration = 1.0\n"
        '[grid]\nmodel = ["velocity", "position"]\npersistence = [0.1, 0.2]\n'
        '[[figures]]\nx = "persistence"\ny = "gamma_end"\nby = "model"\n'
        '[[figures]]\nx = "model"\ny = "speed_end"\n'
    )
    out = tmp_path / "out"
    command = ["sweep", str(path), "-o", str(out), "--jobs", "1", "--json"]
    first = CliRunner().invoke(app, command, catch_exceptions=False)
    assert json.loads(first.stdout)["computed"] == 12
    tables = (out / "results.csv").read_bytes()
    again = CliRunner().invoke(app, command, catch_exceptions=False)
    assert (json.loads(again.stdout)["computed"], json.loads(again.stdout)["found"]) == (0, 12)
    assert (out / "results.csv").read_bytes() == tables
    assert {path.suffix for path in (out / "figures").iterdir()} == {".pdf", ".png"}
    assert len(list((out / "figures").iterdir())) == 4


@pytest.mark.parametrize("study", ["noise", "threshold", "robots"])
def test_example_studies_can_be_read(study):
    root = Path(__file__).resolve().parents[1]
    assert read_study(root / "experiments" / "studies" / f"{study}.toml").runs()


def test_the_robots_can_be_swept():
    study = parse_study(
        {
            "experiment": "robots",
            "replications": 1,
            "common_random_numbers": True,
            "parameters": {"duration": 3.0},
            "grid": {"profile": ["ideal", "gritsbot_x"]},
        }
    )
    ideal, real = (compute("robots", [run])[0] for run in study.runs())
    assert ideal["collisions"] == 0
    assert ideal["smallest_distance"] != real["smallest_distance"]
    with pytest.raises(ParameterError, match="walls"):
        parse_study({"experiment": "robots", "parameters": {"walls": "none"}})
