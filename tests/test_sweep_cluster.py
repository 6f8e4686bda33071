"""The same study on a real Dask scheduler with two workers, one of which dies."""

import os
import shutil
import signal
import subprocess
import sys
import threading
import time

import pytest
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.sweep import cluster as sweep_cluster
from posflock_robotarium.sweep.cluster import Certificates, ClusterError, on_cluster
from posflock_robotarium.sweep.execution import execute, locally
from posflock_robotarium.sweep.results import finished
from posflock_robotarium.sweep.store import ERROR, Store
from posflock_robotarium.sweep.study import parse_study, read_study

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")

STUDY = parse_study(
    {
        "experiment": "freespace",
        "seed": 5,
        "replications": 20,
        "parameters": {"agents": 12, "side": 10.0, "duration": 4.0},
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


KILLER = """
import os, signal
from posflock_robotarium.sweep.experiments import Experiment, register

def run(parameters, seeds):
    if parameters["value"] == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return [{"square": float(parameters["value"] ** 2)} for _ in seeds]

register(Experiment("killer-on-cluster", "", {"value": 0}, run, ("square",), together=2))
"""


@pytest.mark.slow  # workers die and are started again
@pytest.mark.filterwarnings("ignore")
def test_a_run_that_kills_every_worker_has_failed_and_the_rest_goes_on(cluster, tmp_path):
    (tmp_path / "killer.py").write_text(KILLER)
    study = parse_study(
        {
            "experiment": "killer-on-cluster",
            "module": "killer.py",
            "replications": 1,
            "grid": {"value": [1, 2, 3]},
        },
        tmp_path,
    )
    with Store(tmp_path / "store") as store:
        with distributed.Client(cluster.scheduler_address, set_as_default=False) as client:
            client.run_on_scheduler(_allow_no_failures)
            with on_cluster(cluster.scheduler_address) as executor:
                execute(study, store, executor)
        rows = finished(study, store)
    assert [row.get("square") for row in rows] == [1.0, None, 9.0]
    assert "its worker process died" in rows[1][ERROR]


def _allow_no_failures(dask_scheduler):
    """Blame the first run whose worker dies: the default waits for four deaths."""
    dask_scheduler.allowed_failures = 0


SCHEDULER = """
import asyncio, sys
from distributed import Scheduler, Security

async def main():
    files = sys.argv[1:]
    security = Security(
        tls_ca_file=files[0], tls_scheduler_cert=files[1], tls_scheduler_key=files[2],
        require_encryption=True,
    ) if files else None
    address = "tls://127.0.0.1:0" if files else "tcp://127.0.0.1:0"
    async with Scheduler(host=address, dashboard=False, security=security) as scheduler:
        print(scheduler.address, flush=True)
        await scheduler.finished()

asyncio.run(main())
"""


@pytest.fixture
def processes():
    """Return a function that starts a program, all of which end with the test."""
    started = []

    def start(*command):
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_dies_is_one_error_and_the_store_goes_on(processes, tmp_path):
    scheduler = processes(sys.executable, "-c", SCHEDULER)
    address = scheduler.stdout.readline().strip()
    processes(sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny",
              "--no-dashboard", "--nthreads", "1")  # fmt: skip

    def kill(done, whole):
        scheduler.kill()

    with Store(tmp_path) as store:
        with (
            pytest.raises(ClusterError, match="has gone; finished runs are in the store"),
            on_cluster(address) as executor,
        ):
            execute(STUDY, store, executor, kill)
        there = len(store.rows)
        assert 0 < there < 40
    with Store(tmp_path) as store:
        assert execute(STUDY, store, locally(1)) == 40 - there


@pytest.mark.slow  # a scheduler and workers of its own
@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_without_workers_is_not_waited_for_for_ever(processes, tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_cluster, "WITHOUT_WORKERS", 0.2)
    monkeypatch.setattr(sweep_cluster, "_LOOK", 0.1)
    address = processes(sys.executable, "-c", SCHEDULER).stdout.readline().strip()
    with (
        Store(tmp_path) as store,
        pytest.raises(ClusterError, match=r"has had no worker for 0\.2 s; finished runs are in"),
        on_cluster(address) as executor,
    ):
        execute(STUDY, store, executor)


def certified(folder, name, authority=None):
    """Make a key and a certificate, signed by an authority or by itself; return their paths."""
    key, cert = folder / f"{name}.key", folder / f"{name}.pem"
    kind = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2"]
    command = ["openssl", "req", "-x509", *kind, "-subj", f"/CN={name}"]
    command += ["-keyout", key, "-out", cert]
    if authority is not None:
        command += ["-CA", authority[0], "-CAkey", authority[1]]
    subprocess.run(command, check=True, capture_output=True)
    return cert, key


@pytest.mark.slow  # a scheduler and workers of its own
@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes certificates with openssl")
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_over_tls_takes_those_alone_who_have_a_certificate(processes, tmp_path):
    ca = certified(tmp_path, "ca")
    cert, key = certified(tmp_path, "member", ca)
    scheduler = processes(sys.executable, "-c", SCHEDULER, str(ca[0]), str(cert), str(key))
    address = scheduler.stdout.readline().strip()
    assert address.startswith("tls://")
    processes(sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny",
              "--no-dashboard", "--nthreads", "1", "--tls-ca-file", str(ca[0]),
              "--tls-cert", str(cert), "--tls-key", str(key))  # fmt: skip
    study = tmp_path / "study.toml"
    study.write_text('experiment = "freespace"\nreplications = 2\n'
                     "[parameters]\nagents = 4\nside = 4.0\nduration = 1.0\n")  # fmt: skip
    command = ["sweep", str(study), "-o", str(tmp_path / "out"), "--scheduler", address]
    command += ["--tls-ca", str(ca[0]), "--tls-cert", str(cert), "--tls-key", str(key)]
    assert "2 runs computed" in CliRunner().invoke(app, command, catch_exceptions=False).stdout
    names = {"ca-file": ca[0], "client.cert": cert, "client.key": key}
    said = {f"distributed.comm.tls.{name}": str(file) for name, file in names.items()}
    with (
        dask.config.set(said),
        Store(tmp_path / "store") as store,
        on_cluster(address) as executor,
    ):
        assert execute(read_study(study), store, executor) == 2
    for strangers in (None, Certificates(ca[0], *certified(tmp_path, "stranger"))):
        with (
            pytest.raises(ClusterError, match="no Dask scheduler answers"),
            on_cluster(address, patience=1.0, certificates=strangers),
        ):
            pass


def test_certificates_are_all_or_none_and_files(tmp_path):
    assert Certificates.of(None, None, None) is None
    with pytest.raises(ClusterError, match="expected all of"):
        Certificates.of(tmp_path, None, None)
    with pytest.raises(ClusterError, match="--tls-ca: there is no file"):
        Certificates.of(tmp_path / "ca", tmp_path / "cert", tmp_path / "key")
    for name in ("ca", "cert", "key"):
        (tmp_path / name).touch()
    files = Certificates.of(tmp_path / "ca", tmp_path / "cert", tmp_path / "key")
    with pytest.raises(ClusterError, match="tls://"), on_cluster("tcp://here:1", 1.0, files):
        pass
