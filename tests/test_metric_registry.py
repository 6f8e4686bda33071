"""One entry makes a metric: whoever registers it finds it in everything that a report leaves."""

import csv
import dataclasses
import json
import sys

import numpy as np
import pytest

from posflock_robotarium.alignment import catalogue, metrics
from posflock_robotarium.alignment.catalogue import Line, Metric, Panel, Scalar, forget, register
from posflock_robotarium.alignment.measuring import curves_of, measure, numbers_of
from posflock_robotarium.alignment.metric_registry import GROUPS
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.alignment.reductions import largest, settled_mean, smallest
from posflock_robotarium.alignment.summary import summarise, summary_of
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.figures.experiment import alignment_over_time, distances_and_speeds
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.report import analyse, curve_figures, load, write_report
from posflock_robotarium.report.curve_figures import curves, motion


def team_speed(run):
    return np.hypot(*run.velocities("savitzky_golay").mean(axis=2).T)


TEAM_SPEED = Metric(
    "team_speed",
    "speed of the team",
    "m/s",
    "How fast the team's centroid moves.",
    team_speed,
    panel=Panel("team", "The team", "m/s", lines=(Line("fast", lambda robot: 0.2),)),
    figure="team",
    beside_replay=True,
    numbers=(
        Scalar(
            "team_speed",
            "speed of the team",
            "m/s",
            "Mean {run.since}, threshold {run.options.threshold:g}.",
            "Team",
            settled_mean("team_speed"),
            latex=True,
            column="team",
        ),
    ),
)


@pytest.fixture
def team():
    register(TEAM_SPEED)
    yield TEAM_SPEED
    forget(TEAM_SPEED)


def a_run(**changes):
    flock = known_flock("rotating", 0.1, duration=6.0)
    recording = dataclasses.replace(flock.recording, **changes)
    return dataclasses.replace(recording, parameters={"neighbour_radius": flock.radius})


def test_one_entry_is_in_json_csv_latex_table_and_page(team, tmp_path):
    run = analyse(a_run(name="run"))
    write_report([run], tmp_path, latex=True, figures=False)
    expected = np.hypot(*metrics.smoothed_velocities(run.recording.poses[:, :2], 0.033).mean(2).T)
    told = json.loads((tmp_path / "summary.json").read_text())
    number = told["numbers"]["team_speed"]
    assert number["value"] == pytest.approx(expected.mean(), abs=1e-12)
    assert number["definition"] == "Mean of the whole run, threshold 0.9."
    assert list(told["numbers"])[-1] == "team_speed"  # a heading of its own, after the others
    assert told["statistics"]["team_speed"]["largest"] == pytest.approx(expected.max(), abs=1e-12)
    with (tmp_path / "metrics.csv").open() as file:
        column = [float(row["team_speed"]) for row in csv.DictReader(file)]
    np.testing.assert_allclose(column, expected, rtol=0, atol=1e-12)
    assert "speed of the team & " in (tmp_path / "table.tex").read_text()
    page = (tmp_path / "report.html").read_text()
    assert "<summary>Team</summary>" in page
    assert "How fast the team&#39;s centroid moves." in page
    data = json.loads(page.split('id="data">')[1].split("</script>")[0])
    assert data["panels"][-1]["title"] == "The team"
    assert data["panels"][-1]["lines"] == [[0.2, "fast", True]]
    assert [series["key"] for series in data["panels"][-1]["series"]] == ["team_speed"]
    assert {"key": "team_speed", "label": "speed of the team", "unit": "m/s"} in data[
        "beside_replay"
    ]
    assert load(tmp_path / "run.analysis.npz").summary() == run.summary()


def test_one_entry_is_in_the_comparison_of_several_runs(team, tmp_path):
    write_report([analyse(a_run(name=name)) for name in "ab"], tmp_path, figures=False)
    told = json.loads((tmp_path / "summary.json").read_text())
    assert told["comparison"]["numbers"]["team_speed"]["group"] == "Team"
    assert '<th scope="col">team</th>' in (tmp_path / "report.html").read_text()


def test_a_metric_is_drawn_in_the_figure_that_it_names(team, monkeypatch, tmp_path):
    run = analyse(a_run())
    monkeypatch.setattr(curve_figures, "save", lambda figure, folder, name: [folder / name])
    files = {path.name for path in curve_figures.draw([run], tmp_path)}
    assert files == {"snapshots", "alignment", "distances", "motion", "team"}
    line, level = curves(run, "team").axes[0].get_lines()
    assert list(level.get_ydata()) == [0.2, 0.2]
    np.testing.assert_array_equal(line.get_ydata(), run.curves["team_speed"])
    assert curves(run, "team").axes[0].get_ylabel() == "speed of the team (m/s)"
    forget(team)
    beside = dataclasses.replace(team, figure="motion", legend="team")
    register(beside)
    try:
        drawn = {line.get_label(): line for line in motion(run).axes[0].get_lines()}
    finally:
        forget(beside)
        register(team)
    assert list(drawn) == ["mean", "centroid", "team"]
    looks = {(line.get_color(), str(line._dash_pattern)) for line in drawn.values()}
    assert len(looks) == 3


def test_one_file_beside_the_others_is_enough(tmp_path, monkeypatch):
    monkeypatch.setattr(catalogue, "__path__", [*catalogue.__path__, str(tmp_path)])
    (tmp_path / "a_family_of_its_own.py").write_text(
        "from posflock_robotarium.alignment.metric_registry import Metric, register\n"
        "MINE = Metric('mine', 'mine', 's', 'Mine.', lambda run: run.recording.t)\n"
        "register(MINE)\n"
    )
    before = list(catalogue.metrics())
    catalogue.load_families()
    family = sys.modules.pop(f"{catalogue.__name__}.a_family_of_its_own")
    try:
        assert list(analyse(a_run()).curves)[-1] == "mine"
        assert list(catalogue.metrics()) == [*before, "mine"]
    finally:
        forget(family.MINE)


def test_a_key_is_given_once(team):
    before = list(catalogue.metrics()), list(catalogue.scalars())
    with pytest.raises(ParameterError, match="'team_speed' is registered already"):
        register(dataclasses.replace(team, numbers=()))
    with pytest.raises(ParameterError, match="'team_speed' is registered already"):
        register(dataclasses.replace(team, key="other"))
    with pytest.raises(ParameterError, match="'speed' is registered already"):
        register(dataclasses.replace(team.numbers[0], key="speed"))
    (number,) = team.numbers
    twice = tuple(dataclasses.replace(number, key="twice") for _ in range(2))
    with pytest.raises(ParameterError, match="'other': two of its numbers have one key"):
        register(dataclasses.replace(team, key="other", numbers=twice))
    assert (list(catalogue.metrics()), list(catalogue.scalars())) == before


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"key": "team speed"}, "expected letters, digits and underscores"),
        ({"figure": "../team"}, "expected a plain file name"),
        ({"figure": "snapshots"}, "other than snapshots, runs, sightings"),
        ({"of_interest": "least"}, "'least'; expected one of mean, smallest, largest"),
    ],
)
def test_an_entry_that_makes_no_sense_is_refused(wrong, said):
    with pytest.raises(ParameterError, match=said):
        dataclasses.replace(TEAM_SPEED, **wrong)


def test_a_function_of_another_shape_is_named(team):
    run = measure(a_run())
    wrong = dataclasses.replace(run, curve_functions={"speeds": lambda run: run.speeds})
    with pytest.raises(ParameterError, match=r"'speeds'.* shape \(182, 10\); expected .*\(182,\)"):
        wrong.curve("speeds")


@pytest.mark.parametrize("definition", ["{", "{run.nothing}", "{x}", "{}"])
def test_braces_that_name_nothing_of_a_run_are_refused(definition):
    scalar = dataclasses.replace(catalogue.scalars()["speed"], definition=definition)
    with pytest.raises(ParameterError, match="'speed': braces"):
        scalar.of(measure(a_run()))
    in_latex = dataclasses.replace(scalar, definition="$v_{{xy}}$")
    assert in_latex.of(measure(a_run())).definition == "$v_{xy}$"


def test_what_was_not_registered_cannot_be_forgotten():
    with pytest.raises(ParameterError, match="'team_speed' is not registered"):
        forget(TEAM_SPEED)
    with pytest.raises(ParameterError, match="'speed' is not registered"):
        forget(dataclasses.replace(TEAM_SPEED, key="speed"))
    assert "speed" in catalogue.metrics()


def test_every_metric_says_what_it_is():
    for entry in [*catalogue.metrics().values(), *catalogue.scalars().values()]:
        assert entry.label, entry.key
        assert entry.definition.endswith("."), entry.key
        assert entry.unit in ("", "m", "m/s", "s", "rad", "rad/s", "share"), entry.key
    groups = [scalar.group for scalar in catalogue.scalars().values()]
    assert tuple(dict.fromkeys(groups)) == GROUPS
    drawn = [metric.key for _, shown in catalogue.panels() for metric in shown]
    assert len(drawn) == len(set(drawn))


def test_a_curve_of_no_metric_is_named():
    with pytest.raises(ParameterError, match="curve 'gama' is of no metric; expected one of gamma"):
        measure(a_run()).curve("gama")


def test_the_usual_reductions_leave_out_what_is_undefined():
    run = measure(a_run())
    values = np.r_[np.nan, np.full(180, 1.0), 4.0]
    some = dataclasses.replace(run, curve_functions={"x": lambda _: values, "none": lambda _: None})
    assert smallest("x")(some) == 1.0
    assert largest("x")(some) == 4.0
    assert [of("none")(some) for of in (settled_mean, smallest, largest)] == [None] * 3
    assert run.mean(np.r_[np.nan, np.ones(180), 3.0]) == pytest.approx(183 / 181)


def test_each_is_computed_once(monkeypatch):
    asked = []
    alignment = metrics.alignment
    monkeypatch.setattr(metrics, "alignment", lambda *a, **k: asked.append(1) or alignment(*a, **k))
    run = measure(a_run())
    curves_of(run)
    numbers_of(run)
    assert len(asked) == 3  # one an estimator


def test_a_summary_computes_only_what_it_prints(monkeypatch):
    recording = a_run()
    expected = summary_of(analyse(recording))

    def unasked(*arguments, **named):
        raise AssertionError("computed, but printed nowhere")

    for name in ("connected_components", "algebraic_connectivity", "polarisation", "spread"):
        monkeypatch.setattr(metrics, name, unasked)
    for name in ("tracking_noise", "velocities_by_differences"):
        monkeypatch.setattr(f"posflock_robotarium.alignment.estimators.{name}", unasked)
    monkeypatch.setattr(
        "posflock_robotarium.alignment.catalogue.confidence.tracking_noise", unasked
    )
    assert str(summarise(recording)) == str(expected)


@pytest.mark.parametrize("step", [0.033, 0.1])
def test_the_experiments_figures_show_the_curves_of_the_report(step):
    recording = a_run(t=step * np.arange(182), poses=one_noisy().poses)
    analysis = analyse(recording)
    lines = {line.get_label(): line for line in alignment_over_time(recording).axes[0].get_lines()}
    for label, key in (("motion", "gamma_motion"), ("headings", "gamma_headings")):
        np.testing.assert_array_equal(lines[label].get_ydata(), analysis.curves[key])
    left, right = distances_and_speeds(recording).axes
    drawn = {line.get_label(): line for axes in (left, right) for line in axes.get_lines()}
    for label, key in (
        ("mean", "speed"),
        ("centroid", "drift"),
        ("closest pair", "smallest_distance"),
    ):
        np.testing.assert_array_equal(drawn[label].get_ydata(), analysis.curves[key])


def one_noisy():
    return known_flock("random", 0.1, duration=6.0, position_noise=0.002).recording


def test_options_are_those_that_were_given():
    run = measure(a_run(), AnalysisOptions(radius=0.4, transient=2.0))
    assert run.radius == 0.4
    assert run.since == "after 2 s"
    assert run.settled.sum() == (run.recording.t > 2.0).sum()
