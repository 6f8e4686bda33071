"""Three ways to let ``import rps`` mean this package."""

import importlib
import os
import subprocess
import sys

import pytest

import rps_compat
from rps_compat.install import UnknownGenerationError


@pytest.fixture(autouse=True)
def _uninstalled():
    yield
    rps_compat.uninstall()


def test_modules_are_ours_and_have_one_identity():
    rps_compat.install(generation=1)
    import rps.robotarium
    import rps.utilities.misc as misc

    assert rps.robotarium is importlib.import_module("rps_compat.v1.robotarium")
    assert misc is importlib.import_module("rps_compat.v1.utilities.misc")
    assert misc.__spec__.name == "rps_compat.v1.utilities.misc"


def test_generations_can_be_exchanged():
    rps_compat.install(generation=1)
    from rps.robotarium import Robotarium as First

    rps_compat.install(generation=2)
    from rps.robotarium import Robotarium as Second

    assert rps_compat.installed() == 2
    assert hasattr(First, "call_at_scripts_end")
    assert hasattr(Second, "debug")


def test_there_are_two_generations():
    with pytest.raises(UnknownGenerationError, match="generation=3"):
        rps_compat.install(generation=3)
    assert rps_compat.installed() is None


def test_a_module_that_the_api_does_not_have():
    rps_compat.install(generation=2)
    with pytest.raises(ModuleNotFoundError, match=r"rps\.utilities\.barrier_certificates2"):
        import rps.utilities.barrier_certificates2  # noqa: F401


@pytest.mark.parametrize("generation", [1, 2])
def test_any_python_finds_it_on_pythonpath(generation, tmp_path):
    command = [sys.executable, "-m", "rps_compat", "path", "--generation", str(generation)]
    path = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    program = "import rps.utilities.misc, rps.robotarium as r; print(r.Robotarium.__module__)"
    out = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": path},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert out.strip() == f"rps_compat.v{generation}.robotarium"


def test_names_that_numpy_dropped_are_there_on_pythonpath(tmp_path):
    program = (
        "import rps.robotarium, gc, numpy as np\n"
        "gc.collect()\n"
        "print(np.mat([[1, 2]]).shape, np.float(3), float(np.ones(1)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": str(rps_compat.import_path(2))},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == "(1, 2) 3.0 1.0\n", done.stderr
