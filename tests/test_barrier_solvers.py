"""Every solver gives the one optimum, and says what it needs where it is missing."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import nnls

from barrier_certificates import solvers
from barrier_certificates.certificate_errors import ParameterError, SolverNotInstalledError
from barrier_certificates.projection import Projector
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)
RADIUS = 0.12
KINDS = ("random", "packed", "regular", "corner")
FAST = [name for name in solvers.NAMES if name != "cvxpy" and solvers.installed(name)]


def lattice(number, spacing):
    across = int(np.ceil(np.sqrt(number)))
    rows, columns = np.divmod(np.arange(number), across)
    points = spacing * np.stack([columns + 0.5 * (rows % 2), rows * np.sqrt(3) / 2])
    return points - points.mean(axis=1, keepdims=True)


def state(seed, number, kind):
    """Return commands and positions: spread, packed, on a lattice, or pressed into a corner."""
    rng = np.random.default_rng(seed)
    if kind == "random":
        positions = rng.uniform(-1, 1, (2, number)) * [[1.5], [0.9]]
    else:
        spacing = RADIUS * (1.05 if kind == "regular" else 1.02 + 0.1 * rng.random())
        positions = lattice(number, spacing)
        if kind != "regular":
            positions += rng.normal(0, 5e-4, (2, number))
        if kind == "corner":
            inside = np.array([[1.6 - RADIUS / 2], [1.0 - RADIUS / 2]])
            positions += inside - positions.max(axis=1, keepdims=True)
    command = -2 * positions if seed % 2 else rng.uniform(-0.3, 0.3, (2, number))
    return command, positions


def certify(solver, seed, number, kind):
    command, positions = state(seed, number, kind)
    gain = (100.0, 500.0, 2000.0)[seed % 3]
    if seed % 4 < 2:
        certificate = SingleIntegratorCertificate(RADIUS, gain, boundary=ARENA, solver=solver)
        return certificate(command, positions)
    heading = np.random.default_rng(seed).uniform(-np.pi, np.pi, number)
    centres = positions - 0.05 * np.stack([np.cos(heading), np.sin(heading)])
    poses = np.vstack([centres, heading])
    certificate = UnicycleCertificate(
        RADIUS, gain, boundary=ARENA, turn_rate_limit=2.0, solver=solver
    )
    return certificate.project(command, poses)


# The reference is an interior point, itself good to 1e-8 in all but the most degenerate states:
# the examples are the same in every run.
@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 50), st.sampled_from(KINDS))
@example(1, 1, "corner")  # more binding rows than velocities: scipy before 1.16 went astray
def test_all_solvers_find_the_optimum_of_the_readable_reference(seed, number, kind):
    expected, reference = certify("cvxpy", seed, number, kind)
    for solver in ("auto", *FAST):
        velocity, info = certify(solver, seed, number, kind)
        assert info.status == reference.status, solver
        if info.status == "optimal":
            assert info.violation <= 1e-9, solver
            exact = solver in ("auto", "nnls", "daqp")
            assert np.abs(velocity - expected).max() <= (1e-8 if exact else 1e-6), solver


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 50), st.sampled_from(KINDS))
@example(35, 14, "corner")
def test_exact_solvers_agree_to_1e_8_and_satisfy_the_conditions_of_optimality(seed, number, kind):
    answers = [certify(solver, seed, number, kind) for solver in ("auto", "nnls", "daqp")]
    velocity, info = answers[0]
    for other, its_info in answers[1:]:
        assert its_info.status == info.status
        assert np.abs(other - velocity).max() <= 1e-8
        assert its_info.violation <= 1e-9 or info.status == "relaxed"
    if info.status == "optimal":
        command, _ = state(seed, number, kind)
        rows = info.rows
        matrix, excess = rows.dense(np.arange(len(rows))), rows.excess(velocity.T.ravel())
        near = excess > -1e-9
        pull = (command - velocity).T.ravel()
        # Moved off binding rows only, and never towards them: v̂ − v = Aᵀλ with λ ≥ 0.
        _, residual = nnls(matrix[near].T, pull, maxiter=10_000)
        assert residual <= 1e-8


def test_a_solver_that_does_not_exist_is_refused_by_name():
    with pytest.raises(ParameterError, match="'simplex'; expected 'auto' or one of nnls, daqp"):
        SingleIntegratorCertificate(solver="simplex")


def test_a_missing_solver_says_which_extra_brings_it(monkeypatch):
    monkeypatch.setattr(solvers, "installed", lambda name: name == "nnls")
    with pytest.raises(SolverNotInstalledError, match=r"posflock-robotarium\[fast\]"):
        SingleIntegratorCertificate(solver="daqp")
    with pytest.raises(SolverNotInstalledError, match=r"posflock-robotarium\[cvxopt\]"):
        SingleIntegratorCertificate(solver="cvxopt")


def test_the_choice_goes_by_size_and_by_what_is_installed(monkeypatch):
    monkeypatch.setattr(solvers, "installed", lambda name: True)
    assert solvers.choose("auto", 18) == "daqp"
    assert solvers.choose("auto", 2000) == "piqp"
    monkeypatch.setattr(solvers, "installed", lambda name: name in ("nnls", "clarabel"))
    assert solvers.choose("auto", 18) == "nnls"
    assert solvers.choose("auto", 2000) == "clarabel"
    monkeypatch.setattr(solvers, "installed", lambda name: name in ("nnls", "cvxopt"))
    assert solvers.choose("auto", 2000) == "cvxopt"
    assert solvers.choose("osqp", 2000) == "osqp"


def test_options_hold_for_the_call_and_are_never_global():
    cvxopt = pytest.importorskip("cvxopt.solvers")
    before = dict(cvxopt.options)
    certificate = SingleIntegratorCertificate(solver="cvxopt", options={"maxiters": 77})
    _, info = certificate([[0.2, -0.2], [0.0, 0.0]], [[-0.1, 0.1], [0.0, 0.0]])
    assert info.status == "optimal"
    assert info.solver == "cvxopt"
    assert dict(cvxopt.options) == before


def test_a_solver_that_gives_up_is_not_believed():
    """Out of iterations is not infeasible: another solver is asked, and named in the report."""
    certificate = SingleIntegratorCertificate(solver="osqp", options={"max_iter": 1})
    velocity, info = certificate([[0.2, -0.2], [0.0, 0.0]], [[-0.1, 0.1], [0.0, 0.0]])
    assert info.status == "optimal"
    assert info.solver == "nnls"
    expected, _ = SingleIntegratorCertificate()([[0.2, -0.2], [0, 0]], [[-0.1, 0.1], [0, 0]])
    np.testing.assert_allclose(velocity, expected, atol=1e-12)


def test_an_interior_point_short_of_the_optimum_is_not_taken_for_it():
    """cvxopt says "unknown" when its iterations run out, however far it still has to go."""
    pytest.importorskip("cvxopt")
    command, positions = state(3, 12, "packed")
    expected, _ = SingleIntegratorCertificate(RADIUS, boundary=ARENA)(command, positions)
    for iterations in (1, 2, 4, 8):
        options = {"maxiters": iterations}
        certificate = SingleIntegratorCertificate(
            RADIUS, boundary=ARENA, solver="cvxopt", options=options
        )
        velocity, info = certificate(command, positions)
        assert info.status == "optimal"
        np.testing.assert_allclose(velocity, expected, atol=1.5e-5)


@pytest.mark.parametrize("name", solvers.NAMES)
@pytest.mark.parametrize("options", [{"no_such_option": 1}, {"maxiter": "many"}])
def test_options_that_a_solver_does_not_have_are_refused(name, options):
    if not solvers.installed(name):
        pytest.skip(f"{name} is not installed")
    certificate = SingleIntegratorCertificate(solver=name, options=options)
    with pytest.raises(ParameterError, match=name):
        certificate([[0.2, -0.2], [0.0, 0.0]], [[-0.1, 0.1], [0.0, 0.0]])


@pytest.mark.parametrize("number", [60, 250])
def test_leaving_out_far_pairs_changes_nothing(number):
    """A large team with a k-d tree gets the answer that all pairs give."""
    rng = np.random.default_rng(number)
    positions = lattice(number, 1.3 * RADIUS) + rng.normal(0, 0.1 * RADIUS, (2, number))
    command = -positions
    near = SingleIntegratorCertificate(RADIUS)
    every = SingleIntegratorCertificate(RADIUS)
    every._memory.book.prune_from = 10**9
    velocity, info = near(command, positions)
    expected, all_info = every(command, positions)
    assert len(info.rows) < len(all_info.rows)
    assert info.status == all_info.status
    np.testing.assert_allclose(velocity, expected, atol=1e-8)
    assert info.smallest_h == pytest.approx(all_info.smallest_h)
    again, _ = near(command, positions)  # started from the rows that bound
    np.testing.assert_allclose(again, expected, atol=1e-8)


@pytest.mark.parametrize("name", FAST)
def test_a_point_that_satisfies_all_rows_may_still_not_be_the_nearest(name):
    """One robot in a crowd: where scipy's routine stopped rows held, 0.06 m/s off."""
    normals = [
        [-0.9072779373158832, -0.42053150233940434],
        [0.04611657914335065, -0.9989360645847736],
        [-0.4066452890219838, 0.9135861256150003],
        [-0.7829084044846598, 0.6221369866735816],
        [0.24050867047224875, -0.9706469901193077],
        [0.3649732005612728, -0.9310180249984751],
        [-0.30680269943317356, 0.9517731366352582],
    ]
    bounds = [
        4.566670688234674, 0.19403960821813657, -0.00010865538961160155, 0.004999248290961792,
        0.15809798176574044, 9.789150784288748e-05, 0.08462804140933282,
    ]  # fmt: skip
    rows = Rows(
        np.repeat([[0], [1]], 7, axis=1), np.array(normals).T, np.array(bounds), 2,
        np.full(7, 1e6), str,
    )  # fmt: skip
    point, info = Projector(name).project(np.array([[-0.01012081], [-0.12268357]]), rows)
    assert info.status == "optimal"
    assert_allclose(point[:, 0], [2.5969654e-04, -3.33960e-06], atol=1e-6)
