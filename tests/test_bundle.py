"""Bundles are flat, complete, unchanged, the same twice, and run on every Python."""

import ast
import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from posflock_robotarium.flocking.errors import OutputError
from posflock_robotarium.submission.bundle import as_package, bundle
from posflock_robotarium.submission.instructions import INSTRUCTIONS
from posflock_robotarium.submission.interpreters import find_python
from posflock_robotarium.submission.manifest import (
    MANIFEST,
    BundleError,
    check_manifest,
    read_manifest,
)
from rps_compat import testbed
from rps_compat.scripts import import_graph

EXPERIMENT = Path(__file__).parents[1] / "experiments" / "robotarium_9bot.py"


@pytest.fixture
def script(tmp_path):
    """Return a script with a package, a subpackage, a plain module and a data file."""
    home = tmp_path / "home"
    (home / "team" / "sub").mkdir(parents=True)
    (home / "main_script.py").write_text(
        '"""Main."""\nimport helper\nimport team\nfrom team.sub import leaf\n'
        "import team.control as control\n"
        "print(helper.NAME, team.VERSION, leaf.gain(), control.gain(), leaf.gain is control.gain)\n"
        "with open('goals.m') as goals:\n"
        "    print(team.__name__, leaf.__name__, leaf.__package__, goals.read())\n"
    )
    (home / "helper.py").write_text("NAME = 'helper'\n")
    (home / "team" / "__init__.py").write_text(
        '"""A package."""\nfrom __future__ import annotations\n\nfrom .control import gain\n'
        "VERSION = gain() + 1\n"
    )
    (home / "team" / "control.py").write_text("def gain():\n    return 2\n")
    (home / "team" / "sub" / "__init__.py").write_text("")
    (home / "team" / "sub" / "leaf.py").write_text("from ..control import gain\n")
    (home / "goals.m").write_text("42")
    return home / "main_script.py"


EXPECTED = "helper 3 2 2 True\nteam team.sub.leaf team.sub 42\n"
NAMES = {"main_script.py", "helper.py", "team.py", "control.py", "sub.py", "leaf.py", "goals.m"}


def run(python, folder, main):
    return subprocess.run(
        [str(python), "-W", "error", "-B", main],
        cwd=folder,
        capture_output=True,
        text=True,
        env={"PATH": os.environ["PATH"]},
        check=False,
    )


def test_a_bundle_is_flat_and_complete(script, tmp_path):
    ready = bundle(script, tmp_path / "up", robots=3, run_seconds=100.0)
    there = {path.name for path in (tmp_path / "up").iterdir()}
    assert set(ready.files) == NAMES
    assert there == NAMES | {MANIFEST, INSTRUCTIONS}
    assert all(Path(name).suffix in testbed.ENDINGS for name in NAMES)
    home = script.parent
    for name, origin in {
        "main_script.py": "main_script.py", "helper.py": "helper.py", "goals.m": "goals.m",
        "control.py": "team/control.py", "leaf.py": "team/sub/leaf.py",
    }.items():  # fmt: skip
        assert (tmp_path / "up" / name).read_bytes() == (home / origin).read_bytes()
    text = (tmp_path / "up" / INSTRUCTIONS).read_text()
    assert "| Number of robots | 3 |" in text
    assert "180 s" in text
    assert read_manifest(tmp_path / "up").main == "main_script.py"


@pytest.mark.parametrize("version", [(3, minor) for minor in range(8, 14)])
def test_a_bundle_runs_on_every_python(script, tmp_path, version):
    python = find_python(version)
    if python is None:
        pytest.skip(f"no Python {version[0]}.{version[1]} here")
    bundle(script, tmp_path / "up")
    done = run(python, tmp_path / "up", "main_script.py")
    assert (done.stdout, done.stderr) == (EXPECTED, "")


def test_the_same_input_gives_the_same_bytes(script, tmp_path):
    for name in ("one", "two"):
        bundle(script, tmp_path / name)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()


def test_the_manifest_is_sha256sums_and_finds_changes(script, tmp_path):
    up = tmp_path / "up"
    bundle(script, up)
    head, *sums = (up / MANIFEST).read_text().splitlines()
    assert head.startswith("# ")  # a comment to sha256sum
    for line in sums:
        digest, name = line.split("  ")
        assert hashlib.sha256((up / name).read_bytes()).hexdigest() == digest
    assert set(check_manifest(up).files) == NAMES
    (up / "helper.py").write_text("NAME = 'other'\n")
    with pytest.raises(BundleError, match=r"helper\.py was changed"):
        check_manifest(up)
    (up / "helper.py").unlink()
    with pytest.raises(BundleError, match="missing"):
        check_manifest(up)


def test_the_manifest_reads_back_as_it_was_written(script, tmp_path):
    ready = bundle(script, tmp_path / "up", robots=3, run_seconds=100.0)
    assert read_manifest(tmp_path / "up") == ready.manifest
    assert (ready.manifest.robots, ready.manifest.duration) == (3, ready.duration)


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="there is no sha256sum here")
def test_sha256sum_reads_the_manifest(script, tmp_path):
    bundle(script, tmp_path / "up")
    subprocess.run(["sha256sum", "--strict", "-c", MANIFEST], cwd=tmp_path / "up", check=True)


@pytest.mark.parametrize("text", ["", "x", "# {}", '# {"schema": "posflock bundle 0"}', "# []"])
def test_a_manifest_of_another_format_is_refused(text, tmp_path):
    (tmp_path / MANIFEST).write_text(text + "\n")
    with pytest.raises(BundleError, match="make the bundle again"):
        read_manifest(tmp_path)


def test_an_earlier_bundle_is_replaced_and_nothing_else(script, tmp_path):
    up = tmp_path / "up"
    bundle(script, up)
    bundle(script, up)
    (up / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"notes\.txt"):
        bundle(script, up)
    assert (up / "notes.txt").read_text() == "mine"


def write(home, name, text):
    path = home / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("files", "reason"),
    [
        ({"a/__init__.py": "", "a/tools.py": "", "b/__init__.py": "", "b/tools.py": "",
          "main_script.py": "import a.tools, b.tools"}, "would both be tools.py"),
        ({"a/__init__.py": "", "a/random.py": "", "main_script.py": "import a.random"},
         "hide Python's own module 'random'; rename the module, for example to a_random.py"),
        ({"a/__init__.py": "", "a/cvxopt.py": "", "main_script.py": "import a.cvxopt"},
         "hide the testbed's library 'cvxopt'"),
        ({"main.py": "", "main_script.py": "import main"}, "which the testbed runs as main.py"),
        ({"main_script.py": "import pandas"}, "line 1: imports pandas, which the testbed has not"),
        ({"main_script.py": "import nothing_like_it"}, "neither beside the script"),
        ({"main_script.py": "import rps_compat"}, "stands in for rps"),
        ({"main_script.py": "open('goals.m')"}, "line 1: reads goals.m, which is not beside"),
        ({"main_script.py": "open('d/goals.m')", "d/goals.m": ""}, "uploads are flat"),
        ({"main_script.py": "open('goals.csv')", "goals.csv": ""}, "cannot be uploaded"),
    ],
)  # fmt: skip
def test_what_cannot_be_laid_flat_is_refused_with_the_way_out(tmp_path, files, reason):
    home = tmp_path / "home"
    for name, text in files.items():
        write(home, name, text)
    with pytest.raises(BundleError, match=reason):
        bundle(home / "main_script.py", tmp_path / "up")
    assert not (tmp_path / "up").exists()


ZOO = Path(__file__).parent / "zoo"


@pytest.mark.parametrize(
    ("script", "warning"),
    [
        (
            "faulty/generation_one_ending.py",
            r"line 10: call_at_scripts_end\(\) .* debug\(\)",
        ),
        ("faulty/generation_one_utility.py", "line 6: create_single_integrator_barrier"),
        ("sound/two_robots_forward.py", None),
        (EXPERIMENT, None),
    ],
)
def test_a_script_of_the_other_generation_is_warned_of(tmp_path, script, warning):
    ready = bundle(ZOO / script, tmp_path / "up")
    assert [bool(re.search(warning, text)) for text in ready.warnings] == [True] * bool(warning)
    assert all(text in (tmp_path / "up" / INSTRUCTIONS).read_text() for text in ready.warnings)


@pytest.mark.parametrize("text", ["", '"""Nothing yet."""\n', "import numpy\nprint(numpy.pi)\n"])
def test_a_script_that_drives_no_robot_is_warned_of(tmp_path, text):
    ready = bundle(write(tmp_path / "home", "main_script.py", text), tmp_path / "up")
    assert len(ready.warnings) == 1
    assert "no robot" in ready.warnings[0]


def test_folders_without_init_are_packages_too(tmp_path):
    home = tmp_path / "home"
    write(home, "loose/inner.py", "x = 7\n")
    main = write(home, "main_script.py", "from loose import inner\nprint(inner.x)\n")
    bundle(main, tmp_path / "up")
    assert run(sys.executable, tmp_path / "up", "main_script.py").stdout == "7\n"


def test_uploads_may_be_limited_in_size(script, tmp_path):
    with pytest.raises(BundleError, match="100 are allowed"):
        bundle(script, tmp_path / "up", largest=100)


@pytest.mark.parametrize(
    "source", [b"", b'"""D."""', b"from __future__ import annotations", b"x=1"]
)
def test_added_lines_come_where_python_wants_them(source):
    tree = ast.parse(as_package(source))
    compile(tree, "package", "exec")
    assert as_package(source).count(b"__path__ =") == 1


def test_the_experiment_goes_with_what_it_needs_and_no_more(tmp_path):
    ready = bundle(EXPERIMENT, tmp_path / "up")
    assert (tmp_path / "up" / EXPERIMENT.name).read_bytes() == EXPERIMENT.read_bytes()
    assert {"flock.py", "law.py", "pose_log.py", "unicycle.py", "solve_nnls.py"} <= set(ready.files)
    assert {"posflock_robotarium.py", "barrier_certificates.py"} <= set(ready.files)
    assert not {"cli.py", "runner.py", "arena.py"} & set(ready.files)
    assert {name for name in ready.files if name.startswith("solve_")} == {
        "solve_nnls.py", "solve_cvxopt.py"
    }  # fmt: skip
    assert read_manifest(tmp_path / "up").main == EXPERIMENT.name


def test_certificates_lie_flat_with_the_packages_inside_and_work(tmp_path):
    """Everything of ours that a script imports is found in the folder, under its dotted name."""
    home = tmp_path / "home"
    main = write(
        home,
        "main_script.py",
        "import sys\nfrom pathlib import Path\nimport numpy as np\n"
        "from barrier_certificates.projection import Projector\n"
        "from barrier_certificates.rows import Disc\n"
        "from barrier_certificates.unicycle import UnicycleCertificate\n"
        "certificate = UnicycleCertificate(0.3, obstacles=[Disc((0.1, 0.0), 0.1)])\n"
        "poses = np.array([[-0.2, 0.2], [0.0, 0.0], [0.0, np.pi]])\n"
        "_, info = certificate([[0.2, 0.2], [0.0, 0.0]], poses)\n"
        "ours = [m for name, m in sys.modules.items() if name.startswith('barrier_cert')]\n"
        "print(info.status, len(ours), {Path(m.__file__).parent.name for m in ours})\n",
    )
    up = tmp_path / "up"
    ready = bundle(main, up)
    assert {"rows.py", "projection.py", "solvers.py", "row_set.py", "projector.py"} < set(
        ready.files
    )
    done = run(sys.executable, up, "main_script.py")
    assert done.stderr == ""
    status, loaded, folders = done.stdout.split()
    assert (status, folders) == ("relaxed", "{'up'}")
    assert int(loaded) == sum(name != "main_script.py" for name in ready.files) - 1


def test_the_experiments_bundle_is_the_same_where_no_solver_is_installed(tmp_path, monkeypatch):
    here = bundle(EXPERIMENT, tmp_path / "here")
    found = import_graph._spec
    solvers = {"piqp", "daqp", "osqp", "clarabel", "cvxpy", "cvxopt"}
    monkeypatch.setattr(import_graph, "_spec", lambda top: None if top in solvers else found(top))
    bare = bundle(EXPERIMENT, tmp_path / "bare")
    assert (bare.files, bare.left_out) == (here.files, here.left_out)


@pytest.mark.parametrize(
    "needs", ["import not_a_module", 'from importlib import import_module\nimport_module("pandas")']
)
def test_what_a_package_offers_and_cannot_be_used_there_is_left_out(tmp_path, needs):
    home = tmp_path / "home"
    write(home, "team/__init__.py", "def choose():\n    from team import fancy\n")
    write(home, "team/fancy.py", needs)
    ready = bundle(write(home, "main_script.py", "import team"), tmp_path / "up")
    assert set(ready.files) == {"main_script.py", "team.py"}
    assert ready.left_out == {"team.fancy": "pandas" if "pandas" in needs else "not_a_module"}


def test_a_module_named_in_a_call_is_taken_along(tmp_path):
    home = tmp_path / "home"
    write(home, "helper.py", "x = 1\n")
    text = 'import importlib\nhelper = importlib.import_module("helper")\n'
    assert "helper.py" in bundle(write(home, "main_script.py", text), tmp_path / "up").files


def test_takes_a_package_along_that_hides_a_module_of_python(tmp_path):
    (tmp_path / "platform").mkdir()
    (tmp_path / "platform/__init__.py").write_text("")
    (tmp_path / "platform/helper.py").write_text("gain = 1\n")
    (tmp_path / "experiment.py").write_text("import rps\nfrom platform.helper import gain\n")
    with pytest.raises(BundleError, match=r"hide Python's own module 'platform'"):
        bundle(tmp_path / "experiment.py", tmp_path / "upload")


def test_leaves_a_copy_of_the_simulator_beside_the_script_at_home(tmp_path):
    (tmp_path / "rps").mkdir()
    (tmp_path / "rps/__init__.py").write_text("")
    (tmp_path / "rps/robotarium.py").write_text("class Robotarium: pass\n")
    (tmp_path / "experiment.py").write_text("from rps.robotarium import Robotarium\n")
    assert list(bundle(tmp_path / "experiment.py", tmp_path / "up").files) == ["experiment.py"]


def test_follows_folders_without_any_module_of_their_own(tmp_path):
    (tmp_path / "lab/control").mkdir(parents=True)
    (tmp_path / "lab/control/gains.py").write_text("gain = 1\n")
    (tmp_path / "experiment.py").write_text("import rps\nfrom lab.control import gains\n")
    ready = bundle(tmp_path / "experiment.py", tmp_path / "upload")
    assert sorted(ready.files) == ["control.py", "experiment.py", "gains.py", "lab.py"]


@pytest.mark.parametrize(
    "call", ["'.late', 'team'", "'.late', package='team'", "'.late', __package__"]
)
def test_follows_relative_names_given_to_import_module(tmp_path, call):
    (tmp_path / "team").mkdir()
    text = f"from importlib import import_module\nlate = import_module({call})\n"
    (tmp_path / "team/__init__.py").write_text(text)
    (tmp_path / "team/late.py").write_text("")
    (tmp_path / "experiment.py").write_text("import rps\nimport team\n")
    ready = bundle(tmp_path / "experiment.py", tmp_path / "upload")
    assert sorted(ready.files) == ["experiment.py", "late.py", "team.py"]


def test_takes_a_data_file_along_that_is_named_beside_the_script(tmp_path):
    (tmp_path / "goals.npy").write_bytes(b"goals")
    (tmp_path / "experiment.py").write_text(
        "import rps\nimport numpy as np\nfrom pathlib import Path\n"
        "goals = np.load(Path(__file__).resolve().with_name('goals.npy'))\n"
    )
    ready = bundle(tmp_path / "experiment.py", tmp_path / "upload")
    assert sorted(ready.files) == ["experiment.py", "goals.npy"]


def test_refuses_a_main_file_that_is_not_python_by_its_ending(tmp_path):
    (tmp_path / "experiment.txt").write_text("import rps\n")
    with pytest.raises(BundleError, match=r"must end in \.py"):
        bundle(tmp_path / "experiment.txt", tmp_path / "upload")
