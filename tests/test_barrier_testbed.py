"""The certificates work on the testbed's Python and libraries alone."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from posflock_robotarium.bundle import bundle

ROOT = Path(__file__).resolve().parents[1]
PINS = ("numpy==2.2.6", "scipy==1.15.3", "cvxopt==1.3.2")

IMPORTS = (
    "from barrier_certificates import solvers",
    "from barrier_certificates.single_integrator import SingleIntegratorCertificate",
    "from barrier_certificates.unicycle import UnicycleCertificate",
)

REPLAY = """
import sys
import numpy as np, scipy
assert sys.version_info[:2] == (3, 10), sys.version
assert (np.__version__, scipy.__version__) == ("2.2.6", "1.15.3")
{imports}
from recorded_certificates import check, load

assert __import__("pathlib").Path(solvers.__file__).parts[-2:] == ("up", "solvers.py")
assert [name for name in solvers.NAMES if solvers.installed(name)] == ["nnls", "cvxopt"]
cases = load()
for solver in ("auto", "nnls", "cvxopt"):
    for case in cases:
        # An interior point is not asked for the probes of hundreds of m/s.
        if solver != "cvxopt" or abs(case["optimum"]).max() < 10:
            check(case, solver)

rng = np.random.default_rng(0)
for number in (1, 2, 9, 20, 60):
    certificate = UnicycleCertificate(0.17, boundary=(-1.6, 1.6, -1.0, 1.0), time_step=0.033)
    across = int(np.ceil(np.sqrt(number)))
    grid = np.array(np.meshgrid(np.arange(across), np.arange(across))).reshape(2, -1)[:, :number]
    poses = np.vstack([0.22 * (grid - 0.5 * (across - 1)), rng.uniform(-3, 3, (1, number))])
    for step in range(50):
        velocity, info = certificate.project(-poses[:2], poses)
        assert info.violation <= 1e-9 or info.status == "relaxed"
        v, w = certificate.commands(velocity, poses)
        poses = poses + 0.033 * np.array([v * np.cos(poses[2]), v * np.sin(poses[2]), w])
print(len(cases), "recorded optima reproduced")
"""


def python310() -> str | None:
    """Find a Python 3.10: on the PATH, or among pyenv's."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    candidates = [shutil.which("python3.10"), *map(str, sorted(pyenv.glob("3.10*/bin/python")))]
    for candidate in filter(None, candidates):
        asked = [candidate, "-c", "import sys; print(sys.version_info[:2] == (3, 10))"]
        if subprocess.run(asked, capture_output=True, text=True).stdout.strip() == "True":
            return candidate
    return None


@pytest.mark.slow
def test_certificates_run_on_the_testbeds_python_and_libraries(tmp_path):
    python = python310()
    if python is None:
        pytest.skip("no Python 3.10 on the PATH or among pyenv's: the testbed's is not tested")
    subprocess.run([python, "-m", "venv", str(tmp_path / "venv")], check=True)
    venv = tmp_path / "venv"
    inside = next(p for p in (venv / "bin/python", venv / "Scripts/python.exe") if p.exists())
    install = [str(inside), "-m", "pip", "install", "-q", "--only-binary=:all:", *PINS]
    done = subprocess.run(install, capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"cannot install {', '.join(PINS)}: {done.stderr.strip().splitlines()[-1]}")
    # As they travel: flat, packages and the packages in them as files of one folder.
    script = tmp_path / "uploaded.py"
    script.write_text("import rps, cvxopt\n" + "\n".join(IMPORTS) + "\n")
    bundle(script, tmp_path / "up")
    paths = os.pathsep.join([str(tmp_path / "up"), str(ROOT / "tests")])
    done = subprocess.run(
        [str(inside), "-c", REPLAY.replace("{imports}", "\n".join(IMPORTS))],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "recorded optima reproduced" in done.stdout
