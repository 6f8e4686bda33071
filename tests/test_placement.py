"""Starting poses are random, repeatable, inside, and safe for the certificate."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posflock_robotarium.alignment.metrics import heading_vectors, smallest_distance
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE
from posflock_robotarium.flocking.placement import random_poses
from rps_compat.initial import ARRIVAL_HEADING, ARRIVAL_POSITION, near
from rps_compat.testbed import GTERNAL

D = EXPERIMENT_CERTIFICATE.projection_distance


def look_ahead_points(poses):
    return poses[:2] + D * heading_vectors(poses)


@given(st.integers(2, 9), st.integers(0, 2**32 - 1))
def test_robots_are_apart_and_inside(robots, seed):
    poses = random_poses(robots, np.random.default_rng(seed), centre=(0.3, -0.2))
    assert poses.shape == (3, robots)
    assert smallest_distance(poses[:2]) >= 0.30
    assert smallest_distance(look_ahead_points(poses)) >= 0.32
    assert (np.abs(poses[:2] - [[0.3], [-0.2]]) <= 0.5).all()
    assert (np.abs(poses[2]) <= np.pi).all()
    assert np.array_equal(
        poses, random_poses(robots, np.random.default_rng(seed), centre=(0.3, -0.2))
    )


def test_the_default_leaves_the_radius_after_the_testbeds_own_error():
    miss = ARRIVAL_POSITION + 2.0 * D * np.sin(ARRIVAL_HEADING / 2.0)
    least = EXPERIMENT_CERTIFICATE.safety_radius + 2.0 * miss
    assert least <= random_poses.__kwdefaults__["look_ahead_spacing"] < least + 0.001
    for seed in range(50):
        asked = random_poses(9, np.random.default_rng(seed))
        arrived = near(asked, GTERNAL, np.random.default_rng(seed))
        margins = EXPERIMENT_CERTIFICATE.margins(arrived, within=1.0)
        assert margins[0].clearance >= 0.0


@settings(max_examples=25)
@given(
    st.integers(2, 30),
    st.floats(0.3, 3.0),
    st.floats(0.05, 0.6),
    st.floats(0.05, 0.6),
    st.integers(0, 2**32 - 1),
)
def test_any_team_is_placed_safely_or_refused(robots, side, spacing, ahead, seed):
    distances = {"side": side, "spacing": spacing, "look_ahead_spacing": ahead}
    within = (-1.0, 1.2, -0.8, 0.8)
    try:
        poses = random_poses(robots, np.random.default_rng(seed), **distances, within=within)
    except ParameterError:
        return
    points = look_ahead_points(poses)
    assert smallest_distance(poses[:2]) >= spacing - 1e-12
    assert smallest_distance(points) >= ahead - 1e-12
    assert points[0].min() >= -1.0
    assert points[0].max() <= 1.2
    assert np.abs(points[1]).max() <= 0.8


@pytest.mark.parametrize(
    ("robots", "distances", "words"),
    [
        (0, {}, "robots: expected a whole number from 2, got 0"),
        (1, {}, "robots: expected a whole number from 2, got 1"),
        (2.5, {}, "robots: expected a whole number from 2, got 2.5"),
        (9, {"spacing": -0.3}, "spacing: expected more than 0 m"),
        (9, {"spacing": float("nan")}, "spacing: expected more than 0 m"),
        (9, {"look_ahead_spacing": 0.0}, "look_ahead_spacing: expected more than 0 m"),
        (9, {"look_ahead": -0.1}, "look_ahead: expected 0 m or more"),
        (40, {}, "40 do not fit in a square of 1 m .* room for 1[01], and no way for more than 21"),
        (5, {"spacing": 0.8}, "5 do not fit .* room for [34], and no way for more than 5 "),
        (
            20,
            {"spacing": 0.15},
            "20 do not fit .* look-ahead points 0.32 m apart .* room for 1[0-2]",
        ),
        (4, {"within": (5.0, 6.0, 5.0, 6.0)}, "these within .* room for 0"),
    ],
)
def test_what_cannot_be_placed_is_refused(robots, distances, words):
    with pytest.raises(ParameterError, match=words):
        random_poses(robots, np.random.default_rng(0), **distances)
