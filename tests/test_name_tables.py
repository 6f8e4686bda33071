"""The tables of names: lint, verify and run say one thing of every entry, and none is missing."""

import builtins
import importlib
import json
import re
from collections.abc import Set
from pathlib import Path

import numpy as np
import pytest

import rps_compat
from posflock_robotarium.verify.findings import Verdict
from posflock_robotarium.verify.source import Source
from posflock_robotarium.verify.static import check_names
from rps_compat.lint import findings_of
from rps_compat.scripts import (
    generation_names,
    libraries,
    library_names,
    numpy_names,
    python_names,
)
from rps_compat.scripts.changes import CHANGES, Change, Kind
from rps_compat.scripts.evidence import evidence_in
from rps_compat.scripts.faces import API_MODULES, face
from rps_compat.scripts.libraries import IMPORT_NAMES, STANDARD_LIBRARY
from rps_compat.scripts.source import read_script

GOLDEN = Path(__file__).parent / "golden" / "library_names.json"
MODULES = {*STANDARD_LIBRARY, *IMPORT_NAMES}


def told(tmp_path, text):
    """Return the lines that lint wants changed, that verify fails, and that stop a run as 2."""
    path = tmp_path / "script.py"
    path.write_text(text)
    script = read_script(path)
    lint = {finding.line for finding in findings_of(script) if finding.needed}
    failed = {f.line for f in check_names(Source(script)) if f.verdict is Verdict.FAIL}
    stopped = {use.line for use in evidence_in(path).stopping(2)}
    return lint, failed, stopped


def use_of(path):
    """Return a statement that uses a name of a library, on one line."""
    module, _, name = path.rpartition(".")
    if module == "builtins":
        return name
    if not module:
        return f"import {name}"
    return f"from {module} import {name}"


def test_lint_and_verify_agree_on_every_name_of_a_library(tmp_path):
    lines = {path: number for number, path in enumerate(CHANGES, start=1)}
    lint, failed, _ = told(tmp_path, "".join(f"{use_of(path)}\n" for path in CHANGES))
    faulty = {path for path, change in CHANGES.items() if change.kind is not Kind.LATER}
    assert {path for path in CHANGES if lines[path] in lint} == faulty
    assert {path for path in CHANGES if lines[path] in failed} == faulty


def test_no_entry_of_the_libraries_names_is_missing():
    """`tools/library_names.py` compared twelve sets of versions; its list is kept beside."""
    listed = {path: change.kind.value for path, change in CHANGES.items()}
    assert listed == json.loads(GOLDEN.read_text("utf-8"))


def resolves(path):
    """Whether a dotted path of something to write leads to anything, here or among builtins."""
    parts = path.split(".")
    for k in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:k]))
        except ImportError:
            continue
        return all(hasattr(found, part) and (found := getattr(found, part)) for part in parts[k:])
    return hasattr(builtins, path)


def test_what_is_to_be_written_instead_of_a_name_exists():
    missing = []
    for path, change in CHANGES.items():
        module = path.rpartition(".")[0]
        if change.code:
            written = f"{module}{change.code}" if change.code[0] == "." else change.code
            named = re.findall(r"[A-Za-z]\w*(?:\.\w+)*", written.replace("{}", module))
        else:
            named = re.findall(r"write (?:numpy|scipy|matplotlib)(?:\.\w+)+", change.advice)
        for name in named:
            if not resolves(name.removeprefix("write ")):
                missing.append((path, name))
    assert missing == []


TABLES = Path(__file__).parent / "golden" / "name_tables.json"


def tables_as_data():
    """Return every table of names and versions as plain data, sets in order."""

    def plain(value):
        if isinstance(value, dict):
            return {str(key): plain(entry) for key, entry in value.items()}
        if isinstance(value, (set, frozenset)):
            return sorted(map(str, value))
        return [plain(entry) for entry in value] if isinstance(value, tuple) else value

    modules = (libraries, generation_names, numpy_names, python_names, library_names)
    found = {
        module.__name__.rpartition(".")[2]: {
            name: plain(value)
            for name, value in vars(module).items()
            if name.isupper() and name[0] != "_" and isinstance(value, (dict, tuple, Set))
        }
        for module in modules
    }
    # What this Python's own standard library has differs from one Python to the next.
    del found["libraries"]["STANDARD_LIBRARY"]
    return found


def test_no_entry_of_a_table_changes_unnoticed():
    """The tables were read once in libraries and guides; ``python tests/test_name_tables.py``
    renews the copy after a change that is meant."""
    assert tables_as_data() == json.loads(TABLES.read_text("utf-8"))


def test_a_name_is_told_with_its_library_and_the_testbeds_version():
    cases = {
        ("numpy.NaN", Kind.GONE): ("NaN", "numpy 2.2.6", "numpy.NaN is gone from numpy 2.2.6"),
        ("builtins.aiter", Kind.NEWER): ("aiter", "Python 3.10", "aiter is newer than Python 3.10"),
        ("imp", Kind.LATER): (
            "imp", "Python 3.10", "imp is in Python 3.10, and gone from newer versions"),
        ("scipy.x", Kind.NEWER): ("x", "scipy 1.15.3", "scipy.x is newer than scipy 1.15.3"),
    }  # fmt: skip
    for (path, kind), told in cases.items():
        change = Change(path, kind)
        assert (change.name, change.library, change.what) == told
        assert change.is_pythons_newer == (path == "builtins.aiter")


def test_a_change_holds_what_to_write_or_what_to_do_or_since_when():
    kinds = {
        "numpy.Infinity": (Kind.GONE, ".inf", "", ""),
        "scipy.signal.hann": (Kind.GONE, "{}.windows.hann", "", ""),
        "scipy.io.byteordercodes": (Kind.GONE, "", "", ""),
        "scipy.linalg.tril": (Kind.GONE, "", "write numpy.tril(…)", ""),
        "tomllib": (Kind.NEWER, "", "", "3.11"),
    }
    for path, told in kinds.items():
        change = CHANGES[path]
        assert (change.kind, change.code, change.advice, change.since) == told, path


def test_lint_verify_and_run_agree_on_every_name_of_the_other_generations(tmp_path):
    names = generation_names
    lines = ["from rps.robotarium import Robotarium", "r = Robotarium(number_of_robots=1)"]
    wrong = set()

    def add(line, is_wrong):
        lines.append(line)
        if is_wrong:
            wrong.add(len(lines))

    for name in [*names.FUNCTIONS, *names.NEW_FUNCTIONS]:
        for module in API_MODULES:
            there = {g for g in (1, 2) if (f := face(module, g)) and name in f.functions}
            if there:
                add(f"from {module} import {name}", 2 not in there)
    for module, (generation, _) in names.MODULES.items():
        add(f"import {module}", generation == 1)
    for name in [*names.ATTRIBUTES, *names.OLD_ATTRIBUTES]:
        add(f"r.{name}", is_wrong=True)
    for name in [*names.NEW_ATTRIBUTES, *filter(None, names.ATTRIBUTES.values())]:
        add(f"r.{name}", is_wrong=False)
    for name in names.OLD_ARGUMENTS:
        add(f"Robotarium({name}=1)", is_wrong=True)
    for name in [*names.NEW_ARGUMENTS, *names.CONSTRUCTOR]:
        add(f"Robotarium({name}=1)", is_wrong=False)
    for name, (module, _) in names.OLD_FUNCTIONS.items():
        add(f"from rps.utilities.{module} import {name} as old", is_wrong=True)
    lint, failed, stopped = told(tmp_path, "\n".join(lines) + "\n")
    shown = {number: lines[number - 1] for number in lint | failed | stopped | wrong}
    assert {shown[k] for k in failed} == {shown[k] for k in wrong}
    assert {shown[k] for k in stopped} == {shown[k] for k in wrong}
    assert {shown[k] for k in lint} == {shown[k] for k in wrong}


@pytest.fixture(scope="module")
def robotaria():
    """One instance of each generation, with its figure."""
    made = {}
    for api in (1, 2):
        rps_compat.install(generation=api)
        try:
            from rps.robotarium import Robotarium

            options = {"skip_initialization": True} if api == 2 else {}
            made[api] = Robotarium(
                number_of_robots=1,
                show_figure=False,
                sim_in_real_time=False,
                initial_conditions=np.zeros((3, 1)),
                **options,
            )
        finally:
            rps_compat.uninstall()
    return made


def test_no_entry_of_the_generations_names_is_missing(robotaria):
    names = generation_names
    for module in API_MODULES:
        first, second = (
            set() if found is None else {name for name in found.functions if name[0] != "_"}
            for found in (face(module, 1), face(module, 2))
        )
        assert first - second <= names.FUNCTIONS.keys()
        known = names.NEW_FUNCTIONS | set(names.FUNCTIONS.values())
        assert second - first <= known
    public = {api: {n for n in dir(r) if not n.startswith("_")} for api, r in robotaria.items()}
    assert public[1] - public[2] <= names.ATTRIBUTES.keys()
    assert public[2] - public[1] <= names.NEW_ATTRIBUTES | set(names.ATTRIBUTES.values())


if __name__ == "__main__":
    TABLES.write_text(json.dumps(tables_as_data(), indent=0, ensure_ascii=False) + "\n", "utf-8")
