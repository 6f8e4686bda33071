"""The figures are drawn from a log without a display, and leave no trace in matplotlib."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from posflock_robotarium.figures import experiment as figures
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, Flock
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.simulation.flock_trial import simulate


@pytest.fixture(scope="module")
def log():
    return simulate(Flock(), random_poses(9, np.random.default_rng(0)), 8.0).log


def test_every_figure_is_written_twice(log, tmp_path):
    before = dict(matplotlib.rcParams)
    paths = figures.draw_run(log, tmp_path / "new")
    assert sorted(path.suffix for path in paths) == [".pdf"] * 3 + [".png"] * 3
    assert all(path.stat().st_size > 5000 for path in paths)
    assert dict(matplotlib.rcParams) == before


def test_every_axis_has_a_unit(log):
    for figure in (figures.alignment_over_time(log), figures.distances_and_speeds(log)):
        for axes in figure.axes:
            for label in (axes.get_xlabel(), axes.get_ylabel()):
                assert "(" in label, label


def test_robots_are_drawn_to_scale(log):
    panel = figures.snapshots(log).axes[0]
    body = panel.patches[0].get_xy()
    sides = sorted(np.linalg.norm(np.diff(body, axis=0), axis=1)[:2])
    assert sides == pytest.approx([0.10, 0.11])
    assert len(panel.patches) == 2 * 9


def test_a_log_too_short_is_named(log, tmp_path):
    from dataclasses import replace

    unknown = dict.fromkeys(("commands", "intervention", "clearance", "status"))
    short = replace(log, t=log.t[:3], poses=log.poses[:3], **unknown)
    with pytest.raises(LogError, match="holds 3 rows"):
        figures.draw_run(short, tmp_path)


def test_figures_say_what_is_not_the_papers(log):
    for draw in (figures.snapshots, figures.alignment_over_time, figures.distances_and_speeds):
        assert "an addition to the paper's law" in draw(log).get_suptitle()


def test_a_control_run_says_so_on_its_figures():
    certificate = replace(EXPERIMENT_CERTIFICATE, pair_rows=False)
    start = random_poses(9, np.random.default_rng(0))
    control = simulate(Flock(certificate=certificate), start, 3.0).log
    figure = figures.distances_and_speeds(control)
    assert "control run: nobody is kept apart" in figure.get_suptitle()
