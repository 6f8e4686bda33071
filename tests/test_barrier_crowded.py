"""Large teams that press together: rows are exchanged one by one, and the answer is the optimum."""

from unittest.mock import patch

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from barrier_certificates.rows.row_set import Rows
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from barrier_certificates.solvers import row_exchange
from barrier_certificates.solvers.equations import intersection

RADIUS, SPEED, STEP = 0.15, 0.2, 0.033


def packed(number, seed):
    """Return positions on a shaken grid, hardly more than the radius apart."""
    random = np.random.default_rng(seed)
    across = int(np.ceil(np.sqrt(number)))
    grid = np.stack(np.divmod(np.arange(number), across)).astype(float)
    return 1.08 * RADIUS * grid + random.uniform(-0.004, 0.004, (2, number))


def certificate(positions, **others):
    low, high = positions.min(axis=1) - RADIUS, positions.max(axis=1) + RADIUS
    boundary = (low[0], high[0], low[1], high[1])
    return SingleIntegratorCertificate(RADIUS, 100.0, boundary=boundary, **others)


def towards(goals, positions):
    way = goals - positions
    return way * (SPEED / np.maximum(np.hypot(*way), SPEED))


def pressed(number, seed, steps, certify):
    """Drive a packed team to its middle; yield commands, velocities and what was done."""
    positions = packed(number, seed)
    goals = 0.5 * (positions + positions.mean(axis=1, keepdims=True))
    for _ in range(steps):
        desired = towards(goals, positions)
        velocity, info = certify(desired, positions)
        yield desired, positions, velocity, info
        positions = positions + STEP * velocity


def conditions_of_optimality(desired, velocity, info):
    """Return what is left of v̂ − v beyond what binding rows push, and their smallest push."""
    rows = info.rows
    assert_allclose(rows.excess(velocity.T.ravel())[info.binding], 0.0, atol=1e-9)
    matrix = rows.dense(info.binding)
    moved = (desired - velocity).T.ravel()
    push, *_ = np.linalg.lstsq(matrix.T, moved, rcond=None)
    return np.abs(moved - push @ matrix).max(), push.min()


def test_a_team_that_presses_together_needs_no_interior_point_after_the_first_step():
    certify = certificate(packed(225, 0))
    answers = [info for *_, info in pressed(225, 0, 12, certify)]
    assert {info.status for info in answers} == {"optimal"}
    assert [info.solver for info in answers[1:]] == ["active set"] * 11
    assert min(info.binding.shape[0] for info in answers) > 0.9 * 2 * 225


@settings(max_examples=3, deadline=None)
@given(st.integers(0, 10**6), st.integers(100, 110))
def test_whoever_answers_it_is_the_optimum(seed, number):
    certify = certificate(packed(number, seed))
    other = certificate(packed(number, seed), solver="clarabel")
    for desired, positions, velocity, info in pressed(number, seed, 3, certify):
        assert info.status == "optimal"
        assert info.violation <= 1e-9
        left, push = conditions_of_optimality(desired, velocity, info)
        assert left <= 1e-10
        assert push >= -1e-9
        assert_allclose(velocity, other(desired, positions)[0], atol=1e-8)


def last_step(number, seed):
    """Return rows of a packed team, a target, its excess, and the rows that bind."""
    *_, (desired, _, _, info) = pressed(number, seed, 2, certificate(packed(number, seed)))
    target = desired.T.ravel()
    return info.rows, target, info.rows.excess(target), info.binding


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6), st.integers(100, 130))
def test_rows_that_came_wrongly_go_and_those_that_went_come_back(seed, number):
    rows, target, excess, right = last_step(number, seed)
    random = np.random.default_rng(seed)
    wrong = np.setdiff1d(right, random.choice(right, 4))
    wrong = np.union1d(wrong, random.choice(8 * number, 1))  # a limit that nobody reaches
    start = intersection(rows, target, excess, wrong)
    with patch.object(row_exchange, "room", lambda size: size):
        found = row_exchange.exchanged(rows, target, excess, start, 1e-9)
    expected = intersection(rows, target, excess, right).point
    assert_allclose(intersection(rows, target, excess, found).point, expected, atol=1e-9)


def test_who_has_no_room_for_all_changes_says_so():
    rows, target, excess, right = last_step(120, 0)
    start = intersection(rows, target, excess, right[:-30])
    assert row_exchange.exchanged(rows, target, excess, start, 1e-9) is None


def test_a_row_that_depends_on_those_that_bind_takes_the_place_of_one():
    rows, target, _, right = last_step(120, 1)
    count, tighter = len(rows), right[[5, 100, 180]]
    bound = np.append(rows.bound, rows.bound[tighter] - 1e-4)
    twice = np.append(np.arange(count), tighter)
    doubled = Rows(
        rows.index[:, twice],
        rows.coefficient[:, twice],
        bound,
        rows.size,
        rows.weight[twice],
        lambda row: str(row),
    )
    excess = doubled.excess(target)
    found = row_exchange.exchanged(
        doubled, target, excess, intersection(doubled, target, excess, right), 1e-9
    )
    assert set(count + np.arange(3)) <= set(found)
    assert not set(tighter) & set(found)
    point = intersection(doubled, target, excess, found).point
    assert doubled.excess(point).max() <= 1e-9


def test_where_no_point_satisfies_all_rows_there_are_none_that_bind():
    rows, target, _, right = last_step(120, 2)
    bound = rows.bound.copy()
    ahead, back = 60, 4 * 120 + 60  # opposite sides of one robot's octagon
    assert_allclose(rows.coefficient[:2, ahead], -rows.coefficient[:2, back], atol=1e-12)
    bound[[ahead, back]] = -0.05
    rows = rows.with_bound(bound)
    excess = rows.excess(target)
    start = intersection(rows, target, excess, right)
    assert row_exchange.exchanged(rows, target, excess, start, 1e-9) is None
