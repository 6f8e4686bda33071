"""Runs side by side: their groups, their means, and how sure these are."""

import dataclasses

import numpy as np
import pytest

from posflock_robotarium.alignment.comparison import compare, distinctly_named, spread_of
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.report import analyse


def test_the_bootstrap_interval_covers_the_mean_about_as_often_as_it_says():
    rng = np.random.default_rng(5)
    covered = 0
    for k in range(200):
        spread = spread_of(rng.normal(3.0, 1.0, 20), seed=k)
        covered += spread.low <= 3.0 <= spread.high
    assert 178 <= covered <= 198  # 95 % in theory, a little less for twenty values


def test_fewer_than_three_runs_have_no_interval():
    assert np.isnan(spread_of(np.array([1.0, 2.0])).low)
    assert spread_of(np.array([np.nan, np.nan])).runs == 0
    assert spread_of(np.array([1.0, 2.0, 4.0]), seed=1) == spread_of(
        np.array([1.0, 2.0, 4.0]), seed=1
    )


def test_simulation_and_reality_side_by_side():
    runs = []
    for simulated, seed in ((True, 0), (True, 1), (False, 2)):
        flock = known_flock("parallel", 0.1, duration=5.0, seed=seed)
        recording = dataclasses.replace(flock.recording, parameters={"simulated": simulated})
        runs.append(analyse(recording, radius=flock.radius))
    comparison = compare(distinctly_named(runs))
    assert comparison.groups == ("simulation", "testbed")
    row = next(row for row in comparison.rows if row.key == "gamma_motion")
    assert row.by_label["simulation"].runs == 2
    assert row.by_label["simulation"].mean == pytest.approx(np.mean(row.values[:2]))
    assert len({a.name for a in comparison.analyses}) == 3
    with pytest.raises(ParameterError, match="labels"):
        compare(runs, ["a"])
