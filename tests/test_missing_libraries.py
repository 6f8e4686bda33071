"""What is not installed is named with the `pip install` that brings it; the rest works without."""

import sys

import pytest
from typer.testing import CliRunner

from barrier_certificates import solvers
from barrier_certificates.certificate_errors import SolverNotInstalledError
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import read
from posflock_robotarium.sweep import results

STUDY = """
experiment = "freespace"
replications = 1
[parameters]
duration = 1.0
"""


def test_a_sweep_without_pyarrow_writes_csv_and_says_what_brings_parquet(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "find_spec", lambda name: None)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (tmp_path / "study.toml").write_text(STUDY)
    out = tmp_path / "out"
    out.mkdir()
    (out / "results.parquet").write_text("of an earlier call")
    words = ["sweep", str(tmp_path / "study.toml"), "-o", str(out), "--jobs", "1"]
    told = CliRunner().invoke(app, words, catch_exceptions=False)
    assert told.exit_code == 0
    assert "pip install 'posflock-robotarium[parquet]'" in told.output
    assert (out / "results.csv").exists()
    assert not (out / "results.parquet").exists()


@pytest.mark.parametrize(
    ("solver", "line"),
    [("cvxpy", "pip install cvxpy"), ("osqp", "pip install osqp"),
     ("clarabel", "pip install clarabel"),
     ("cvxopt", r"pip install 'posflock-robotarium\[cvxopt\]'"),
     ("daqp", r"pip install 'posflock-robotarium\[fast\]'")],
)  # fmt: skip
def test_a_solver_that_is_missing(solver, line, monkeypatch):
    monkeypatch.setattr(solvers, "installed", lambda name: name == "nnls")
    with pytest.raises(SolverNotInstalledError, match=line):
        SingleIntegratorCertificate(solver=solver)
    certificate = SingleIntegratorCertificate()
    _, info = certificate([[0.1, -0.1], [0.0, 0.0]], [[-0.1, 0.1], [0.0, 0.0]])
    assert info.status == "optimal"


def test_a_matlab_file_that_needs_h5py(tmp_path, monkeypatch):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "poses.mat", "w") as file:
        file["poses"] = [[0.0]]
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(LogError, match="pip install h5py"):
        read(tmp_path / "poses.mat")


def test_watching_without_a_server_says_what_brings_one(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    told = CliRunner().invoke(app, ["watch", str(tmp_path / "main.py")])
    assert "pip install 'posflock-robotarium[watch]'" in str(told.exception)
