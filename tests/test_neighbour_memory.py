"""Who went out of range has to come well within it to count again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.flocking.neighbour_memory import NeighbourMemory


def pair(distance):
    return np.array([[0.0, distance], [0.0, 0.0]])


def linked(memory, distances):
    return [bool(memory.update(pair(distance))[0, 1]) for distance in distances]


def test_a_link_that_broke_comes_back_well_within_the_radius():
    memory = NeighbourMemory(0.75, 0.15)
    assert linked(memory, [0.74, 0.76, 0.74, 0.61, 0.59, 0.74]) == [
        True, False, False, False, True, True,
    ]  # fmt: skip
    assert linked(NeighbourMemory(0.75, 0.15), [0.74]) == [True]  # at first the radius decides


def test_a_reset_memory_begins_again():
    memory = NeighbourMemory(0.75, 0.15)
    assert linked(memory, [0.8, 0.7]) == [False, False]
    memory.reset()
    assert linked(memory, [0.7]) == [True]


def test_each_robot_remembers_by_its_own_radius():
    memory = NeighbourMemory(np.array([0.75, 0.5]), 0.1)
    memory.update(pair(0.8))
    answers = memory.update(pair(0.6))
    assert answers.tolist() == [[False, True], [False, False]]


@given(st.integers(2, 9), st.floats(0.0, 0.7), st.integers(0, 2**32 - 1))
def test_neighbours_are_within_the_radius_and_those_well_within_are_neighbours(n, band, seed):
    rng = np.random.default_rng(seed)
    memory, points = NeighbourMemory(0.75, band), rng.uniform(-1, 1, (2, n))
    for _ in range(20):
        points = points + rng.uniform(-0.1, 0.1, (2, n))
        found, by_the_paper = memory.update(points), neighbours(points, 0.75)
        assert not (found & ~by_the_paper).any()
        assert not (neighbours(points, 0.75 - band) & ~found).any()
        assert np.array_equal(found, found.T)
        if band == 0.0:
            assert np.array_equal(found, by_the_paper)


@pytest.mark.parametrize("hysteresis", [-0.1, 0.75, float("nan"), float("inf")])
def test_a_band_that_means_nothing_is_refused(hysteresis):
    with pytest.raises(ParameterError, match=r"less than the radius, 0\.75 m; got"):
        NeighbourMemory(0.75, hysteresis)
