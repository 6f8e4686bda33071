"""The certificate for late robots on board: its libraries, both faces of the API, the flock."""

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, Flock
from posflock_robotarium.flocking.placement import random_poses
from rps_compat.late_profiles import late_certificate
from rps_compat.profiles import load_profile
from rps_compat.session import Session
from rps_compat.v1.robotarium import Robotarium as Robotarium1
from rps_compat.v2.robotarium import Robotarium as Robotarium2

ROOT = Path(__file__).resolve().parents[1]
PROFILE = load_profile("gritsbot_x")
IDEAL = UnicycleCertificate(0.185, speed_limit=0.15, turn_rate_limit=0.55, time_step=0.033)

ALONE = """
import sys
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_robots import LateRobots
import numpy as np
certificate = LateCertificate(
    speed_limit=0.15, turn_rate_limit=0.5, time_step=0.033, robots=LateRobots(dead_time=(0.2, 0.2))
)
certificate(np.zeros((2, 2)), np.array([[0.0, 0.5], [0.0, 0.0], [0.0, 0.0]]))
loaded = {name.partition(".")[0] for name in sys.modules}
print(*sorted(loaded - sys.stdlib_module_names - {"numpy", "scipy", "barrier_certificates"}))
"""


def test_it_needs_numpy_and_scipy_alone():
    done = subprocess.run(
        [sys.executable, "-c", ALONE], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert not {"rps_compat", "posflock_robotarium", "matplotlib"} & set(done.stdout.split())


@pytest.mark.parametrize("robotarium", [Robotarium1, Robotarium2])
def test_what_it_answers_goes_to_set_velocities_of_both_generations(robotarium):
    certificate = late_certificate(IDEAL, PROFILE, barrier_gain=2e4)
    start = np.array([[-0.25, 0.25, 0.0], [0.0, 0.0, 0.5], [0.0, np.pi, -1.5]])
    with Session(initial="exact", seed=3, realism=PROFILE.start).active():
        r = robotarium(
            number_of_robots=3,
            show_figure=False,
            sim_in_real_time=False,
            initial_conditions=start,
        )
        wheels = 0.0
        for _ in range(150):
            commands, _ = certificate(np.tile([[0.15], [0.0]], 3), r.get_poses())
            r.set_velocities(np.arange(3), commands)
            wheels = max(wheels, float(np.abs(commands[0]).max()))
            r.step()
        true = r._arena.poses
        assert not r._arena.violations.close_pairs
    points = true[:2] + 0.05 * np.stack([np.cos(true[2]), np.sin(true[2])])
    apart = np.hypot(*(points[:, [0, 0, 1]] - points[:, [1, 2, 2]]))
    assert apart.min() >= certificate.guarantee().pairs
    assert 0.1 < wheels <= 0.15 + 1e-9


def test_a_flock_may_fly_by_it():
    ideal = dataclasses.replace(EXPERIMENT_CERTIFICATE, safety_radius=0.185, time_step=0.033)
    flock = Flock(certificate=late_certificate(ideal, PROFILE, barrier_gain=2e4))
    assert flock.certificate.answers_late
    poses = random_poses(9, np.random.default_rng(0))
    first = flock.step(poses)
    second = flock.step(poses)
    assert second.status in ("trivial", "optimal")
    assert first.clearance > 0.0
    assert first.clearance != second.clearance  # a command is on its way by now
    described = flock.parameters()["wheels"]["robots"]
    assert described["lag"] == pytest.approx((0.17, 0.18))
