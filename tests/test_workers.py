"""Worker processes: one BLAS thread each, and the caller's settings left alone."""

import os

import pytest

from posflock_robotarium.errors import PosflockError
from posflock_robotarium.progress import counted
from posflock_robotarium.sweep.execution import WorkerError, execute, locally
from posflock_robotarium.sweep.experiments import Experiment, register
from posflock_robotarium.sweep.store import Store
from posflock_robotarium.sweep.study import parse_study
from posflock_robotarium.workers import THREAD_VARIABLES, local_pool, processors


def die(experiment, runs):
    os._exit(1)


def test_workers_have_one_thread_and_the_caller_keeps_its_own(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with local_pool(1) as pool:
        seen = [pool.submit(os.getenv, name).result() for name in THREAD_VARIABLES]
    assert seen == ["1"] * len(THREAD_VARIABLES)
    assert os.environ["OPENBLAS_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ
    assert 1 <= processors() <= (os.cpu_count() or 1)


def test_a_worker_that_dies_is_an_error_that_says_what_to_do(tmp_path, monkeypatch):
    study = parse_study(
        {"experiment": "freespace", "replications": 1, "grid": {"persistence": [0.1, 0.2]}}
    )
    monkeypatch.setattr("posflock_robotarium.sweep.execution.compute", die)
    with Store(tmp_path) as store, pytest.raises(WorkerError, match="start again"):
        execute(study, store, locally(2))


def test_an_error_of_one_run_reaches_the_caller_and_leaves_the_others(tmp_path):
    class NoisyError(PosflockError):
        pass

    def picky(parameters, seeds):
        if parameters["value"] == 2:
            raise NoisyError("no twos")
        return [{"value_squared": parameters["value"] ** 2} for _ in seeds]

    register(Experiment("picky-for-test", "", {"value": 0}, picky, ("value_squared",)))
    study = parse_study(
        {"experiment": "picky-for-test", "replications": 1, "grid": {"value": [1, 2, 3]}}
    )
    with Store(tmp_path) as store:
        with pytest.raises(NoisyError):
            execute(study, store, locally(1))
        assert [row["value_squared"] for row in store.rows.values()] == [1]


def test_progress_tells_each_tenth_once_where_there_is_no_terminal(capsys):
    with counted("working") as progress:
        for done in range(1, 51):
            progress(done, 50)
        progress(50, 50)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("working: 5 of 50")
    assert 10 <= len(lines) <= 11
