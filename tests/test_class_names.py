"""One name for one thing: no two classes of the three packages are called the same."""

import ast
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("barrier_certificates", "rps_compat", "posflock_robotarium")
#: What both published faces of the API call so.
PUBLISHED = {"Robotarium", "UnicycleEKF"}
#: Each package refuses what is given to it by errors of its own, which callers catch by package.
ERRORS = {"NotFiniteError", "ParameterError", "ShapeError"}


def test_no_name_is_given_to_two_classes():
    found = defaultdict(list)
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    found[node.name].append(path.relative_to(ROOT).as_posix())
    twice = {name: paths for name, paths in found.items() if len(paths) > 1}
    assert twice.keys() == PUBLISHED | ERRORS, twice
