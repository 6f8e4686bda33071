"""The modules that go to the testbed need numpy and scipy alone, and lie flat without a clash."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

#: Installed on the testbed (published list), by import name.
TESTBED_LIBRARIES = {
    "numpy", "scipy", "matplotlib", "cvxopt", "sklearn", "networkx", "shapely", "torch", "cv2",
    "PIL", "sympy", "yaml", "requests", "jinja2", "gym", "gtsam", "rps",
}  # fmt: skip

FLY_ON_NUMPY_AND_SCIPY = """
import importlib.abc, sys
class Refuse(importlib.abc.MetaPathFinder):
    allowed = {"numpy", "scipy", "barrier_certificates", "posflock_robotarium"}
    def find_spec(self, name, path, target=None):
        top = name.partition(".")[0]
        known = self.allowed | sys.stdlib_module_names
        if top not in known and not top.startswith("_"):
            raise ImportError(f"{name} is not on the testbed")
sys.meta_path.insert(0, Refuse())
import numpy as np
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.flocking.progress import steps_of
flock, poses = Flock(), random_poses(9, np.random.default_rng(0))
with PoseLog(sys.argv[1], 9, 30) as log:
    for step in steps_of(30, 0.033, "onboard"):
        decision = flock.step(poses)
        log.append(step * 0.033, poses, **decision.logged())
        v, w = decision.command
        poses = poses + 0.033 * np.array([v * np.cos(poses[2]), v * np.sin(poses[2]), w])
ours = sorted(m for m in sys.modules if m.startswith(("barrier_c", "posflock")) and "." in m)
print(*ours)
"""


@pytest.fixture(scope="module")
def onboard(tmp_path_factory):
    """Return the names of our modules that a flight loads."""
    log = tmp_path_factory.mktemp("flight") / "log"
    done = subprocess.run(
        [sys.executable, "-c", FLY_ON_NUMPY_AND_SCIPY, str(log)],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_a_flight_needs_numpy_and_scipy_alone(onboard):
    assert "posflock_robotarium.flocking.flock" in onboard
    assert "barrier_certificates.unicycle" in onboard


def test_onboard_names_clash_with_nothing(onboard):
    """Packages, the packages in them and modules all become files of one folder."""
    names = [name.rpartition(".")[2] for name in onboard]
    assert {"rows", "projection", "solvers"} < set(names)
    assert len(set(names)) == len(names)
    assert not set(names) & (TESTBED_LIBRARIES | set(sys.stdlib_module_names))
