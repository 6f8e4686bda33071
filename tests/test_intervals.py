"""Intervals over runs: Wilson's of a share, bootstrapped of a median."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.stats import binomtest

from posflock_robotarium.alignment import intervals as intervals_module
from posflock_robotarium.alignment.intervals import (
    mean_interval,
    median_interval,
    told_interval,
    wilson_interval,
)


@given(st.integers(1, 200), st.data())
def test_wilson_intervals_hold_the_proportion_and_stay_inside(trials, data):
    hits = data.draw(st.integers(0, trials))
    low, high = wilson_interval(hits, trials)
    assert 0.0 <= low <= hits / trials <= high <= 1.0
    assert high - low < 1.0


def test_wilson_intervals_are_the_textbook_ones():
    assert wilson_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=1e-4)
    assert wilson_interval(10, 20) == pytest.approx((0.2993, 0.7007), abs=1e-4)


@pytest.mark.parametrize(("hits", "trials"), [(0, 3), (18, 20), (96, 100), (100, 100), (1, 2000)])
def test_wilson_intervals_are_those_of_scipy(hits, trials):
    known = binomtest(hits, trials).proportion_ci(method="wilson")
    assert wilson_interval(hits, trials) == pytest.approx((known.low, known.high), abs=1e-7)


def test_fewer_than_three_runs_tell_no_interval():
    assert told_interval(2, 2) is None
    assert told_interval(3, 3) == wilson_interval(3, 3)
    for values in (np.array([1.0, 2.0]), np.array([1.0, 2.0, np.nan])):
        assert np.isnan(median_interval(values)).all()
    assert np.isnan(mean_interval(np.array([1.0, 2.0]))).all()


def test_the_interval_covers_the_median():
    """A 95 % interval misses the true median in about one of twenty samples."""
    generator = np.random.default_rng(0)
    missed = 0
    for _ in range(1000):
        low, high = median_interval(generator.normal(size=30))
        assert low <= high
        missed += not low <= 0.0 <= high
    assert 25 <= missed <= 90
    assert median_interval(np.array([1.0, np.inf, np.inf]))[1] == np.inf


@pytest.mark.parametrize("runs", [3, 20, 99, 100])
def test_the_interval_of_a_median_is_that_of_resampling_it(runs):
    """Drawing ranks is drawing runs: the plain way finds the same ends, up to its own chance."""
    values = np.sort(np.random.default_rng(3).normal(size=runs))
    drawn = np.random.default_rng(4).integers(runs, size=(20_000, runs))
    plain = np.percentile(np.median(values[drawn], axis=1), [2.5, 97.5], method="nearest")
    places = np.searchsorted(values, [plain, median_interval(values)])
    assert np.abs(np.diff(places, axis=0)).max() <= 1 + runs // 50


def test_the_interval_of_a_median_is_the_same_in_every_process():
    values = np.random.default_rng(7).normal(size=101)
    intervals = set()
    for _ in range(5):
        intervals.add(median_interval(values))
        intervals_module._ranks_of_medians.cache_clear()  # as in a process that has just begun
    assert len(intervals) == 1


@given(
    arrays.arrays(
        float, st.integers(3, 40), elements=st.floats(-1e6, 1e6) | st.just(np.inf), unique=False
    ),
    st.randoms(use_true_random=False),
)
def test_the_interval_of_a_median_hangs_on_the_values_alone(values, random):
    low, high = median_interval(values)
    assert values.min() <= low <= np.median(values) <= high <= values.max()
    shuffled = values.copy()
    random.shuffle(shuffled)
    assert median_interval(shuffled) == (low, high)
