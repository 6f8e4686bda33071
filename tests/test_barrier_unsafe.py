"""Teams that are not safe are parted, brought back and told of; none is called safe."""

import numpy as np
import pytest
from driven_unicycles import ARENA, STEP, D

from barrier_certificates.certificate_errors import InfeasibleError
from barrier_certificates.rows import Disc
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

UNSAFE = {
    "1 mm of overlap": [[-0.0745, 0.0745], [0.0, 0.0]],
    "half the radius": [[-0.0375, 0.0375], [0.0, 0.0]],
    "0.9 of the radius": [[-0.0075, 0.0075], [0.0, 0.0]],
    "coincident": [[0.3, 0.3], [0.2, 0.2]],
    "three coincident": [[0.3, 0.3, 0.3], [0.2, 0.2, 0.2]],
    "half a metre outside": [[2.1, 0.0], [0.0, 0.0]],
    "outside a corner": [[2.0, -2.0], [1.5, -1.5]],
    "packed into a corner": [[1.55, 1.52, 1.58, 1.5], [0.95, 0.97, 0.91, 0.93]],
    "coincident in a corner": [[1.6, 1.6], [1.0, 1.0]],
}


@pytest.mark.parametrize("positions", UNSAFE.values(), ids=UNSAFE.keys())
def test_relaxed_answers_part_robots_and_bring_them_back(positions):
    certificate = SingleIntegratorCertificate(0.15, 1e4, boundary=ARENA)
    positions = np.array(positions)
    command = np.full(positions.shape, 0.1)
    first = None
    for _ in range(400):
        velocity, info = certificate(command, positions)
        first = first or info
        assert np.all(np.isfinite(velocity))
        assert np.hypot(*velocity).max() <= 0.2 + 1e-9
        if info.status == "optimal":
            assert info.violation <= 1e-9
        positions = positions + STEP * velocity
    assert first.clearance < 0
    # A cubic barrier undoes the last millimetres ever more slowly.
    assert info.clearance > -0.01
    assert info.clearance > first.clearance
    assert info.status == "optimal"


@pytest.mark.parametrize("which", UNSAFE)
@pytest.mark.parametrize("policy", ["relax", "stop", "raise"])
def test_a_state_without_safe_velocity_is_never_called_optimal(which, policy):
    """At a gain this high no overlap can be undone at the demanded rate within the limits."""
    certificate = SingleIntegratorCertificate(
        0.15, 100.0, unsafe_gain=1e9, boundary=ARENA, on_infeasible=policy
    )
    positions = np.array(UNSAFE[which])
    command = np.zeros(positions.shape)
    if which == "1 mm of overlap":  # the one that can be undone in time
        assert certificate(command, positions)[1].status == "optimal"
        return
    if policy == "raise":
        with pytest.raises(InfeasibleError, match="wall" if "outside" in which else "robots"):
            certificate(command, positions)
        return
    velocity, info = certificate(command, positions)
    assert np.all(np.isfinite(velocity))
    assert np.hypot(*velocity).max() <= 0.2 + 1e-9
    assert info.violation > 1e-9
    assert info.status == ("relaxed" if policy == "relax" else "failed")


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["positions", "command"])
def test_what_is_not_a_number_stops_the_team(value, where):
    positions = np.array([[-0.5, 0.5, 0.0], [0.0, 0.0, 0.5]])
    command = np.full((2, 3), 0.1)
    (positions if where == "positions" else command)[0, 1] = value
    velocity, info = SingleIntegratorCertificate(boundary=ARENA)(command, positions)
    assert info.status == "failed"
    assert not velocity.any()


def test_margins_name_what_is_near():
    certificate = SingleIntegratorCertificate(boundary=ARENA, obstacles=[Disc((0.0, 0.5), 0.1)])
    margins = certificate.margins([[-0.1, 0.1, 1.5], [0.0, 0.0, 0.0]], within=0.1)
    assert [m.what for m in margins] == ["robot 2 and wall +x", "robots 0 and 1"]
    assert margins[0].clearance == pytest.approx(0.025)
    assert margins[1].h == pytest.approx(0.2**2 - 0.15**2)


@pytest.mark.parametrize("which", UNSAFE)
def test_relaxed_unicycles_stay_within_what_their_motors_can_do(which):
    certificate = UnicycleCertificate(
        0.15, 100.0, unsafe_gain=1e9, boundary=ARENA, turn_rate_limit=3.6, time_step=STEP
    )
    points = np.array(UNSAFE[which])
    heading = np.linspace(-2, 2, points.shape[1])
    poses = np.vstack([points - D * np.stack([np.cos(heading), np.sin(heading)]), heading])
    first = None
    for _ in range(400):
        velocity, info = certificate.project(np.zeros(points.shape), poses)
        first = first or info
        v, w = certificate.commands(velocity, poses)
        assert np.abs(v).max() <= 0.2 + 1e-9
        assert np.abs(w).max() <= 3.6 + 1e-9
        assert (np.abs(v) + 0.0525 * np.abs(w)).max() <= 12.5 * 0.016 + 1e-9
        assert info.status in ("trivial", "optimal", "relaxed")
        assert info.status != "optimal" or info.violation <= 1e-9
        poses = poses + STEP * np.stack([v * np.cos(poses[2]), v * np.sin(poses[2]), w])
    assert info.clearance > max(first.clearance, -0.06)


def test_the_first_call_says_whether_the_team_starts_unsafe():
    certificate = SingleIntegratorCertificate(0.2, boundary=ARENA, wall_margin=0.1)
    still, near = np.zeros((2, 2)), np.array([[0.0, 0.15], [0.0, 0.0]])
    _, info = certificate(still, near)
    assert info.unsafe_start
    assert info.nearest == "robots 0 and 1"
    assert info.clearance == pytest.approx(-0.05)
    assert not certificate(still, near)[1].unsafe_start, "said at the first call alone"
    certificate.reset()
    assert not certificate(still, 2 * near)[1].unsafe_start
    assert not certificate(still, near)[1].unsafe_start, "it was safe at the first call"
    certificate.reset()
    _, info = certificate(still, 2 * near + [[1.3], [0.0]])
    assert info.unsafe_start
    assert info.nearest == "robot 1 and wall +x"
