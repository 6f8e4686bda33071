"""The filter changes nothing where robots obey, and saves the flock where they answer late."""

import numpy as np
import pytest

from posflock_robotarium.alignment.metrics import alignment, smoothed_velocities
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.flocking.pose_filter import PoseFilter, PoseFilterParameters
from rps_compat.arena import Arena
from rps_compat.profiles import load_profile
from rps_compat.testbed import GTERNAL

STEP = 0.033


def fly(profile, seconds, filtering=None, seed=0):
    """Return tracked poses (T, 3, 9) and the arena of a run."""
    start = random_poses(9, np.random.default_rng(seed))
    arena = Arena(
        start, GTERNAL, realism=load_profile(profile).start(), rng=np.random.default_rng(seed)
    )
    flock = Flock(time_step=STEP, filtering=filtering)
    seen = np.empty((flock.steps_in(seconds), 3, 9))
    for k in range(len(seen)):
        seen[k] = arena.observe()
        arena.commands = flock.step(seen[k]).command
        arena.step()
    return seen, arena


def gamma(seen):
    velocity = smoothed_velocities(seen[:, :2], STEP)
    late = np.arange(len(seen)) * STEP > 20.0
    return float(np.nanmean(alignment(velocity, seen[:, :2], 0.75).gamma[late]))


AT_ONCE = PoseFilterParameters(rate=1 / STEP, lost=1e-9)


def test_robots_that_obey_are_where_the_filter_says():
    with_filter, _ = fly("ideal", 20.0)
    without, _ = fly("ideal", 20.0, AT_ONCE)
    np.testing.assert_allclose(with_filter, without, atol=1e-9)


def test_the_flock_aligns_on_late_robots_with_the_filter_and_not_without():
    aligned, arena = fly("gritsbot_x", 35.0)
    assert gamma(aligned) >= 0.95
    assert arena.violations.clean
    assert gamma(fly("gritsbot_x", 35.0, AT_ONCE)[0]) < 0.5


def test_errors_decay_at_the_rate():
    pose_filter = PoseFilter(PoseFilterParameters(rate=0.5), STEP)
    pose_filter.update(np.zeros((3, 1)))
    displaced = np.array([[0.1], [0.0], [0.2]])
    for _ in range(round(2.0 / STEP)):
        pose_filter.moved(np.zeros((2, 1)))
        pose = pose_filter.update(displaced)
    np.testing.assert_allclose(displaced - pose, displaced * np.exp(-1.0), rtol=0.02)


def test_headings_are_corrected_the_short_way_round():
    pose_filter = PoseFilter(PoseFilterParameters(), STEP)
    pose_filter.update(np.array([[0.0], [0.0], [np.pi - 0.01]]))
    pose_filter.moved(np.zeros((2, 1)))
    turned = pose_filter.update(np.array([[0.0], [0.0], [-np.pi + 0.01]]))[2, 0]
    assert np.pi - 0.01 < turned < np.pi


def test_a_robot_that_was_carried_away_is_believed_at_once():
    pose_filter = PoseFilter(PoseFilterParameters(lost=0.15), STEP)
    pose_filter.update(np.zeros((3, 2)))
    pose_filter.moved(np.zeros((2, 2)))
    seen = np.array([[0.5, 0.0], [0.0, 0.0], [1.0, 0.0]])
    assert pose_filter.update(seen) == pytest.approx(seen, abs=1e-12)


def test_bad_parameters_are_refused():
    for wrong in ({"rate": 0.0}, {"rate": np.nan}, {"lost": -1.0}):
        with pytest.raises(ParameterError):
            PoseFilterParameters(**wrong)
    with pytest.raises(ParameterError, match="update first"):
        PoseFilter(PoseFilterParameters(), STEP).moved(np.zeros((2, 1)))
