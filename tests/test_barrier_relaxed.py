"""Where no velocity satisfies all rows: the least broken is the optimum of a priced program."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from barrier_certificates import solvers
from barrier_certificates.certificate_errors import InfeasibleError, ParameterError, ShapeError
from barrier_certificates.projection import ProjectionInfo, Projector, Status
from barrier_certificates.projection.infeasible import least_broken
from barrier_certificates.projection.scaled_program import TOLERANCE, QuadraticProgram
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.single_integrator import SingleIntegratorCertificate

NEVER = math.inf  # the price of a hard limit
APART = {0: 1.0, 2: -1.0}  # the first robot is to go left of the second


def rows_of(robots, *entries):
    """Return rows from ({unknown: coefficient}, bound, price)."""
    size = 2 * robots
    index = np.full((4, len(entries)), size)
    coefficient = np.zeros(index.shape)
    for k, (terms, _, _) in enumerate(entries):
        index[: len(terms), k] = list(terms)
        coefficient[: len(terms), k] = list(terms.values())
    bounds, prices = (np.array([entry[part] for entry in entries], float) for part in (1, 2))
    return Rows(index, coefficient, bounds, size, prices, lambda row: f"row {row}")


def speed_limits(robots, top=0.2):
    """Return the limits of each unknown, both ways."""
    return [({k: sign}, top, NEVER) for k in range(2 * robots) for sign in (1.0, -1.0)]


def least_by_price(rows, command, top):
    """Return argmin ‖v − v̂‖² + Σ price · excess², by a least distance program (Lawson, Hanson)."""
    soft = np.flatnonzero(np.isfinite(rows.weight))
    slack = np.zeros((len(rows), len(soft)))
    slack[soft, np.arange(len(soft))] = -1.0 / np.sqrt(rows.weight[soft])
    matrix = np.hstack([rows.dense(np.arange(len(rows))), slack])
    start = np.concatenate([command / top, np.zeros(len(soft))])
    bound = np.maximum(rows.bound / top, -math.sqrt(2.0))  # nobody parts faster
    system = np.vstack([-matrix.T, matrix @ start - bound])
    aim = np.eye(len(system))[-1]
    multipliers, _ = nnls(system, aim, maxiter=10_000)
    residual = system @ multipliers - aim
    return top * (start - residual[:-1] / residual[-1])[: rows.size]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 5), st.sampled_from([0.15, 15.0, 1e3]))
def test_the_least_broken_is_the_optimum_of_the_priced_program(seed, number, top):
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-0.12, 0.12, (2, number))
    command = rng.normal(0, top, (2, number))
    certificate = SingleIntegratorCertificate(
        0.17, 1e6, boundary=(-0.1, 0.1, -0.1, 0.1), speed_limit=top
    )
    _, info = certificate(command, positions)
    velocity, info = Projector().project(command, info.rows, top)
    if info.status != "relaxed":
        return
    expected = least_by_price(info.rows, command.T.ravel(), top)
    np.testing.assert_allclose(velocity.T.ravel() / top, expected / top, atol=2e-6)
    excess = info.rows.excess(velocity.T.ravel())
    hard = np.isinf(info.rows.weight)
    assert excess[hard].max() <= TOLERANCE * max(1.0, top)
    assert info.violation == pytest.approx(excess.max(), rel=1e-9)
    assert info.broken[0] == np.argmax(excess)
    assert (np.diff(excess[info.broken]) <= 1e-9 * top).all()
    assert set(np.flatnonzero(excess > 1e-7 * top)) <= set(info.broken)
    bound = np.maximum(info.rows.bound, -math.sqrt(2.0) * top)
    beyond = excess + info.rows.bound - bound
    assert set(np.flatnonzero(beyond > 1e-6 * top)) <= set(info.binding)
    assert (beyond[info.binding] > -1e-5 * top).all()


class Told:
    """In the place of a search: keeps what it is asked, and says what it was made with."""

    def __init__(self, *velocity):
        self.velocity = velocity

    def solve(self, target, rows, working, info, tolerance):
        self.target, self.rows, self.tolerance = target, rows, tolerance
        assert working.all()
        assert len(working) == len(rows)
        answer = np.zeros(rows.size)
        answer[: len(self.velocity)] = self.velocity
        answer[len(self.velocity) :] = 1e3  # slacks for whatever is wanted
        return answer


def told(rows, velocity, command=None, top=0.2):
    search = Told(*velocity)
    program = QuadraticProgram.of(np.zeros(rows.size) if command is None else command, rows, top)
    return least_broken(program, search, ProjectionInfo(Status.OPTIMAL)), search


@pytest.mark.parametrize(
    ("prices", "largest"), [((1e6, 1e4), 1e3), ((1e4, 1e4), 1e2), ((0.01,), 1)]
)
def test_slacks_are_large_numbers_so_that_rows_may_be_broken_by_more(prices, largest):
    """A slack is the root of its price times what it stands for, never less than that."""
    rows = rows_of(2, *speed_limits(2), *((APART, -1.0, price) for price in prices))
    command = np.array([0.1, 0.0, 0.05, -0.05])
    _, search = told(rows, [0.0] * 4, command)
    assert search.tolerance == pytest.approx(largest * TOLERANCE)
    np.testing.assert_array_equal(search.target[:4], command)
    assert not search.target[4:].any()
    reachable = max(-1.0, -math.sqrt(2.0) * 0.2)
    np.testing.assert_allclose(search.rows.bound, [reachable] * len(prices))


def test_hard_limits_alone_are_not_softened():
    rows = rows_of(1, ({0: 1.0}, -0.1, NEVER), ({0: -1.0}, -0.1, NEVER))
    point, search = told(rows, [0.05, 0.0])
    assert search.tolerance == TOLERANCE
    assert point is None  # whatever the speed, one of them is broken by 0.1 or more


@pytest.mark.parametrize("robot", [0, 1, 2])
def test_a_robot_over_its_limit_by_rounding_is_shortened_alone(robot):
    limits = [({2 * robot: 1.0}, 0.2, NEVER), ({2 * robot + 1: 1.0}, 0.1, NEVER)]
    rows = rows_of(3, *limits, (APART, -1.0, 1e6), ({1: 1.0}, -1.0, 1e6))
    over = np.full(6, 0.05)
    over[2 * robot : 2 * robot + 2] = [0.2 + 2e-8, 0.1 + 3e-8]
    point, _ = told(rows, over)
    part = np.ones(6)
    part[2 * robot : 2 * robot + 2] = 0.1 / (0.1 + 3e-8)  # the stricter of the two
    np.testing.assert_allclose(point, part * over, rtol=1e-13)
    assert (rows.excess(point)[:2] <= TOLERANCE).all()
    over[2 * robot + 1] = 0.05  # the first alone
    point, _ = told(rows, over)
    assert point[2 * robot] == pytest.approx(0.2, abs=1e-15)


def test_where_a_robot_may_not_move_it_stands():
    rows = rows_of(2, ({0: 1.0}, 0.0, NEVER), ({2: 1.0}, 0.0, NEVER), (APART, -1.0, 1e6))
    point, _ = told(rows, [1e-8, 0.1, 0.0, 0.1])
    np.testing.assert_array_equal(point, [0.0, 0.0, 0.0, 0.1])


def test_what_cannot_be_shortened_is_no_answer():
    rows = rows_of(2, ({0: 1.0}, -0.1, NEVER), ({2: 1.0}, 0.2, NEVER), (APART, -1.0, 1e6))
    point, _ = told(rows, [-0.1 + 1e-6, 0.0, 0.1, 0.0])
    assert point is None


def test_without_hard_limits_the_answer_stands():
    rows = rows_of(2, (APART, -1.0, 1e6), ({0: -1.0}, -0.3, 1e4))
    point, _ = told(rows, [5.0, 0.0, 0.1, 0.0])
    np.testing.assert_array_equal(point, [5.0, 0.0, 0.1, 0.0])


def test_the_error_names_the_three_rows_that_are_furthest_from_holding_in_metres_a_second():
    for scale in (1.0, 1e4):
        pulls = [({k: -1.0}, -scale * ask, 1e6) for k, ask in enumerate((0.3, 0.5, 0.9, 0.4))]
        rows = rows_of(2, *speed_limits(2, 0.2 * scale), *pulls)
        words = "; ".join(
            f"row {k} \\({scale * ask:.3g} m/s\\)" for k, ask in ((10, 0.9), (9, 0.5), (11, 0.4))
        ).replace("+", r"\+")
        with pytest.raises(InfeasibleError, match=f"all 12 rows; .* most: {words}\\. Part"):
            Projector(on_infeasible="raise").project(np.zeros((2, 2)), rows, 0.2 * scale)
    one = rows_of(2, *speed_limits(2), ({0: -1.0}, -0.3, 1e6))
    with pytest.raises(InfeasibleError, match=r"most: row 8 \(0.3 m/s\)\. Part"):
        Projector(on_infeasible="raise").project(np.zeros((2, 2)), one, 0.2)


def test_a_report_prints_without_its_arrays():
    assert repr(ProjectionInfo(Status.TRIVIAL)) == (
        "ProjectionInfo(status=<Status.TRIVIAL: 'trivial'>, violation=0.0, iterations=0, solver='',"
        " intervention=0.0, clearance=inf, smallest_h=inf, unsafe_start=False,"
        " range_left=inf, disconnected_start=False, stuck=array([], dtype=int64))"
    )
    new = ProjectionInfo(Status.TRIVIAL)
    assert (new.rows, new.nearest_row, new.nearest, new.active, new.violated) == (
        None, -1, None, (), (),
    )  # fmt: skip
    assert not new.deadlocked
    assert ProjectionInfo(Status.TRIVIAL, stuck=np.array([0])).deadlocked


def test_policies_have_names():
    with pytest.raises(ParameterError, match="'panic'; expected one of relax, stop, raise"):
        Projector(on_infeasible="panic")
    assert Projector().on_infeasible == "relax"
    with pytest.raises(ParameterError, match="expected its name too"):
        Projector(options={"maxiter": 7})


def test_commands_of_another_team_are_refused():
    rows = rows_of(2, *speed_limits(2))
    for shape in ((2, 3), (2, 1), (3, 2), (4,)):
        with pytest.raises(ShapeError, match=r"the rows are for \(2, 2\)"):
            Projector().project(np.zeros(shape), rows)


def test_without_rows_every_command_is_safe():
    velocity, info = Projector().project(np.full((2, 1), 0.3), rows_of(1))
    np.testing.assert_array_equal(velocity, [[0.3], [0.3]])
    assert (info.status, info.violation) == ("trivial", 0.0)


@pytest.mark.parametrize(
    ("over", "status"), [(-0.1, "trivial"), (5e-10, "trivial"), (5e-9, "optimal")]
)
def test_a_row_holds_that_is_broken_by_rounding(over, status):
    rows = rows_of(1, ({0: 1.0}, 0.1, NEVER))
    velocity, info = Projector().project(np.array([[0.1 + over], [0.0]]), rows)
    assert info.status == status
    assert info.violation == pytest.approx(
        max(over, 0.0) if status == "trivial" else 0.0, abs=1e-15
    )
    assert velocity[0, 0] == pytest.approx(0.1 + (over if status == "trivial" else 0.0), abs=1e-15)


@pytest.mark.parametrize("top", [0.2, 5.0])
@pytest.mark.parametrize(("ask", "status"), [(1.2, "optimal"), (1.5, "relaxed")])
def test_two_robots_part_as_fast_as_both_can_and_no_faster(ask, status, top):
    """A pair's row has unit norm: √2 times the top speed is the most that can be asked of it."""
    norm = math.sqrt(0.5)
    pair = ({0: norm, 2: -norm}, -ask * top, 1e6)
    rows = rows_of(2, *speed_limits(2, top), pair)
    for solver in ("auto", "nnls"):
        velocity, info = Projector(solver).project(np.zeros((2, 2)), rows, top)
        assert info.status == status
        speed = min(ask / math.sqrt(2.0), 1.0) * top
        np.testing.assert_allclose(velocity, [[-speed, speed], [0, 0]], atol=1e-6 * top)


@pytest.mark.parametrize("top", [0.2, 1e3])
def test_commands_from_afar_keep_their_direction_and_the_speed_that_there_is(top):
    rows = rows_of(2, *speed_limits(2, top))
    velocity, info = Projector().project(np.array([[1e15, 0.1], [-1e15, 0.0]]), rows, top)
    assert info.status == "optimal"
    np.testing.assert_allclose(velocity, [[top, 0.1], [-top, 0.0]], rtol=1e-9, atol=1e-9)


def test_other_rows_next_time_are_other_rows():
    """What bound last time is known by its number only, where rows have no names."""
    projector = Projector()
    many = rows_of(2, *speed_limits(2), ({0: 1.0}, 0.1, NEVER))
    few = rows_of(2, ({1: 1.0}, 0.05, NEVER))
    command = np.full((2, 2), 0.15)
    for rows, first in ((many, [0.1, 0.15]), (few, [0.15, 0.05]), (many, [0.1, 0.15])) * 2:
        for _ in range(2):
            velocity, info = projector.project(command, rows)
            assert info.status == "optimal"
            np.testing.assert_allclose(velocity, np.transpose([first, [0.15, 0.15]]), atol=1e-12)


@pytest.fixture
def conversation(monkeypatch):
    """Let answers be given for solvers by turns, and keep what they were asked."""
    asked, answers = [], []

    def solve(name, rows, which, target, options):
        asked.append((name, which.tolist(), dict(options)))
        return answers.pop(0)

    monkeypatch.setattr(solvers, "solve", solve)
    monkeypatch.setattr(solvers, "installed", lambda name: True)
    monkeypatch.setattr(solvers, "LARGE", 0)
    return asked, answers


WALLS = (({0: 1.0}, 0.1, NEVER), ({1: 1.0}, 0.1, NEVER))


def test_who_finds_nothing_or_breaks_its_rows_is_not_believed(conversation):
    asked, answers = conversation
    rows = rows_of(1, *WALLS)
    right = np.array([0.1, 0.1])
    answers[:] = [None, np.array([0.1, 0.3]), right]
    command = np.array([[0.3], [0.3]])
    velocity, info = Projector("nnls", options={"maxiter": 7}).project(command, rows)
    np.testing.assert_array_equal(velocity, [[0.1], [0.1]])
    names = [name for name, _, _ in asked]
    assert len(set(names)) == 3
    assert names[0] == "nnls"
    assert info.solver == names[2]
    assert info.iterations == 3
    assert [options for _, _, options in asked] == [{"maxiter": 7}, {}, {}]
    assert {tuple(which) for _, which, _ in asked} == {(0, 1)}


def test_rows_that_an_answer_breaks_are_added(conversation):
    asked, answers = conversation
    rows = rows_of(1, *WALLS, ({0: -1.0}, 0.0, NEVER))
    answers[:] = [np.array([-0.2, 0.1]), np.array([0.05, 0.1])]
    command = np.array([[0.05], [0.3]])
    velocity, info = Projector("nnls").project(command, rows)
    np.testing.assert_array_equal(velocity, [[0.05], [0.1]])
    assert [which for _, which, _ in asked] == [[1], [1, 2]]
    assert info.iterations == 2
    assert info.binding.tolist() == [1]  # the added one is idle after all
    assert info.violation == 0.0


def test_the_violation_is_what_the_answer_breaks_its_rows_by(conversation):
    _, answers = conversation
    rows = rows_of(1, *WALLS)
    for answer, violation in (([0.1 + 5e-10, 0.1], 5e-10), ([0.1 - 5e-10, 0.1 - 4e-10], 0.0)):
        answers[:] = [np.array(answer)]
        _, info = Projector("nnls").project(np.array([[0.3], [0.3]]), rows)
        assert info.violation == pytest.approx(violation, abs=1e-15)
        assert info.binding.tolist() == [0, 1]
