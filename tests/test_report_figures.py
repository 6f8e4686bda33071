"""Figures show the curves of the analysis, broken at gaps, under legends that hide nothing."""

import dataclasses

import numpy as np
import pytest

from posflock_robotarium.alignment.comparison import distinctly_named
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.figures.style import save
from posflock_robotarium.report import analyse
from posflock_robotarium.report.curve_figures import alignment, distances, motion, runs


def a_run(seed=0, name="run", keep=slice(None)):
    flock = known_flock("rotating", 0.1, duration=6.0, seed=seed)
    recording = dataclasses.replace(
        flock.recording, name=name, t=flock.recording.t[keep], poses=flock.recording.poses[keep]
    )
    return analyse(recording, radius=flock.radius)


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def test_gamma_is_drawn_as_analysed_with_the_share_left_out():
    analysis = a_run()
    top, bottom = alignment(analysis).axes
    drawn = lines(top)
    assert {"motion", "headings", "raw differences"} <= set(drawn)
    np.testing.assert_array_equal(drawn["motion"].get_ydata(), analysis.curves["gamma_motion"])
    assert bottom.get_ylabel().startswith("left out")


def test_no_line_crosses_a_gap():
    analysis = a_run(keep=np.r_[0:80, 110:180])
    for figure in (alignment(analysis), distances(analysis), motion(analysis)):
        for line in figure.axes[0].get_lines():
            x = np.asarray(line.get_xdata(), dtype=float)
            if len(x) > 2:
                assert np.isnan(x[80])
                assert np.nanmax(np.diff(x)) < 0.04


def test_the_collision_line_is_the_testbeds():
    [limit] = [
        line for line in distances(a_run()).axes[0].get_lines() if len(line.get_ydata()) == 2
    ]
    assert list(limit.get_ydata()) == [0.135, 0.135]


@pytest.mark.parametrize("figure", [alignment, distances, motion])
def test_legends_lie_outside_the_axes(figure):
    drawn = figure(a_run())
    drawn.draw_without_rendering()
    [legend] = drawn.legends
    box = legend.get_window_extent()
    for axes in drawn.axes:
        assert not box.overlaps(axes.get_window_extent())
    assert drawn.bbox.x1 >= box.x1


@pytest.mark.parametrize("name", ["$\\frac{", "_hidden", "<b>&", "a$b"])
def test_any_name_can_be_drawn(name, tmp_path):
    drawn = runs([a_run(name=name), a_run(1, name="other")])
    drawn.draw_without_rendering()
    assert len(drawn.legends[0].get_texts()) == 2


def test_many_runs_get_a_mean_and_its_interval():
    analyses = distinctly_named([a_run(seed) for seed in range(6)])
    drawn = runs(analyses)
    mean = lines(drawn.axes[0])["mean over runs"]
    middle = np.mean([a.curves["gamma_motion"][91] for a in analyses])
    k = int(np.argmin(np.abs(np.asarray(mean.get_xdata()) - 91 * 0.033)))
    assert mean.get_ydata()[k] == pytest.approx(middle, abs=2e-3)
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == [
        "95 % of the mean",
        "mean over runs",
    ]


def test_the_same_run_gives_the_same_files(tmp_path):
    analysis = a_run()
    first, second = (save(motion(analysis), tmp_path / name, "motion") for name in ("a", "b"))
    assert [path.suffix for path in first] == [".png", ".pdf"]
    for one, two in zip(first, second, strict=True):
        assert one.read_bytes() == two.read_bytes()
