"""Replays the noise of all sensors: not number by number, but what many readings have in common."""

import warnings
from typing import Any

import numpy as np
from golden_vectors import Vectors, expect, quietly, robotarium


def replay_noise(case: dict[str, Any], v: Vectors) -> None:
    """Means and spreads of all sensors of robots that stand still."""
    names = ("distances", "encoders", "accelerations", "gyros", "magnetic_fields", "orientations")
    series: dict[str, list[Any]] = {name: [] for name in names}
    with quietly():
        r = robotarium(v.value(case["init"]))
        np.random.seed(12345)  # noqa: NPY002
        for _ in range(case["steps"]):
            r.get_poses()
            r.step()
            for name, readings in series.items():
                readings.append(np.array(getattr(r, f"get_{name}")(), float))
    for name, readings in series.items():
        centre, spread, missed = statistics(name, np.array(readings))
        recorded = v.array(case["expect"][name])
        expect(np.array_equal(np.isnan(centre), np.isnan(recorded[0])), name, "missing readings")
        sigma = np.nan_to_num(recorded[1])
        wide = 1.6 if name == "distances" else 1.0
        apart = np.abs(np.nan_to_num(centre - recorded[0]))
        limit = 6 * wide * sigma * np.sqrt(2 / case["steps"]) + 1e-9
        expect((apart <= limit).all(), name, "mean", centre, "not", recorded[0])
        share = 0.25 if name == "encoders" else 0.12
        apart = np.abs(np.nan_to_num(spread) - sigma)
        expect((apart <= share * sigma + 1e-9).all(), name, "spread", spread, "not", sigma)
        if missed is not None:
            rate = recorded[2]
            limit = 6 * np.sqrt(2 * rate * (1 - rate) / case["steps"]) + 1e-9
            expect((np.abs(missed - rate) <= limit).all(), name, "dropouts", missed, "not", rate)


def statistics(name: str, readings: np.ndarray) -> tuple[Any, Any, Any]:
    """Centre, spread and rate of missed readings, each as the vectors have it."""
    if name == "encoders":
        readings = np.diff(readings, axis=0)
    if name == "orientations":  # on a circle
        turned = np.exp(1j * np.deg2rad(readings))
        mean = np.angle(turned.mean(axis=0))
        around = np.angle(turned * np.exp(-1j * mean))
        return np.mod(np.rad2deg(mean), 360), np.rad2deg(around.std(axis=0)), None
    if name == "distances":  # with outliers: median and quartiles
        hit = readings >= 0
        read = np.where(hit, readings, np.nan)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            low, middle, high = np.nanpercentile(read, [25, 50, 75], axis=0)
        return middle, (high - low) / 1.349, 1 - hit.mean(axis=0)
    return readings.mean(axis=0), readings.std(axis=0), None
