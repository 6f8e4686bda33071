"""A run that is being measured: time that samples stand for, stretches, what is kept."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_numbers import eventful

from posflock_robotarium.alignment import measured_run
from posflock_robotarium.alignment.measured_run import weighted_mean
from posflock_robotarium.alignment.measuring import measure
from posflock_robotarium.alignment.options import TRANSIENT, AnalysisOptions
from posflock_robotarium.report import Run, analyse


def run_at(t, robots=2, **options):
    poses = np.zeros((len(t), 3, robots))
    poses[:, 0] = 0.1 * np.asarray(t)[:, None]
    poses[:, 1] = 0.3 * np.arange(robots)
    return measure(Run("run", np.asarray(t), poses), AnalysisOptions(radius=1.0, **options))


@pytest.mark.parametrize(
    ("steps", "weights"),
    [
        ([0.1, 0.1, 0.1], [1.0, 1.0, 1.0, 1.0]),
        ([0.1, 0.2, 0.3], [0.1, 0.2, 0.3, 0.2]),  # one step is the mean of all
        ([0.03301, 0.033, 0.033], [0.03301, 0.033, 0.033, 0.033]),
        ([0.1, 0.1, 5.0, 0.1], [0.1, 0.1, 0.1, 0.1, 0.1]),  # nobody knows what was in a gap
    ],
)
def test_a_sample_stands_for_the_time_to_the_next(steps, weights):
    run = run_at(np.r_[2.0, 2.0 + np.cumsum(steps)])
    np.testing.assert_allclose(run.weights, weights, rtol=1e-12)


@given(
    st.lists(st.tuples(st.floats(-5, 5) | st.just(math.nan), st.floats(0.1, 3)), min_size=1),
    st.booleans(),
)
def test_a_mean_is_over_what_is_defined(samples, alike):
    values, weights = np.array(samples).T
    weights = np.full(len(samples), 1.0) if alike else weights
    known = [(value, w) for value, w in zip(values, weights, strict=True) if value == value]
    total = sum(w for _, w in known)
    expected = sum(value * w for value, w in known) / total if known else math.nan
    assert weighted_mean(values, weights) == pytest.approx(expected, nan_ok=True, abs=1e-12)


def test_when_the_settled_part_begins():
    t = np.arange(40.0)
    assert run_at(t).transient == TRANSIENT
    assert run_at(t).since == f"after {TRANSIENT + 1:.0f} s"
    assert run_at(t, transient=3.0).transient == 3.0
    assert run_at(t, transient=0.0).transient == 0.0
    assert run_at(t[:10]).since == "of the whole run"


@pytest.mark.parametrize("pairs", [1, 9, 26, 27, 10**6])
@pytest.mark.parametrize("robots", [1, 3])
def test_stretches_hold_as_many_pairs_as_were_agreed_on(pairs, robots, monkeypatch):
    monkeypatch.setattr(measured_run, "PAIRS_AT_A_TIME", pairs)
    stretches = list(run_at(np.arange(10.0), robots).stretches())
    assert [k for s in stretches for k in range(s.start, s.stop)] == list(range(10))
    longest = max(1, min(10, pairs // robots**2))
    assert all(s.stop - s.start == longest for s in stretches[:-1])
    assert stretches[-1].stop - stretches[-1].start <= longest


@pytest.mark.parametrize("samples", [2, 7])
def test_stretches_change_no_number(samples, monkeypatch):
    whole = analyse(eventful())
    monkeypatch.setattr(measured_run, "PAIRS_AT_A_TIME", samples * 4**2)
    parts = analyse(eventful())
    for key, curve in whole.curves.items():
        np.testing.assert_allclose(parts.curves[key], curve, rtol=1e-12, err_msg=key)
    assert len(set(whole.curves["components"])) > 1  # the graph does change


def test_what_was_found_is_kept_for_this_run_and_its_options_alone():
    run, asked = run_at(np.arange(10.0)), []

    def ask(run, word):
        asked.append(word)

    for measured in (run, run, replace(run, options=AnalysisOptions(radius=0.1))):
        measured.once(ask, "first")
        measured.once(ask, "second")
    assert asked == ["first", "second"] * 2


def test_radius_may_be_one_a_robot():
    run = run_at(np.arange(10.0))
    assert type(run.radius) is float
    unequal = replace(run, options=AnalysisOptions(radius=np.array([1, 2])))
    np.testing.assert_array_equal(unequal.radius, [1.0, 2.0])
    assert unequal.radius.dtype == float


def test_a_run_prints_as_what_was_recorded_and_asked_for():
    run = run_at(np.arange(10.0))
    words = repr(run)
    assert "recording=" in words
    assert "options=" in words
    assert "curve_functions" not in words
    assert "_found" not in words
