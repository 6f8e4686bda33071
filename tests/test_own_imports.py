"""Files beside the script hide nothing from libraries or from us, and are what the script gets."""

import builtins
import contextlib
import importlib
import io
import os
import queue
import random
import subprocess
import sys
import zipfile
from _imp import is_frozen
from pathlib import Path
from types import ModuleType

import pytest

import rps_compat
from rps_compat.own_imports import hidden_names, whose
from rps_compat.own_imports.last_resort import LastResort
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script

WAYS = ("run", "path")
PATH_IS_SLOW = ("run", pytest.param("path", marks=pytest.mark.slow))
#: Two robots that drive, are kept apart and drawn, with all that is imported for that.
ROBOTS = """
from rps.robotarium import Robotarium
from rps.utilities.barrier_certificates import *
from rps.utilities.misc import *

def drive(steps=5):
    numpy_of_ours = np
    start = numpy_of_ours.array([[-0.5, 0.5], [0, 0], [0, 3.0]])
    r = Robotarium(number_of_robots=2, show_figure=True, sim_in_real_time=False,
                   initial_conditions=start)
    keep = create_single_integrator_barrier_certificate_with_boundary()
    for k in range(steps):
        x = r.get_poses()
        keep(numpy_of_ours.ones((2, 2)), x[:2])
        r.set_velocities([0, 1], numpy_of_ours.full((2, 2), 0.1))
        r.step()
    r.call_at_scripts_end()
    return r
"""
#: The same, undrawn: half as long, where it is not matplotlib that imports what is hidden.
UNDRAWN = ROBOTS.replace("show_figure=True", "show_figure=False")


@pytest.fixture
def home(tmp_path):
    """Return the folder of a script."""
    folder = tmp_path / "home"
    folder.mkdir()
    return folder


def write(folder, **modules):
    """Write modules into a folder."""
    for name, text in modules.items():
        (folder / f"{name}.py").write_text(text)


def run(way, folder, script="script.py"):
    """Run a script of generation 1, and return what it said and what it was told.

    By `posflock run` ("command"), by that in this process ("run"), or by plain Python with our
    folder on PYTHONPATH ("path").
    """
    if way == "run":
        told, said = [], io.StringIO()
        settings = RunSettings(headless=True, generation=1, tell=told.append)
        with contextlib.redirect_stdout(said):
            result = run_script(folder / script, (), settings)
        assert told == list(result.notes)[: len(told)]
        return result.exit_code, said.getvalue(), "\n".join([*result.notes, result.reason])
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    command = [sys.executable, script]
    if way == "command":
        command = [
            Path(sys.executable).with_name("posflock"),
            "run",
            "--headless",
            "--generation",
            "1",
        ]
        command += ["-o", folder.parent / "out", folder / script]
    else:
        environment["PYTHONPATH"] = str(rps_compat.import_path(1))
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout, done.stderr


def said(way, folder, **options):
    """What a script says that runs to its end."""
    code, text, told = run(way, folder, **options)
    assert code == 0, told
    return text.splitlines()


def names_that_files_can_hide():
    """Every module of Python, of what is installed, and of ours, that a file can stand before."""
    names = {*sys.stdlib_module_names, *whose.OURS, *whose.OPTIONAL, "report", "clock", "utils"}
    for entry in map(Path, sys.path):
        if entry.name == "site-packages":
            names |= {path.name.partition(".")[0] for path in entry.iterdir()}
    first = hidden_names._FIRST | {"distutils", "rps"}  # setuptools' stands before any file
    return sorted(name for name in names - first if name.isidentifier() and not is_frozen(name))


@pytest.mark.parametrize("way", [pytest.param("command", marks=pytest.mark.slow), "path"])
def test_files_named_after_everything_that_anybody_imports(home, way):
    names = names_that_files_can_hide()
    assert {"random", "types", "numpy", "scipy", "matplotlib", "barrier_certificates"} <= {*names}
    assert len(names) > 200
    checks = "\n".join(f"import {name}\nassert {name}.WHOSE == 'script', {name}" for name in names)
    write(home, **dict.fromkeys(names, "WHOSE = 'script'\n"))
    pictures = "for name in ('png', 'svg', 'pdf'):\n    r.figure.savefig(f'arena.{name}')\n"
    text = f"{ROBOTS}r = drive()\n{pictures}{checks}\ndrive()\nprint('all are the script\\'s')\n"
    write(home, script=text)
    lines = said(way, home)
    assert "all are the script's" in lines
    assert sum("real seconds" in line or "This run takes" in line for line in lines) == 2


@pytest.mark.parametrize("way", WAYS)
def test_a_module_imported_before_ours_stays_the_scripts(home, way):
    write(home, barrier_certificates="import helper\nSTATE = []\n", helper="import queue\n")
    write(home, queue="import barrier_certificates\nSTATE = []\n")
    text = (
        "import barrier_certificates\nbarrier_certificates.STATE.append(1)\n"
        "import helper\nhelper.queue.STATE.append(2)\n"
    )
    later = (
        "drive()\nimport barrier_certificates as again, queue\nprint(again.STATE, queue.STATE)\n"
    )
    write(home, script=text + ROBOTS + later)
    assert "[1] [2]" in said(way, home)


@pytest.mark.parametrize("way", PATH_IS_SLOW)
def test_a_package_of_the_scripts_with_submodules_called_like_ours(home, way):
    package = home / "barrier_certificates"
    package.mkdir()
    for name, text in {
        "__init__": "from . import rows\nfrom .unicycle import *\nNAME = __name__",
        "rows": "ROWS = 'own rows'\nclass Row: pass",
        "unicycle": "__all__ = ['own']\ndef own(): return __name__",
        "late": "from . import rows\nfrom .sub import leaf\nimport barrier_certificates as top",
        "sub/__init__": "",
        "sub/leaf": "from ..rows import ROWS\nfrom .. import NAME",
    }.items():
        (package / f"{name}.py").parent.mkdir(exist_ok=True)
        (package / f"{name}.py").write_text(text)
    text = """
import barrier_certificates as b, importlib
from barrier_certificates import late, own
import barrier_certificates.rows as rows
print(rows.ROWS, own(), b.NAME, late.rows is rows, late.leaf.ROWS, late.top is b)
print(importlib.import_module(".late", "barrier_certificates") is late)
try:
    import barrier_certificates.walls
except ModuleNotFoundError as error:
    print(error)
try:
    from barrier_certificates import nothing
except ImportError as error:
    print(error.name)
"""
    write(home, script=f"{UNDRAWN}drive()\nprint('then')\n{text}drive()")
    lines = said(way, home)
    assert lines[lines.index("then") + 1 :][:4] == [
        "own rows barrier_certificates.unicycle barrier_certificates True own rows True",
        "True",
        "No module named 'barrier_certificates.walls'",
        "barrier_certificates",
    ]


@pytest.mark.parametrize("way", PATH_IS_SLOW)
def test_classes_of_hiding_modules_can_be_pickled(home, way):
    write(home, queue="class Job:\n    pass\ndef work(job):\n    return type(job).__name__\n")
    write(home, barrier_certificates="class Job:\n    pass\n", test="class Job:\n    pass\n")
    text = """
import pickle, queue, barrier_certificates, test
from multiprocessing import get_context
for module in (queue, barrier_certificates, test):
    job = pickle.loads(pickle.dumps(module.Job()))
    assert type(job) is module.Job and job.__module__ == module.__name__
import logging.handlers  # has Python's own queues
if __name__ == "__main__":
    drive()
    with get_context("fork").Pool(1) as pool:
        print(pool.map(queue.work, [queue.Job(), barrier_certificates.Job(), test.Job()]))
"""
    write(home, script=UNDRAWN + text)
    assert "['Job', 'Job', 'Job']" in said(way, home)


@pytest.mark.parametrize("way", PATH_IS_SLOW)
def test_folders_that_the_script_puts_on_the_path(home, way):
    for folder in ("lib", "more"):
        (home / folder).mkdir()
    write(home / "lib", barrier_certificates="WHOSE = 'lib'", uses="import random")
    write(home / "lib", random="WHOSE = 'lib'")
    write(home / "more", posflock_robotarium="WHOSE = 'more'")
    with zipfile.ZipFile(home / "zipped.zip", "w") as zipped:
        zipped.writestr("rps_compat.py", "WHOSE = 'zipped'")
    text = """
import sys
for k, folder in enumerate(["lib", "more"]):
    sys.path.insert(k, folder)
sys.path = ["zipped.zip"] + sys.path
sys.path += []
import barrier_certificates, posflock_robotarium, rps_compat, uses
print(barrier_certificates.WHOSE, posflock_robotarium.WHOSE, rps_compat.WHOSE, uses.random.WHOSE)
"""
    write(home, script=f"{ROBOTS}drive()\n{text}drive()")
    assert "lib more zipped lib" in said(way, home)


@pytest.mark.parametrize("way", WAYS)
def test_a_script_that_empties_the_path_leaves_us_ours(home, way):
    write(home, random="WHOSE = 'script'")
    text = "import sys\nimport random\nsys.path[:] = [sys.path[0]]\ndrive()\n"
    write(home, script=f"{ROBOTS}{text}print(random.WHOSE)\nimport not_installed\n")
    _, text, told = run(way, home)
    assert "script" in text.splitlines(), told
    assert "No module named 'not_installed'" in told


@pytest.mark.parametrize("way", PATH_IS_SLOW)
def test_threads_import_at_the_same_time(home, way):
    write(home, queue="import time\ntime.sleep(0.05)\nimport helper\nDONE = True")
    write(home, helper="import queue")
    text = """
import threading
found = []
def look():
    import queue
    found.append(queue.DONE)
threads = [threading.Thread(target=look) for _ in range(8)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
print(found.count(True))
"""
    write(home, script=f"{UNDRAWN}import concurrent.futures\n{text}drive()")
    assert "8" in said(way, home)


@pytest.mark.parametrize("way", PATH_IS_SLOW)
def test_a_script_is_called_like_a_module_of_ours(home, way):
    write(home, barrier_certificates=f"{UNDRAWN}if __name__ == '__main__':\n    drive()\n")
    assert said(way, home, script="barrier_certificates.py")


@pytest.mark.parametrize("way", WAYS)
def test_what_is_hidden_is_noted_where_somebody_needs_it(home, way):
    write(home, random="", turtle="", utils="", barrier_certificates="", wave="")
    write(home, script=ROBOTS + "drive()\nimport utils, turtle")
    _, _, told = run(way, home)
    assert "random.py beside the script hides Python's own module 'random'" in told
    assert "utils.py" not in told
    assert "barrier_certificates.py" not in told
    if way == "run":  # it is told once more at the end
        assert "turtle.py beside the script hides Python's own module 'turtle'" in told
    assert "wave.py" not in told, "nobody has asked for it"


def test_nothing_is_changed_where_nothing_is_hidden(home, monkeypatch):
    project = Path(__file__).parents[1]  # on the path of tests alone; its setup.py hides a name
    path = [entry for entry in sys.path if Path(entry).resolve() != project]
    monkeypatch.setattr(sys, "path", path)
    write(home, helper="")
    text = (
        "import builtins, importlib, helper\n"
        "print(builtins.__import__.__module__, importlib.import_module.__module__)\n"
    )
    write(home, script=UNDRAWN + text)
    for way in WAYS:
        assert "builtins importlib" in said(way, home)


def test_imports_are_left_as_they_were(tmp_path):
    write(tmp_path, queue="class Job: pass", random="WHOSE = 'script'", test="import queue")
    script = "import queue, random, test, pickle\npickle.dumps(queue.Job())\nqueue.Job.a = 1\n"
    write(tmp_path, script=script)
    python, call, path = builtins.__import__, importlib.import_module, sys.path
    finders = [f for f in sys.meta_path if not isinstance(f, LastResort)]
    for _ in range(2):
        said("run", tmp_path)
    assert python is builtins.__import__
    assert call is importlib.import_module
    assert path is sys.path
    assert [f for f in sys.meta_path if not isinstance(f, LastResort)] == finders
    assert sys.modules["queue"] is queue
    assert sys.modules["random"] is random
    assert "test" not in sys.modules
    assert "__getattr__" not in vars(queue)
    assert not hasattr(queue, "Job")


def test_modules_of_another_folder_are_set_aside(tmp_path, home, monkeypatch):
    """As those of a study, or of a notebook, that has imported its own file of that name before."""
    another = ModuleType("helper")
    another.__file__ = str(tmp_path / "elsewhere" / "helper.py")
    monkeypatch.setitem(sys.modules, "helper", another)
    write(home, helper="WHOSE = 'script'", script=UNDRAWN + "import helper\nprint(helper.WHOSE)\n")
    for _ in range(2):
        assert "script" in said("run", home)
    assert sys.modules["helper"] is another


def test_files_of_an_installation_within_the_scripts_folder_are_not_the_scripts(tmp_path):
    whose.add_script_folder(str(tmp_path))
    try:
        site = tmp_path / ".venv" / "lib" / "python3.10" / "site-packages"
        assert whose.is_environments(str(site / "numpy" / "__init__.py"))
        assert not whose.is_environments(str(tmp_path / "numpy.py"))
        whose.add_script_folder(str(site / "examples"))
        assert not whose.is_environments(str(site / "examples" / "numpy.py"))
        assert whose.is_environments(rps_compat.__file__)
        assert whose.is_environments(os.__file__)
        assert whose.is_environments(None)
        assert whose.is_environments("frozen")
    finally:
        whose.forget_script_folders({str(tmp_path), str(site / "examples")})
