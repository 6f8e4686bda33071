"""No state is called infeasible, and no team fails, because numbers are large."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from barrier_certificates import solvers
from barrier_certificates.projection import Projector
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)
EXACT = ("auto", "nnls", "daqp", "clarabel", "piqp", "cvxopt")


def overlapping(seed):
    """Return commands, positions and a firm certificate of a team of 20 to 60 that overlaps."""
    rng = np.random.default_rng(seed)
    number = int(rng.integers(20, 61))
    half = 10 ** rng.uniform(-2, 0)
    positions = rng.uniform(-half, half, (2, number))
    if rng.random() < 0.2:
        positions = positions.round(2)  # coincident robots, and robots in line
    firm = {
        "safety_radius": rng.choice([0.12, 0.17, 0.3]),
        "barrier_gain": 10 ** rng.uniform(4, 6),
        "unsafe_gain": None if rng.random() < 0.5 else 10 ** rng.uniform(4, 7),
    }
    return rng.normal(0, 0.2, (2, number)), positions, firm


def check_optimal(command, velocity, info):
    """All rows hold, and the conditions of optimality do, to rounding of the largest speed."""
    unit = max(1.0, np.abs(velocity).max())
    rows = info.rows
    excess = rows.excess(velocity.T.ravel()) / unit
    assert excess.max() <= 1e-9
    near = np.flatnonzero(excess > -1e-9)
    pull = (command - velocity).T.ravel() / unit
    _, residual = nnls(rows.dense(near).T, pull, maxiter=10_000)
    assert residual <= 1e-8


@pytest.mark.parametrize("solver", EXACT)
def test_overlapping_teams_without_speed_limit_part(solver):
    """Pairs alone can always part, each along its own ray: every one of these has an optimum."""
    if solver != "auto" and not solvers.installed(solver):
        pytest.skip(f"{solver} is not installed")
    speeds = []
    for seed in range(150 if solver == "auto" else 25):
        command, positions, firm = overlapping(seed)
        certificate = SingleIntegratorCertificate(**firm, speed_limit=None, solver=solver)
        velocity, info = certificate(command, positions)
        assert info.status == "optimal", seed
        assert info.solver in ("active set", solver) or solver in ("auto", "cvxopt"), seed
        check_optimal(command, velocity, info)
        speeds.append(info.intervention)
    assert max(speeds) > 1e5  # m/s: these are large numbers indeed


@pytest.mark.parametrize("speed_limit", [15.0, 1e3, 1e5])
def test_fast_robots_have_exact_certificates_too(speed_limit):
    rng = np.random.default_rng(7)
    optimal = 0
    for _ in range(40):
        positions = rng.uniform(-0.6, 0.6, (2, 12))
        command = rng.normal(0, speed_limit, (2, 12))
        certificate = SingleIntegratorCertificate(0.1, 1e5, speed_limit=speed_limit)
        velocity, info = certificate(command, positions)
        assert np.hypot(*velocity).max() <= speed_limit * (1 + 1e-9)
        assert info.status in ("optimal", "relaxed")
        if info.status == "optimal":
            optimal += 1
            check_optimal(command, velocity, info)
    assert optimal > 10


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 12), st.sampled_from([1.0, 30.0, 1e4, 1e8]))
def test_the_answer_does_not_depend_on_the_unit_of_speed(seed, number, unit):
    rng = np.random.default_rng(seed)
    command = rng.uniform(-0.3, 0.3, (2, number))
    positions = rng.uniform(-0.3, 0.3, (2, number))
    certificate = SingleIntegratorCertificate(0.12, 500.0, speed_limit=None)
    expected, info = certificate(command, positions)
    rows = info.rows.with_bound(unit * info.rows.bound)
    velocity, its_info = Projector().project(unit * command, rows)
    np.testing.assert_allclose(
        velocity / unit, expected, atol=1e-8 * max(1, np.abs(expected).max())
    )
    assert its_info.intervention == pytest.approx(unit * info.intervention, rel=1e-6, abs=1e-8)
    assert {info.status, its_info.status} <= {"trivial", "optimal"}


@pytest.mark.parametrize("names", [("nnls",), ("nnls", "cvxopt"), solvers.NAMES])
def test_rows_give_way_whatever_is_installed_and_motors_limits_hold(names, monkeypatch):
    installed = solvers.installed
    monkeypatch.setattr(solvers, "installed", lambda name: name in names and installed(name))
    rng = np.random.default_rng(11)
    relaxed = 0
    for _ in range(30):
        number = int(rng.integers(2, 16))
        half = 10 ** rng.uniform(-2, 0)
        poses = rng.uniform(-1, 1, (3, number)) * [[half], [half], [3.0]]
        certificate = UnicycleCertificate(
            rng.choice([0.15, 0.3, 1.0]),
            10 ** rng.uniform(2, 8),
            boundary=ARENA,
            turn_rate_limit=3.6,
        )
        (v, w), info = certificate(rng.normal(0, 0.3, (2, number)), poses)
        relaxed += info.status == "relaxed"
        assert info.status != "failed"
        assert np.abs(v).max() <= 0.2 + 1e-9
        assert np.abs(w).max() <= 3.6 + 1e-8
        assert (np.abs(v) + 0.0525 * np.abs(w)).max() <= 12.5 * 0.016 + 1e-9
    assert relaxed > 5


def test_a_large_team_without_solution_needs_no_sparse_solver(monkeypatch):
    monkeypatch.setattr(solvers, "installed", lambda name: name == "nnls")
    grid = np.array(np.meshgrid(np.arange(8), np.arange(8))).reshape(2, -1) * 0.3
    grid[:, 0] = grid[:, 1] + 0.01  # two of 64 overlap
    certificate = SingleIntegratorCertificate(unsafe_gain=1e9)
    velocity, info = certificate(np.zeros(grid.shape), grid)
    assert info.status == "relaxed"
    assert info.violated[0] == "robots 0 and 1"
    assert info.nearest == "robots 0 and 1"
    assert np.hypot(*velocity)[[0, 1]].min() > 0.1
