"""A study of a script: its constants are varied, and nothing else of it is touched."""

import ast
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.sweep.execution import compute
from posflock_robotarium.sweep.parameter_distribution import StudyError
from posflock_robotarium.sweep.results import succeeded
from posflock_robotarium.sweep.script_constants import constants_in, with_constants
from posflock_robotarium.sweep.store import ERROR
from posflock_robotarium.sweep.study import parse_study
from posflock_robotarium.sweep.study_figures import outcome_over
from rps_compat.scripts.source import parse_script

SCRIPT = '''"""Drives straight on; the names in functions are its own."""
import numpy as np
from start_poses import START
from rps.robotarium import Robotarium

SPEED = 0.05  # m/s
STEPS = 3 * \\
    30
SEED: int = 4
LABEL = "straight on"
places = np.zeros(3)
twice = 1
twice = 2
for i in range(2):
    loose = 3


def drive(SPEED, LABEL=LABEL):
    r = Robotarium(number_of_robots=1, initial_conditions=START)
    for _ in range(STEPS):
        r.get_poses()
        r.set_velocities([0], np.array([[SPEED], [0.0]]))
        r.step()
    with open("left.txt", "w") as left:
        left.write(LABEL)
    print("done")


drive(SPEED)
if LABEL == "fails":
    raise ValueError("as told")
'''


@pytest.fixture
def script(tmp_path):
    path = tmp_path / "straight.py"
    path.write_text(SCRIPT)
    (tmp_path / "start_poses.py").write_text("import numpy as np\nSTART = np.zeros((3, 1))\n")
    return path


def test_constants_are_what_the_outermost_level_binds_once():
    found = constants_in(parse_script(SCRIPT.encode()))
    assert found == {"SPEED": 0.05, "STEPS": 90, "SEED": 4, "LABEL": "straight on"}


@settings(max_examples=25)
@given(
    speed=st.floats(-1e6, 1e6), steps=st.integers(-(10**9), 10**9), label=st.text(max_size=9),
    newline=st.sampled_from(["\n", "\r\n"]),
)  # fmt: skip
def test_other_values_stand_in_the_places_of_the_old_and_no_line_moves(
    speed, steps, label, newline
):
    script = parse_script(SCRIPT.replace("\n", newline).encode())
    asked = {"SPEED": speed, "STEPS": steps, "LABEL": label}
    changed = parse_script(with_constants(script, asked))
    assert constants_in(changed) == constants_in(script) | asked
    lines = [[node.lineno for node in ast.parse(s.text).body] for s in (script, changed)]
    assert lines[0] == lines[1]
    assert with_constants(script, {"SPEED": 0.05}) == script.data


def test_a_constant_that_is_not_there_is_refused_by_name(script):
    with pytest.raises(ParameterError, match=r"SPEDE.*SPEED, STEPS"):
        with_constants(parse_script(SCRIPT.encode()), {"SPEDE": 1.0})
    study = {"script": "straight.py", "grid": {"places": [1.0]}}
    with pytest.raises(ParameterError, match="SPEED"):
        parse_study(study, script.parent)
    with pytest.raises(StudyError, match="not both"):
        parse_study(study | {"experiment": "robots"}, script.parent)
    with pytest.raises(ParameterError, match="script ="):
        parse_study({"experiment": "script"})


def test_a_study_runs_copies_and_tells_of_each(script):
    (script.parent / "mine.py").write_text(
        "def way(run):\n    return run.positions[:, 0, 0] - run.positions[0, 0, 0]\n"
    )
    said = {
        "script": "straight.py",
        "replications": 1,
        "parameters": {"metric": "mine.py:way"},
        "grid": {"SPEED": [0.05, 0.1], "LABEL": ["straight on", "fails"]},
    }
    study = parse_study(said, script.parent)
    before = {path: path.read_bytes() for path in script.parent.iterdir() if path.is_file()}
    runs = study.runs()
    rows = [compute("script", [run], study.module)[0] for run in runs]
    assert {p: p.read_bytes() for p in script.parent.iterdir() if p.is_file()} == before
    driven = [row["way_largest"] for row in rows if row["LABEL"] == "straight on"]
    np.testing.assert_allclose(driven, 0.033 * 89 * np.array([0.05, 0.1]), atol=1e-9)
    assert [row[ERROR] for row in rows if row["LABEL"] == "fails"] == [
        "ScriptRunError: failed: ValueError: as told"
    ] * 2
    pictured = parse_study(
        said | {"figures": [{"x": "SPEED", "y": y} for y in ("speed", "way")]}, script.parent
    )
    labels = [
        (axes.get_xlabel(), axes.get_ylabel())
        for asked in pictured.figures
        for axes in outcome_over(pictured, succeeded(rows), asked).axes
    ]
    assert labels == [("SPEED", "speed (m/s)"), ("SPEED", "way")]  # units that nobody told
    # What a run hangs on is in its key: the file of the metric, too.
    (script.parent / "mine.py").write_text("def way(run):\n    return run.positions[:, 0, 0]\n")
    again = {run.key for run in parse_study(said, script.parent).runs()}
    assert again.isdisjoint(run.key for run in runs)


def test_the_command_says_which_names_there_are(script):
    (script.parent / "study.toml").write_text('script = "straight.py"\n[grid]\nspeed = [1.0]\n')
    told = CliRunner().invoke(app, ["sweep", str(script.parent / "study.toml"), "--json"])
    assert told.exit_code != 0
    assert not told.stdout or json.loads(told.stdout)
