"""Whose code computed a run: an edited source never passes for the old one; laws of one's own."""

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import displacements, position_based_input
from posflock_robotarium.freespace.sensing import Sensing
from posflock_robotarium.freespace.simulation import FreeSpace, simulate
from posflock_robotarium.sweep import sources
from posflock_robotarium.sweep.execution import WorkerError, execute, locally
from posflock_robotarium.sweep.experiments import Experiment, find, register
from posflock_robotarium.sweep.parameter_distribution import StudyError
from posflock_robotarium.sweep.points import register_law
from posflock_robotarium.sweep.store import Store
from posflock_robotarium.sweep.study import parse_study, read_study

ROOT = Path(__file__).resolve().parents[1]
STUDY = """
experiment = "{experiment}"
{module}
replications = 2
[parameters]
agents = 6
side = 6.0
duration = 1.0
[grid]
persistence = [0.1, 0.2]
"""
LAW = """
from helper import STRENGTH
from posflock_robotarium.flocking.law import velocity_based_input
from posflock_robotarium.sweep.points import register_law

def brake(sensed, law, braking):
    asked = velocity_based_input(sensed.positions, sensed.velocities, law, detected=sensed.detected)
    return STRENGTH * asked - braking * sensed.velocities

register_law("braking", "The baseline, with brakes.", brake, {"braking": 0.5})
"""


@pytest.fixture
def own(tmp_path):
    """Return a study file beside a law of one's own, which imports a file beside it."""
    (tmp_path / "my_law.py").write_text(LAW)
    (tmp_path / "helper.py").write_text("STRENGTH = 1.0\n")
    study = tmp_path / "study.toml"
    study.write_text(STUDY.format(experiment="braking", module='module = "my_law.py"'))
    return study


SWEEP = """
import json, sys
from pathlib import Path
from posflock_robotarium.sweep.execution import execute, locally
from posflock_robotarium.sweep.results import finished, of_other_code
from posflock_robotarium.sweep.store import Store
from posflock_robotarium.sweep.study import read_study
if __name__ == "__main__":
    study = read_study(Path(sys.argv[1]))
    with Store(Path("store")) as store:
        stale = of_other_code(study, store)
        computed = execute(study, store, locally(int(sys.argv[2])))
        gammas = [row["gamma_end"] for row in finished(study, store)]
    print(json.dumps({"computed": computed, "stale": stale, "gammas": gammas}))
"""


def sweep(study, *, packages=ROOT, workers=1):
    """Sweep in a process of its own, as a user does who has just edited a source."""
    script = study.parent / "sweep_it.py"
    script.write_text(SWEEP)
    done = subprocess.run(
        [sys.executable, str(script), str(study), str(workers)],
        cwd=study.parent,
        env={**os.environ, "PYTHONPATH": str(packages)},
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return json.loads(done.stdout)


def test_an_edited_law_is_computed_again_and_the_old_results_stay(tmp_path):
    packages = tmp_path / "packages"
    for name in ("posflock_robotarium", "rps_compat", "barrier_certificates"):
        shutil.copytree(ROOT / name, packages / name)
    study = tmp_path / "study.toml"
    study.write_text(STUDY.format(experiment="freespace", module=""))
    first = sweep(study, packages=packages)
    assert (first["computed"], first["stale"]) == (4, 0)

    law = packages / "posflock_robotarium" / "flocking" / "law.py"
    original = law.read_text()
    edited = original.replace("dtype=float) * rate", "dtype=float) * rate * 0.5")
    assert edited != original
    law.write_text(edited)
    second = sweep(study, packages=packages)
    assert (second["computed"], second["stale"]) == (4, 4)
    assert not set(second["gammas"]) & set(first["gammas"])

    law.write_text(original)
    third = sweep(study, packages=packages)
    assert (third["computed"], third["stale"]) == (0, 4)
    assert third["gammas"] == first["gammas"]


def test_the_sources_of_an_experiment_are_all_that_decides_it():
    found = {
        name: set(sources.sources(Path(sys.modules[find(name).run.__module__].__file__)))
        for name in ("freespace", "robots")
    }
    ours = "posflock_robotarium"
    agents = {f"{ours}.freespace.{name}" for name in ("simulation", "sensing", "neighbour_search")}
    agents |= {f"{ours}.alignment.{name}" for name in ("metrics.directions", "point_agents")}
    assert agents | {f"{ours}.flocking.law"} <= found["freespace"]
    robots = {f"{ours}.flocking.{name}" for name in ("law", "flock", "placement")}
    robots |= {f"{ours}.alignment.summary", f"{ours}.simulation.flock_trial"}
    robots |= {f"{ours}.alignment.catalogue.{name}" for name in ("gamma", "distances", "walls")}
    robots |= {f"rps_compat.{name}" for name in ("arena", "realism", "profiles", "distributions")}
    robots |= {f"barrier_certificates.{name}" for name in ("unicycle", "rows", "rows.pairs")}
    assert robots <= found["robots"]
    # What only keeps books or draws may change without costing anyone a night of computing.
    for name in ("sweep.store", "sweep.results", "figures.style", "cli"):
        assert f"{ours}.{name}" not in found["freespace"] | found["robots"]
    assert not any(name.startswith("rps_compat") for name in found["freespace"])


def test_streams_do_not_depend_on_the_code(monkeypatch):
    study = parse_study({"experiment": "freespace", "replications": 2})
    before = study.runs()
    monkeypatch.setattr("posflock_robotarium.sweep.study.code_of", lambda *_: "other")
    for old, new in zip(before, study.runs(), strict=True):
        assert old.key != new.key
        np.testing.assert_array_equal(old.stream.generate_state(4), new.stream.generate_state(4))


def test_a_worker_with_other_code_is_refused(tmp_path, monkeypatch):
    study = parse_study({"experiment": "freespace", "parameters": {"duration": 1.0}})
    monkeypatch.setattr("posflock_robotarium.sweep.execution.code_of", lambda *_: "other")
    with Store(tmp_path) as store, pytest.raises(WorkerError, match="source was changed"):
        execute(study, store, locally(1))
    with Store(tmp_path) as store:
        assert not store.rows


def test_a_profile_that_is_edited_is_another_profile(tmp_path):
    profile = tmp_path / "lab.toml"
    said = {"experiment": "robots", "replications": 1, "parameters": {"profile": str(profile)}}
    profile.write_text('name = "lab"\n[dead_time]\nseconds = 0.1\n')
    (before,) = parse_study(said).runs()
    profile.write_text('name = "lab"\n[dead_time]\nseconds = 0.2\n')
    (after,) = parse_study(said).runs()
    assert before.key != after.key


def test_a_function_without_a_file_is_known_by_its_instructions(tmp_path):
    """As typed in a shell: there is no file whose digest could be taken."""
    codes = []
    for number, factor in enumerate((2.0, 3.0)):
        typed = {"__name__": "__shell__"}
        exec(f"def run(parameters, seeds): return [{{'x': {factor}}} for _ in seeds]", typed)
        experiment = Experiment(f"typed-{number}-for-test", "", {}, typed["run"], ("x",))
        codes.append(sources.code_of(experiment))
    assert codes[0] != codes[1]


def test_an_edit_beside_a_law_of_ones_own_counts_however_quick(own, monkeypatch):
    monkeypatch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
    first = sweep(own)
    assert first["computed"] == 4
    helper = own.parent / "helper.py"
    before = helper.stat()
    helper.write_text("STRENGTH = 0.5\n")
    os.utime(helper, ns=(before.st_atime_ns, before.st_mtime_ns))  # as in the same second
    second = sweep(own)
    assert (second["computed"], second["stale"]) == (4, 4)
    assert second["gammas"] != first["gammas"]


def test_the_law_of_the_documentation_is_swept_by_workers_as_it_is_printed(tmp_path):
    page = (ROOT / "docs/how-to/sweeps.md").read_text(encoding="utf-8")
    law = re.search(r"^```python\n# near_law.py\n(.*?)^```", page, re.M | re.S)[1]
    study = re.search(r"^```toml\n# near.toml\n(.*?)^```", page, re.M | re.S)[1]
    (tmp_path / "near_law.py").write_text(law)
    (tmp_path / "near.toml").write_text(
        study.replace("10000", "2") + "[parameters]\nagents = 10\nside = 10.0\nduration = 2.0\n"
    )
    found = sweep(tmp_path / "near.toml", workers=2)
    assert found["computed"] == 6
    assert len(set(found["gammas"])) == 6


def test_modules_that_cannot_be_imported_are_named(own):
    (own.parent / "my_law.py").write_text("import nowhere_to_be_found\n")
    with pytest.raises(StudyError, match=r"my_law\.py fails: ModuleNotFoundError"):
        read_study(own)
    (own.parent / "my_law.py").unlink()
    with pytest.raises(StudyError, match=r"expected a Python file, got .*my_law\.py"):
        read_study(own)
    own.write_text('experiment = "x"\nmodule = 3\n')
    with pytest.raises(StudyError, match="module: expected str"):
        read_study(own)


def test_a_law_of_ones_own_is_told_what_the_models_are():
    def imprinted(sensed, law):
        return position_based_input(
            sensed.positions,
            displacements(sensed.first_positions),
            sensed.time,
            law,
            detected=sensed.detected,
        )

    sensing = Sensing(position_noise=0.01, dropout=0.1, delay=0.1)
    scenario = FreeSpace(agents=9, side=8.0, duration=3.0, sensing=sensing)
    own = replace(scenario, own_law=imprinted)
    expected = simulate(scenario, 2)
    np.testing.assert_array_equal(simulate(own, 2).positions, expected.positions)
    assert own.as_dict()["own_law"] == "imprinted"
    json.dumps(own.as_dict())


def test_neighbours_that_are_missed_are_no_neighbours():
    seen = []

    def look(sensed, law):
        seen.append(sensed.neighbours(law.radius))
        return np.zeros_like(sensed.positions)

    scenario = FreeSpace(agents=9, side=4.0, duration=0.1, record_interval=0.1, own_law=look)
    simulate(scenario, 1)
    assert seen[-1].sum() == 9 * 8
    simulate(replace(scenario, sensing=Sensing(dropout=1.0)), 1)
    assert seen[-1].sum() == 0


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda sensed, law: np.zeros(3), "shape"),
        (lambda sensed, law: sensed.positions[..., :1] * np.nan, "shape"),
        (lambda sensed, law: sensed.positions * np.nan, "finite"),
        (lambda sensed, law: None, "own law"),
    ],
)
def test_an_input_that_means_nothing_is_refused(wrong, said):
    with pytest.raises(ParameterError, match=said):
        simulate(FreeSpace(agents=4, duration=0.5, own_law=wrong), 1)


def test_a_law_cannot_take_a_parameter_that_is_there():
    with pytest.raises(ParameterError, match="radius"):
        register_law("taken-for-test", "", lambda sensed, law: None, {"radius": 1.0})
    with pytest.raises(ParameterError, match="already"):
        register(Experiment("robots", "", {}, lambda parameters, seeds: [], ()))


def test_the_command_says_what_it_left_out(own, monkeypatch):
    out = own.parent / "out"
    own.write_text(own.read_text() + '[[figures]]\nx = "persistence"\ny = "gamma_end"\n')
    command = ["sweep", str(own), "-o", str(out), "--jobs", "1"]
    first = CliRunner().invoke(app, command, catch_exceptions=False)
    assert "4 runs computed, 0 found" in first.stdout
    (segment,) = (out / "store").glob("rows-*.jsonl")
    segment.write_bytes(segment.read_bytes()[:-2])
    again = CliRunner().invoke(app, command, catch_exceptions=False)
    assert "1 run computed, 3 found" in again.stdout
    assert "1 torn line in" in again.stdout
    for user in ("study", "execution"):
        monkeypatch.setattr(f"posflock_robotarium.sweep.{user}.code_of", lambda *_: "other")
    # In this process, the one whose code is another.
    monkeypatch.setattr(
        "posflock_robotarium.sweep.execution.in_processes", lambda workers: locally(1)
    )
    edited = CliRunner().invoke(app, command, catch_exceptions=False)
    assert "4 runs computed, 0 found" in edited.stdout
    assert "4 runs in" in edited.output
    assert "before a source was changed" in edited.output
