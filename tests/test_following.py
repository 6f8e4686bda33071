"""How robots followed their commands: a gain of .7 is found, shown, and no gain is made up."""

import json
import re

import numpy as np
import pytest

from posflock_robotarium.alignment.following import INCREMENTS, Following, _most_varied
from posflock_robotarium.report import Run, analyse, load, write_report
from posflock_robotarium.report.following_figure import following_figure
from posflock_robotarium.report.following_page import following_section
from posflock_robotarium.report.page import render

STEP, ROWS, ROBOTS = 0.033, 600, 4
T = STEP * np.arange(ROWS)


def a_run(speed_gain=0.7, turning=True, seed=0, rows=ROWS, **known):
    """Robots that drive `speed_gain` of what they are told, six steps late, seen with noise."""
    rng = np.random.default_rng(seed)
    held = rows // 30 + 1
    v = np.repeat(rng.uniform(0.05, 0.15, (held, ROBOTS)), 30, axis=0)[:rows]
    w = np.repeat(rng.uniform(-1, 1, (held, ROBOTS)), 30, axis=0)[:rows] * turning
    late = 6
    driven = np.zeros((2, rows, ROBOTS))
    driven[:, late:] = speed_gain * v[:-late], w[:-late]
    theta = np.cumsum(STEP * np.vstack([np.zeros(ROBOTS), driven[1, :-1]]), axis=0)
    middle = theta + 0.5 * STEP * driven[1]
    ways = STEP * driven[0] * np.stack([np.cos(middle), np.sin(middle)])
    places = np.concatenate([np.zeros((2, 1, ROBOTS)), np.cumsum(ways, axis=1)[:, :-1]], axis=1)
    places[1] += 0.8 * np.arange(ROBOTS)
    poses = np.stack([*places, theta], axis=1)
    poses += np.array([0.0005, 0.0005, 0.0015])[:, None] * rng.standard_normal(poses.shape)
    commands = np.stack([v, w], axis=1)
    t = STEP * np.arange(rows)
    return Run("run", t, poses, commands, parameters={"neighbour_radius": 0.75}, **known)


@pytest.fixture(scope="module")
def slow():
    return analyse(a_run())


def test_a_gain_of_seven_tenths_is_found_and_said(slow):
    assert slow.numbers["speed_gain"].value == pytest.approx(0.7, abs=0.02)
    assert slow.numbers["turn_gain"].value == pytest.approx(1.0, abs=0.03)
    verdict = next(v for v in slow.verdicts if "as they were told" in v.question)
    assert (verdict.mark, verdict.answer) == (
        "caution",
        "No: they drove 0.70 of the speed they were told.",
    )
    for response in slow.following.speed:
        assert response.gain.low < 0.7 < response.gain.high
        slope = np.polyfit(response.commanded, response.achieved, 1)[0]
        assert slope == pytest.approx(0.7, abs=0.1)


def test_robots_that_do_as_told_are_called_so():
    analysis = analyse(a_run(1.0))
    verdict = next(v for v in analysis.verdicts if "as they were told" in v.question)
    assert (verdict.mark, verdict.answer) == ("good", "Yes, in speed and turn rate.")


def test_a_robot_that_never_turns_has_no_turn_gain():
    analysis = analyse(a_run(turning=False))
    assert all(response.gain is None for response in analysis.following.turn)
    assert "too little turning" in analysis.following.turn[0].reason
    assert np.isnan(analysis.numbers["turn_gain"].value)
    verdict = next(v for v in analysis.verdicts if "as they were told" in v.question)
    assert "turn rate gain of no robot is determined" in verdict.because
    section = following_section(analysis.following)
    assert section.undetermined
    assert section.rows[0].turn.startswith("none: too little turning")


def test_without_commands_nothing_is_said():
    run = a_run()
    analysis = analyse(Run("run", run.t, run.poses), radius=0.75)
    assert analysis.following is None
    assert "speed_gain" not in analysis.numbers
    assert "Commanded and achieved" not in render([analysis])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda run: Run("run", run.t[:30], run.poses[:30], run.commands[:30]), "30 rows"),
        (
            lambda run: Run("run", run.t, run.poses * [[1.0], [1.0], [np.nan]], run.commands),
            "no headings",
        ),
        (lambda run: Run("run", run.t, run.poses, run.commands * 0.0), "determines nothing"),
        (lambda run: Run("run", run.t, run.poses, run.commands * 1e4), "none that a robot"),
    ],
)
def test_what_cannot_be_fitted_says_why(change, reason):
    analysis = analyse(change(a_run()), radius=0.75)
    assert reason in analysis.following.refused
    assert not any("as they were told" in v.question for v in analysis.verdicts)
    assert "No gains:" in render([analysis])


def test_the_stretch_of_most_varied_commands_is_taken():
    run = a_run(rows=8000)
    commands = run.commands.copy()
    commands[:4500] = 0.05
    commands[7600:] = 0.05
    part = _most_varied(Run("run", run.t, run.poses, commands), 0.0)
    assert len(part.t) == INCREMENTS // ROBOTS
    assert STEP * 4400 < part.t[0] < STEP * (7700 - len(part.t))
    late = _most_varied(Run("run", run.t, run.poses, commands), STEP * 7000)
    assert late.t[0] == pytest.approx(STEP * 7000)


def test_page_figures_and_json_show_it(slow, tmp_path):
    write_report([slow], tmp_path / "report", figures=False)
    page = (tmp_path / "report" / "report.html").read_text()
    assert "Speed: gain 0.70" in page
    assert page.count("<svg viewBox=") >= 3
    assert not re.search(r"[ \"(,]nan[ \",)]", page[page.index('id="following"') :][:30_000])
    titles = [axes.get_title(loc="left") for axes in following_figure(slow.following).axes]
    assert titles[:2] == ["speed: gain 0.70", "turn rate: gain 1.00"]
    said = json.loads((tmp_path / "report" / "summary.json").read_text())["following"]
    assert said["speed"][0]["gain"]["low"] < 0.7 < said["speed"][0]["gain"]["high"]


def test_a_saved_analysis_keeps_it(slow, tmp_path):
    again = load(slow.save(tmp_path / "saved.npz"))
    assert isinstance(again.following, Following)
    assert again.following == slow.following
