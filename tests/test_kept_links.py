"""Which links a team keeps, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from scipy.sparse.csgraph import minimum_spanning_tree

from barrier_certificates.certificate_errors import ParameterError
from barrier_certificates.late.late_certificate import LateCertificate
from barrier_certificates.late.late_robots import LateRobots
from barrier_certificates.rows import ConnectivityParameters
from barrier_certificates.rows.kept_links import KeptLinks, spanning_tree
from barrier_certificates.single_integrator import SingleIntegratorCertificate


@given(st.integers(0, 2**32 - 1), st.integers(1, 12))
def test_the_shortest_tree_is_the_one_that_scipy_finds(seed, number):
    points = np.random.default_rng(seed).normal(size=(2, number))
    length = np.hypot(*(points[:, :, None] - points[:, None, :]))
    found = {tuple(sorted(edge)) for edge in spanning_tree(length).T.tolist()}
    edges = np.stack(minimum_spanning_tree(length).nonzero()).T.tolist()
    assert found == {tuple(sorted(edge)) for edge in edges}


def test_robots_at_one_point_are_linked_too():
    kept = KeptLinks(ConnectivityParameters(0.6))
    links = kept.keep(np.array([[0.0, 0.0, 0.0, 0.5], [0.0, 0.0, 0.0, 0.0]]))
    assert_array_equal(links, [[0, 0, 0], [1, 2, 3]])


def test_robots_at_the_very_range_are_linked_whatever_the_last_bit_of_their_distance():
    points = np.array([[0.0, 0.1 + 0.2, 0.15], [0.0, 0.0, 0.1]])
    assert points[0, 1] > 0.3
    kept = KeptLinks(ConnectivityParameters(0.3, "all"))
    assert_array_equal(kept.keep(points), [[0, 0, 1], [1, 2, 2]])


def test_links_are_in_order_from_whatever_robot_the_tree_grew():
    along = np.array([[0.0, 0.3, 0.2, 0.1], [0.0, 0.0, 0.0, 0.0]])
    assert_array_equal(KeptLinks(ConnectivityParameters(0.15)).keep(along), [[0, 1, 2], [3, 2, 3]])


def test_all_links_are_those_of_the_first_call():
    kept = KeptLinks(ConnectivityParameters(0.45, "all"))
    apart = np.array([[0.0, 0.4, 0.2, 0.9], [0.0, 0.0, 0.1, 0.0]])
    links = kept.keep(apart)
    assert_array_equal(links, [[0, 0, 1, 1], [1, 2, 2, 3]])  # that to robot 3 is out of range
    assert kept.keep(apart[:, ::-1]) is links
    assert kept.keep(apart[:, :2]).shape == (2, 1)  # another team
    kept.forget()
    assert_array_equal(kept.keep(apart[:, ::-1]), [[0, 1, 1, 2], [2, 2, 3, 3]])


def triangle(top):
    """Return robots 0 and 1, 0.4 m apart, and robot 2 above their middle."""
    return np.array([[0.0, 0.4, 0.2], [0.0, 0.0, top]])


@pytest.mark.parametrize(("hysteresis", "top"), [(0.0, 0.346), (0.1, 0.299), (0.5, 0.0)])
def test_a_tree_is_kept_until_another_is_shorter_by_the_hysteresis(hysteresis, top):
    """Robot 2 comes down; from where its links are short enough, that of the others is dropped."""
    kept = KeptLinks(ConnectivityParameters(0.6, hysteresis=hysteresis))
    first = kept.keep(triangle(0.5))
    assert_array_equal(first, [[0, 0], [1, 2]])  # of equally long links the first is taken
    assert kept.keep(triangle(top + 0.001)) is first
    assert_array_equal(kept.choose(triangle(top - 0.001)), [[0, 1], [2, 2]] if top else first)
    assert kept.keep(triangle(top + 0.001)) is first  # to choose is not to keep


def test_the_first_tree_is_kept_for_good_as_long_as_it_is_in_range():
    kept = KeptLinks(ConnectivityParameters(0.6, hysteresis=1.0))
    assert_array_equal(kept.keep(triangle(0.2)), [[0, 1], [2, 2]])
    assert_array_equal(kept.keep(triangle(0.5)), [[0, 1], [2, 2]])
    moved = triangle(0.5)
    moved[0, 2] = -0.01  # out of range of robot 1
    assert_array_equal(kept.keep(moved), [[0, 0], [1, 2]])


def connected(connectivity, **more):
    return SingleIntegratorCertificate(connectivity=connectivity, **more)


def test_a_step_may_be_as_long_as_turns_rows_by_thirty_degrees():
    certificate = connected(ConnectivityParameters(0.8, time_step=1.0), speed_limit=0.2)
    velocity, _ = certificate([[-1.0, 1.0], [0.5, 0.0]], [[-0.35, 0.35], [0.0, 0.0]])
    assert np.hypot(*(velocity @ [-1.0, 1.0] + [0.7, 0.0])) <= 0.8


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: ConnectivityParameters(0.0), "communication_range is 0.0"),
        (lambda: ConnectivityParameters(0.4, gain=-1.0), "gain is -1.0"),
        (lambda: ConnectivityParameters(0.4, hysteresis=1.5), "hysteresis is 1.5"),
        (lambda: ConnectivityParameters(0.4, hysteresis=-0.5), "hysteresis is -0.5"),
        (lambda: ConnectivityParameters(0.4, time_step=-0.1), "time_step is -0.1"),
        (lambda: ConnectivityParameters(0.4, "star"), "links are 'star'; expected one of tree"),
        (lambda: ConnectivityParameters(0.4, [(0, 0)]), "two different robots"),
        (lambda: ConnectivityParameters(0.4, [(-1, 2)]), "links are"),
        (lambda: ConnectivityParameters(0.4, [(0, 1), (1,)]), "links are"),
        (lambda: ConnectivityParameters(0.4, [(0.5, 1)]), "links are"),
        (lambda: ConnectivityParameters(0.4, []), "links are"),
        (lambda: connected(0.4), "connectivity is 0.4"),
        (lambda: connected(ConnectivityParameters(0.15)), "more than the 0.15 m"),
        (lambda: connected(ConnectivityParameters(0.4, time_step=1.0)), "expected at least 0.8 m"),
        (lambda: connected(ConnectivityParameters(9.0, time_step=1), speed_limit=None), "a speed"),
        (
            lambda: LateCertificate(
                0.2, 2000.0, speed_limit=0.15, turn_rate_limit=0.55, time_step=0.033,
                robots=LateRobots(dead_time=(0.19, 0.2)), connectivity=ConnectivityParameters(0.6),
            ),
            "late robots keeps no links",
        ),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(make, says):
    with pytest.raises(ParameterError, match=says):
        make()
