"""The mutation tester changes one thing at a time, and knows what a test noticed."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from equivalent_mutants import EQUIVALENT  # noqa: E402
from mutants import TARGETS, mutants_of  # noqa: E402
from mutations import mutations  # noqa: E402

sys.path.remove(str(ROOT / "tools"))


def changed(text):
    """Return what every mutation makes of a text."""
    found = []
    for index in range(len(list(mutations(ast.parse(text))))):
        tree = ast.parse(text)
        list(mutations(tree))[index].apply()
        found.append(ast.unparse(ast.fix_missing_locations(tree)))
    return found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a + b", ["a - b"]),
        ("a < b", ["a <= b", "a > b"]),
        ("a is None", ["a is not None"]),
        ("a and b", ["a or b"]),
        ("-a", ["+a"]),
        ("f(3, k=a)", ["f(3)", "f(4, k=a)"]),
        ("x.max()", ["x.min()"]),
        ("{'a': b}", ["{}", "{'a_': b}"]),
        ("{a, b}", ["{b}", "{a}"]),
        ("x = True", ["x = False"]),
        ("if a:\n    b()", ["if not a:\n    b()", "if a:\n    pass"]),
        ("[a for a in b if c]", ["[a for a in b]"]),
        ("x.y = z", ["pass"]),
        ("x += z", ["pass", "x -= z"]),
        ("if a:\n    raise E('b', 1)", ["if not a:\n    raise E('b', 1)", "if a:\n    pass"]),
    ],
)
def test_one_thing_is_changed_at_a_time(text, expected):
    assert sorted(
        changed(f"y = {text}" if text[0] in "af{[-" or "x.m" in text else text)
    ) == sorted(f"y = {e}" if text[0] in "af{[-" or "x.m" in text else e for e in expected)


@pytest.mark.parametrize(
    "text",
    [
        '"""Words."""',
        "x: int | None",
        "def f(a: int = b) -> 'C': ...",
        "assert a > 0",
        "y = 'words with spaces'",
        "y = f'{a + 1} b'",
        "__all__ = ['a', 'b']",
        "from a import b",
    ],
)
def test_what_says_nothing_of_behaviour_is_left_alone(text):
    assert changed(text) == []


def test_every_target_has_mutants_and_tests_and_every_equivalent_mutant_is_one():
    everything = [mutant for target in TARGETS.values() for mutant in mutants_of(target)]
    for name, target in TARGETS.items():
        assert mutants_of(target), name
        assert all((ROOT / "tests" / f"{test}.py").is_file() for test in target.tests), name
    for file, source, change, why in EQUIVALENT:
        assert why
        assert any(
            file in m.file and source in m.source and change in m.change for m in everything
        ), (file, source, change)


@pytest.mark.slow
def test_a_fault_that_its_tests_miss_is_told_and_fails(tmp_path):
    """A copy of the tool with a module of its own, of which one test sees half."""
    for name in ("mutants", "mutations", "equivalent_mutants"):
        text = (ROOT / "tools" / f"{name}.py").read_text("utf-8")
        (tmp_path / "tools").mkdir(exist_ok=True)
        (tmp_path / "tools" / f"{name}.py").write_text(text, "utf-8")
    tool = tmp_path / "tools" / "mutants.py"
    head, tail = tool.read_text("utf-8").split("TARGETS = {", 1)
    tail = tail.split("\n}\n", 1)[1].replace("in PRELOADED", "in ['hypothesis', 'pytest']", 1)
    tool.write_text(
        f'{head}TARGETS = {{"sum": Target(("sums.py",), ("test_sums",))}}\n{tail}', "utf-8"
    )
    (tmp_path / "sums.py").write_text(
        "def twice(a):\n    return a + a\n\n\ndef less(a):\n    return a - 1\n"
    )
    (tmp_path / "tests").mkdir()
    seen = tmp_path / "tests" / "test_sums.py"
    seen.write_text("import sums\n\ndef test():\n    assert sums.twice(3) == 6\n")

    def run(*options):
        return subprocess.run(
            [sys.executable, tool, *options], cwd=tmp_path, capture_output=True, text=True
        )

    done = run()
    assert done.returncode == 1, done.stderr
    assert "sum: 2 of 3 mutants survived, 66.7%" in done.stdout
    assert "sums.py:6: Sub to Add   return a - 1" in done.stdout
    assert "sums.py:2" not in done.stdout
    seen.write_text(seen.read_text() + "    assert sums.less(3) == 2\n")
    done = run("sum", "--sample", "2", "--seed", "4")
    assert (done.returncode, done.stdout) == (
        0, "sum: 0 of 2 mutants survived, 0.0% (of 3, 0 equivalent)\n"
    )  # fmt: skip
    seen.write_text("def test():\n    assert False\n")
    assert "do not pass without any mutant" in run().stderr
