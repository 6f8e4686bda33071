"""Estimators against truth, at the noise and speeds of the testbed."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.estimators import (
    estimate,
    expected_bias,
    tracking_noise,
    window_points,
)
from posflock_robotarium.alignment.truth import MOTIONS, POSITION_NOISE, errors, known_flock
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.report import Run, analyse


@pytest.fixture(scope="module")
def table():
    return {(e.motion, e.speed, e.estimator): e for e in errors()}


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
def test_savitzky_golay_reads_parallel_robots_as_parallel(table, speed):
    assert table["parallel", speed, "motion"].estimate >= 0.999
    assert table["parallel", speed, "motion"].left_out == 0


@pytest.mark.parametrize(("speed", "bias"), [(0.05, 0.15), (0.1, 0.03), (0.2, 0.007)])
def test_raw_differences_are_biased(table, speed, bias):
    assert table["parallel", speed, "differences"].error < -bias


@pytest.mark.parametrize("motion", [m for m in MOTIONS if m != "stopped"])
@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
def test_headings_and_motion_are_within_a_thousandth_of_truth(table, motion, speed):
    assert abs(table[motion, speed, "headings"].error) < 1e-4
    assert abs(table[motion, speed, "motion"].error) < 1e-3


def test_a_stopped_flock_has_headings_and_no_motion(table):
    assert table["stopped", 0.0, "headings"].estimate == pytest.approx(1, abs=1e-4)
    assert np.isnan(table["stopped", 0.0, "motion"].estimate)
    assert table["stopped", 0.0, "motion"].left_out > 0.999


def test_without_noise_every_estimator_is_exact():
    for e in errors(("parallel", "counter", "random"), position_noise=0.0, heading_noise=0.0):
        assert e.estimate == pytest.approx(e.truth, abs=1e-9)


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
def test_the_noise_and_the_bias_are_measured_from_the_log_itself(speed, table):
    flock = known_flock("parallel", speed)
    noise = tracking_noise(flock.recording, speed)
    assert noise.position == pytest.approx(POSITION_NOISE, rel=0.03)
    assert noise.heading == pytest.approx(0.0015, rel=0.03)
    error = -table["parallel", speed, "motion"].error
    assert expected_bias(noise.course) == pytest.approx(error, rel=0.2)


def test_the_noise_of_stretches_is_their_mean_by_length():
    """A short noisy stretch before a gap must not count as much as a long one behind it."""
    rng = np.random.default_rng(1)
    t = [0.033 * np.arange(60), 10.0 + np.cumsum(rng.uniform(0.02, 0.05, 400))]
    runs = []
    for times, noise in zip(t, (0.004, 0.0005), strict=True):
        poses = rng.normal(0.0, noise, (len(times), 3, 4))
        poses[:, 0] += 0.1 * times[:, np.newaxis]
        poses[:, 2] *= 3.0
        runs.append(Run("stretch", times, poses))
    both = Run("both", np.concatenate(t), np.concatenate([run.poses for run in runs]))
    assert len(both.segments) == 2
    # The window is counted in median steps; one that is the same number of samples for all three.
    window = 11 * both.step
    assert {window_points(run.step, window) for run in (*runs, both)} == {11}
    short, long = (tracking_noise(run, 0.1, window) for run in runs)
    found = tracking_noise(both, 0.1, window)
    lengths = np.array([60, 400])

    def mean(*values):
        return np.average(values, weights=lengths)

    assert found.position**2 == pytest.approx(mean(short.position**2, long.position**2))
    assert found.heading**2 == pytest.approx(mean(short.heading**2, long.heading**2))
    slope = np.sqrt(mean((short.course / short.position) ** 2, (long.course / long.position) ** 2))
    assert found.course == pytest.approx(found.position * slope)


def uneven(recording, jitter, seed=0):
    """Sample a straight flock at uneven times: a loop that misses its slots."""
    rng = np.random.default_rng(seed)
    t = recording.t + jitter * rng.uniform(-1, 1, len(recording.t))
    return t


@given(st.floats(0.0, 0.014), st.integers(0, 50))
def test_uneven_steps_do_not_bend_a_straight_line_or_a_parabola(jitter, seed):
    t = uneven(known_flock("parallel", 0.1, duration=3.0).recording, jitter, seed)
    x = 0.3 + 0.1 * t - 0.02 * t**2
    poses = np.zeros((len(t), 3, 1))
    poses[:, 0, 0] = x
    motion = estimate(Run("uneven", t, poses), "savitzky_golay")
    np.testing.assert_allclose(motion.velocities[:, 0, 0], 0.1 - 0.04 * t, atol=1e-9)


def test_even_steps_are_the_metrics_own_filter():
    recording = known_flock("rotating", 0.1, duration=5.0).recording
    motion = estimate(recording, "savitzky_golay")
    assert motion.points == metrics.SMOOTHING_POINTS
    expected = metrics.smoothed_velocities(recording.poses[:, :2], 0.033)
    np.testing.assert_allclose(motion.velocities, expected, rtol=1e-10, atol=1e-14)
    # The fit for uneven times is the same filter: tell it that steps are a little uneven.
    nudged = recording.t.copy()
    nudged[50] += 1e-6
    other = estimate(Run("nudged", nudged, recording.poses), "savitzky_golay")
    np.testing.assert_allclose(other.velocities, expected, atol=2e-5)


def test_no_estimate_looks_across_a_gap():
    t = np.concatenate([np.arange(30), np.arange(200, 230)]) * 0.033
    poses = np.zeros((60, 3, 1))
    poses[:30, 0, 0] = 0.1 * t[:30]
    poses[30:, 1, 0] = 0.1 * t[30:]
    recording = Run("gap", t, poses)
    for name in ("savitzky_golay", "differences"):
        velocities = estimate(recording, name).velocities[:, :, 0]
        np.testing.assert_allclose(velocities[:30], [[0.1, 0]] * 30, atol=1e-12)
        np.testing.assert_allclose(velocities[30:], [[0, 0.1]] * 30, atol=1e-12)


def test_stretches_too_short_for_the_window_use_what_they_have():
    t = np.array([0, 1, 2, 3, 30, 60, 61.0]) * 0.033
    poses = np.zeros((7, 3, 2))
    poses[:, 0] = 0.2 * t[:, np.newaxis]
    velocities = estimate(Run("short", t, poses), "savitzky_golay").velocities
    expected = np.full(7, 0.2)
    expected[4] = np.nan  # a sample alone between two gaps has no motion
    np.testing.assert_allclose(velocities[:, 0, 0], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("step", "window", "points"),
    [(0.033, 0.36, 11), (0.033, 0.01, 3), (0.1, 0.36, 3), (0.02, 0.36, 17), (0.033, 1.0, 31)],
)
def test_the_window_is_given_in_seconds(step, window, points):
    assert window_points(step, window) == points


@pytest.mark.parametrize("window", [0.0, -1.0, np.nan, np.inf])
def test_a_window_that_is_none_is_refused(window):
    with pytest.raises(ParameterError, match="window"):
        window_points(0.033, window)


def test_unknown_estimators_are_refused():
    with pytest.raises(ParameterError, match="none of headings"):
        estimate(known_flock("parallel", 0.1, duration=1.0).recording, "kalman")


def test_counter_movers_cancel_in_polarisation_but_not_in_alignment():
    flock = known_flock("counter", 0.1, duration=5.0, position_noise=0)
    analysis = analyse(flock.recording, radius=flock.radius)
    assert analysis.numbers["polarisation_motion"].value == pytest.approx(0, abs=1e-9)
    assert analysis.numbers["gamma_motion"].value == pytest.approx(-1 / 9)


def test_the_table_in_the_documentation_is_the_table_measured(table):
    page = (Path(__file__).parents[1] / "docs/how-to/report.md").read_text()
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")]
    # The speeds alone: the table of bands tells of the same motions.
    rows = [row for row in rows if row[0] in MOTIONS and row[1] in ("0", "0.05", "0.1", "0.2")]
    assert len(rows) == 13
    for motion, speed, truth, *cells in rows:
        found = [table[motion, float(speed), e] for e in ("headings", "motion", "differences")]
        assert float(truth) == pytest.approx(found[0].truth, abs=5e-5)
        for cell, error in zip(cells, found, strict=True):
            if "left out" in cell:
                share = float(cell.split(", ")[1].removesuffix("% left out"))
                assert share == pytest.approx(100 * error.left_out, abs=0.51)
            else:
                assert float(cell) == pytest.approx(error.error, abs=2e-5)
