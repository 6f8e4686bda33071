"""The same study on a real Dask scheduler with two workers, one of which dies."""

import os
import signal
import threading
import time

import pytest

from posflock_robotarium.sweep.execution import ClusterError, execute, locally, on_cluster
from posflock_robotarium.sweep.results import finished
from posflock_robotarium.sweep.store import Store
from posflock_robotarium.sweep.study import parse_study

distributed = pytest.importorskip("distributed")

STUDY = parse_study(
    {
        "experiment": "freespace",
        "seed": 5,
        "replications": 20,
        "parameters": {"agents": 12, "side": 10.0, "duration": 10.0},
        "grid": {"model": ["velocity", "position"]},
        # Drawn anew for every run: forty tasks of one run each.
        "distributions": {"distance_scale": {"uniform": [0.4, 0.6]}},
    }
)


@pytest.fixture(scope="module")
def cluster():
    """Start a scheduler and two worker processes."""
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        silence_logs=50,
    ) as running:
        yield running


@pytest.mark.filterwarnings("ignore")
def test_a_worker_killed_in_mid_study_changes_nothing(cluster, tmp_path):
    with Store(tmp_path / "here") as store:
        execute(STUDY, store, locally(1))
        here = finished(STUDY, store)

    with distributed.Client(cluster.scheduler_address, set_as_default=False) as client:
        victim, survivor = client.run(os.getpid).values()
    assert victim != survivor
    killed = threading.Event()

    def kill_once(done, whole):
        if done >= 5 and not killed.is_set():
            killed.set()
            os.kill(victim, signal.SIGKILL)

    with Store(tmp_path / "there") as store, on_cluster(cluster.scheduler_address) as executor:
        assert execute(STUDY, store, executor, kill_once) == 40
        assert killed.is_set()
        assert finished(STUDY, store) == here


def test_nobody_at_an_address_is_said():
    started = time.monotonic()
    with (
        pytest.raises(ClusterError, match="no Dask scheduler answers"),
        on_cluster("tcp://127.0.0.1:1", patience=1.0),
    ):
        pass
    assert time.monotonic() - started < 10.0
