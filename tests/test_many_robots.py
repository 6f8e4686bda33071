"""Thousands of robots are analysed by k-d trees and lists of pairs, to the results of a few."""

import numpy as np
import pytest

from posflock_robotarium.alignment import gamma_band, measured_run
from posflock_robotarium.alignment.catalogue import connectivity
from posflock_robotarium.alignment.metrics import connectivity as of_graphs
from posflock_robotarium.alignment.metrics import directions, distances
from posflock_robotarium.report import Run, analyse
from rps_compat import logged_violations

MODULES = (gamma_band, measured_run, connectivity, of_graphs, directions, distances)


@pytest.mark.parametrize("unseen", [0.0, 0.03])
def test_trees_find_what_all_pairs_do(monkeypatch, unseen):
    rng = np.random.default_rng(1)
    samples, robots = 40, 40
    heading = rng.uniform(-np.pi, np.pi, robots) + 0.01 * np.cumsum(
        rng.standard_normal((samples, robots)), axis=0
    )
    step = 0.0033 * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    noise = 5e-4 * rng.standard_normal((samples, 2, robots))
    places = rng.uniform(-1.6, 1.6, (2, robots)) + np.cumsum(step, axis=0) + noise
    poses = np.concatenate([places, heading[:, np.newaxis]], axis=1)
    poses[np.repeat(rng.random((samples, 1, robots)) < unseen, 3, axis=1)] = np.nan
    run = Run("many", 0.033 * np.arange(samples), poses)
    radius = rng.uniform(0.5, 0.7, robots)
    few = analyse(run, radius=radius)
    for module in MODULES:
        monkeypatch.setattr(module, "TREE_FROM_AGENTS", 2)
    monkeypatch.setattr(measured_run, "KEPT_PAIRS", 0)
    monkeypatch.setattr(logged_violations, "_MANY", 2)
    many = analyse(run, radius=radius)
    assert few.numbers["collisions"].value > 0
    assert "gamma_motion_low" in few.curves
    for key, curve in few.curves.items():
        np.testing.assert_allclose(many.curves[key], curve, atol=1e-9, err_msg=key)
    assert [str(event) for event in many.events] == [str(event) for event in few.events]
    shift = few.numbers.get("gamma_unseen")
    assert (shift is None) == (unseen == 0.0)
    if shift is not None:
        assert many.numbers["gamma_unseen"].value == pytest.approx(shift.value)
