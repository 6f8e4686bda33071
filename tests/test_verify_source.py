"""What can be read off a source, case by case."""

import ast
from pathlib import Path

import pytest

from posflock_robotarium import import_graph
from posflock_robotarium.verify.constants import constants_of
from posflock_robotarium.verify.static import check_source
from rps_compat.scripts import libraries
from rps_compat.scripts.syntax import newer_syntax


def codes(tmp_path, text, generation=2, name="main_script.py"):
    script = tmp_path / name
    script.write_text(text)
    found, _ = check_source(script, generation)
    return [(finding.code, finding.line) for finding in found if finding.verdict > 1]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # A name in a comment or a string is no finding.
        ('# plt.show()\nx = "input()"\n', []),
        ("import matplotlib.pyplot as p\np.show(block=False)\n", []),
        ("import matplotlib.pyplot as p\np.show()\n", [("blocking-call", 2)]),
        ("from matplotlib.pyplot import show as s\ns()\n", [("blocking-call", 2)]),
        ("from rps.robotarium_abc import *\nplt.show()\n", [("blocking-call", 2)]),
        (
            "from rps.robotarium import *\nplt.show()\n",
            [("generation", 2), ("blocking-call", 2)],
        ),
        ("from matplotlib.pyplot import *\nshow()\n", [("blocking-call", 2)]),
        (
            "from rps.robotarium_abc import *\nfrom math import *\nplt.show()\n",
            [("blocking-call", 3)],
        ),
        ("breakpoint()\n", [("blocking-call", 1)]),
        ("import builtins\nbuiltins.input()\n", [("blocking-call", 2)]),
        # Libraries: there, not there, caught, never run.
        ("import cvxopt, cv2, yaml, sklearn.cluster\n", []),
        ("import osqp\n", [("library-absent", 1)]),
        ("try:\n    import osqp\nexcept ImportError:\n    osqp = None\n", []),
        ("def f():\n    import pandas\n", [("library-absent", 2)]),
        ("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import pandas\n", []),
        ("try:\n    import rps\nexcept ImportError:\n    import rps_compat\n", []),
        ("import rps_compat\n", [("stand-in", 1)]),
        ("from . import helper\n", [("module-missing", 1)]),
        ("import tomllib\n", [("newer-python", 1)]),
        ("import numpy as np\nx = np.Inf\n", [("removed-from-numpy", 2)]),
        ("from numpy import product\n", [("removed-from-numpy", 1)]),
        # Files.
        ("import numpy as np\nnp.save('a.npy', 1)\nnp.load('a.npy')\n", []),
        ("NAME = 'goals'\nopen(f'{NAME}.m')\n", [("file-missing", 2)]),
        ("import os\nopen(os.path.join('d', 'goals.m'))\n", [("file-in-folder", 2)]),
        ("from pathlib import Path\nPath('x.m').read_text()\n", [("file-missing", 2)]),
        ("open('/etc/x.m')\n", [("file-in-folder", 1)]),
        ("import sys\nopen(sys.argv[1])\n", []),
        ("open('out.csv', 'w')\n", []),
        ("open(__file__)\n", []),
        (
            "import os\nopen(os.path.join(os.path.dirname(__file__), 'a.m'))\n",
            [("file-missing", 2)],
        ),
        (
            "from pathlib import Path\nF = Path(__file__).resolve().parent\n(F / 'a.m').open()\n",
            [("file-missing", 3)],
        ),
        (
            "from pathlib import Path\n(Path(__file__).parent.parent / 'a.m').read_text()\n",
            [("file-in-folder", 2)],
        ),
        ("import numpy as np\nnp.load(file='a.npy')\n", [("file-missing", 2)]),
        ("import numpy as np\nnp.savez('a', x=1)\nnp.load('a.npz')\n", []),
        ("from pathlib import Path\np = Path('a.m')\np.write_text('')\np.read_text()\n", []),
        ("import os\nif os.path.exists('a.json'):\n    open('a.json')\n", []),
        ("try:\n    open('a.m')\nexcept FileNotFoundError:\n    pass\n", []),
        # What never runs there, or is ready for its absence.
        ("import sys\nif sys.version_info >= (3, 11):\n    import tomllib\n", []),
        (
            "import sys\nif sys.version_info < (3, 11):\n    import pandas\n",
            [("library-absent", 3)],
        ),
        ("try:\n    from typing import Self\nexcept ImportError:\n    pass\n", []),
        ("from typing import Self\n", [("newer-python", 1)]),
        # Generation 1, on what is known to be a Robotarium.
        (
            "from rps.robotarium import Robotarium as T\ndef f(r: T):\n"
            "    r.call_at_scripts_end()\n",
            [("generation", 3)],
        ),
    ],
)
def test_one_source_at_a_time(tmp_path, text, expected):
    assert codes(tmp_path, text) == expected


LOOP = (
    "import numpy as np\nfrom rps.robotarium import Robotarium\n"
    "r = Robotarium(number_of_robots=1)\n{before}\n"
    "for k in range(9):\n    r.get_poses()\n    r.step()\n    {during}\n{after}\nr.debug()\n"
)


@pytest.mark.parametrize(
    ("places", "expected"),
    [
        ({}, []),
        ({"after": "np.save('x.npy', 1)"}, [("save-at-end", 9)]),
        ({"during": "np.save('x.npy', 1)"}, []),
        ({"during": "f.write('1')", "before": "f = open('x.txt', 'w')"}, []),
        ({"after": "def end():\n    np.save('x.npy', 1)\nend()"}, [("save-at-end", 10)]),
        ({"before": "import atexit\natexit.register(lambda: None)"}, []),
    ],
)
def test_saving_only_at_the_end(tmp_path, places, expected):
    text = LOOP.format(**({"before": "", "during": "", "after": ""} | places))
    assert codes(tmp_path, text) == expected


@pytest.mark.parametrize("number", ["24", "4 * 6", "N"])
def test_robots_are_counted_through_constants(tmp_path, number):
    text = (
        "from rps.robotarium import Robotarium\nN = 12 + 12\n"
        f"r = Robotarium(number_of_robots={number})\nr.debug()\n"
    )
    assert codes(tmp_path, text) == [("too-many-robots", 3)]


def test_names_bound_twice_are_not_constants():
    assert constants_of(ast.parse("a = 1\nb = a + 1\nc = 1\nc = 2\nfor d in x: pass\n")) == {
        "a": 1,
        "b": 2,
    }


def test_a_script_of_generation_one_passes_where_that_is_asked_for(tmp_path):
    text = "from rps.robotarium import Robotarium\nr = Robotarium(3)\nr.call_at_scripts_end()\n"
    assert codes(tmp_path, text, generation=1) == []
    assert codes(tmp_path, text, generation=2) == [("generation", 2), ("generation", 3)]


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    pass\nexcept* ValueError:\n    pass\n",
        "a[*b]\n",
        "type X = int\n",
        "type Pair[T] = tuple[T, T]\n",
        "def f[T](x: T) -> T: ...\n",
        "class Queue[T]: pass\n",
        "f'{x['a']}'\n",
        'print(f"at {", ".join(x)} m")\n',
        "f'{\"\\n\".join(x)}'\n",
        't"at {x} m"\n',
        "try:\n    pass\nexcept A, B:\n    pass\n",
    ],
)
def test_syntax_newer_than_the_testbeds(tmp_path, text):
    """Whether the Python that looks at it reads it or is too old itself."""
    assert [code for code, _ in codes(tmp_path, text)] == ["newer-python"]


@pytest.mark.parametrize(
    "text", ["f'{x'\n", "type X\n", "def f(:\n", "x = (1\n", "print 'hello'\n", "except A:\n"]
)
def test_what_no_python_reads_is_not_called_newer(tmp_path, text):
    assert [code for code, _ in codes(tmp_path, text)] == ["syntax"]


@pytest.mark.parametrize(
    "text", ["a[(*b,)]\n", "match x:\n    case 1: pass\n", "f'{x[\"a\"]}'\n", "with (a, b): pass\n"]
)
def test_syntax_of_the_testbeds_python_is_accepted(text):
    assert newer_syntax(text, ast.parse(text)) == []


def test_local_files_are_followed_and_hidden_names_found(tmp_path):
    (tmp_path / "helper.py").write_text("import deeper\n")
    (tmp_path / "deeper.py").write_text("import numpy\n")
    (tmp_path / "tools").mkdir()
    (tmp_path / "tools" / "__init__.py").write_text("from .inner import x\n")
    (tmp_path / "tools" / "inner.py").write_text("x = 1\n")
    script = tmp_path / "main_script.py"
    script.write_text("import helper\nfrom tools import inner\n")
    found = import_graph.trace(script)
    assert sorted(local.name for local in found.locals) == [
        "deeper", "helper", "tools", "tools.inner"
    ]  # fmt: skip
    (tmp_path / "random.py").write_text("x = 1\n")
    assert codes(tmp_path, "import random\n") == [("shadowed-name", 1)]


def test_a_package_may_offer_what_the_testbed_lacks(tmp_path):
    package = tmp_path / "solvers_of_mine"
    package.mkdir()
    (package / "__init__.py").write_text(
        "def fast():\n    from solvers_of_mine import quick\n    return quick\n"
    )
    (package / "quick.py").write_text("import osqp\n")
    script = tmp_path / "main_script.py"
    script.write_text("import solvers_of_mine\n")
    found = import_graph.trace(script)
    assert found.missing == []
    assert found.left_out == {"solvers_of_mine.quick": "osqp"}


def test_the_testbeds_list_is_consistent():
    assert set(libraries.IMPORT_NAMES.values()) == set(libraries.LIBRARIES)
    assert not set(libraries.ABSENT) & set(libraries.IMPORT_NAMES)
    assert libraries.shadowed_by("numpy")
    assert libraries.shadowed_by("random")
    assert libraries.shadowed_by("my_helper") is None


def test_the_experiment_has_nothing_to_mend():
    script = Path(__file__).parents[1] / "experiments" / "robotarium_9bot.py"
    found, _ = check_source(script)
    assert [finding.code for finding in found] == ["local-module"]


def test_a_module_of_a_newer_python_is_no_local_file(tmp_path):
    script = tmp_path / "main.py"
    script.write_text("import tomllib\n")
    found, _ = check_source(script)
    assert [finding.code for finding in found] == ["newer-python"]
