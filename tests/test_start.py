"""With the package alone: a demonstration, the examples, a script of one's own."""

import ast
import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.alignment.own_metrics import own_metrics
from posflock_robotarium.alignment.users_code import imported
from posflock_robotarium.cli import app
from posflock_robotarium.examples import NINE_ROBOTS, copy_examples, example_files
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.new_script import ExperimentKind, write_script
from posflock_robotarium.sweep.study import read_study
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script

EXPERIMENTS = Path(__file__).resolve().parents[1] / "experiments"


def posflock(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def test_examples_are_the_experiments_byte_for_byte(tmp_path):
    told = posflock("examples", "-o", tmp_path / "here")
    assert told.exit_code == 0
    for name in example_files():
        assert (tmp_path / "here" / name).read_bytes() == (EXPERIMENTS / name).read_bytes()
    assert {NINE_ROBOTS, "old_script.py", "nine_robots.ipynb"} <= {str(n) for n in example_files()}


def test_examples_never_overwrite_what_was_changed(tmp_path):
    copy_examples(tmp_path)
    copy_examples(tmp_path)  # equal: no harm
    (tmp_path / NINE_ROBOTS).write_text("# mine now\n")
    (tmp_path / "old_script.py").unlink()
    with pytest.raises(OutputError, match="nothing was copied"):
        copy_examples(tmp_path)
    assert (tmp_path / NINE_ROBOTS).read_text() == "# mine now\n"
    assert not (tmp_path / "old_script.py").exists()


def test_a_demonstration_leaves_log_and_summary(tmp_path, monkeypatch):
    monkeypatch.setattr("posflock_robotarium.figures.experiment.draw_run", lambda log, path: [])
    told = posflock("demo", "-o", tmp_path / "new" / "results", "--duration", 3)
    assert told.exit_code == 0, told.output
    assert json.loads((tmp_path / "new/results/summary.json").read_text())["collisions"] == 0
    assert len(np.load(tmp_path / "new/results/nine_robots.npy")) == 91
    assert posflock("demo", "--duration", "nan").exit_code == 1


def test_a_notebook_is_one_that_jupyter_opens():
    book = json.loads((EXPERIMENTS / "nine_robots.ipynb").read_text(encoding="utf-8"))
    assert book["nbformat"] == 4
    assert len({cell["id"] for cell in book["cells"]}) == len(book["cells"])
    for cell in book["cells"]:
        if cell["cell_type"] == "code":
            assert not cell["outputs"]
            ast.parse("".join(cell["source"]))


@pytest.mark.slow
def test_a_notebook_runs_from_top_to_bottom(tmp_path):
    book = json.loads((EXPERIMENTS / "nine_robots.ipynb").read_text(encoding="utf-8"))
    code = ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == "code"]
    program = "import matplotlib\nmatplotlib.use('agg')\n" + "\n".join(code)
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True)
    assert (tmp_path / "results/notebook.png").exists()


# --- A script of one's own ----------------------------------------------------------------------


@pytest.mark.parametrize("experiment", ExperimentKind)
def test_a_new_script_runs_logs_itself_and_its_metric_reads_the_log(experiment, tmp_path):
    script, metric, readme, *_ = write_script("mine", experiment, tmp_path)
    short = script.read_text().replace(f"DURATION = {experiment.kind.duration}", "DURATION = 3.0")
    assert "DURATION = 3.0" in short
    script.write_text(short)
    outcome = run_script(script, settings=RunSettings(headless=True))
    assert outcome.clean, outcome.reason
    log = np.load(script.with_name("mine.npy"))
    assert len(log) == 91
    assert np.isfinite(log["pose"]).all()
    told = subprocess.run(
        [sys.executable, metric.name], cwd=script.parent, capture_output=True, text=True, check=True
    ).stdout
    assert experiment.kind.metric in told
    assert f"python {metric.name}" in readme.read_text()


@pytest.mark.slow
@pytest.mark.parametrize("experiment", ExperimentKind)
def test_a_new_script_passes_verify_and_does_what_it_is_for(experiment, tmp_path):
    script, metric, *_ = write_script("mine", experiment, tmp_path)
    posflock = [sys.executable, "-m", "posflock_robotarium"]
    command = [*posflock, "verify", "mine.py", "-n", "5", "--json"]
    done = subprocess.run(command, cwd=script.parent, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    subprocess.run([*posflock, "run", "mine.py"], cwd=script.parent, check=True)
    values = subprocess.run(
        [sys.executable, "-c", "import mine_metric as m, numpy as np; log = np.load('mine.npy')\n"
         "print(m.metric(log['pose'][0]), m.metric(log['pose'][-1]))"],
        cwd=metric.parent, capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    first, last = map(float, values)
    assert last > 0.95 if experiment is ExperimentKind.FLOCKING else last < 0.75 * first


def test_a_new_script_is_what_our_own_style_asks_for(tmp_path):
    pytest.importorskip("ruff", reason="only developers have it")
    for experiment in ExperimentKind:
        write_script(f"my_{experiment.name.lower()}", experiment, tmp_path)
    ruff = [sys.executable, "-m", "ruff"]
    settings = ["--config", str(EXPERIMENTS.parent / "pyproject.toml"), "--no-cache"]
    subprocess.run(
        [*ruff, "check", "-q", *settings, "--ignore", "D103", "."], cwd=tmp_path, check=True
    )
    subprocess.run([*ruff, "format", "-q", "--check", *settings, "."], cwd=tmp_path, check=True)


@pytest.mark.parametrize(
    ("name", "why"),
    [("main", "what the testbed calls"), ("numpy", "hide"), ("my flock", "as Python has them"),
     ("class", "as Python has them"), ("../mine", "as Python has them"), ("random", "hide")],
)  # fmt: skip
def test_names_that_no_script_can_have(name, why, tmp_path):
    with pytest.raises(ParameterError, match=why):
        write_script(name, ExperimentKind.FLOCKING, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_new_script_never_overwrites(tmp_path):
    write_script("mine", ExperimentKind.COVERAGE, tmp_path)
    with pytest.raises(OutputError, match="is there already"):
        write_script("mine", ExperimentKind.FLOCKING, tmp_path)
    with pytest.raises(ParameterError, match="none of flocking, formation"):
        CliRunner().invoke(app, ["new", "x", "--kind", "milling"], catch_exceptions=False)


def test_a_new_scripts_metric_joins_a_report_and_its_readme_has_a_study(tmp_path):
    for experiment in ExperimentKind:
        script, metric, readme, *_ = write_script(
            f"my_{experiment.name.lower()}", experiment, tmp_path
        )
        poses = np.zeros((60, 3, experiment.kind.robots))
        poses[:, :2] = np.random.default_rng(0).uniform(-0.9, 0.9, (2, experiment.kind.robots))
        poses[30:, :, 0] = np.nan  # who is not seen
        run = SimpleNamespace(poses=poses)
        (asked,) = set(re.findall(rf"{metric.name}:(\w+)", readme.read_text(encoding="utf-8")))
        with own_metrics([f"{metric}:{asked}"]) as (entry,):
            assert entry.unit == experiment.kind.unit
        values = vars(imported(metric))[asked](run)
        assert np.isfinite(values[:30]).all()
        assert np.isnan(values[30:]).all()
        toml = re.search(r"```toml\n(.*?)```", readme.read_text(encoding="utf-8"), re.S)[1]
        (script.parent / "study.toml").write_text(toml)
        study = read_study(script.parent / "study.toml")
        assert experiment.kind.constant in study.grid
