"""Starting poses are random, apart, inside, and repeatable."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from posflock_robotarium.alignment.metrics import smallest_distance
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.placement import random_poses


@given(st.integers(2, 9), st.integers(0, 2**32 - 1))
def test_robots_are_apart_and_inside(robots, seed):
    poses = random_poses(robots, np.random.default_rng(seed), centre=(0.3, -0.2))
    assert poses.shape == (3, robots)
    assert smallest_distance(poses[:2]) >= 0.30
    assert (np.abs(poses[:2] - [[0.3], [-0.2]]) <= 0.5).all()
    assert (np.abs(poses[2]) <= np.pi).all()
    assert np.array_equal(
        poses, random_poses(robots, np.random.default_rng(seed), centre=(0.3, -0.2))
    )


@pytest.mark.parametrize(
    ("robots", "spacing", "words"),
    [
        (0, 0.3, "robots: expected a whole number from 2, got 0"),
        (1, 0.3, "robots: expected a whole number from 2, got 1"),
        (2.5, 0.3, "robots: expected a whole number from 2, got 2.5"),
        (9, -0.3, "spacing: expected more than 0 m"),
        (9, float("nan"), "spacing: expected more than 0 m"),
        (40, 0.3, "40 do not fit in a square of 1 m at a spacing of 0.3 m .at most 21 could"),
        (5, 0.8, "random placement found no way"),
    ],
)
def test_what_cannot_be_placed_is_refused(robots, spacing, words):
    with pytest.raises(ParameterError, match=words):
        random_poses(robots, np.random.default_rng(0), spacing=spacing)
