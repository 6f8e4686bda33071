"""Figures and pages: targets of every metric that is drawn, and runs that begin together."""

import base64

import numpy as np
import pytest
from rolling_robots import rolling

from posflock_robotarium.report import AnalysisOptions, Run, analyse
from posflock_robotarium.report import curve_figures as figures
from posflock_robotarium.report.page_data import page_data

T, POSES = rolling(samples=400)


def one(name="run", drive=0.0, **options):
    """A run whose drive to the start lies before the same experiment."""
    waiting = round(drive / 0.033)
    poses = np.concatenate([np.repeat(POSES[:1], waiting, axis=0), POSES])
    poses[:waiting, 0] += 0.5 - 0.5 * np.arange(waiting)[:, np.newaxis] / max(waiting, 1)
    run = Run(
        name, 0.033 * np.arange(len(poses)), poses, parameters={"drive": drive} if drive else {}
    )
    return analyse(run, AnalysisOptions(radius=0.75, **options))


@pytest.mark.parametrize(
    ("draw", "target", "limit"),
    [
        (figures.distances, "smallest_distance > 0.21 m always", 0.21),
        (figures.motion, "speed < 0.12 m/s always", 0.12),
        (figures.motion, "speed_fastest < 0.13 m/s always", 0.13),
        (figures.alignment, "gamma_motion > 0.8 at the end", 0.8),
    ],
)
def test_targets_are_drawn_in_the_figures_of_their_metrics(draw, target, limit):
    axes = draw(one(targets=(target,))).axes[0]
    (line,) = [line for line in axes.get_lines() if "target" in str(line.get_label())]
    np.testing.assert_array_equal(line.get_ydata(), limit)


def test_experiments_of_several_runs_begin_together():
    runs = [one("at once"), one("driven", drive=6.6)]
    targets = AnalysisOptions(radius=0.75, targets=("smallest_distance > 0.2 m always",))
    assert runs[1].start == pytest.approx(6.6)
    axes = figures.overlaid(runs, "smallest_distance").axes[0]
    first, second = axes.get_lines()[:2]
    np.testing.assert_allclose(first.get_xdata(), second.get_xdata(), atol=1e-9)
    np.testing.assert_allclose(first.get_ydata(), second.get_ydata(), atol=1e-9)
    assert axes.get_xlabel() == "time since the drive to the start (s)"
    assert axes.get_xlim()[1] == pytest.approx(T[-1])
    data = page_data(runs)
    (plot,) = [p for p in data.panels if p.series[0].key == "nearest_neighbour"]
    drawn = [np.frombuffer(base64.b64decode(s.values), "<f4") for s in plot.series]
    np.testing.assert_allclose(drawn[0], drawn[1], atol=1e-6)
    assert (data.runs[0].start, data.runs[1].start) == (0.0, runs[1].start)
    asked = [analyse(run.recording, targets) for run in runs]
    drawn = figures.runs(asked).axes[1].get_lines()
    assert any("target" in str(line.get_label()) for line in drawn)
