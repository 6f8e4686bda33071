"""A run is asked what it can be asked: a flock whether it flocked, another what its user wants."""

import dataclasses
import re

import numpy as np
import pytest
from judged_runs import verdict
from typer.testing import CliRunner

from posflock_robotarium.alignment.questions import ChosenBy
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.alignment.verdicts import headline
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, ParameterError
from posflock_robotarium.report import (
    AnalysisOptions,
    Questions,
    Run,
    analyse,
    curve_figures,
    load,
    write_report,
)
from posflock_robotarium.report.outputs import latex_table
from posflock_robotarium.report.page import render
from posflock_robotarium.report.page_data import page_data

T = 0.1 * np.arange(400)


def team(places, heading=0.0):
    """Robots at `places` (T, 2, N), as a run whose log says nothing else."""
    poses = np.full((len(T), 3, places.shape[2]), heading)
    poses[:, :2] = places
    return Run("team", T, poses)


def closing(rest=0.0):
    """Four robots on a line that close up in the first half, and then are `rest` (m/s) restless."""
    reach = np.clip(1.0 - T / 20, 0, 1)[:, np.newaxis]
    x = np.arange(4) * 0.3 - 0.5 + 0.2 * reach * np.arange(4)
    x[:, 3] += rest * np.maximum(T - 20, 0)
    return team(np.stack([x, np.zeros_like(x)], axis=1))


def standing():
    return team(np.broadcast_to([[-0.5, 0.0, 0.5], [0.0, 0.3, 0.0]], (len(T), 2, 3)).copy())


def test_a_log_that_says_no_radius_is_answered_and_not_told_that_it_failed():
    analysis = analyse(standing())
    assert (analysis.asked.questions, analysis.asked.by) == (Questions.NONE, ChosenBy.DEFAULT)
    questions = [each.question for each in analysis.verdicts]
    assert questions == ["Was it safe?", "Within the robots' limits?", "How sure are we?"]
    assert not [each for each in analysis.verdicts if each.mark == "bad"]
    assert not [key for key in analysis.curves if key.startswith(("gamma", "components"))]
    assert not [key for key in analysis.numbers if "aligned" in key or "connected" in key]
    page = render([analysis])
    assert "--questions" in page
    assert "γ" not in page.split("Numbers and what they mean")[0].split('id="data"')[0]


@pytest.mark.parametrize(
    ("parameters", "options", "questions", "by"),
    [
        ({}, {}, Questions.NONE, ChosenBy.DEFAULT),
        ({"neighbour_radius": 0.5}, {}, Questions.FLOCKING, ChosenBy.LOG),
        ({}, {"radius": 0.5}, Questions.FLOCKING, ChosenBy.RADIUS),
        ({"neighbour_radius": 0.5}, {"questions": Questions.NONE}, Questions.NONE, ChosenBy.USER),
    ],
)
def test_what_is_asked_is_said_with_its_reason(parameters, options, questions, by, tmp_path):
    run = dataclasses.replace(closing(), parameters=parameters)
    analysis = analyse(run, AnalysisOptions(**options))
    assert (analysis.asked.questions, analysis.asked.by) == (questions, by)
    told = any("flock align" in each.question for each in analysis.verdicts)
    assert told is (questions is Questions.FLOCKING)
    assert analysis.summary()["asked"]["reason"] == analysis.asked.reason
    again = load(analysis.save(tmp_path / "run.analysis.npz"))
    assert (again.asked, again.options) == (analysis.asked, analysis.options)
    assert again.summary() == analysis.summary()


def test_whoever_asks_about_flocking_is_asked_for_the_radius():
    with pytest.raises(LogError, match="--radius"):
        analyse(closing(), AnalysisOptions(questions=Questions.FLOCKING))


@pytest.mark.parametrize(
    ("run", "mark", "answer"),
    [
        (closing(), "good", "Yes, from 1"),
        (closing(rest=0.05), "bad", "No: distances change to the end."),
        (standing(), "caution", "It kept the shape that it began with: nothing moves."),
    ],
)
def test_a_formation_is_taken_up_and_kept(run, mark, answer):
    analysis = analyse(run, AnalysisOptions(questions=Questions.FORMATION))
    said = verdict(analysis, "formation")
    assert said.mark == mark
    assert said.answer.startswith(answer)


def test_a_shape_that_travels_and_turns_is_kept():
    angle = 0.05 * T[:, np.newaxis] + np.linspace(0, 6, 5, endpoint=False)
    places = 0.3 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + 0.01 * T[:, None, None]
    analysis = analyse(team(places), AnalysisOptions(questions=Questions.FORMATION))
    assert analysis.curves["shape_change"].max() < 1e-9
    assert verdict(analysis, "formation").answer == "Yes, throughout."


def test_one_robot_has_no_formation():
    analysis = analyse(
        team(np.zeros((len(T), 2, 1))), AnalysisOptions(questions=Questions.FORMATION)
    )
    assert verdict(analysis, "formation").mark == "unknown"


@pytest.mark.parametrize(
    ("start", "end", "mark"),
    [
        ([-0.1, 0.1], [-0.8, 0.8], "good"),
        ([-0.1, 0.1], [-0.4, 0.4], "caution"),
        ([-0.8, 0.8], [0, 0.1], "bad"),
    ],
)
def test_coverage_is_judged_by_cells_and_distances(start, end, mark):
    share = np.clip(T / 20, 0, 1)[:, np.newaxis]
    x = np.asarray(start) * (1 - share) + np.asarray(end) * share
    analysis = analyse(
        team(np.stack([x, np.zeros_like(x)], axis=1)), AnalysisOptions(questions=Questions.COVERAGE)
    )
    assert verdict(analysis, "cover").mark == mark
    # Two halves of 1.6 m by 2 m, each with its robot in the middle.
    if mark == "good":
        assert analysis.numbers["cell_offset_end"].value == pytest.approx(0.0, abs=0.01)
        grid = np.stack(np.meshgrid(np.linspace(-0.8, 0.8, 801), np.linspace(-1, 1, 801)))
        expected = np.hypot(*grid).mean()
        assert analysis.numbers["coverage_end"].value == pytest.approx(expected, rel=0.01)


def outcome(run, target, **options):
    analysis = analyse(run, AnalysisOptions(targets=(target,), **options))
    [found] = analysis.targets
    return found, analysis


def test_targets_are_verdicts_numbers_and_lines(tmp_path):
    found, analysis = outcome(closing(), "cohesive_radius < 0.6 m for 50 % of the time")
    curve = analysis.curves["cohesive_radius"]
    assert found.share == pytest.approx((curve < 0.6).mean(), abs=1e-9)
    assert found.met is True
    said = analysis.verdicts[0]
    assert said.question == "cohesive_radius < 0.6 m for 50 % of the time?"
    assert (said.mark, said.short) == ("good", "cohesive radius on target")
    assert analysis.numbers["on_target_cohesive_radius"].value == found.share
    write_report([analysis], tmp_path, figures=False)
    assert "target 0.6" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_two_targets_of_one_metric_are_two_rows_and_one_word_in_the_headline():
    kept = ("cohesive_radius > 0.1 m always", "cohesive_radius < 0.6 m at the end")
    analysis = analyse(closing(), AnalysisOptions(targets=kept))
    assert headline(analysis.verdicts).count("cohesive radius on target") == 1
    at_end = analysis.numbers["at_end_cohesive_radius"]
    assert at_end.value == analysis.curves["cohesive_radius"][-1] == analysis.targets[1].value
    assert (at_end.label, at_end.unit) == ("cohesive radius at the end", "m")
    assert "on_target_cohesive_radius" in analysis.numbers
    assert analysis.verdicts[1].because == ""  # the mean and range of the run are not of its end
    mixed = analyse(closing(), AnalysisOptions(targets=(*kept, "cohesive_radius > 9 m")))
    assert headline(mixed.verdicts).startswith("cohesive radius on 2 of 3 targets, ")


@pytest.mark.parametrize(
    ("target", "met"),
    [
        ("cohesive_radius < 0.6 m", False),
        ("cohesive_radius < 60 cm after 25 s", True),
        ("cohesive_radius < 0.6 m at the end", True),
        ("cohesive_radius < 0.5 m on average", False),
        ("cohesive_radius > 0.1 m always", True),
        ("collisions <= 0", True),
        ("robots > 4", False),
        ("standing < 1 %", False),
        ("cohesive_radius < 1 m after 100 s", None),
        ("fastest_wheel < 5 rad/s", None),
        ("gamma_motion > 0.9", None),
    ],
)
def test_a_target_is_kept_or_missed_or_unknown(target, met):
    assert outcome(closing(), target)[0].met is met


def test_what_is_undefined_is_neither_kept_nor_missed():
    run = known_flock("parallel", 0.1, duration=20.0, position_noise=0).recording
    poses = run.poses.copy()
    poses[: len(poses) // 5] = poses[len(poses) // 5]  # nobody moves: no direction, no γ
    run = dataclasses.replace(run, poses=poses)
    marks = {
        share: outcome(run, f"polarisation_motion > 0.9 for {share} % of the time")[0].met
        for share in (70, 90)
    }
    assert marks == {70: True, 90: None}
    assert outcome(run, "polarisation_motion < 0.9 for 90 % of the time")[0].met is False


@pytest.mark.parametrize(
    ("target", "said"),
    [
        ("cohesive_radus < 1 m", "no metric is called 'cohesive_radus'; expected cohesive_radius"),
        ("cohesive_radius < 1 s", "cohesive_radius is in m"),
        ("collisions < 1 always", "collisions is one number a run"),
        ("cohesive_radius", "METRIC < VALUE UNIT"),
    ],
)
def test_a_target_that_means_nothing_is_refused(target, said):
    with pytest.raises(ParameterError, match=said):
        outcome(closing(), target)


def test_what_is_asked_stands_first_and_nothing_of_flocks_beside_it():
    """A target of a flock's metric brings its plot back."""
    options = AnalysisOptions(questions=Questions.FORMATION, targets=("shape_change < 5 cm",) * 2)
    analysis = analyse(closing(), options)
    assert list(analysis.numbers)[:3] == [
        "on_target_shape_change",
        "on_target_shape_change_2",
        "shape_change_end",
    ]
    assert latex_table([analysis]).split(r"\midrule")[1].strip().startswith("change of shape")
    drawn = page_data([analysis]).panels
    assert "polarisation" not in {panel.key for panel in drawn}
    assert drawn[0].lines == ((0.05, "target 0.05 m", True),)  # once, with its unit
    assert "flock" not in re.sub(r"posflock\w*", "", render([analysis]).split("<script")[0])
    flocks = dataclasses.replace(options, targets=("polarisation_motion > 0.9",))
    assert "polarisation" in {panel.key for panel in page_data([analyse(closing(), flocks)]).panels}


def test_figures_are_those_that_the_run_has_curves_for(monkeypatch, tmp_path):
    monkeypatch.setattr(curve_figures, "save", lambda figure, folder, name: [folder / name])
    options = AnalysisOptions(questions=Questions.FORMATION, targets=("shape_change < 5 cm",))
    analysis = analyse(closing(), options)
    drawn = {path.name for path in curve_figures.draw([analysis], tmp_path)}
    assert drawn == {"snapshots", "distances", "motion", "formation"}
    lines = [line.get_label() for line in curve_figures.curves(analysis, "formation").axes[0].lines]
    assert lines == ["change of shape", "target 0.05 m"]
    drawn = {path.name for path in curve_figures.draw([analysis] * 3, tmp_path)}
    assert drawn == {"runs", "runs_shape_change"}


def test_the_command_says_what_it_asked(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.savez("run.npz", t=T, poses=closing().poses)
    told = CliRunner().invoke(app, ["report", "run.npz", "--no-figures"]).output
    assert "asked    none, since the log says no neighbour radius" in told
    with pytest.raises(ParameterError, match="none of flocking, formation, coverage, none"):
        CliRunner().invoke(
            app, ["report", "run.npz", "--questions", "flock"], catch_exceptions=False
        )
