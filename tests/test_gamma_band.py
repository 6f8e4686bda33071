"""The band of γ: it holds the truth as often as it says, and is absent where it cannot be known."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from posflock_robotarium.alignment.band_truth import FLOCKS, clean_flock, coverage, noisy
from posflock_robotarium.alignment.gamma_band import gamma_band, of_headings, of_motion
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.alignment.velocity_noise import noise_persistence, velocity_gain
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.report import analyse


@pytest.mark.parametrize("flock", FLOCKS)
def test_bands_hold_the_truth_in_about_95_percent(flock):
    found = coverage(clean_flock(flock, 6, 0.1, duration=20.0, seed=3), 0.001, 0.01, repeats=3)
    for estimator in ("motion", "headings"):
        # A sixth of the benchmark's samples, and kin to their neighbours: so wider limits.
        assert 0.91 <= found[estimator].held <= 0.99
        assert found[estimator].known > 0.9


def test_raw_differences_have_a_band_where_noise_leaves_directions():
    clean = clean_flock("parallel", 6, 0.2, duration=20.0)
    assert 0.91 <= coverage(clean, 0.00025, 0.001, repeats=2)["differences"].held <= 0.99
    assert np.isnan(coverage(clean, 0.002, 0.001, repeats=1)["differences"].held)


def test_the_band_of_parallel_robots_reaches_one_though_the_reading_never_does():
    flock = known_flock("parallel", 0.05, duration=20.0, position_noise=0.001)
    curves = analyse(flock.recording, radius=flock.radius).curves
    assert curves["gamma_motion"].max() < 1.0
    assert (curves["gamma_motion_high"] == 1.0).mean() > 0.9
    assert np.nanmean(curves["gamma_motion_low"]) > curves["gamma_motion"].mean() - 0.02


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    robots=st.integers(2, 8),
    noise=st.sampled_from([1e-6, 1e-3, 0.02, 0.1]),
    radius=st.sampled_from([0.3, 0.8, 5.0]),
)
def test_a_band_is_in_order_within_bounds_and_turns_with_nothing(seed, robots, noise, radius):
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-1, 1, (7, 2, robots))
    angles = rng.uniform(-3, 3, (7, robots)) * rng.choice([0.0, 0.1, 1.0])

    def band(turn):
        unit = np.stack([np.cos(angles + turn), np.sin(angles + turn)], axis=1)
        whole = iter([slice(0, 3), slice(3, 7)])
        return gamma_band(of_headings(unit, noise), positions, radius, 1e-12, whole)

    found, turned = band(0.0), band(1.2)
    known = np.isfinite(found.low)
    assert (known == np.isfinite(found.high)).all()
    low, high = found.low[known], found.high[known]
    assert (low >= -1).all()
    assert (high <= 1).all()
    assert (low <= high).all()
    np.testing.assert_allclose(turned.low[known], low, atol=1e-5)
    np.testing.assert_allclose(turned.high[known], high, atol=1e-5)


def test_without_noise_the_band_is_the_curve():
    flock = known_flock("rotating", 0.1, duration=10.0, position_noise=0.0, heading_noise=0.0)
    curves = analyse(flock.recording, radius=flock.radius).curves
    for end in ("low", "high"):
        np.testing.assert_allclose(curves[f"gamma_motion_{end}"], curves["gamma_motion"], atol=1e-6)


def test_a_neighbour_in_doubt_widens_the_band():
    unit = np.array([[[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]])
    positions = np.array([[[0.0, 0.3, 0.5], [0.0, 0.0, 0.0]]])

    def width(radius):
        band = gamma_band(of_headings(unit, 1e-3), positions, radius, 5e-4, iter([slice(0, 1)]))
        return float(band.high[0] - band.low[0])

    assert width(0.4) < 0.01
    assert width(0.5003) > 0.1


def test_a_robot_at_the_edge_of_standing_widens_the_band():
    positions = np.array([[[0.0, 0.3, 0.5], [0.0, 0.0, 0.0]]])

    def width(speed):
        velocities = np.array([[[0.1, 0.1, 0.0], [0.0, 0.0, speed]]])
        directions = of_motion(velocities, np.array([0.001]), 0.01)
        band = gamma_band(directions, positions, 1.0, 1e-4, iter([slice(0, 1)]))
        return float(band.high[0] - band.low[0])

    assert width(0.0105) > 0.5
    assert width(0.1) < 0.1


def test_a_direction_that_noise_hides_has_no_band():
    velocities = np.array([[[0.02, 0.02], [0.0, 0.0]]])
    positions = np.array([[[0.0, 0.3], [0.0, 0.0]]])
    directions = of_motion(velocities, np.array([0.01]), 0.01)
    assert np.isnan(gamma_band(directions, positions, 1.0, 1e-4, iter([slice(0, 1)])).low).all()


def filtered(recording, share):
    """Return a recording whose noise is carried over from frame to frame."""
    poses = recording.poses.copy()
    for k in range(1, len(poses)):
        poses[k, :2] = share * poses[k - 1, :2] + (1 - share) * poses[k, :2]
    return dataclasses.replace(recording, poses=poses)


def test_filtered_poses_have_no_band_and_the_verdict_says_why():
    flock = known_flock("parallel", 0.05, duration=20.0, position_noise=0.002)
    seen = analyse(filtered(flock.recording, 0.6), radius=flock.radius)
    assert not [key for key in seen.curves if key.endswith("_low")]
    assert "gamma_band" not in seen.numbers
    assert any("look filtered" in verdict.because for verdict in seen.verdicts)
    assert noise_persistence(flock.recording) == pytest.approx(1.0, abs=0.1)


def test_a_log_too_short_to_measure_its_noise_has_no_band():
    flock = known_flock("parallel", 0.1, duration=0.25)
    seen = analyse(flock.recording, radius=flock.radius)
    assert not [key for key in seen.curves if key.endswith("_low")]


@pytest.mark.parametrize("estimator", ["savitzky_golay", "differences"])
def test_the_noise_of_a_velocity_is_what_a_thousand_noisy_runs_say(estimator):
    from posflock_robotarium.alignment.estimators import estimate

    clean = clean_flock("parallel", 300, 0.1, duration=1.2)
    error = (
        estimate(noisy(clean, 0.001, 0.0), estimator).velocities
        - estimate(clean, estimator).velocities
    )
    found = error.std(axis=(1, 2)) / 0.001
    np.testing.assert_allclose(velocity_gain(clean, estimator), found, rtol=0.15)


def test_an_unknown_flock_is_refused():
    with pytest.raises(ParameterError, match="none of parallel"):
        clean_flock("dancing", 4, 0.1)


def test_exact_poses_have_a_band_without_width():
    angles = np.array([[0.3, 0.3, 0.4]])
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    positions = np.array([[[0.0, 0.3, 0.5], [0.0, 0.0, 0.0]]])
    band = gamma_band(of_headings(unit, 0.0), positions, 1.0, 0.0, iter([slice(0, 1)]))
    assert band.low[0] == pytest.approx(band.high[0], abs=1e-12)
    assert band.low[0] < 1.0
