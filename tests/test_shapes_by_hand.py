"""Formation, coverage and what unseen robots may change, against numbers computed by hand."""

import numpy as np
import pytest

from posflock_robotarium.alignment.questions import Questions
from posflock_robotarium.report import AnalysisOptions, Run, analyse

T = np.arange(21) * 1.0
ASKED = {q: AnalysisOptions(questions=q) for q in Questions}


def team(places, headings=0.0):
    """Poses of robots at (T, 2, N) places."""
    poses = np.zeros((len(T), 3, places.shape[2]))
    poses[:, :2], poses[:, 2] = places, headings
    return Run("by hand", T, poses, parameters={"arena": [-9.0, 9.0, -9.0, 9.0]})


def opening():
    """Three robots in a row, whose neighbours go from 0.3 m apart to 0.5 m, on their way."""
    x = np.array([-1.0, 0.0, 1.0]) * (0.5 - 0.2 * (1.0 - T / T[-1]) ** 2)[:, np.newaxis]
    return np.stack([x, np.zeros_like(x) + 0.01 * T[:, np.newaxis]], axis=1)


def test_the_change_of_shape_is_that_of_distances_from_their_means_over_the_end():
    places = opening()
    change = analyse(team(places), options=ASKED[Questions.FORMATION]).curves["shape_change"]
    x = places[:, 0]
    apart = np.stack([x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], x[:, 2] - x[:, 1]], axis=1)
    off = apart - apart[-3:].mean(axis=0)  # the last tenth, both ends with it
    assert change == pytest.approx(np.sqrt((off**2).mean(axis=1)))


def test_a_shape_is_kept_from_its_last_sample_beyond_five_centimetres():
    analysis = analyse(team(opening()), options=ASKED[Questions.FORMATION])
    change = analysis.curves["shape_change"]
    first = int(np.flatnonzero(change > 0.05)[-1]) + 1
    assert 0 < first < 20
    assert analysis.numbers["shape_kept_from"].value == first
    assert analysis.numbers["shape_change_end"].value == change[-3:].max()


def test_a_shape_and_a_target_are_counted_from_the_end_of_the_drive_to_the_start():
    """The same run, once with the drive that is no part of it: all times and the end are the same.

    In the drive robots stand in their last shape, which must count for neither.
    """
    places = opening()
    targets = ("shape_change < 0.05 m always after 2 s", "shape_change < 0.05 m")
    options = AnalysisOptions(questions=Questions.FORMATION, targets=targets)
    short = analyse(team(places), options=options)
    whole = np.concatenate([np.repeat(places[-1:], 40, axis=0), places])
    poses = np.zeros((61, 3, 3))
    poses[:, :2] = whole
    said = {"arena": [-9.0, 9.0, -9.0, 9.0], "drive": 40.0}
    long = analyse(Run("by hand", np.arange(61.0), poses, parameters=said), options=options)
    for key in ("shape_kept_from", "shape_change_end"):
        assert long.numbers[key].value == pytest.approx(short.numbers[key].value)
    for key in ("coverage_start", "coverage_end"):
        first, second = (
            analyse(one.recording, options=ASKED[Questions.COVERAGE]).numbers[key].value
            for one in (short, long)
        )
        assert first == pytest.approx(second), key
    kept = short.numbers["shape_kept_from"].value
    answers = {v.question: f"{v.answer} {v.because}" for v in long.verdicts}
    since = f"from {kept:.1f} s after the drive to the start."
    assert f"Yes, {since}" in answers["Did it take up a formation and keep it?"]
    assert f"For good {since}" in answers["shape_change < 0.05 m?"]
    assert f"For good from {kept:.1f} s on." in short.verdicts[1].because


@pytest.mark.parametrize("asked", [Questions.FLOCKING, Questions.COVERAGE, Questions.NONE])
def test_no_shape_is_told_where_nobody_asks(asked):
    options = AnalysisOptions(questions=asked, radius=0.75)
    assert "shape_change" not in analyse(team(opening()), options=options).curves


def test_what_the_unseen_may_change_is_what_they_change_where_they_are_seen():
    """One of three goes the other way: γ is −1/3 with it, 1 without; it is unseen for a quarter."""
    t = np.arange(0.0, 40.0, 0.033)
    poses = np.zeros((len(t), 3, 3))
    poses[:, 1] = np.array([0.0, 0.3, 0.6])
    poses[:, 2] = np.array([0.0, 0.0, np.pi])
    poses[:, 0] = 0.05 * t[:, np.newaxis] * np.array([1.0, 1.0, -1.0])
    poses[:, 0] -= poses[:, 0].mean(axis=0)
    gone = (t > 25.0) & (t < 30.0)
    poses[np.ix_(gone, [0, 1, 2], [2])] = np.nan
    run = Run("by hand", t, poses, parameters={"arena": [-9.0, 9.0, -9.0, 9.0]})
    options = AnalysisOptions(questions=Questions.FLOCKING, radius=9.0)
    numbers = analyse(run, options=options).numbers
    share = gone[t > 20.0].mean()
    assert numbers["gamma_unseen"].value == pytest.approx(share * 4.0 / 3.0, rel=0.03)
    assert numbers["longest_unseen"].value == pytest.approx(5.0, abs=0.05)
    assert numbers["robots_seen"].value == pytest.approx(3 - gone.mean(), rel=1e-3)
