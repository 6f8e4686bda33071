"""What has to change in a script of generation 1, and that the changed script does the same."""

import textwrap

import pytest
from typer.testing import CliRunner

from posflock_robotarium.cli import app
from rps_compat.lint import findings_in, findings_of, rewritten
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.scripts.evidence import evidence_in
from rps_compat.scripts.source import UnreadableError, parse_script

IMPORTS = """\
import numpy as np
from rps.robotarium import Robotarium
from rps.utilities.barrier_certificates import *
from rps.utilities.controllers import *
from rps.utilities.graph import *
from rps.utilities.misc import *
from rps.utilities.transformations import *
"""
#: A line that makes a script one of generation 1, before and after.
FIRST, SECOND = "Robotarium(1)\n", "Robotarium(number_of_robots=1)\n"


def lint(source, above=IMPORTS, rewritten_above=IMPORTS):
    script = parse_script((above + textwrap.dedent(source)).encode(), "nowhere/s.py")
    findings = findings_of(script)
    new = rewritten(script, findings).decode()
    lines = above.count("\n")
    told = [(f.line - lines, f.kind) for f in findings if f.needed and f.line > lines]
    assert new.startswith(rewritten_above)
    return told, new.removeprefix(rewritten_above)


def lint_first(source):
    return lint(source, IMPORTS + FIRST, IMPORTS + SECOND)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("r = Robotarium(5, True)", "r = Robotarium(number_of_robots=5, show_figure=True)"),
        (
            "r = Robotarium(number_of_robots=5)\nt = r.time_step  # s\nr.call_at_scripts_end()",
            "r = Robotarium(number_of_robots=5)\nt = r.TIME_STEP  # s\nr.debug()",
        ),
        ("from rps.utilities.misc import at_pose", "from rps.utilities.misc import create_at_pose"),
        (
            "done = at_pose(x, goal, rotation_error=100)",
            "done = create_at_pose(rotation_error=100)(x, goal)[1].nonzero()",
        ),
        ("at_pose(x, goal, 0.1, 0.2)", "create_at_pose(0.1, 0.2)(x, goal)[1].nonzero()"),
        (
            "c = create_single_integrator_barrier_certificate(100, 0.2)",
            "c = create_si_barrier_certificate(barrier_gain=100, safety_radius=0.2)",
        ),
        (
            "c = create_unicycle_barrier_certificate(magnitude_limit=0.1, safety_radius=0.2)",
            "c = create_uni_barrier_certificate(velocity_magnitude_limit=0.1, safety_radius=0.2)",
        ),
        (
            "c = create_si_position_controller(x_velocity_gain=2)",
            "c = create_si_position_controller(x_velocity_gain=2, y_velocity_gain=1)",
        ),
        ("a, b = create_si_to_uni_mapping(0.05, np.pi)", "a, b = create_si_to_uni_mapping(0.05)"),
        ("f = create_uni_to_si_dynamics()", "f = create_uni_to_si_mapping()[0]"),
        ("poses = generate_initial_conditions(N, 0.4)", "poses = generate_random_poses(N, 0.4)"),
        (
            "class Env(Robotarium):\n    def __init__(self, n):\n        super().__init__(n, True)",
            "class Env(Robotarium):\n    def __init__(self, n):\n"
            "        super().__init__(number_of_robots=n, show_figure=True)",
        ),
        ("L = completeGL(N - 1)", "L = completeGL(N - 1)"),
        ("L = completeGL(N=5)", "L = completeGL(n=5)"),
        ("L = lineGL(N)", "L = lineGL(N)"),
        ("L = lineGL(N=N)", "L = lineGL(n=N)"),
        ("L = cycle_GL(5)", "L = cycleGL(5)"),
        ("L = cycle_GL(N=5)", "L = cycleGL(n=5)"),
        ("L = completeGL(n=5)", "L = completeGL(n=5)"),
        (
            "c = create_single_integrator_barrier_certificate(100, whatever=1)",
            "c = create_si_barrier_certificate(barrier_gain=100, whatever=1, safety_radius=0.17)",
        ),
        ("m = np.mat('1 2')", "m = np.asmatrix('1 2')"),
        ("x = np.Inf; é = np.float_(1)", "x = np.inf; é = np.float64(1)"),
        ("x = -np.NINF ** 2", "x = -(-np.inf) ** 2"),
        ("x = np.zeros(3, np.float)", "x = np.zeros(3, float)"),
        ("from numpy import mat, pi\nmat('1')", "from numpy import asmatrix, pi\nasmatrix('1')"),
        ("from numpy import product as p\np(3)", "from numpy import prod as p\np(3)"),
        (
            "from scipy.signal import hanning\nhanning(3)",
            "from scipy.signal.windows import hann\nhann(3)",
        ),
        ("import scipy.integrate as i\ni.simps(x)", "import scipy.integrate as i\ni.simpson(x)"),
        # Within each other.
        (
            "c = create_single_integrator_barrier_certificate(np.float(at_pose(x, np.mat(g))))",
            "c = create_si_barrier_certificate(barrier_gain=float("
            "create_at_pose()(x, np.asmatrix(g))[1].nonzero()), safety_radius=0.17)",
        ),
        # Only the name that is bound to the function of the API.
        (
            "if at_pose(x, goal):\n    at_pose = 3\nprint(at_pose)",
            "if create_at_pose()(x, goal)[1].nonzero():\n    at_pose = 3\nprint(at_pose)",
        ),
        ("check = at_position\n", "check = at_position\n"),  # by hand
        ("f = topological_neighbors\n", "f = topological_neighbors\n"),
    ],
)
def test_rewriting(old, new):
    assert lint_first(old)[1] == new


@pytest.mark.parametrize(
    ("source", "finding"),
    [
        ("r = Robotarium(number_of_robots=1)\n\nr.boundaries", (3, "name")),
        ("s = determine_marker_size(r, 0.1)", (1, "name")),
        ("Robotarium(number_of_robots=1).set_velocities(None, v)", (1, "argument")),
        ("r = Robotarium()\nr.set_velocities([0], v)", (2, "argument")),
        ("c = create_si_position_controller()", (1, "default")),
        ("import tomllib", (1, "version")),
        ("from typing import Self", (1, "version")),
        ("\nx = np.asfarray([1])", (2, "version")),
        ("import pandas", (1, "version")),
    ],
)
def test_findings(source, finding):
    assert finding in lint_first(source)[0]


@pytest.mark.parametrize(
    "source",
    [
        "class Car:\n    time_step = 1\n\ncar = Car()\nprint(car.time_step, car.axes)",
        "r = Robotarium(number_of_robots=3)\nr.set_velocities(np.arange(3), v)\nr.debug()",
        "import matplotlib.pyplot as plt\nfig, axes = plt.subplots()\nfig.axes[0].figure",
        "def at_pose(x):\n    return x\n\nat_pose(3)",
        "x = np.float64(1.0) + np.inf",
        "class Env(Gym):\n    def __init__(self):\n        super().__init__(3, True)",
    ],
)
def test_nothing_to_find(source):
    assert lint(source) == ([], source)


@pytest.mark.parametrize(
    "source",
    [
        "r = Robotarium(number_of_robots=1)\nr.time_step; r.time_step; r.time_step",
        "x = np.float(3) + np.float(4)",
        "c = create_single_integrator_barrier_certificate(100, 0.2)",
        "p = create_clf_unicycle_position_controller(1, 2)",
        "L = completeGL(N - 1) + completeGL(N=3)",
    ],
)
def test_each_finding_is_told_once_and_in_full(source):
    script = parse_script((IMPORTS + source).encode())
    findings = findings_of(script)
    messages = [(finding.line, finding.message) for finding in findings]
    assert 1 <= len(messages) == len(set(messages)) <= 5
    assert not any(message.rstrip().endswith(":") for _, message in messages)
    assert findings_in(rewritten(script, findings)) == []


def test_formatting_and_comments_stay():
    source = """\
    from rps.robotarium import *
    r = Robotarium( 3 ,   # three
                    False )
    if True :   r.call_at_scripts_end( )  # the end
    """
    assert lint(source, "", "")[1] == textwrap.dedent(
        """\
        from rps.robotarium import *
        r = Robotarium( number_of_robots=3 ,   # three
                        show_figure=False )
        if True :   r.debug( )  # the end
        """
    )


def test_newer_syntax_is_named():
    source = "try:\n    pass\nexcept* ValueError:\n    pass\n"
    try:
        compile(source, "", "exec")
    except SyntaxError:
        with pytest.raises(UnreadableError, match=r"line 3: newer than Python 3\.10: except"):
            lint(source, "", "")
    else:
        assert lint(source, "", "")[0] == [(3, "version")]


GENERATION_1 = """
import numpy as np
from rps.robotarium import Robotarium
from rps.utilities.barrier_certificates import *
from rps.utilities.controllers import *
from rps.utilities.misc import *
from rps.utilities.transformations import *

start = np.array([[-0.8, 0.8, 0.0], [0.0, 0.0, 0.6], [0.0, 3.0, -1.5]])
goals = np.array([[0.8, -0.8, 0.1], [0.1, -0.1, -0.6], [0.0, 3.0, -1.5]])
r = Robotarium(3, False, False, start)
controller = create_si_position_controller()
barrier = create_single_integrator_barrier_certificate_with_boundary(safety_radius=0.2)
si_to_uni, uni_to_si = create_si_to_uni_mapping()
for k in range(2000):
    x = r.get_poses()
    if np.size(at_pose(x, goals, position_error=0.1, rotation_error=100)) == 3:
        break
    dxi = barrier(controller(uni_to_si(x), goals[:2]), uni_to_si(x))
    r.set_velocities(np.arange(3), si_to_uni(dxi, x))
    r.step()
print("there", k < 1999)
r.call_at_scripts_end()
"""


def test_rewritten_script_runs_on_generation_2(tmp_path, capsys):
    old, new = tmp_path / "old.py", tmp_path / "new.py"
    old.write_text(GENERATION_1)
    told = CliRunner().invoke(app, ["lint", str(old), "--generation", "2", "-o", str(new)])
    assert told.exit_code == 1
    pairs = zip(old.read_text().splitlines(), new.read_text().splitlines(), strict=True)
    changed = sum(before != after for before, after in pairs)
    last = told.stderr.splitlines()[-1]
    assert last == f"wrote {new}: {changed} lines changed, 0 to change by hand"
    assert CliRunner().invoke(app, ["lint", str(new)]).exit_code == 0
    assert (evidence_in(old).generation, evidence_in(new).generation) == (1, 2)
    for script in (old, new):
        result = run_script(script, (), RunSettings(headless=True, initial="exact", timeout=30))
        assert result.exit_code == 0
        assert "there True" in capsys.readouterr().out


def test_lint_command_tells_lines(tmp_path):
    script = tmp_path / "s.py"
    start = "from rps.robotarium import Robotarium\nr = Robotarium(number_of_robots=1)\n"
    script.write_text(start + "r.call_at_scripts_end()\n")
    result = CliRunner().invoke(app, ["lint", str(script)])
    assert result.exit_code == 1
    assert f"{script}:3: call_at_scripts_end() is generation 1's" in result.output
    script.write_text(start + "r.debug()\n")
    result = CliRunner().invoke(app, ["lint", str(script)])
    assert result.exit_code == 0
    assert result.output.splitlines() == [
        f"{script}: nothing to change for generation 2, numpy 2.2 and Python 3.10"
    ]
    assert CliRunner().invoke(app, ["lint", str(script), "--json"]).output == "[]\n"
    script.write_text("not python at all")
    assert CliRunner().invoke(app, ["lint", str(script)]).exit_code != 0
