"""A metric from a user's file joins the report, and its mistakes are told by file and line."""

import csv
import dataclasses
import json

import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.alignment.catalogue import metrics, scalars
from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.alignment.users_code import MetricError
from posflock_robotarium.cli import app
from posflock_robotarium.report import analyse, load, own_metrics, write_report
from posflock_robotarium.report.curve_figures import curves

GOOD = '''
import numpy as np
from posflock_robotarium.alignment.catalogue import Metric, Scalar
from posflock_robotarium.report import metric

import beside


@metric(unit="m", description="Distance of the centroid from {0, 0}", label="way of $c$")
def way(run):
    print("words of the user's")
    return np.hypot(*run.positions.mean(axis=2).T) * beside.ONE


def bare(run):
    """How many robots."""
    return run.robots


def lazy(run):
    import beside

    return [beside.ONE] * len(run.t)


lazy.unit = "s"
ENTRY = Metric("entry", "entry", "s", "Times.", lambda run: run.t)
NUMBER = Scalar("number", "number", "", "One.", "Mine", lambda run: 1 / 0)
'''


@pytest.fixture(scope="module")
def run():
    return known_flock("rotating", 0.1, duration=4.0).recording


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(GOOD)
    (tmp_path / "beside.py").write_text("ONE = 1.0\n")
    return "own.py"


def test_a_function_joins_everything_a_report_leaves(run, file, tmp_path):
    known = dataclasses.replace(run, name="a"), dataclasses.replace(run, name="b")
    with own_metrics([f"{file}:way", f"{file}:bare", f"{file}:lazy", f"{file}:ENTRY"]):
        analysis, other = (analyse(each) for each in known)
        write_report([analysis], tmp_path / "one", latex=True, figures=False)
        write_report([analysis, other], tmp_path / "two", figures=False)
        [line] = curves(analysis, "way").axes[0].get_lines()
        assert curves(analysis, "way").axes[0].get_ylabel() == r"way of \$c\$ (m)"
    expected = np.hypot(*run.poses[:, :2].mean(axis=2).T)
    np.testing.assert_array_equal(line.get_ydata(), analysis.curves["way"])
    np.testing.assert_allclose(analysis.curves["way"], expected)
    number = analysis.numbers["way"]
    assert number.value == pytest.approx(expected.mean())
    assert number.definition == "Distance of the centroid from {0, 0}. Mean of the whole run."
    assert (number.unit, number.label) == ("m", "way of $c$")
    assert analysis.numbers["way_largest"].value == pytest.approx(expected.max())
    assert analysis.numbers["bare"].value == run.robots
    assert analysis.numbers["bare"].definition == "How many robots."
    assert "bare_largest" not in analysis.numbers
    assert analysis.numbers["lazy"].unit == "s"
    with (tmp_path / "one" / "metrics.csv").open() as rows:
        assert float(next(csv.DictReader(rows))["way"]) == expected[0]
    assert json.loads((tmp_path / "one" / "summary.json").read_text())["numbers"]["way"]
    assert r"way of \$c\$ & " in (tmp_path / "one" / "table.tex").read_text()
    data = (tmp_path / "one" / "report.html").read_text().split('id="data">')[1]
    panels = json.loads(data.split("</script>")[0])["panels"]
    assert [panel["title"] for panel in panels[:2]] == ["Way of $c$", "Lazy"]
    summary = json.loads((tmp_path / "two" / "summary.json").read_text())
    assert summary["comparison"]["numbers"]["way"]["group"] == "Own metrics"
    assert load(tmp_path / "one" / "a.analysis.npz").numbers["way"] == number


def test_the_catalogue_is_afterwards_as_it_was(run, file):
    before = list(metrics()), list(scalars())
    with own_metrics([f"{file}:way"]):
        assert "way" in metrics()
    with pytest.raises(MetricError), own_metrics([f"{file}:way", f"{file}:missing"]):
        pass
    assert (list(metrics()), list(scalars())) == before


MISTAKES = {
    "raise IndexError('no robot 7')": r"own.py:3: error: IndexError: no robot 7",
    "raise SystemExit(3)": r"own.py:3: error: SystemExit: 3",
    "return 1 / 0": r"own.py:3: error: ZeroDivisionError",
    "return sum(": r"own.py:3: SyntaxError",
    "return run.speeds": r"own.py:2: error returned shape \(121, 10\); .*\(121,\)\. One a robot",
    "return np.diff(run.t)": r"shape \(120,\); expected one .* 121 samples.*One is missing",
    "return run.t[:, None]": r"returned shape \(121, 1\).*ravel",
    "return run.t * np.nan": r"returned NaN at 121 of 121 samples, first at 0.000 s; ",
    "return np.where(run.t > 2, np.inf, 0)": r"returned inf at 60 of 121 samples",
    "return float('nan')": r"returned NaN; expected finite",
    "return run.t + 0j": r"returned complex numbers \(complex128\); expected one real number",
    "return None": r"returned None; .*'return'",
    "return 'far'": r"returned str; expected one real number",
    "return [[1.0], [1.0, 2.0]]": r"returned list",
    "return {'a': 1}": r"returned dict; expected",
    "return (x for x in run.t)": r"returned generator; expected",
    "run.positions[:] = 0": r"own.py:3: error: ValueError: .*read-only",
    "run.recording.poses[:] = 0": r"own.py:3: error: ValueError: .*read-only",
    "run.velocities('headings')[:] = 0\n    return 1.0": "ValueError: .*read-only",
    "run.curve('speed')[:] = 0\n    return 1.0": "ValueError: .*read-only",
    "return np.ma.masked_less(run.t, 1.0)": r"returned NaN at 31 of 121 samples",
}


@pytest.mark.parametrize("body", MISTAKES)
def test_a_mistake_is_told_by_file_and_line(run, tmp_path, monkeypatch, body):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(f"import numpy as np\ndef error(run):\n    {body}\n")
    with (
        pytest.raises(MetricError, match=MISTAKES[body]) as told,
        own_metrics(["own.py:error"]),
    ):
        analyse(run)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("own.py", "expected FILE.py:FUNCTION"),
        ("own:way", "expected FILE.py:FUNCTION"),
        ("none.py:way", "none.py: no such file"),
        ("own.py:wai", "own.py: no function 'wai' in it; its functions: way, bare, lazy"),
        ("own.py:beside", "no function 'beside'"),
    ],
)
def test_what_is_not_there_is_told(file, asked, said):
    with pytest.raises(MetricError, match=said), own_metrics([asked]):
        pass


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("unit='two words'", r"own.py:3: error: unit is 'two words'; expected one word"),
        ("unit=3", r"own.py:3: error: unit is 3; expected str"),
        ("unit='for'", "unit is 'for'"),
        ("of_interest='least'", "expected one of mean, smallest, largest"),
    ],
)
def test_words_that_make_no_sense_are_refused(tmp_path, monkeypatch, said, told):
    monkeypatch.chdir(tmp_path)
    text = f"from posflock_robotarium.report import metric\n@metric({said})\ndef error(run): ...\n"
    (tmp_path / "own.py").write_text(text)
    with pytest.raises(MetricError, match=told), own_metrics(["own.py:error"]):
        pass


def test_a_name_that_is_taken_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text("def speed(run): return run.t\n")
    with pytest.raises(MetricError, match="'speed' is registered already"):
        own_metrics(["own.py:speed"]).__enter__()


def test_what_may_be_undefined_may_be(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(
        "import numpy as np\ndef late(run): return np.where(run.t < 2, np.nan, 1.0)\n"
        "late.may_be_undefined = True\n"
    )
    with own_metrics(["own.py:late"]):
        assert analyse(run).numbers["late"].value == 1.0


def test_an_entry_that_fails_is_told_by_line(run, file):
    line = GOOD.splitlines().index(
        'NUMBER = Scalar("number", "number", "", "One.", "Mine", lambda run: 1 / 0)'
    )
    told = rf"own.py:{line + 1}: NUMBER: ZeroDivisionError"
    with pytest.raises(MetricError, match=told), own_metrics([f"{file}:NUMBER"]):
        analyse(run)


def test_two_folders_may_have_files_of_one_name(run, tmp_path, monkeypatch):
    for name, one in (("a", 1.0), ("b", 2.0)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "beside.py").write_text(f"ONE = {one}\n")
        (tmp_path / name / "own.py").write_text("import beside\ndef one(run): return beside.ONE\n")
        with own_metrics([str(tmp_path / name / "own.py") + ":one"]):
            assert analyse(run).numbers["one"].value == one


def test_what_a_function_prints_is_no_data(run, file, tmp_path):
    np.savez(tmp_path / "run.npz", t=run.t, poses=run.poses)
    arguments = ["report", "run.npz", "--metric", f"{file}:way", "--no-figures", "--json"]
    told = CliRunner().invoke(app, arguments)
    assert told.exit_code == 0, told.output
    assert json.loads(told.stdout)["numbers"]["way"]
    assert "words of the user's" in told.stderr


def test_a_saved_analysis_is_asked_again(run, file, tmp_path):
    analyse(run).save(tmp_path / "run.analysis.npz")
    arguments = ["run.analysis.npz", "run.analysis.npz", "--metric", f"{file}:way"]
    arguments += ["--target", "way < 100 m", "--questions", "formation", "--json"]
    told = json.loads(CliRunner().invoke(app, ["compare", *arguments]).stdout)
    assert set(told["numbers"]) >= {"way", "on_target_way", "shape_change_end"}
